import type { Material } from "three";
import { FieldError } from "./field.js";
import { chunksOf } from "./glb.js";
import { ReflectanceMaterial } from "./material.js";
import { type FileSource, loadShare } from "./share.js";
import { ReflectanceTexture } from "./texture.js";

/** The extension of glTF materials that carries functions of light (docs/formats.md). */
export const REFLECTANCE_EXTENSION = "RELUME_reflectance";

/** What of three.js's GLTFParser is used. */
export interface GltfParser {
  json: { materials?: { name?: string; extensions?: Record<string, unknown> }[] };
  getDependency(type: "bufferView", index: number): Promise<ArrayBuffer>;
}

interface ReflectanceExtension {
  share: object;
  files: Record<string, number>;
}

/**
 * A plugin for three.js's GLTFLoader that makes a `ReflectanceMaterial` of every material with functions of light:
 * `new GLTFLoader().register((parser) => new ReflectanceGltf(parser))`.
 */
export class ReflectanceGltf {
  readonly name = REFLECTANCE_EXTENSION;

  constructor(private readonly parser: GltfParser, private readonly anisotropy = 8) {}

  loadMaterial(index: number): Promise<Material> | null {
    const definition = this.parser.json.materials?.[index], extension = definition?.extensions?.[this.name];
    return extension === undefined ? null : this.load(extension as ReflectanceExtension, definition?.name ?? "");
  }

  private async load(extension: ReflectanceExtension, name: string): Promise<Material> {
    const bytes = async (view: number): Promise<Uint8Array> => new Uint8Array(await this.parser.getDependency("bufferView", view));
    const texture = new ReflectanceTexture(await loadShare(sourceOf(extension, bytes)), this.anisotropy);
    const material = new ReflectanceMaterial(texture);
    material.name = name;
    // The second texture coordinate of glTF runs down.
    material.setTiling(1, -1, 0, 1);
    return material;
  }
}

/** The files of the functions of a material in a binary glTF file (`.glb`), for `loadShare`. */
export function glbSource(glb: Uint8Array, material = 0): FileSource {
  const { json, binary } = chunksOf(glb);
  const extension = json.materials?.[material]?.extensions?.[REFLECTANCE_EXTENSION];
  if (extension === undefined) throw new FieldError(`material ${material} of the glTF file has no functions of light (${REFLECTANCE_EXTENSION})`);
  return sourceOf(extension as ReflectanceExtension, async (index) => {
    const view = json.bufferViews?.[index], start = view?.byteOffset ?? 0;
    if (!view || start + view.byteLength > binary.length) throw new FieldError(`the glTF file has no buffer view ${index}`);
    return binary.subarray(start, start + view.byteLength);
  });
}

function sourceOf({ share, files }: ReflectanceExtension, bytes: (view: number) => Promise<Uint8Array>): FileSource {
  return async (name) => {
    if (name === "share.json") return new TextEncoder().encode(JSON.stringify(share));
    const view = Object.hasOwn(files ?? {}, name) ? files[name] : undefined;
    if (view === undefined) throw new FieldError(`${name} is missing`);
    return bytes(view);
  };
}
