import { DataArrayTexture, LinearFilter, LinearMipmapLinearFilter, RGBAFormat, RepeatWrapping, type Texture } from "three";
import { FieldError } from "./field.js";
import type { ShareShapes } from "./header.js";
import { unrolled } from "./unrolled.js";

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

/** Look-ups of distances and contrasts, at the place and around it. */
const BOUNDARY_LOOKUPS = `
uniform sampler2DArray distances, contrasts;
uniform vec2 shapeStrengths, shapeSteps, shapeMost;
uniform float shapeSoftness;
// EACH: a number for the place, and one for each level around it; PATCH: four of them.
#if MODE == MULTI_LIGHT
#define EACH vec4
#define PATCH mat4
#define FOR_EACH(F) F(0.0), F(FINE), F(MIDDLE), F(SOFT)
#define INSIDE_EACH(d) mat4(INSIDE(d[0], softness.x), INSIDE(d[1], softness.y), INSIDE(d[2], softness.z), INSIDE(d[3], softness.w))
#elif BLURS
#define EACH vec2
#define PATCH mat2x4
#define FOR_EACH(F) F(0.0), F(radius)
#define INSIDE_EACH(d) mat2x4(INSIDE(d[0], softness.x), INSIDE(d[1], softness.y))
#else
#define EACH float
#define PATCH vec4
#define FOR_EACH(F) F(0.0)
#define INSIDE_EACH(d) INSIDE(d, softness)
#endif
#define INSIDE(d, s) (0.5 + 0.5 * (d) * inversesqrt((d) * (d) + (s) * (s)))
EACH softness;
vec4 boundaryBy(sampler2DArray source, int k, float blur) {
#if ANISOTROPIC > 1
  if (blur == 0.0) return sampled(source, k);
#endif
  return blurredBy(source, k, blur);
}
// Of a patch of several texels a boundary covers a part: there the step is as wide as the patch.
float softnessBy(float blur) {
  float wider = 0.5 * (exp2(blur > 0.0 ? level + blur : footprint) - 1.0);
  return sqrt(shapeSoftness * shapeSoftness + wider * wider);
}
PATCH distancesOf(int k, float unit) {
#define DISTANCE(blur) (boundaryBy(distances, k, blur) * 255.0 - 128.0) / unit
  return PATCH(FOR_EACH(DISTANCE));
}
PATCH contrastsOf(int k) {
#define CONTRAST(blur) boundaryBy(contrasts, k, blur)
  return PATCH(FOR_EACH(CONTRAST));
}
#if BLURS
EACH mixOf(vec4 w, PATCH patches) { return w * patches; }
#else
EACH mixOf(vec4 w, PATCH patches) { return dot(w, patches); }
#endif`;

/**
 * In GLSL: what moved boundaries add to the linear value, as the library's `ShapeLookup::corrections`; and to the luminance around the
 * place, where that is asked for. What does not depend on the light is looked up once.
 */
export function boundariesGlsl({ lights, channels }: FieldBoundaries): string {
  const groups = Math.ceil(lights / 4), kinds = [0, 1], parts = kinds.flatMap((kind) => unrolledParts(kind, channels));
  return `${BOUNDARY_LOOKUPS}
PATCH distanceTo[${2 * groups}], insideOf[${2 * groups}], contrastOf[${2 * channels}];
void holdBoundaries() {
  softness = EACH(FOR_EACH(softnessBy));
  ${unrolled(2 * groups, (k) => `distanceTo[${k}] = distancesOf(${k}, shapeSteps[${k < groups ? 0 : 1}]); insideOf[${k}] = INSIDE_EACH(distanceTo[${k}]);`)}
  ${unrolled(2 * channels, (k) => `contrastOf[${k}] = contrastsOf(${k});`)}
}
void addMovedBoundaries(vec3 light, inout vec3 sum) {
  EACH mixed[2], linear[2], moved, added[3];
  mixed[0] = mixed[1] = linear[0] = linear[1] = added[0] = added[1] = added[2] = EACH(0.0);
  vec4 w, terms = vec4(1.0, light);
  ${unrolled(groups, (g) => `w = weightGroup(0, ${g}); ${kinds.map((kind) => `mixed[${kind}] += mixOf(w, distanceTo[${kind * groups + g}]); linear[${kind}] += mixOf(w, insideOf[${kind * groups + g}]);`).join(" ")}`)}
  ${parts.join("\n  ")}
#if BLURS
  sum += vec3(added[0].x, added[1].x, added[2].x);
  EACH brightness = LUMINANCE.x * added[0] + LUMINANCE.y * added[1] + LUMINANCE.z * added[2];
#if MODE == MULTI_LIGHT
  around += brightness.yzw;
#else
  around.x += brightness.y;
#endif
#else
  sum += vec3(added[0], added[1], added[2]);
#endif
}`;
}

/** How far the boundaries of a kind move, and what that adds to red, green and blue. */
function unrolledParts(kind: number, channels: number): string[] {
  const add = (c: number): string => `added[${c}] += shapeStrengths[${kind}] * moved * clamp(mixOf(terms, contrastOf[${2 * (channels === 1 ? 0 : c) + kind}]), 0.0, shapeMost[${kind}]);`;
  return [`moved = INSIDE(mixed[${kind}], softness) - linear[${kind}];`, ...[0, 1, 2].map(add)];
}
