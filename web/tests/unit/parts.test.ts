import { expect, test } from "vitest";
import { flatScale, shownParts } from "../../src/parts.js";
import type { StagedTexture } from "../../src/stage.js";
import { FIRST, type ViewState } from "../../src/state.js";

/** What is asked of a texture here. */
const texture = (width: number, height: number, mmPerTexel: number | null): StagedTexture => ({ width, height, endless: null, data: { mmPerTexel } }) as unknown as StagedTexture;

/** The scales of both pictures, and the middles of their views in texels from the middles of their textures. */
function compared(state: Partial<ViewState>, ...textures: StagedTexture[]): { scales: number[]; middles: [number, number][] } {
  const shown = shownParts({ ...FIRST, texture: 0, other: 1, ...state }, (index) => textures[index] ?? null, 434, 440);
  const of = (index: number): StagedTexture => textures[index] as StagedTexture;
  return {
    scales: shown.map(({ state, view }) => flatScale(state, of(state.texture), view.width, 440)),
    middles: shown.map(({ state: { texture: index, x, y } }) => [(x - 0.5) * of(index).width, (y - 0.5) * of(index).height]),
  };
}

test("textures whose texels have known sizes are compared at one scale in millimetres, about the same place", () => {
  for (const compare of ["side", "wipe"] as const) {
    const { scales: [a = 0, b = 0], middles: [m, n] } = compared({ compare, zoom: 3, x: 0.7, y: 0.2 }, texture(128, 128, 0.1), texture(200, 90, 0.25));
    expect(b / 0.25, compare).toBeCloseTo(a / 0.1, 6);
    expect((n?.[0] ?? 0) * 0.25, compare).toBeCloseTo((m?.[0] ?? 1) * 0.1, 6);
    expect((n?.[1] ?? 0) * 0.25, compare).toBeCloseTo((m?.[1] ?? 1) * 0.1, 6);
  }
});

test("without a known size each texture is fitted to its part, about the same part of the whole", () => {
  for (const mm of [[null, null], [0.1, null]] as const) {
    const { scales, middles } = compared({ compare: "side", x: 0.75 }, texture(128, 128, mm[0]), texture(200, 90, mm[1]));
    expect(scales).toEqual([217 / 128, 217 / 200]);
    expect(middles).toEqual([[32, 0], [50, 0]]);
  }
});
