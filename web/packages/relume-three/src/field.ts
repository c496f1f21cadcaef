import type { FieldBoundaries } from "./boundaries.js";
import type { EnvironmentLamps } from "./environment.js";
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

/** By-example noise of planes of normal values. */
export interface FieldNoise {
  planes: number;
  /** Side of a triangle in texels. */
  side: number;
  /** The key of the hash of vertices, the low half first. */
  key: [number, number];
  /** The largest normal value of a table. */
  reach: number;
  entries: number;
  tables: Float32Array;
  /** Coefficients of the mean and of each plane, channel after channel. */
  functions: Float32Array;
}

/** Squares of an endless plane, loaded when they are looked at: the planes of each as half floats. */
export interface FieldBlocks {
  side: number;
  load(column: number, row: number): Promise<Uint16Array[]>;
}

/** A map beside the functions: `channels` values a texel, one plane after another, rows from the top. */
export interface FieldMap {
  channels: 1 | 3;
  values: Float32Array;
  /** The least and the greatest value, where they are those of a larger texture. */
  range?: [number, number];
}

/** Planes as codes of 8 bits: value = scale code + offset, with a scale and an offset for each plane. */
export interface FieldCodes {
  planes: Uint8Array[];
  scale: number[];
  offset: number[];
}

/** A texture of functions in memory. Planes are half floats, rows from the top, in the order of the layout; what is null is not there. */
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
  /** The cosine of the polar angle of the lowest light of functions that stay as they are below it; 0 of others. */
  lowestLight: number;
  /** The functions, unless they have formulas. */
  table: BasisTable | MeasuredBasis | null;
  planes: Uint16Array[];
  /** The same planes as they are stored, where these are codes: a graphics card then takes half the memory. */
  codes: FieldCodes | null;
  normals: FieldMap | null;
  heights: FieldMap | null;
  albedo: FieldMap | null;
  mmPerTexel: number | null;
  cells: FieldCells | null;
  /** The planes are normal values from which an endless plane is made. */
  noise: FieldNoise | null;
  /** There are no planes: an endless plane comes in squares. */
  blocks: FieldBlocks | null;
  /** Light from all around, prepared for the functions. */
  environment: EnvironmentLamps | null;
  /** Boundaries of shadows and highlights that move between the lights. */
  boundaries: FieldBoundaries | null;
}

/** The number of planes of a layout. */
export function planeCount(layout: FieldLayout, functions: number): number {
  if (layout === "rgb") return 3 * functions;
  return layout === "lrgb" ? functions + 3 : functions;
}

/** A texture without what is not given: sRGB-encoded functions of light, without maps. */
export function fieldOf(
  given: Pick<FieldData, "title" | "width" | "height" | "layout" | "basis" | "functions" | "planes"> & Partial<FieldData>,
): FieldData {
  return {
    space: "srgb", channels: given.layout === "luminance" ? 1 : 3, dependsOnView: false, lowestLight: 0, table: null, codes: null, normals: null, heights: null,
    albedo: null, mmPerTexel: null, cells: null, noise: null, blocks: null, environment: null, boundaries: null, ...given,
  };
}
