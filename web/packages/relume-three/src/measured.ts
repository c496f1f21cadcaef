import { FieldError } from "./field.js";
import { fromHalf } from "./half.js";
import { LAMP_TABLE_GLSL } from "./lampTable.js";
import { OCTAHEDRAL_GLSL, between } from "./table.js";

type Vector = [number, number, number];
type Point = [number, number];

/**
 * Functions at all of some lights with all of some views, linear in the triangles of both, as the library's
 * format/share/measured.rs describes them.
 */
export class MeasuredBasis {
  readonly layers: number;

  constructor(
    readonly lights: Point[],
    readonly views: Point[],
    readonly functions: number,
    readonly channels: number,
    /** Half floats: layer after layer, a row for each view, a texel of four values for each light. */
    readonly texels: Uint16Array,
    readonly mapNodes: number,
    /** Three directions around each node of the maps of lights and of views, and a 0. */
    readonly corners: Uint16Array,
  ) {
    this.layers = channels * Math.ceil(functions / 4);
    if (texels.length !== MeasuredBasis.numbers(functions, channels, lights.length, views.length) || corners.length !== MeasuredBasis.corners(mapNodes)) {
      throw new FieldError("the table of the basis has another size than its header says");
    }
    const isInside = (index: number, i: number): boolean => index < (i < corners.length / 2 ? lights.length : views.length);
    if (!corners.every(isInside)) throw new FieldError("the table of the basis names directions that it does not have");
  }

  /** The numbers of `texels`. */
  static numbers(functions: number, channels: number, lights: number, views: number): number {
    return 4 * channels * Math.ceil(functions / 4) * lights * views;
  }

  /** The numbers of `corners`. */
  static corners(mapNodes: number): number {
    return 8 * mapNodes ** 2;
  }

  /** The values of the functions of a channel, as the shader finds them. */
  weights(channel: number, light: Vector, view: Vector = [0, 0, 1]): number[] {
    const out = new Array<number>(this.functions).fill(0);
    for (const [row, a] of this.shares(view, 1))
      for (const [column, b] of this.shares(light, 0))
        for (let k = 0; k < this.functions; k++) {
          const layer = channel * Math.ceil(this.functions / 4) + (k >> 2);
          const place = ((layer * this.views.length + row) * this.lights.length + column) * 4 + (k & 3);
          out[k] = (out[k] ?? 0) + a * b * fromHalf(this.texels[place] ?? 0);
        }
    return out;
  }

  /** The directions around one and their shares; `which` is 0 for lights and 1 for views. */
  shares(direction: Vector, which: 0 | 1): [number, number][] {
    const [column, row] = between(direction, this.mapNodes).map(([lower, t]) => lower + Number(t >= 0.5)) as Point;
    const at = 4 * ((which * this.mapNodes + row) * this.mapNodes + column);
    const corners = [0, 1, 2].map((k) => this.corners[at + k] ?? 0);
    const points = corners.map((i) => (which === 0 ? this.lights : this.views)[i] ?? [0, 0]) as [Point, Point, Point];
    const scale = 1 / (1 + Math.max(direction[2], 0));
    const shares = sharesIn([direction[0] * scale, direction[1] * scale], points, corners[0] === corners[2]);
    return corners.map((corner, k) => [corner, shares[k] ?? 0]);
  }
}

function sharesIn(p: Point, [a, b, c]: [Point, Point, Point], isEdge: boolean): number[] {
  if (isEdge) {
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const t = ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / Math.max(dx * dx + dy * dy, 1e-12);
    const along = Math.min(1, Math.max(0, t));
    return [1 - along, along, 0];
  }
  const cross = (p: Point, q: Point, r: Point): number => (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  const area = cross(a, b, c), u = cross(p, b, c) / area, v = cross(a, p, c) / area;
  const shares = [u, v, 1 - u - v].map((share) => Math.max(share, 0));
  const sum = shares.reduce((sum, share) => sum + share, 0);
  return shares.map((share) => share / sum);
}

/** The look-up in GLSL. */
export const MEASURED_GLSL = `
precision highp usampler2D;
uniform sampler2DArray basisTable;
uniform usampler2D cornerMap;
uniform highp sampler2D directionPoints;
${OCTAHEDRAL_GLSL}
ivec3 lightCorners, viewCorners;
vec3 lightShares, viewShares;
float crossOf(vec2 p, vec2 q, vec2 r) { return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x); }
void findTriangle(vec3 d, int which, out ivec3 corners, out vec3 shares) {
  ivec2 node = min(ivec2(octahedral(d) * float(MAP_NODES - 1) + 0.5), MAP_NODES - 1);
  corners = ivec3(texelFetch(cornerMap, node + ivec2(0, which * MAP_NODES), 0).xyz);
  vec2 a = texelFetch(directionPoints, ivec2(corners.x, which), 0).xy, b = texelFetch(directionPoints, ivec2(corners.y, which), 0).xy;
  vec2 c = texelFetch(directionPoints, ivec2(corners.z, which), 0).xy, p = d.xy / (1.0 + max(d.z, 0.0));
  if (corners.x == corners.z) {
    float t = clamp(dot(p - a, b - a) / max(dot(b - a, b - a), 1e-12), 0.0, 1.0);
    shares = vec3(1.0 - t, t, 0.0);
    return;
  }
  float area = crossOf(a, b, c);
  shares.xy = vec2(crossOf(p, b, c), crossOf(a, p, c)) / area;
  shares.z = 1.0 - shares.x - shares.y;
  shares = max(shares, 0.0);
  shares /= shares.x + shares.y + shares.z;
}
${LAMP_TABLE_GLSL}
void fillWeights(vec3 light, vec3 view) {
#if AMBIENT && LAMP_SIDE > 0
  isForLamp = false;
#endif
  findTriangle(light, 0, lightCorners, lightShares);
  findTriangle(view, 1, viewCorners, viewShares);
}
vec4 weightGroup(int channel, int group) {
  int layer = channel * GROUPS + group;
#if AMBIENT && LAMP_SIDE > 0
  if (isForLamp) return lampGroup(layer);
#endif
  vec4 sum = vec4(0.0);
  for (int v = 0; v < 3; v++) {
    if (viewShares[v] == 0.0) continue;
    vec4 row = lightShares.x * texelFetch(basisTable, ivec3(lightCorners.x, viewCorners[v], layer), 0);
    row += lightShares.y * texelFetch(basisTable, ivec3(lightCorners.y, viewCorners[v], layer), 0);
    row += lightShares.z * texelFetch(basisTable, ivec3(lightCorners.z, viewCorners[v], layer), 0);
    sum += viewShares[v] * row;
  }
  return sum;
}
`;
