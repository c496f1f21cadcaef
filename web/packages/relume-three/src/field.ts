import type { MeasuredBasis } from "./measured.js";
import type { BasisTable } from "./table.js";

/** What is wrong with a file, in one sentence. */
export class FieldError extends Error {
  override name = "FieldError";
}

/** How planes form the channels: one function, one for each channel, one times a colour, or common coefficients. */
export type FieldLayout = "luminance" | "rgb" | "lrgb" | "shared";

/** Whether values are proportional to light or sRGB-encoded. */
export type FieldSpace = "linear" | "srgb";

/** The tiles of an endless plane, one below the other in the planes; steps in texels, y down. */
export interface FieldCells {
  tiles: number;
  right: [number, number];
  down: [number, number];
  origin: [number, number];
  corners: number;
}

/** A map beside the functions: `channels` values a texel, one plane after another, rows from the top. */
export interface FieldMap {
  channels: 1 | 3;
  values: Float32Array;
}

/** A texture of functions in memory. Planes are half floats, rows from the top, in the order of the layout. */
export interface FieldData {
  title: string;
  width: number;
  height: number;
  space: FieldSpace;
  layout: FieldLayout;
  channels: 1 | 3;
  basis: string;
  functions: number;
  dependsOnView: boolean;
  /** The functions, unless they have formulas. */
  table: BasisTable | MeasuredBasis | null;
  planes: Uint16Array[];
  normals: FieldMap | null;
  heights: FieldMap | null;
  albedo: FieldMap | null;
  mmPerTexel: number | null;
  cells: FieldCells | null;
}

/** The number of planes of a layout. */
export function planeCount(layout: FieldLayout, functions: number): number {
  if (layout === "rgb") return 3 * functions;
  return layout === "lrgb" ? functions + 3 : functions;
}
