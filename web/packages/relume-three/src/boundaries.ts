import { DataArrayTexture, LinearFilter, LinearMipmapLinearFilter, RGBAFormat, RepeatWrapping, type Texture } from "three";
import { FieldError } from "./field.js";
import type { ShareShapes } from "./header.js";

/** Numbers of a channel: the contrasts of shadows and of highlights, each as a polynomial of 1, x, y and z. */
const CONTRASTS = 8;

/** Boundaries of shadows and highlights that move between the lights (the library's field/shapes). */
export class FieldBoundaries {
  /** Of shadows and then of highlights the distances of each light, a plane each: 128 is the boundary. */
  readonly distances: Uint8Array;
  /** Half floats, plane after plane: for each channel those of shadows and those of highlights. */
  readonly contrasts: Uint16Array;

  constructor(readonly header: ShareShapes, readonly lights: number, readonly channels: number, texels: number, raw: Uint8Array) {
    const codes = 2 * lights * texels, bytes = FieldBoundaries.bytes(lights, channels, texels);
    if (raw.length !== bytes) throw new FieldError(`${header.file} has ${raw.length} bytes: expected ${bytes}`);
    this.distances = raw.subarray(0, codes);
    this.contrasts = new Uint16Array(raw.slice(codes).buffer);
  }

  /** The length of the file. */
  static bytes(lights: number, channels: number, texels: number): number {
    return 2 * lights * texels + 2 * CONTRASTS * channels * texels;
  }
}

/** Four distances a texel: layers of shadows, then as many of highlights. */
export function distanceLayers({ distances, lights }: FieldBoundaries): Uint8Array[] {
  const texels = distances.length / (2 * lights), groups = Math.ceil(lights / 4);
  return Array.from({ length: 2 * groups }, (_, layer) => {
    const first = Math.floor(layer / groups) * lights, from = 4 * (layer % groups), out = new Uint8Array(4 * texels).fill(128);
    for (let j = 0; j < 4 && from + j < lights; j++) {
      const plane = distances.subarray((first + from + j) * texels, (first + from + j + 1) * texels);
      for (let i = 0; i < texels; i++) out[4 * i + j] = plane[i] ?? 128;
    }
    return out;
  });
}

/** The four terms of a contrast a texel: for each channel a layer of shadows and one of highlights. */
export function contrastLayers({ contrasts, channels }: FieldBoundaries): Uint16Array[] {
  const layers = 2 * channels, texels = contrasts.length / (4 * layers);
  return Array.from({ length: layers }, (_, layer) => {
    const out = new Uint16Array(4 * texels);
    for (let j = 0; j < 4; j++) for (let i = 0; i < texels; i++) out[4 * i + j] = contrasts[(4 * layer + j) * texels + i] ?? 0;
    return out;
  });
}

/** The distances on the graphics card. */
export function distanceTexture(boundaries: FieldBoundaries, width: number, height: number, anisotropy: number): Texture {
  const layers = distanceLayers(boundaries), whole = new Uint8Array(4 * width * height * layers.length);
  layers.forEach((layer, k) => whole.set(layer, k * layer.length));
  const texture = new DataArrayTexture(whole, width, height, layers.length);
  texture.format = RGBAFormat;
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.magFilter = LinearFilter;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = anisotropy;
  texture.needsUpdate = true;
  return texture;
}

/** In GLSL: what moved boundaries add to the linear value, as the library's `ShapeLookup::corrections`. */
export const BOUNDARIES_GLSL = `
#if SHAPES
uniform sampler2DArray distances, contrasts;
uniform vec2 shapeStrengths, shapeSteps, shapeMost;
uniform float shapeSoftness;
vec4 insideOf(vec4 distance, float softness) { return 0.5 + 0.5 * distance * inversesqrt(distance * distance + softness * softness); }
vec4 ofBoundary(sampler2DArray source, int k) { return blurBy > 0.0 ? blurredBy(source, k, blurBy) : sampled(source, k); }
// Of a patch of several texels a boundary covers a part: there the step is as wide as the patch.
vec3 movedBoundaries(vec3 light) {
  float wider = 0.5 * (exp2(blurBy > 0.0 ? level + blurBy : footprint) - 1.0), softness = sqrt(shapeSoftness * shapeSoftness + wider * wider);
  vec3 sum = vec3(0.0);
  for (int kind = 0; kind < 2; kind++) {
    float mixed = 0.0, linear = 0.0;
    for (int g = 0; g < GROUPS; g++) {
      vec4 w = weightGroup(0, g), distance = (ofBoundary(distances, kind * GROUPS + g) * 255.0 - 128.0) / shapeSteps[kind];
      mixed += dot(w, distance);
      linear += dot(w, insideOf(distance, softness));
    }
    float moved = insideOf(vec4(mixed), softness).x - linear;
    for (int c = 0; c < SHAPES; c++) {
      float contrast = clamp(dot(ofBoundary(contrasts, 2 * c + kind), vec4(1.0, light)), 0.0, shapeMost[kind]);
      sum[c] += shapeStrengths[kind] * moved * contrast;
    }
  }
  return SHAPES == 1 ? sum.xxx : sum;
}
#endif`;
