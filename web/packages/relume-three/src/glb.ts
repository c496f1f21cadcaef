import { FieldError } from "./field.js";

/** What is read of the JSON of a file (glTF 2.0). */
export interface GltfJson {
  scene?: number;
  scenes?: { nodes?: number[] }[];
  nodes?: GltfNode[];
  meshes?: { primitives: GltfPrimitive[] }[];
  accessors?: GltfAccessor[];
  bufferViews?: { buffer?: number; byteOffset?: number; byteLength: number; byteStride?: number }[];
  buffers?: { uri?: string }[];
  materials?: { name?: string; extensions?: Record<string, unknown> }[];
  extensionsRequired?: string[];
}

export interface GltfNode {
  mesh?: number;
  children?: number[];
  matrix?: number[];
  translation?: [number, number, number];
  rotation?: [number, number, number, number];
  scale?: [number, number, number];
}

export interface GltfPrimitive {
  attributes: Record<string, number>;
  indices?: number;
  mode?: number;
}

export interface GltfAccessor {
  bufferView?: number;
  byteOffset?: number;
  componentType: number;
  normalized?: boolean;
  count: number;
  type: string;
  sparse?: unknown;
}

/** The JSON and the binary chunk of a file (glTF 2.0, section 4.4). */
export function chunksOf(glb: Uint8Array): { json: GltfJson; binary: Uint8Array } {
  const view = new DataView(glb.buffer, glb.byteOffset, glb.byteLength);
  if (glb.length < 4 || view.getUint32(0, true) !== 0x46546c67) throw new FieldError("the file is not binary glTF");
  if (glb.length < 20) throw new FieldError(`the glTF file ends after ${glb.length} bytes, before its content`);
  if (view.getUint32(4, true) !== 2) throw new FieldError(`glTF ${view.getUint32(4, true)} is not read: export the mesh as binary glTF 2.0`);
  const chunks = new Map<number, Uint8Array>();
  for (let at = 12; at + 8 <= glb.length; ) {
    const length = view.getUint32(at, true);
    if (at + 8 + length > glb.length) throw new FieldError("the glTF file ends early");
    chunks.set(view.getUint32(at + 4, true), glb.subarray(at + 8, at + 8 + length));
    at += 8 + length;
  }
  try {
    const json = JSON.parse(new TextDecoder().decode(chunks.get(0x4e4f534a))) as GltfJson;
    return { json, binary: chunks.get(0x004e4942) ?? new Uint8Array() };
  } catch {
    throw new FieldError("the JSON of the glTF file is damaged");
  }
}
