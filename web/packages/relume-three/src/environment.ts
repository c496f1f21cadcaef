import { type DataArrayTexture, DataTexture, FloatType, RGBAFormat } from "three";
import { FieldError } from "./field.js";
import { fromHalf, halfLayers, halvesFrom } from "./half.js";
import { type ShareEnvironment, isTurned } from "./header.js";
import { unrolled } from "./unrolled.js";

/** Light from all around as lamps of each normal (the library's render/environment/nodes.rs). */
export class EnvironmentLamps {
  /** Unit vectors in the frame of a normal, and in that of the flat texture. */
  readonly nodes: Float32Array;
  readonly flatNodes: Float32Array;
  readonly flatLight: Float32Array;
  /** For both halves of the sphere, for each lamp, row after row: red, green, blue and 1; or for each moment, where these are turned. */
  readonly light: Uint16Array;
  /** The factors of the moments, for each lamp. */
  readonly factors: Float32Array;

  constructor(readonly header: ShareEnvironment, raw: Uint8Array) {
    const { nodes, functions, side, scale } = header, floats = nodes * (9 + functions), halves = 6 * functions * side * side;
    if (raw.length !== EnvironmentLamps.bytes(header)) throw new FieldError(`${header.file} has another length than its header says`);
    const numbers = new Float32Array(raw.buffer, raw.byteOffset, floats);
    let at = 0;
    const next = (count: number): Float32Array => numbers.subarray(at, (at += count));
    this.nodes = next(3 * nodes);
    this.factors = next(functions * nodes);
    this.flatNodes = next(3 * nodes);
    this.flatLight = next(3 * nodes);
    const moments = Float32Array.from(new Uint16Array(raw.buffer, raw.byteOffset + 4 * floats, halves), fromHalf);
    this.light = halvesFrom(lamps(moments, isTurned(header) ? null : this.factors, functions, side * side, scale));
  }

  /** The length of the file. */
  static bytes({ nodes, functions, side }: ShareEnvironment): number {
    return 4 * nodes * (9 + functions) + 12 * functions * side * side;
  }
}

/** The light of each lamp at each normal: the factors times the moments; without factors the moments themselves. */
function lamps(moments: Float32Array, factors: Float32Array | null, functions: number, normals: number, scale: number): Float32Array {
  const nodes = factors ? factors.length / functions : functions, light = new Float32Array(2 * nodes * normals * 4).fill(1);
  for (let half = 0; half < 2; half++)
    for (let node = 0; node < nodes; node++) {
      const to = (half * nodes + node) * normals * 4, of = (p: number, i: number): number => moments[(half * functions + p) * 3 * normals + i] ?? 0;
      for (let i = 0; i < 3 * normals; i++) {
        let sum = factors ? 0 : of(node, i);
        if (factors) for (let p = 0; p < functions; p++) sum += (factors[node * functions + p] ?? 0) * of(p, i);
        light[to + 4 * Math.floor(i / 3) + (i % 3)] = sum * scale;
      }
    }
  return light;
}

/** The light of the lamps, or the moments: a layer for each, of the upper half and then of the lower one. */
export function lampLightTexture({ light, header }: EnvironmentLamps): DataArrayTexture {
  return halfLayers(light, header.side, header.side, 2 * (isTurned(header) ? header.functions : header.nodes));
}

/** Rows: the directions of the lamps, those of the flat texture, their light, and four by four the factors of the moments. */
export function lampNodeTexture({ nodes, flatNodes, flatLight, factors, header }: EnvironmentLamps): DataTexture {
  const lamps = header.nodes, rows = 3 + (isTurned(header) ? Math.ceil(header.functions / 4) : 0), values = new Float32Array(4 * rows * lamps);
  const put = (x: number, y: number, channel: number, value: number): number => (values[4 * (y * lamps + x) + channel] = value);
  [nodes, flatNodes, flatLight].forEach((row, y) => row.forEach((value, i) => put(Math.floor(i / 3), y, i % 3, value)));
  if (isTurned(header)) factors.forEach((value, i) => put(Math.floor(i / header.functions), 3 + ((i % header.functions) >> 2), (i % header.functions) & 3, value));
  const texture = new DataTexture(values, lamps, rows, RGBAFormat, FloatType);
  texture.needsUpdate = true;
  return texture;
}

