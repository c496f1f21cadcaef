import { BufferGeometry, Float32BufferAttribute, Uint32BufferAttribute } from "three";
import { FieldError } from "./field.js";
import { inflated } from "./png.js";

/** Numbers of a vertex: position, normal, tangent with its sign, texture coordinates. */
const ATTRIBUTES: [name: string, size: number][] = [["position", 3], ["normal", 3], ["tangent", 4], ["uv", 2]];

/** A mesh that `relume share --mesh` wrote (docs/formats.md). */
export async function loadMesh(bytes: Uint8Array): Promise<BufferGeometry> {
  const raw = await inflated([bytes], "gzip");
  const [vertices, triangles] = raw.length < 8 ? [0, 0] : new Uint32Array(raw.buffer, raw.byteOffset, 2);
  if (!vertices || !triangles || raw.length !== 8 + 48 * vertices + 12 * triangles) throw new FieldError("the mesh is damaged: write the page anew");
  const geometry = new BufferGeometry();
  let at = raw.byteOffset + 8;
  for (const [name, size] of ATTRIBUTES) {
    geometry.setAttribute(name, new Float32BufferAttribute(new Float32Array(raw.buffer, at, size * vertices), size));
    at += 4 * size * vertices;
  }
  const indices = new Uint32Array(raw.buffer, at, 3 * triangles);
  if (indices.some((index) => index >= vertices)) throw new FieldError("a triangle of the mesh has a vertex that is missing: write the page anew");
  geometry.setIndex(new Uint32BufferAttribute(indices, 1));
  return geometry;
}
