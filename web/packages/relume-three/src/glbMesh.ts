import { Matrix3, Matrix4, Quaternion, Vector3 } from "three";
import { FieldError } from "./field.js";
import { type GltfAccessor, type GltfJson, type GltfNode, type GltfPrimitive, chunksOf } from "./glb.js";
import { Triangles } from "./triangles.js";

/** The deepest nesting of nodes, and the most in all: more is a loop or an attack. */
const MOST_DEPTH = 64, MOST_NODES = 100_000;
/** Extensions that concern looks alone, which the texture replaces, and quantised numbers. */
const KNOWN = /^(KHR_mesh_quantization$|KHR_materials_|KHR_texture_|EXT_texture_|MSFT_texture_|KHR_lights_|KHR_xmp|RELUME_)/;

type NumberReader = (view: DataView, at: number) => number;

/** Component types: bytes, the largest number, how they are read. */
const COMPONENTS: Record<number, [bytes: number, largest: number, read: NumberReader]> = {
  5120: [1, 127, (view, at) => view.getInt8(at)],
  5121: [1, 255, (view, at) => view.getUint8(at)],
  5122: [2, 32767, (view, at) => view.getInt16(at, true)],
  5123: [2, 65535, (view, at) => view.getUint16(at, true)],
  5125: [4, 1, (view, at) => view.getUint32(at, true)],
  5126: [4, 1, (view, at) => view.getFloat32(at, true)],
};
const SIZES: Record<string, number> = { SCALAR: 1, VEC2: 2, VEC3: 3 };

/** The triangles of the default scene of a binary glTF file, placed by its nodes. */
export function parseGlb(bytes: Uint8Array): Triangles {
  const { json, binary } = chunksOf(bytes), unknown = json.extensionsRequired?.find((name) => !KNOWN.test(name));
  if (unknown !== undefined) throw new FieldError(`the mesh needs ${unknown}, which is not read: export it without compression and extensions`);
  const reader = new GlbReader(json, binary);
  const scene = json.scenes?.[json.scene ?? 0];
  if (!scene) throw new FieldError("the glTF file has no scene");
  for (const node of scene.nodes ?? []) reader.node(node, new Matrix4(), 0);
  return reader.out;
}

class GlbReader {
  readonly out = new Triangles();
  private nodes = 0;

  constructor(private readonly json: GltfJson, private readonly binary: Uint8Array) {}

  node(index: number, parent: Matrix4, depth: number): void {
    const node = this.json.nodes?.[index];
    if (!node) throw new FieldError(`the glTF file has no node ${index}`);
    if (depth > MOST_DEPTH || ++this.nodes > MOST_NODES) throw new FieldError(`the glTF scene has more than ${MOST_NODES} nodes, or more than ${MOST_DEPTH} below one another`);
    const world = parent.clone().multiply(transformOf(node));
    for (const primitive of (node.mesh === undefined ? undefined : this.json.meshes?.[node.mesh])?.primitives ?? []) this.primitive(primitive, world);
    for (const child of node.children ?? []) this.node(child, world, depth + 1);
  }

  private primitive({ attributes, indices, mode = 4 }: GltfPrimitive, world: Matrix4): void {
    if (mode < 4) throw new FieldError("points and lines of the glTF file are not read: expected triangles");
    if (attributes["TEXCOORD_0"] === undefined) throw new FieldError("a part of the mesh has no texture coordinates: unwrap it before exporting it");
    const positions = this.numbers(attributes["POSITION"], "VEC3"), texcoords = this.numbers(attributes["TEXCOORD_0"], "VEC2"), count = positions.length / 3;
    const normals = attributes["NORMAL"] === undefined ? new Float64Array(3 * count) : this.numbers(attributes["NORMAL"], "VEC3");
    if (texcoords.length !== 2 * count || normals.length !== 3 * count) throw new FieldError("positions, normals and texture coordinates of the mesh differ in number");
    const corners = indices === undefined ? Float64Array.from({ length: count }, (_, i) => i) : this.numbers(indices, "SCALAR");
    if (corners.some((vertex) => vertex >= count)) throw new FieldError(`a triangle refers to a vertex beyond the ${count} that there are`);
    const { out } = this, first = out.positions.length / 3, turn = new Matrix3().getNormalMatrix(world), v = new Vector3();
    for (let i = 0; i < count; i++) {
      out.positions.push(...v.fromArray(positions, 3 * i).applyMatrix4(world).toArray());
      out.normals.push(...v.fromArray(normals, 3 * i).applyMatrix3(turn).toArray());
      // glTF counts from the top.
      out.texcoords.push(texcoords[2 * i] ?? 0, 1 - (texcoords[2 * i + 1] ?? 0));
    }
    for (const triangle of trianglesOf(mode, corners.length)) for (const i of triangle) out.indices.push(first + (corners[i] ?? 0));
  }

  private numbers(index: number | undefined, type: string): Float64Array {
    const accessor = this.json.accessors?.[index ?? -1], view = this.json.bufferViews?.[accessor?.bufferView ?? -1];
    const [bytes = 0, largest = 1, read] = COMPONENTS[accessor?.componentType ?? 0] ?? [];
    if (!accessor || !view || !read || accessor.type !== type || accessor.sparse) throw new FieldError(`accessor ${index} of the glTF file is missing, sparse or of another type than ${type}`);
    if ((view.buffer ?? 0) !== 0 || this.json.buffers?.[0]?.uri !== undefined) throw new FieldError("the glTF file has buffers outside of itself: export it as one .glb");
    const size = SIZES[type] ?? 1, step = view.byteStride ?? size * bytes, start = (view.byteOffset ?? 0) + (accessor.byteOffset ?? 0);
    if (!isWithin(accessor, start + (accessor.count - 1) * step + size * bytes, this.binary.length)) throw new FieldError(`accessor ${index} of the glTF file reaches beyond its bytes`);
    const data = new DataView(this.binary.buffer, this.binary.byteOffset, this.binary.byteLength), scale = accessor.normalized ? 1 / largest : 1;
    return Float64Array.from({ length: size * accessor.count }, (_, i) => Math.max(read(data, start + Math.floor(i / size) * step + (i % size) * bytes) * scale, accessor.normalized ? -1 : -Infinity));
  }
}

function isWithin({ count }: GltfAccessor, end: number, length: number): boolean {
  return Number.isInteger(count) && count >= 1 && Number.isInteger(end) && end >= 0 && end <= length;
}

function transformOf({ matrix, translation, rotation, scale }: GltfNode): Matrix4 {
  if (matrix?.length === 16) return new Matrix4().fromArray(matrix);
  return new Matrix4().compose(new Vector3(...(translation ?? [0, 0, 0])), new Quaternion(...(rotation ?? [0, 0, 0, 1])), new Vector3(...(scale ?? [1, 1, 1])));
}

/** The corners of triangles, strips (5) or fans (6). */
function trianglesOf(mode: number, corners: number): [number, number, number][] {
  if (mode === 4) return Array.from({ length: Math.floor(corners / 3) }, (_, t) => [3 * t, 3 * t + 1, 3 * t + 2]);
  return Array.from({ length: Math.max(0, corners - 2) }, (_, t) => (mode === 6 ? [t + 1, t + 2, 0] : [t, t + 1 + (t % 2), t + 2 - (t % 2)]));
}
