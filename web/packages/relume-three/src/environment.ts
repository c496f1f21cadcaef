import { type DataArrayTexture, DataTexture, FloatType, RGBAFormat } from "three";
import { FieldError } from "./field.js";
import { fromHalf, halfLayers, halvesFrom } from "./half.js";
import type { ShareEnvironment } from "./header.js";

/** Light from all around as lamps of each normal (the library's render/environment/nodes.rs). */
export class EnvironmentLamps {
  /** Unit vectors in the frame of a normal, and in that of the flat texture. */
  readonly nodes: Float32Array;
  readonly flatNodes: Float32Array;
  readonly flatLight: Float32Array;
  /** For both halves of the sphere, for each lamp, row after row: red, green, blue and 1. */
  readonly light: Uint16Array;

  constructor(readonly header: ShareEnvironment, raw: Uint8Array) {
    const { nodes, functions, side, scale } = header;
    const floats = nodes * (9 + functions), halves = 6 * functions * side * side;
    if (raw.length !== 4 * floats + 2 * halves) throw new FieldError(`${header.file} has another length than its header says`);
    const numbers = new Float32Array(raw.buffer, raw.byteOffset, floats);
    let at = 0;
    const next = (count: number): Float32Array => numbers.subarray(at, (at += count));
    this.nodes = next(3 * nodes);
    const factors = next(functions * nodes);
    this.flatNodes = next(3 * nodes);
    this.flatLight = next(3 * nodes);
    const moments = Float32Array.from(new Uint16Array(raw.buffer, raw.byteOffset + 4 * floats, halves), fromHalf);
    this.light = halvesFrom(lamps(moments, factors, functions, side * side, scale));
  }
}

/** The light of each lamp at each normal: the factors times the moments. */
function lamps(moments: Float32Array, factors: Float32Array, functions: number, normals: number, scale: number): Float32Array {
  const nodes = factors.length / functions, light = new Float32Array(2 * nodes * normals * 4).fill(1);
  for (let half = 0; half < 2; half++)
    for (let node = 0; node < nodes; node++) {
      const to = (half * nodes + node) * normals * 4;
      for (let c = 0; c < 3; c++)
        for (let i = 0; i < normals; i++) {
          let sum = 0;
          for (let p = 0; p < functions; p++) sum += (factors[node * functions + p] ?? 0) * (moments[((half * functions + p) * normals + i) * 3 + c] ?? 0);
          light[to + 4 * i + c] = sum * scale;
        }
    }
  return light;
}

/** The light of the lamps: a layer for each, of the upper half and then of the lower one. */
export function lampLightTexture({ light, header }: EnvironmentLamps): DataArrayTexture {
  return halfLayers(light, header.side, header.side, 2 * header.nodes);
}

/** Rows: the directions of the lamps, those of the flat texture, and their light. */
export function lampNodeTexture({ nodes, flatNodes, flatLight, header }: EnvironmentLamps): DataTexture {
  const rows = [nodes, flatNodes, flatLight], values = new Float32Array(4 * rows.length * header.nodes);
  rows.forEach((row, y) => row.forEach((value, i) => (values[4 * (y * header.nodes + Math.floor(i / 3)) + (i % 3)] = value)));
  const texture = new DataTexture(values, header.nodes, rows.length, RGBAFormat, FloatType);
  texture.needsUpdate = true;
  return texture;
}

/** In GLSL: every lamp lights the texture as a light at infinity does. */
export const ENVIRONMENT_GLSL = `
#if AMBIENT
uniform float environment;
uniform mat3 environmentTurn;
uniform bool environmentTurned;
uniform sampler2DArray environmentLight;
uniform sampler2D environmentNodes;
vec3 underEnvironment(vec3 v, vec3 n) {
  bool plain = flat_ && !environmentTurned;
  vec3 z = environmentTurn * tangentZ, pole = vec3(0.0, 0.0, z.z < 0.0 ? -1.0 : 1.0);
  vec3 x = vec3(1.0, 0.0, 0.0) - (z + pole) * (z.x / (1.0 + abs(z.z)));
  // From the frame of the normal to that of the texture.
  mat3 world = transpose(environmentTurn) * mat3(x, cross(z, x), z);
  mat3 frame = mat3(inFrame(world[0]), inFrame(world[1]), inFrame(world[2]));
  float side = float(textureSize(environmentLight, 0).x), first = z.z < 0.0 ? float(NODES) : 0.0;
  vec2 at = vec2(z.x + z.y, z.x - z.y) / (abs(z.x) + abs(z.y) + abs(z.z));
  at = ((0.5 * at + 0.5) * (side - 1.0) + 0.5) / side;
  vec3 sum = vec3(0.0);
  for (int j = 0; j < NODES; j++) {
    vec3 light, l;
    if (plain) {
      l = texelFetch(environmentNodes, ivec2(j, 1), 0).xyz;
      light = texelFetch(environmentNodes, ivec2(j, 2), 0).rgb;
    } else {
      l = frame * texelFetch(environmentNodes, ivec2(j, 0), 0).xyz;
      light = textureLod(environmentLight, vec3(at, first + float(j)), 0.0).rgb;
    }
    sum += light * underLight(fromDisk(l.xy), v, n);
  }
  return environment * max(sum, 0.0);
}
#endif
`;
