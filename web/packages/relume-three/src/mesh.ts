import { BufferGeometry, Float32BufferAttribute, Uint32BufferAttribute } from "three";
import { FieldError } from "./field.js";
import { parseGlb } from "./glbMesh.js";
import { parseObj } from "./obj.js";
import { inflated } from "./png.js";

/** What is no OBJ file for certain: its first bytes, and its name. */
const OTHERS: [start: RegExp, name: string][] = [
  [/^\s*\{/, "text glTF (.gltf)"], [/^ply/, "PLY"], [/^solid /, "STL"], [/^(Kaydara FBX|; FBX)/, "FBX"], [/^BLENDER/, "a Blender file"],
  [/^(PXR-USDC|#usda)/, "USD"], [/^PK\x03\x04/, "an archive"], [/^\s*</, "XML"],
];

/**
 * The mesh of a `.glb` or `.obj` file, with normals and tangents as the library computes them. It needs texture
 * coordinates: any choice of them would be a guess.
 */
export function readMesh(bytes: Uint8Array): BufferGeometry {
  const text = new TextDecoder().decode(bytes);
  if (text.startsWith("glTF")) return parseGlb(bytes).geometry();
  const other = OTHERS.find(([start]) => start.test(text.slice(0, 4096)));
  if (other) throw new FieldError(`${other[1]} is not read: export the mesh as binary glTF (.glb) or OBJ`);
  if (bytes.includes(0)) throw new FieldError("the file is no mesh: it is neither binary glTF, which begins with the letters glTF, nor OBJ, which is text");
  return parseObj(text).geometry();
}

/** Numbers of a vertex: position, normal, tangent with its sign, texture coordinates. */
const ATTRIBUTES: [name: string, size: number][] = [["position", 3], ["normal", 3], ["tangent", 4], ["uv", 2]];

/** Of about ten million vertices. */
const MOST_BYTES = 1 << 29;

/** A mesh that `relume share --mesh` wrote (docs/formats.md). */
export async function loadMesh(bytes: Uint8Array): Promise<BufferGeometry> {
  const raw = await inflated([bytes], "gzip", MOST_BYTES);
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
