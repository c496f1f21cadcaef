import { FieldError } from "./field.js";
import { fromHalf } from "./half.js";

type Vector = [number, number, number];

/**
 * Functions as a table over directions: an atlas of squares of lights, one for each view, four values a texel, as the
 * library's format/share/table.rs describes it.
 */
export class BasisTable {
  readonly layers: number;
  readonly side: number;

  constructor(
    readonly lightNodes: number,
    readonly viewNodes: number,
    readonly functions: number,
    readonly channels: number,
    /** Half floats, layer after layer. */
    readonly texels: Uint16Array,
  ) {
    this.side = lightNodes * viewNodes;
    this.layers = channels * Math.ceil(functions / 4);
    const expected = BasisTable.numbers(functions, channels, this.side);
    if (texels.length !== expected) throw new FieldError(`the table of the basis has ${texels.length} numbers: expected ${expected}`);
  }

  /** The numbers of `texels`, of squares that are so many texels across together. */
  static numbers(functions: number, channels: number, side: number): number {
    return 4 * channels * Math.ceil(functions / 4) * side ** 2;
  }

  /** The values of the functions of a channel for unit vectors towards light and viewer, as the shader finds them. */
  weights(channel: number, light: Vector, view: Vector = [0, 0, 1]): number[] {
    const [lx, ly] = between(light, this.lightNodes), [vx, vy] = between(view, this.viewNodes);
    const out = new Array<number>(this.functions).fill(0);
    for (const [row, shareRow] of corners(vy))
      for (const [column, shareColumn] of corners(vx))
        for (const [y, shareY] of corners(ly))
          for (const [x, shareX] of corners(lx)) {
            const share = shareRow * shareColumn * shareY * shareX;
            if (share === 0) continue;
            for (let k = 0; k < this.functions; k++) {
              const place = this.place(channel, k, column * this.lightNodes + x, row * this.lightNodes + y);
              out[k] = (out[k] ?? 0) + share * fromHalf(this.texels[place] ?? 0);
            }
          }
    return out;
  }

  private place(channel: number, k: number, x: number, y: number): number {
    const layer = channel * Math.ceil(this.functions / 4) + (k >> 2);
    return ((layer * this.side + y) * this.side + x) * 4 + (k & 3);
  }
}

/** The lower node and the fraction along both axes of the octahedral map of the hemisphere. */
export function between([x, y, z]: Vector, nodes: number): [[number, number], [number, number]] {
  if (nodes === 1) return [[0, 0], [0, 0]];
  const up = Math.max(z, 0), sum = Math.abs(x) + Math.abs(y) + up;
  const spread = sum * (1 + Math.sqrt(up / sum));
  const place = (coordinate: number): [number, number] => {
    const place = ((0.5 * coordinate) / spread + 0.5) * (nodes - 1);
    const lower = Math.min(Math.floor(place), nodes - 2);
    return [lower, place - lower];
  };
  return [place(x + y), place(x - y)];
}

/** The unit vector at a node of the octahedral map of the hemisphere: `between` the other way round. */
export function directionAt(column: number, row: number, nodes: number): [number, number, number] {
  const a = (2 * column) / (nodes - 1) - 1, b = (2 * row) / (nodes - 1) - 1, rise = 1 - Math.max(Math.abs(a), Math.abs(b));
  const x = (0.5 + 0.5 * rise) * (a + b), y = (0.5 + 0.5 * rise) * (a - b), z = rise ** 2, length = Math.hypot(x, y, z);
  return [x / length, y / length, z / length];
}

function corners([lower, fraction]: [number, number]): [number, number][] {
  return [[lower, 1 - fraction], [lower + 1, fraction]];
}

/** In GLSL: the place of a direction in the octahedral map of the hemisphere, from 0 to 1. */
export const OCTAHEDRAL_GLSL = `
vec2 octahedral(vec3 d) {
  float up = max(d.z, 0.0), sum = abs(d.x) + abs(d.y) + up;
  return 0.5 * vec2(d.x + d.y, d.x - d.y) / (sum * (1.0 + sqrt(up / sum))) + 0.5;
}
`;

/** The look-up in GLSL: a group of four values, for light and view in the frame of the texture. */
export const TABLE_GLSL = `
uniform sampler2DArray basisTable;
${OCTAHEDRAL_GLSL}
vec2 tablePlace;
#if VIEW_NODES > 1
vec2 viewLower, viewFraction;
#endif
void fillTablePlaces(vec3 light, vec3 view) {
  tablePlace = octahedral(light) * float(LIGHT_NODES - 1) + 0.5;
#if VIEW_NODES > 1
  vec2 place = octahedral(view) * float(VIEW_NODES - 1);
  viewLower = min(floor(place), float(VIEW_NODES - 2));
  viewFraction = place - viewLower;
#endif
}
vec4 tableAt(vec2 view, int layer) {
  return textureLod(basisTable, vec3((view * float(LIGHT_NODES) + tablePlace) / float(LIGHT_NODES * VIEW_NODES), float(layer)), 0.0);
}
void fillWeights(vec3 light, vec3 view) { fillTablePlaces(light, view); }
vec4 weightGroup(int channel, int group) {
  int layer = channel * GROUPS + group;
#if VIEW_NODES > 1
  vec4 lower = mix(tableAt(viewLower, layer), tableAt(viewLower + vec2(1.0, 0.0), layer), viewFraction.x);
  vec4 upper = mix(tableAt(viewLower + vec2(0.0, 1.0), layer), tableAt(viewLower + vec2(1.0), layer), viewFraction.x);
  return mix(lower, upper, viewFraction.y);
#else
  return tableAt(vec2(0.0), layer);
#endif
}
`;
