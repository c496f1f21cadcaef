import { BufferGeometry, Float32BufferAttribute, Uint32BufferAttribute, Vector3 } from "three";
import { FieldError } from "./field.js";

/** Smaller objects are nothing that cameras can be placed around. */
const LEAST_EXTENT = 1e-6;

/** Vertices and triangles of a file; texture coordinates have their origin at the bottom left. */
export class Triangles {
  /** Three, three and two numbers a vertex; normals of zero length are computed. */
  readonly positions: number[] = [];
  readonly normals: number[] = [];
  readonly texcoords: number[] = [];
  readonly indices: number[] = [];

  /** With normals, and tangents that keep mirrored halves of the texture apart, as the library's render/mesh. */
  geometry(): BufferGeometry {
    const { positions, texcoords, indices } = this, vertices = positions.length / 3;
    if (indices.length === 0) throw new FieldError("the mesh has no triangles");
    if (![...[positions, texcoords]].every((list) => list.every((v) => Math.abs(v) < 1e18))) throw new FieldError("a position or texture coordinate of the mesh is not a number below 1e18");
    if (this.extent() < LEAST_EXTENT) throw new FieldError(`all points of the mesh lie within ${LEAST_EXTENT} of one another: export the mesh in other units`);
    const normals = this.unitNormals();
    const corners: Corners = { positions: [], normals: [], texcoords: [], tangents: [], indices: [] }, made = new Map<number, number>();
    const sums = this.tangentSums(normals);
    for (let t = 0; t < indices.length; t += 3) {
      const sign = this.handedness(t);
      for (const vertex of indices.slice(t, t + 3)) {
        const key = sign > 0 ? vertex : vertices + vertex;
        let at = made.get(key);
        if (at === undefined) {
          made.set(key, (at = made.size));
          corners.positions.push(...positions.slice(3 * vertex, 3 * vertex + 3));
          corners.normals.push(...normals.slice(3 * vertex, 3 * vertex + 3));
          corners.texcoords.push(...texcoords.slice(2 * vertex, 2 * vertex + 2));
          corners.tangents.push(...sums.slice(3 * key, 3 * key + 3), sign);
        }
        corners.indices.push(at);
      }
    }
    return geometryOf(corners);
  }

  /** The longest side of the box around all points. */
  private extent(): number {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    this.positions.forEach((v, i) => {
      low[i % 3] = Math.min(low[i % 3] ?? v, v);
      high[i % 3] = Math.max(high[i % 3] ?? v, v);
    });
    return Math.max(...low.map((v, i) => (high[i] ?? v) - v));
  }

  private at(vertex: number): Vector3 {
    return new Vector3().fromArray(this.positions, 3 * vertex);
  }

  /** The normals of the file, or the sums of the area vectors around a vertex. */
  private unitNormals(): number[] {
    const { indices } = this, sums = new Array<number>(this.positions.length).fill(0);
    for (let t = 0; t < indices.length; t += 3) {
      const [i = 0, j = 0, k = 0] = indices.slice(t, t + 3), a = this.at(i);
      const area = this.at(j).sub(a).cross(this.at(k).sub(a)).toArray();
      for (const vertex of [i, j, k]) area.forEach((v, c) => (sums[3 * vertex + c] = (sums[3 * vertex + c] ?? 0) + v));
    }
    const unit = (list: number[], from: number): number[] | null => {
      const v = list.slice(from, from + 3), size = Math.hypot(...v);
      return Number.isFinite(size) && size > 1e-30 ? v.map((n) => n / size) : null;
    };
    const out: number[] = [];
    for (let from = 0; from < sums.length; from += 3) out.push(...(unit(this.normals, from) ?? unit(sums, from) ?? [0, 0, 1]));
    return out;
  }

  /** The differences of the texture coordinates of a triangle, and twice its area among them. */
  private spans(t: number): { s1: number; t1: number; s2: number; t2: number; area: number } {
    const [i = 0, j = 0, k = 0] = this.indices.slice(t, t + 3), uv = this.texcoords;
    const s = (n: number): number => (uv[2 * n] ?? 0) - (uv[2 * i] ?? 0), v = (n: number): number => (uv[2 * n + 1] ?? 0) - (uv[2 * i + 1] ?? 0);
    const [s1, t1, s2, t2] = [s(j), v(j), s(k), v(k)];
    return { s1, t1, s2, t2, area: s1 * t2 - s2 * t1 };
  }

  /** -1 where a triangle shows the texture mirrored. */
  private handedness(t: number): number {
    return this.spans(t).area < 0 ? -1 : 1;
  }

  /** For each vertex dP/ds in plain triangles, then in mirrored ones, weighted by the angles of the corners. */
  private tangentSums(normals: number[]): number[] {
    const { indices, positions } = this, sums = new Array<number>(2 * positions.length).fill(0);
    for (let t = 0; t < indices.length; t += 3) {
      const corners = indices.slice(t, t + 3), points = corners.map((vertex) => this.at(vertex)) as [Vector3, Vector3, Vector3];
      const { t1, t2, area } = this.spans(t);
      if (area === 0) continue;
      const [a, b, c] = points, along = b.clone().sub(a).multiplyScalar(t2).sub(c.clone().sub(a).multiplyScalar(t1)).multiplyScalar(Math.sign(area));
      corners.forEach((vertex, k) => {
        const normal = new Vector3().fromArray(normals, 3 * vertex), flat = along.clone().addScaledVector(normal, -normal.dot(along)).normalize();
        const side = (other: number): Vector3 => (points[other % 3] ?? a).clone().sub(points[k] ?? a);
        const from = 3 * (area < 0 ? positions.length / 3 + vertex : vertex);
        flat.multiplyScalar(side(k + 1).angleTo(side(k + 2))).toArray().forEach((v, i) => (sums[from + i] = (sums[from + i] ?? 0) + v));
      });
    }
    return sums;
  }
}

interface Corners {
  positions: number[];
  normals: number[];
  texcoords: number[];
  tangents: number[];
  indices: number[];
}

function geometryOf({ positions, normals, texcoords, tangents, indices }: Corners): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new Float32BufferAttribute(normals, 3));
  geometry.setAttribute("uv", new Float32BufferAttribute(texcoords, 2));
  geometry.setAttribute("tangent", new Float32BufferAttribute(tangents, 4));
  geometry.setIndex(new Uint32BufferAttribute(indices, 1));
  return geometry;
}
