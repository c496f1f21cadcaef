import type { DataArrayTexture } from "three";
import type { EnvironmentLamps } from "./environment.js";
import { fromHalf, halfLayers, halvesFrom } from "./half.js";
import type { MeasuredBasis } from "./measured.js";
import { directionAt } from "./table.js";

/** Nodes along the side of a square of views: six degrees apart at most, where they fit. */
const MOST_SIDE = 33, LEAST_SIDE = 9;
const MOST_BYTES = 32 << 20;
/** What every card takes. */
const MOST_WIDTH = 2048;
const BYTES_PER_TEXEL = 8;

type Shares = [index: number, share: number][];

/**
 * Measured functions at the lamps of an environment. A layer for each lamp has a square of views, an octahedral map of the
 * hemisphere, for each group of four functions; and below these a row of the groups for the lamp of the flat texture, and one for
 * the lamp, both as seen from above. A shader looks up one place of it for a lamp and a group, instead of nine; those of a lamp lie
 * close together, which is half of the speed.
 */
export class LampTable {
  /** One for all tiles of a large texture. */
  private static readonly known = new WeakMap<EnvironmentLamps, LampTable>();

  readonly across: number;
  readonly side: number;
  private readonly width: number;
  private readonly height: number;
  private readonly lamps: number;
  private made: DataArrayTexture | null = null;
  private users = 0;

  static of(basis: MeasuredBasis, environment: EnvironmentLamps): LampTable {
    const table = LampTable.known.get(environment) ?? new LampTable(basis, environment);
    LampTable.known.set(environment, table);
    return table;
  }

  private constructor(private readonly basis: MeasuredBasis, private readonly environment: EnvironmentLamps) {
    this.lamps = environment.header.nodes;
    const fitting = Math.floor(Math.sqrt(MOST_BYTES / BYTES_PER_TEXEL / basis.layers / this.lamps));
    this.side = Math.min(MOST_SIDE, Math.max(LEAST_SIDE, fitting));
    this.across = Math.min(basis.layers, Math.floor(MOST_WIDTH / this.side));
    this.width = Math.max(this.across * this.side, basis.layers);
    this.height = Math.ceil(basis.layers / this.across) * this.side + 2;
  }

  /** The table on the card, made for its first user; all users let it go again. */
  taken(): DataArrayTexture {
    this.users++;
    return (this.made ??= this.texture());
  }

  letGo(): void {
    if (--this.users > 0) return;
    this.made?.dispose();
    this.made = null;
  }

  private texture(): DataArrayTexture {
    const { side, across, width, height, basis, lamps } = this, { nodes, flatNodes } = this.environment;
    const out = new Float32Array(4 * width * height * lamps), rows = new LightRows(basis), above = basis.shares([0, 0, 1], 1);
    const views = Array.from({ length: side * side }, (_, i) => basis.shares(directionAt(i % side, Math.floor(i / side), side), 1));
    for (let lamp = 0; lamp < lamps; lamp++) {
      const put = (x: number, y: number, group: number, shares: Shares): void =>
        rows.addInto(out, 4 * ((lamp * height + y) * width + x), group, shares);
      rows.fill(vectorOf(flatNodes, lamp));
      for (let group = 0; group < basis.layers; group++) put(group, height - 2, group, above);
      rows.fill(vectorOf(nodes, lamp));
      for (let group = 0; group < basis.layers; group++) {
        const [left, top] = [(group % across) * side, Math.floor(group / across) * side];
        put(group, height - 1, group, above);
        views.forEach((shares, i) => put(left + (i % side), top + Math.floor(i / side), group, shares));
      }
    }
    return halfLayers(halvesFrom(out), width, height, lamps);
  }
}

function vectorOf(vectors: Float32Array, index: number): [number, number, number] {
  const [x = 0, y = 0, z = 1] = vectors.subarray(3 * index, 3 * index + 3);
  return [x, y, z];
}

/** The functions for one light at all measured views. */
class LightRows {
  private readonly values: Float32Array;
  private readonly rows: Float32Array;

  constructor(private readonly basis: MeasuredBasis) {
    this.values = Float32Array.from(basis.texels, fromHalf);
    this.rows = new Float32Array(4 * basis.layers * basis.views.length);
  }

  fill(light: [number, number, number]): void {
    const { rows, values } = this, { lights } = this.basis, shares = this.basis.shares(light, 0);
    for (let i = 0; i < rows.length; i++) {
      let sum = 0;
      for (const [column, share] of shares) sum += share * (values[4 * ((i >> 2) * lights.length + column) + (i & 3)] ?? 0);
      rows[i] = sum;
    }
  }

  /** Adds four values of a layer for a view. */
  addInto(out: Float32Array, to: number, layer: number, shares: Shares): void {
    for (const [view, share] of shares) {
      const from = 4 * (layer * this.basis.views.length + view);
      for (let k = 0; k < 4; k++) out[to + k] = (out[to + k] ?? 0) + share * (this.rows[from + k] ?? 0);
    }
  }
}

/** In GLSL: the weights for a lamp, instead of those for its direction. */
export const LAMP_TABLE_GLSL = `
#if AMBIENT && LAMP_SIDE > 0
uniform sampler2DArray lampTable;
// The lamp of the light that is added; and whether weights are looked up for it.
int lampOfLight = 0;
bool isForLamp = false;
bool lampIsFlat = false;
vec2 lampView = vec2(0.0);
void findLampView(vec3 d) {
  lampView = (octahedral(d) * float(LAMP_SIDE - 1) + 0.5) / vec2(textureSize(lampTable, 0).xy);
}
vec4 lampGroup(int group) {
  ivec2 size = textureSize(lampTable, 0).xy;
#if FLAT
  return texelFetch(lampTable, ivec3(group, size.y - (lampIsFlat ? 2 : 1), lampOfLight), 0);
#else
  vec2 square = vec2(LAMP_SIDE * ivec2(group % LAMPS_ACROSS, group / LAMPS_ACROSS)) / vec2(size);
  return textureLod(lampTable, vec3(lampView + square, float(lampOfLight)), 0.0);
#endif
}
#endif
`;
