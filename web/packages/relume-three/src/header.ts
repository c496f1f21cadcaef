import { hasClosedForm } from "./basis.js";
import { type FieldCells, FieldError, type FieldLayout, type FieldSpace, planeCount } from "./field.js";

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
  basis: { name: string; functions: number; channels: number; depends_on_view: boolean; table?: ShareTable; measured?: ShareMeasured };
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

const MOST_SIDE = 16384;
const MOST_FUNCTIONS = 1024;
const MOST_NODES = 256;
/** Layers that every graphics card has, for each half of the sphere. */
const MOST_HALF_LAYERS = 128;

/** Checks a header that was read from a file. */
export function parseHeader(text: string): ShareHeader {
  let header: ShareHeader;
  try {
    header = JSON.parse(text) as ShareHeader;
  } catch {
    throw new FieldError("the header is not JSON: write the texture anew with relume share");
  }
  const wrong = fault(header);
  if (wrong !== null) throw new FieldError(wrong);
  return header;
}

/** What is wrong with a header, or null. The types are those of the format; a file may hold anything. */
function fault(header: ShareHeader): string | null {
  if (typeof header !== "object" || (header as unknown) === null || header.relume !== "share") return "the file is not the header of a shared texture";
  if (![1, 2].includes(header.version)) return `the shared texture has version ${String(header.version)}: this page reads versions 1 and 2`;
  const isCount = (n: unknown, most: number): boolean => Number.isInteger(n) && (n as number) >= 1 && (n as number) <= most;
  if (!Array.isArray(header.size) || !header.size.every((side) => isCount(side, 1 << 20))) return "the shared texture has no size";
  if (!header.pyramid && header.size[0] > MOST_SIDE) return `the texture is ${header.size.join(" x ")} texels: at most ${MOST_SIDE} across can be shown`;
  if (!["linear", "srgb"].includes(header.space)) return "the shared texture has an unknown space";
  if (!["luminance", "rgb", "lrgb", "shared"].includes(header.layout)) return "the shared texture has an unknown layout";
  const basis = header.basis;
  if (typeof basis?.name !== "string" || !isCount(basis.functions, MOST_FUNCTIONS)) return "the shared texture has no basis";
  if (!basis.table && !basis.measured && !hasClosedForm(basis.name)) return `the basis ${basis.name} comes without a table`;
  const light = header.environment;
  if (light && !(typeof light.file === "string" && isCount(light.nodes, MOST_NODES) && isCount(isTurned(light) ? light.functions : light.nodes, MOST_HALF_LAYERS) && [undefined, "normal", "texture", "measured"].includes(light.lamps) && isCount(light.functions, MOST_FUNCTIONS) && isCount(light.side, MOST_SIDE) && Number.isFinite(light.scale))) {
    return "the shared texture has a damaged environment";
  }
  if (light && ((light.lamps === "measured" && light.nodes !== basis.measured?.lights.length) || !Number.isInteger(Math.sqrt(light.functions)))) {
    return "the shared texture has an environment for other lights than those of its basis";
  }
  const { shapes } = header, isPair = (pair: unknown): boolean => Array.isArray(pair) && pair.length === 2 && pair.every(Number.isFinite);
  if (shapes && !(typeof shapes.file === "string" && [shapes.strengths, shapes.steps, shapes.most].every(isPair) && shapes.steps.every((step) => step > 0) && shapes.softness > 0 && header.layout !== "lrgb" && basis.channels === 1)) {
    return "the shared texture has damaged shapes";
  }
  if (header.version === 2) return pyramidFault(header);
  return endlessFault(header) ?? planesFault(header);
}

function endlessFault({ noise, blocks, layout }: ShareHeader): string | null {
  const isNumber = (n: unknown, least: number, most: number): boolean => Number.isFinite(n) && (n as number) >= least && (n as number) <= most;
  if (noise && layout !== "rgb" && layout !== "luminance") return "the noise has another layout than rgb or luminance";
  const counts = noise ? [noise.planes, noise.entries, noise.side, noise.reach, ...(noise.key ?? [NaN])] : [1];
  if (!counts.every((n) => isNumber(n, 0, 2 ** 32)) || (noise && !(noise.planes >= 1 && noise.side >= 1 && noise.entries >= 2))) return "the noise of the shared texture is incomplete";
  return blocks && !(isNumber(blocks.side, 16, 1024) && Number.isInteger(1024 / blocks.side)) ? "the blocks of the shared texture have an unknown side" : null;
}

function pyramidFault({ pyramid, size, basis }: ShareHeader): string | null {
  const count = (n: unknown, most: number): boolean => Number.isInteger(n) && (n as number) >= 1 && (n as number) <= most;
  if (!pyramid || !count(pyramid.side, 4096) || !count(pyramid.border, 64) || !Array.isArray(pyramid.maps) || !Array.isArray(pyramid.levels)) return "the shared texture has no tiles";
  for (const [i, level] of pyramid.levels.entries()) {
    if (!Array.isArray(level.size) || level.size.some((side, axis) => side !== Math.max(1, (size[axis] ?? 0) >> i))) return `level ${i} of the shared texture has another size than it should`;
    if (!["luminance", "rgb", "lrgb", "shared"].includes(level.layout) || level.planes !== planeCount(level.layout, basis.functions)) return `level ${i} of the shared texture has planes that are out of order`;
  }
  return pyramid.levels.length > 0 ? null : "the shared texture has no levels";
}

function planesFault({ planes, layout, basis, noise, blocks }: ShareHeader): string | null {
  if (!Array.isArray(planes)) return "the shared texture has no planes";
  let next = 0;
  for (const group of planes) {
    if (group.first !== next || !(group.count >= 1 && group.count <= 3) || typeof group.file !== "string") return "the planes of the shared texture are out of order";
    next += group.count;
  }
  const expected = blocks ? 0 : (noise?.planes ?? planeCount(layout, basis.functions));
  return next === expected ? null : `the shared texture has ${next} planes: expected ${expected}`;
}
