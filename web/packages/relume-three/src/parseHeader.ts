import { hasClosedForm } from "./basis.js";
import { FieldError, planeCount } from "./field.js";
import { type PlaneGroup, type ShareHeader, type ShareMap, isTurned } from "./header.js";

const MOST_SIDE = 16384;
const MOST_FUNCTIONS = 1024;
const MOST_NODES = 256;
/** Layers that every graphics card has, for each half of the sphere. */
const MOST_HALF_LAYERS = 128;
const MOST_DIRECTIONS = 1 << 15;
const MOST_TABLE_SIDE = 1 << 12;
const LAYOUTS = ["luminance", "rgb", "lrgb", "shared"];

/** Checks a header that was read from a file. */
export function parseHeader(text: string): ShareHeader {
  let header: ShareHeader;
  try {
    header = JSON.parse(text) as ShareHeader;
  } catch {
    throw new FieldError("the header is not JSON: write the texture anew with relume share");
  }
  const wrong = headerFault(header);
  if (wrong !== null) throw new FieldError(wrong);
  return header;
}

/** What is wrong with a header, or null. The types are those of the format; a file may hold anything. */
function headerFault(header: ShareHeader): string | null {
  if (typeof header !== "object" || (header as unknown) === null || header.relume !== "share") return "the file is not the header of a shared texture";
  if (![1, 2].includes(header.version)) return `the shared texture has version ${String(header.version)}: this page reads versions 1 and 2`;
  return generalFault(header) ?? basisFault(header) ?? environmentFault(header) ?? shapesFault(header) ?? (header.version === 2 ? pyramidFault(header) : wholeFault(header));
}

function isCount(n: unknown, most: number): n is number {
  return Number.isInteger(n) && (n as number) >= 1 && (n as number) <= most;
}

function isNumber(n: unknown, least: number, most: number): boolean {
  return Number.isFinite(n) && (n as number) >= least && (n as number) <= most;
}

function isPair(pair: unknown): boolean {
  return Array.isArray(pair) && pair.length === 2 && pair.every(Number.isFinite);
}

/** Whether there is nothing, or some numbers. */
function areNumbers(list: unknown, count: number): boolean {
  return list === undefined || (Array.isArray(list) && list.length === count && list.every(Number.isFinite));
}

function generalFault({ title, size, pyramid, space, layout, channels, mm_per_texel: millimetres }: ShareHeader): string | null {
  if (!Array.isArray(size) || size.length !== 2 || !size.every((side) => isCount(side, 1 << 20))) return "the shared texture has no size";
  if (!pyramid && size[0] > MOST_SIDE) return `the texture is ${size.join(" x ")} texels: at most ${MOST_SIDE} across can be shown`;
  if (typeof title !== "string") return "the shared texture has no title";
  if (!["linear", "srgb"].includes(space)) return "the shared texture has an unknown space";
  if (!LAYOUTS.includes(layout)) return "the shared texture has an unknown layout";
  if (channels !== (layout === "luminance" ? 1 : 3)) return `the shared texture has ${JSON.stringify(channels)} channels, which is not what its layout has`;
  return millimetres === undefined || isNumber(millimetres, 1e-9, 1e9) ? null : "the size of a texel of the shared texture is no length";
}

function basisFault({ basis }: ShareHeader): string | null {
  if (typeof basis?.name !== "string" || !isCount(basis.functions, MOST_FUNCTIONS) || ![1, 3].includes(basis.channels)) return "the shared texture has no basis";
  const { table, measured, lowest_light: lowest } = basis;
  if (lowest !== undefined && !isNumber(lowest, 0, 1)) return "the lowest light of the texture's basis is no cosine";
  if (!table && !measured && !hasClosedForm(basis.name)) return `the basis ${basis.name} comes without a table`;
  if (table && !(typeof table.file === "string" && isCount(table.light_nodes, MOST_TABLE_SIDE) && isCount(table.view_nodes, MOST_TABLE_SIDE) && table.light_nodes * table.view_nodes <= MOST_TABLE_SIDE)) {
    return "the table of the basis has an unknown size";
  }
  const areDirections = (list: unknown): boolean => Array.isArray(list) && isCount(list.length, MOST_DIRECTIONS) && list.every(isPair);
  if (measured && !([measured.file, measured.corners].every((file) => typeof file === "string") && isCount(measured.map_nodes, MOST_TABLE_SIDE) && areDirections(measured.lights) && areDirections(measured.views))) {
    return "the directions of the texture's basis are damaged";
  }
  return null;
}

