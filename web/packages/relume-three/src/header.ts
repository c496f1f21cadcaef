import type { FieldCells, FieldLayout, FieldSpace } from "./field.js";

/** How numbers are stored in a file. */
export type Storage = "png" | "half";

export interface PlaneGroup {
  file: string;
  storage: Storage;
  first: number;
  count: number;
  scale?: number[];
  offset?: number[];
}

export interface ShareMap {
  role: string;
  file: string;
  storage: Storage;
  scale?: number;
  offset?: number;
}

export interface ShareTable {
  file: string;
  light_nodes: number;
  view_nodes: number;
}

export interface ShareMeasured {
  file: string;
  corners: string;
  map_nodes: number;
  lights: [number, number][];
  views: [number, number][];
}

export interface ShareEnvironment {
  file: string;
  nodes: number;
  functions: number;
  side: number;
  scale: number;
  /** In which frame the lamps are: of a normal, unless said otherwise; measured lights are in that of the texture. */
  lamps?: "normal" | "texture" | "measured";
}

/** Whether the moments are turned into the frame of the texture, instead of the lamps. */
export function isTurned({ lamps = "normal" }: ShareEnvironment): boolean {
  return lamps !== "normal";
}

/** Pairs are of shadows and of highlights. */
export interface ShareShapes {
  file: string;
  strengths: [number, number];
  steps: [number, number];
  most: [number, number];
  softness: number;
}

export interface ShareLevel {
  size: [number, number];
  layout: FieldLayout;
  storage: Storage;
  planes: number;
  scale?: number[];
  offset?: number[];
}

/** A large texture in tiles. */
export interface SharePyramid {
  side: number;
  border: number;
  maps: string[];
  height_range?: [number, number];
  levels: ShareLevel[];
}

/** The header of a shared texture (docs/formats.md). */
export interface ShareHeader {
  relume: "share";
  version: 1 | 2;
  title: string;
  size: [number, number];
  space: FieldSpace;
  layout: FieldLayout;
  channels: 1 | 3;
  basis: { name: string; functions: number; channels: number; depends_on_view: boolean; lowest_light?: number; table?: ShareTable; measured?: ShareMeasured };
  planes: PlaneGroup[];
  error: number;
  maps: ShareMap[];
  mm_per_texel?: number;
  cells?: FieldCells;
  noise?: { planes: number; side: number; key: [number, number]; reach: number; entries: number; tables: string; functions: string };
  blocks?: { side: number };
  environment?: ShareEnvironment;
  shapes?: ShareShapes;
  pyramid?: SharePyramid;
}