/**
 * In GLSL: the moments in the frame of the texture, which is that of the normal turned, those of each m mixed in pairs; and the
 * light of a lamp.
 */
export function momentsGlsl(header: ShareEnvironment | undefined): string {
  if (!header || !isTurned(header)) return "";
  const degree = Math.round(Math.sqrt(header.functions)) - 1, turned: string[] = [];
  for (let m = 1, p = degree + 1; m <= degree; m++) {
    for (let k = m; k <= degree; k++, p += 2)
      turned.push(`a = moments[${p}]; b = moments[${p + 1}]; moments[${p}] = turn.x * a + turn.y * b; moments[${p + 1}] = hand * (turn.x * b - turn.y * a);`);
    turned.push("turn = vec2(turn.x * once.x - turn.y * once.y, turn.y * once.x + turn.x * once.y);");
  }
  const added = (p: number): string => ["x", "y", "z", "w"].slice(0, header.functions - p).map((c, i) => `f.${c} * moments[${p + i}]`).join(" + ");
  return `
vec3 moments[${header.functions}];
void turnMoments(vec2 at, float first, mat3 frame) {
  vec2 once = vec2(frame[0].x, frame[1].x), turn = once;
  float hand = frame[0].x * frame[1].y < frame[0].y * frame[1].x ? -1.0 : 1.0;
  vec3 a, b;
  ${unrolled(header.functions, (p) => `moments[${p}] = textureLod(environmentLight, vec3(at, first + ${p}.0), 0.0).rgb;`)}
  ${turned.join("\n  ")}
}
vec3 lightOfLamp(int j) {
  vec3 light = vec3(0.0);
  vec4 f;
  ${unrolled(Math.ceil(header.functions / 4), (q) => `f = texelFetch(environmentNodes, ivec2(j, ${3 + q}), 0); light += ${added(4 * q)};`)}
  return light;
}`;
}

/** In GLSL: every lamp lights the texture as a light at infinity does. */
export const ENVIRONMENT_GLSL = `
#if AMBIENT
uniform float environment;
uniform mat3 environmentTurn;
uniform bool environmentTurned;
uniform sampler2DArray environmentLight;
uniform sampler2D environmentNodes;
//MOMENTS
vec3 underEnvironment(vec3 v, vec3 n) {
  bool plain = flat_ && !environmentTurned;
  vec3 z = environmentTurn * tangentZ, pole = vec3(0.0, 0.0, z.z < 0.0 ? -1.0 : 1.0);
  vec3 x = vec3(1.0, 0.0, 0.0) - (z + pole) * (z.x / (1.0 + abs(z.z)));
  // From the frame of the normal to that of the texture.
  mat3 world = transpose(environmentTurn) * mat3(x, cross(z, x), z);
  mat3 frame = mat3(inFrame(world[0]), inFrame(world[1]), inFrame(world[2]));
  float side = float(textureSize(environmentLight, 0).x), lower = z.z < 0.0 ? 1.0 : 0.0;
  vec2 at = vec2(z.x + z.y, z.x - z.y) / (abs(z.x) + abs(z.y) + abs(z.z));
  at = ((0.5 * at + 0.5) * (side - 1.0) + 0.5) / side;
  vec3 sum = vec3(0.0);
#if LAMP_SIDE > 0
  findLampView(v);
  lampIsFlat = plain;
#endif
#if MOMENTS
  if (!plain) turnMoments(at, lower * float(MOMENTS), frame);
#endif
  for (int j = 0; j < NODES; j++) {
    vec3 light, l;
    if (plain) {
      l = texelFetch(environmentNodes, ivec2(j, 1), 0).xyz;
      light = texelFetch(environmentNodes, ivec2(j, 2), 0).rgb;
    } else {
#if MOMENTS
      l = texelFetch(environmentNodes, ivec2(j, 0), 0).xyz;
      light = lightOfLamp(j);
#else
      l = frame * texelFetch(environmentNodes, ivec2(j, 0), 0).xyz;
      light = textureLod(environmentLight, vec3(at, lower * float(NODES) + float(j)), 0.0).rgb;
#endif
    }
#if LAMP_SIDE > 0
    lampOfLight = j;
#endif
    sum += light * underLight(fromDisk(l.xy), v, n);
  }
  return environment * max(sum, 0.0);
}
#endif
`;
