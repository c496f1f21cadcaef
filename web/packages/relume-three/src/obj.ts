import { ShapeUtils, Vector2 } from "three";
import { FieldError } from "./field.js";
import { Triangles } from "./triangles.js";

/** Wavefront OBJ: vertices, texture coordinates, normals and polygons; all else is passed over. */
export function parseObj(text: string): Triangles {
  const lists: Record<string, number[][]> = { v: [], vt: [], vn: [] }, made = new Map<string, number>(), out = new Triangles();
  text.replace(/\\\r?\n/g, " ").split(/\r?\n/).forEach((line, i) => {
    const [word = "", ...rest] = line.replace(/(^|\s)#.*$/, "").trim().split(/\s+/), list = lists[word];
    try {
      if (list) list.push(numbers(word, rest));
      else if (word === "f" || word === "fo") addFace(rest.map((corner) => vertexOf(corner, lists, made, out)), out);
    } catch (error) {
      throw new FieldError(`line ${i + 1}: ${(error as Error).message}`);
    }
  });
  if (lists["v"]?.length === 0) throw new FieldError("the file is neither binary glTF nor OBJ: no line of it gives a vertex (`v x y z`)");
  return out;
}

function numbers(word: string, rest: string[]): number[] {
  const size = word === "vt" ? 2 : 3, values = rest.slice(0, size).map(Number);
  if (word === "vt" && values.length === 1) values.push(0);
  if (values.length < size || !values.every(Number.isFinite)) throw new FieldError(`'${word}' needs ${size} numbers`);
  return values;
}

/** The vertex of a corner such as `3/1/2`; corners with the same indices share one. */
function vertexOf(corner: string, { v = [], vt = [], vn = [] }: Record<string, number[][]>, made: Map<string, number>, out: Triangles): number {
  const known = made.get(corner);
  // Indices from the end mean another vertex with every line.
  if (known !== undefined && !corner.includes("-")) return known;
  const [p, t, n] = corner.split("/"), position = entry("vertex", p, v), texcoord = entry("texture coordinate", t, vt), normal = entry("normal", n, vn);
  if (!position) throw new FieldError(`the corner '${corner}' names no vertex`);
  if (!texcoord) throw new FieldError(`the corner '${corner}' has no texture coordinate: unwrap the mesh before exporting it`);
  const vertex = out.positions.length / 3;
  out.positions.push(...position);
  out.texcoords.push(...texcoord);
  out.normals.push(...(normal ?? [0, 0, 0]));
  made.set(corner, vertex);
  return vertex;
}

/** What a field of a corner names: from 1 on, or from the end. */
function entry(what: string, field: string | undefined, list: number[][]): number[] | null {
  if (!field) return null;
  const number = Number(field), found = Number.isInteger(number) ? list[number > 0 ? number - 1 : list.length + number] : undefined;
  if (!found || number === 0) throw new FieldError(`a face refers to ${what} ${field}, but there are ${list.length} so far`);
  return found;
}

/** A polygon as a fan, or where it is not convex by its ears. */
function addFace(corners: number[], out: Triangles): void {
  if (corners.length < 3) throw new FieldError(`a face needs at least 3 corners, found ${corners.length}`);
  const points = corners.length > 3 ? flattened(corners, out.positions) : [];
  const fan = corners.slice(2).map((_, i) => [0, i + 1, i + 2]), area = ([a = 0, b = 0, c = 0]: number[]): number => cross(points[a], points[b], points[c]);
  const isFan = corners.length === 3 || fan.every((triangle) => area(triangle) >= 0);
  for (const triangle of isFan ? fan : ShapeUtils.triangulateShape(points, [])) {
    const turned = !isFan && area(triangle) < 0 ? [...triangle].reverse() : triangle;
    out.indices.push(...turned.map((i) => corners[i] ?? 0));
  }
}

function cross(a = new Vector2(), b = new Vector2(), c = new Vector2()): number {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/** The corners in the plane of their Newell normal, counter-clockwise. */
function flattened(corners: number[], positions: number[]): Vector2[] {
  const at = (i: number, axis: number): number => positions[3 * (corners[i % corners.length] ?? 0) + axis] ?? 0;
  const shadow = (a: number, b: number): number => corners.reduce((sum, _, i) => sum + (at(i, a) - at(i + 1, a)) * (at(i, b) + at(i + 1, b)), 0);
  const normal = [shadow(1, 2), shadow(2, 0), shadow(0, 1)], sizes = normal.map(Math.abs), axis = sizes.indexOf(Math.max(...sizes));
  const [a, b] = [(axis + 1) % 3, (axis + 2) % 3], isTurned = (normal[axis] ?? 0) < 0;
  return corners.map((_, i) => (isTurned ? new Vector2(at(i, b), at(i, a)) : new Vector2(at(i, a), at(i, b))));
}