function environmentFault({ environment: light, basis }: ShareHeader): string | null {
  if (!light) return null;
  const layers = isTurned(light) ? light.functions : light.nodes;
  if (!(typeof light.file === "string" && isCount(light.nodes, MOST_NODES) && isCount(light.functions, MOST_FUNCTIONS) && isCount(layers, MOST_HALF_LAYERS) && isCount(light.side, MOST_SIDE) && Number.isFinite(light.scale) && [undefined, "normal", "texture", "measured"].includes(light.lamps))) {
    return "the shared texture has a damaged environment";
  }
  const fits = (light.lamps !== "measured" || light.nodes === basis.measured?.lights.length) && Number.isInteger(Math.sqrt(light.functions));
  return fits ? null : "the shared texture has an environment for other lights than those of its basis";
}

function shapesFault({ shapes, layout, basis }: ShareHeader): string | null {
  if (!shapes) return null;
  const isWhole = typeof shapes.file === "string" && [shapes.strengths, shapes.steps, shapes.most].every(isPair) && shapes.steps.every((step) => step > 0) && shapes.softness > 0;
  return isWhole && layout !== "lrgb" && basis.channels === 1 ? null : "the shared texture has damaged shapes";
}

function wholeFault(header: ShareHeader): string | null {
  return endlessFault(header) ?? cellsFault(header) ?? planesFault(header) ?? mapsFault(header);
}

function cellsFault({ cells, size }: ShareHeader): string | null {
  if (!cells) return null;
  const { tiles, corners, right, down, origin } = cells, areSteps = [right, down, origin].every((pair) => isPair(pair) && pair.every((step) => Number.isInteger(step) && Math.abs(step) <= MOST_SIDE));
  if (!isCount(tiles, size[1]) || size[1] % tiles !== 0 || !isCount(corners, tiles) || !areSteps) return "the tiles of the shared texture are out of order";
  return right[0] * down[1] - right[1] * down[0] > 0 ? null : "the tiles of the shared texture do not cover a plane";
}

/** Maps of roles that this page does not know are no fault. */
function mapsFault({ maps }: ShareHeader): string | null {
  const isMap = (map: ShareMap | null): boolean =>
    typeof map?.role === "string" && typeof map.file === "string" && isStorage(map.storage) && [map.scale, map.offset].every((number) => number === undefined || Number.isFinite(number));
  return Array.isArray(maps) && maps.every(isMap) ? null : "the maps of the shared texture are out of order";
}

function isStorage(storage: unknown): boolean {
  return storage === "png" || storage === "half";
}

function endlessFault({ noise, blocks, layout }: ShareHeader): string | null {
  if (noise && layout !== "rgb" && layout !== "luminance") return "the noise has another layout than rgb or luminance";
  const counts = noise ? [noise.planes, noise.entries, noise.side, noise.reach, ...(noise.key ?? [NaN])] : [1];
  if (!counts.every((n) => isNumber(n, 0, 2 ** 32)) || (noise && !(noise.planes >= 1 && noise.side >= 1 && noise.entries >= 2))) return "the noise of the shared texture is incomplete";
  return blocks && !(isNumber(blocks.side, 16, 1024) && Number.isInteger(1024 / blocks.side)) ? "the blocks of the shared texture have an unknown side" : null;
}

function pyramidFault({ pyramid, size, basis }: ShareHeader): string | null {
  if (!pyramid || !isCount(pyramid.side, 4096) || !isCount(pyramid.border, 64) || !Array.isArray(pyramid.maps) || !Array.isArray(pyramid.levels)) return "the shared texture has no tiles";
  for (const [i, level] of pyramid.levels.entries()) {
    if (!Array.isArray(level.size) || level.size.some((side, axis) => side !== Math.max(1, (size[axis] ?? 0) >> i))) return `level ${i} of the shared texture has another size than it should`;
    if (!LAYOUTS.includes(level.layout) || !isStorage(level.storage) || level.planes !== planeCount(level.layout, basis.functions)) return `level ${i} of the shared texture has planes that are out of order`;
  }
  return pyramid.levels.length > 0 ? null : "the shared texture has no levels";
}

function planesFault({ planes, layout, basis, noise, blocks }: ShareHeader): string | null {
  if (!Array.isArray(planes)) return "the shared texture has no planes";
  let next = 0;
  const isGroup = (group: PlaneGroup | null): group is PlaneGroup =>
    typeof group?.file === "string" && isStorage(group.storage) && isCount(group.count, 3) && areNumbers(group.scale, group.count) && areNumbers(group.offset, group.count);
  for (const group of planes) {
    if (!isGroup(group) || group.first !== next) return "the planes of the shared texture are out of order";
    next += group.count;
  }
  const expected = blocks ? 0 : (noise?.planes ?? planeCount(layout, basis.functions));
  return next === expected ? null : `the shared texture has ${next} planes: expected ${expected}`;
}
