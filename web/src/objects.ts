import { BufferGeometry, Float32BufferAttribute } from "three";
import type { ObjectName } from "./state.js";

// The built-in objects of the library (render/mesh/primitives.rs): the same formulas on the same grids.

type Vector = [number, number, number];
type Surface = (s: number, t: number) => Vector;

/** How often a texture repeats over texture coordinates 0..1, where texels are about square. */
export const DEFAULT_TILING: Record<ObjectName, [number, number]> = {
  flat: [1, 1], plane: [1, 1], sphere: [4, 2], torus: [6, 2], cloth: [2, 2], mesh: [1, 1],
};

/** An object; `aspect` is the width of what texture coordinates 0..1 span over its height: the proportions of a plane. */
export function geometryOf(object: ObjectName, aspect: number): BufferGeometry {
  switch (object) {
    case "sphere":
      return grid(192, 96, sphere, sphere);
    case "torus":
      return grid(192, 96, torus, torusNormal);
    case "cloth":
      return grid(160, 160, cloth, clothNormal);
    default: {
      const x = Math.min(aspect, 1), y = Math.min(1 / aspect, 1);
      return grid(1, 1, (s, t) => [(2 * s - 1) * x, (2 * t - 1) * y, 0], () => [0, 0, 1]);
    }
  }
}

/** The sphere around the box of an object: centre and radius, as the library's `bounding_sphere`. */
export function boundingSphere(geometry: BufferGeometry): { center: Vector; radius: number } {
  const positions = geometry.getAttribute("position").array;
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i++) {
    const k = i % 3, value = positions[i] ?? 0;
    low[k] = Math.min(low[k] ?? 0, value);
    high[k] = Math.max(high[k] ?? 0, value);
  }
  const center = [0, 1, 2].map((k) => ((low[k] ?? 0) + (high[k] ?? 0)) / 2) as Vector;
  let square = 0;
  for (let i = 0; i < positions.length; i += 3) {
    const [x, y, z] = [0, 1, 2].map((k) => (positions[i + k] ?? 0) - (center[k] ?? 0)) as Vector;
    square = Math.max(square, x * x + y * y + z * z);
  }
  return { center, radius: Math.sqrt(square) };
}

/** A grid of columns x rows cells over (s, t) in 0..1, seams not shared. */
function grid(columns: number, rows: number, position: Surface, normal: Surface): BufferGeometry {
  const positions: number[] = [], normals: number[] = [], uvs: number[] = [], indices: number[] = [];
  for (let j = 0; j <= rows; j++) {
    for (let i = 0; i <= columns; i++) {
      const s = i / columns, t = j / rows;
      positions.push(...position(s, t));
      normals.push(...normal(s, t));
      uvs.push(s, t);
    }
  }
  const apart = (a: number, b: number): boolean =>
    Math.hypot(...[0, 1, 2].map((k) => (positions[3 * a + k] ?? 0) - (positions[3 * b + k] ?? 0))) > 1e-6;
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++) {
      const a = j * (columns + 1) + i, b = a + 1, d = a + columns + 1, c = d + 1;
      for (const [p, q, r] of [[a, b, c], [a, c, d]] as [number, number, number][])
        // At the poles one half of each cell is a line.
        if (apart(p, q) && apart(q, r) && apart(r, p)) indices.push(p, q, r);
    }
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new Float32BufferAttribute(normals, 3));
  geometry.setAttribute("uv", new Float32BufferAttribute(uvs, 2));
  geometry.setIndex(indices);
  geometry.computeTangents();
  return geometry;
}

function sphere(s: number, t: number): Vector {
  const longitude = 2 * Math.PI * (s - 0.5), latitude = Math.PI * (t - 0.5);
  return [Math.cos(latitude) * Math.sin(longitude), Math.sin(latitude), Math.cos(latitude) * Math.cos(longitude)];
}

const TILT = -0.6;

function tipped([x, y, z]: Vector): Vector {
  const sin = Math.sin(TILT), cos = Math.cos(TILT);
  return [x, cos * y - sin * z, sin * y + cos * z];
}

function torusNormal(s: number, t: number): Vector {
  const a = 2 * Math.PI * s, b = 2 * Math.PI * t;
  return tipped([Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)]);
}

function torus(s: number, t: number): Vector {
  const center = tipped([0.7 * Math.cos(2 * Math.PI * s), 0.7 * Math.sin(2 * Math.PI * s), 0]);
  const normal = torusNormal(s, t);
  return [0, 1, 2].map((k) => (center[k] ?? 0) + 0.3 * (normal[k] ?? 0)) as Vector;
}

/** Height of the cloth over (x, y) and its slopes. */
function folds(x: number, y: number): Vector {
  const a = 2.6 * x + 1.3 * y, b = 0.9 * x - 3.4 * y + 0.8;
  const da = 0.16 * Math.cos(a), db = 0.07 * Math.cos(b);
  return [0.16 * Math.sin(a) + 0.07 * Math.sin(b), 2.6 * da + 0.9 * db, 1.3 * da - 3.4 * db];
}

function cloth(s: number, t: number): Vector {
  const x = 2 * s - 1, y = 2 * t - 1;
  return [x, y, folds(x, y)[0]];
}

function clothNormal(s: number, t: number): Vector {
  const [, dx, dy] = folds(2 * s - 1, 2 * t - 1), length = Math.hypot(dx, dy, 1);
  return [-dx / length, -dy / length, 1 / length];
}
