import { FieldError } from "./field.js";
import type { FileSource } from "./share.js";

/** Red, green, blue and opacity of pixels, row after row. */
export interface Pixels {
  width: number;
  height: number;
  data: ArrayLike<number>;
}

/** Gives the pixels of a JPEG file. */
export type JpegDecoder = (bytes: Uint8Array) => Promise<Pixels>;

/** A plane of a web folder, red, green and blue of each texel. */
export type PlaneReader = (plane: number) => Promise<Uint8Array>;

/** The tiles of a level. */
interface TileGrid {
  width: number;
  height: number;
  side: number;
  overlap: number;
}

type TileSource = (plane: number, x: number, y: number) => { name: string; bytes: Promise<Uint8Array> };

/** How the planes of a web folder of some size are stored, of which there are `planes`: whole, or as tiles of a pyramid. */
export async function planeReader(source: FileSource, width: number, height: number, planes: number, decode: JpegDecoder): Promise<PlaneReader> {
  const optional = (name: string): Promise<Uint8Array | null> => source(name).catch(() => null);
  const whole = await optional("plane_0.jpg");
  if (whole) {
    const grid = { width, height, side: Math.max(width, height), overlap: 0 };
    return assembled(grid, decode, (plane) => named(source, `plane_${plane}.jpg`));
  }
  const deep = await optional("plane_0.dzi");
  if (deep) return deepZoom(new TextDecoder().decode(deep), { source, width, height, decode });
  const all = await optional("planes.tzi");
  if (all) {
    const archive = await archiveOf(all, "planes", source, width, height);
    if (archive.stride < planes) throw new FieldError(`planes.tzi holds ${archive.stride} planes: expected ${planes}`);
    return assembled(archive.grid, decode, (plane, x, y) => archive.tile(plane, x, y));
  }
  const first = await optional("plane_0.tzi");
  if (!first) throw new FieldError("the folder has no planes: expected plane_0.jpg, plane_0.dzi, plane_0.tzi or planes.tzi beside info.json");
  return async (plane) => {
    const name = `plane_${plane}`, text = plane === 0 ? first : await named(source, `${name}.tzi`).bytes;
    const archive = await archiveOf(text, name, source, width, height);
    return assembled(archive.grid, decode, (_, x, y) => archive.tile(0, x, y))(plane);
  };
}

function named(source: FileSource, name: string): { name: string; bytes: Promise<Uint8Array> } {
  const missing = (): never => {
    throw new FieldError(`the folder has no file ${name}: it is incomplete`);
  };
  return { name, bytes: source(name).catch(missing) };
}

/** The first texel and the number of texels of a tile along an axis. */
function span(index: number, length: number, { side, overlap }: TileGrid): [first: number, count: number] {
  const first = Math.max(0, index * side - overlap);
  return [first, Math.min((index + 1) * side + overlap, length) - first];
}

/** Planes put together of tiles. Where these overlap, both hold the same texels. */
function assembled(grid: TileGrid, decode: JpegDecoder, tile: TileSource): PlaneReader {
  const { width, height, side } = grid;
  return async (plane) => {
    const out = new Uint8Array(3 * width * height);
    for (let y = 0; y * side < height; y++)
      for (let x = 0; x * side < width; x++) {
        const { name, bytes } = tile(plane, x, y), found = await decode(await bytes);
        const [left, across] = span(x, width, grid), [top, down] = span(y, height, grid);
        if (found.width !== across || found.height !== down) throw new FieldError(`${name} has ${found.width} x ${found.height} texels: expected ${across} x ${down}`);
        for (let row = 0, from = 0; row < down; row++)
          for (let column = 0, to = 3 * ((top + row) * width + left); column < across; column++, from += 4, to += 3)
            for (let c = 0; c < 3; c++) out[to + c] = found.data[from + c] ?? 0;
      }
    return out;
  };
}

interface WebFolder {
  source: FileSource;
  width: number;
  height: number;
  decode: JpegDecoder;
}

/** Files `plane_K_files/LEVEL/X_Y.jpg`; a pyramid may go on down to a single texel, so the number of the finest level is searched. */
async function deepZoom(text: string, { source, width, height, decode }: WebFolder): Promise<PlaneReader> {
  const number = (name: string, least: number, most: number): number => {
    const value = Number(new RegExp(`${name}\\s*=\\s*["'](\\d+)`).exec(text)?.[1]);
    if (!(value >= least && value <= most)) throw new FieldError(`plane_0.dzi has no ${name} from ${least} to ${most}`);
    return value;
  };
  const grid = { width, height, side: number("TileSize", 16, 1 << 16), overlap: number("Overlap", 0, 64) };
  sameSize("plane_0.dzi", [number("Width", 1, 1 << 24), number("Height", 1, 1 << 24)], [width, height]);
  for (let level = Math.ceil(Math.log2(Math.max(width, height))); level >= 0; level--) {
    const found = await source(`plane_0_files/${level}/0_0.jpg`).catch(() => null);
    if (found) return assembled(grid, decode, (plane, x, y) => named(source, `plane_${plane}_files/${level}/${x}_${y}.jpg`));
  }
  throw new FieldError("the folder has no file plane_0_files/0/0_0.jpg: it is incomplete");
}

function sameSize(name: string, said: number[], expected: number[]): void {
  if (said.some((side, axis) => side !== expected[axis])) throw new FieldError(`${name} has ${said.join(" x ")} texels, and info.json ${expected.join(" x ")}`);
}

/** Tiles in ranges of one file, from the coarsest level on, of one plane or of `stride` planes after one another. */
async function archiveOf(text: Uint8Array, name: string, source: FileSource, width: number, height: number): Promise<{ grid: TileGrid; stride: number; tile: TileSource }> {
  const index = indexOf(text, name);
  const { tilesize: side = 0, overlap = 0, stride = 1, offsets = [] } = index, grid = { width, height, side, overlap };
  sameSize(`${name}.tzi`, [index.width ?? 0, index.height ?? 0], [width, height]);
  const bytes = await named(source, `${name}.tzb`).bytes, across = Math.ceil(width / side), finest = across * Math.ceil(height / side);
  let before = 0;
  for (let [w, h] = [width, height]; Math.max(w, h) > side; ) {
    [w, h] = [Math.max(1, w >> 1), Math.max(1, h >> 1)];
    before += Math.ceil(w / side) * Math.ceil(h / side);
  }
  const count = (before + finest) * stride, rises = offsets.every((n, i) => Number.isInteger(n) && n >= (offsets[i - 1] ?? 0));
  if (offsets.length <= count || !rises || (offsets.at(-1) ?? 0) > bytes.length) throw new FieldError(`${name}.tzi does not match ${name}.tzb: expected ${count + 1} rising offsets up to ${bytes.length}`);
  const tile: TileSource = (plane, x, y) => {
    const at = (before + y * across + x) * stride + plane;
    return { name: `tile ${x}, ${y} of plane ${plane}`, bytes: Promise.resolve(bytes.subarray(offsets[at], offsets[at + 1])) };
  };
  return { grid, stride, tile };
}

interface ArchiveIndex {
  width?: number;
  height?: number;
  tilesize?: number;
  overlap?: number;
  stride?: number;
  offsets?: number[];
}

function indexOf(text: Uint8Array, name: string): ArchiveIndex {
  let index: ArchiveIndex | null = null;
  try {
    index = JSON.parse(new TextDecoder().decode(text)) as ArchiveIndex | null;
  } catch {
    // Said below.
  }
  if (typeof index !== "object" || index === null) throw new FieldError(`${name}.tzi is not JSON`);
  const isWithin = (n: unknown, least: number, most: number): boolean => n === undefined || (Number.isInteger(n) && (n as number) >= least && (n as number) <= most);
  if (!index.tilesize || !isWithin(index.tilesize, 16, 1 << 16)) throw new FieldError(`${name}.tzi has no tilesize from 16 to 65536`);
  if (!isWithin(index.overlap, 0, 64) || !isWithin(index.stride, 1, 300)) throw new FieldError(`${name}.tzi has an overlap or a stride that is not a small whole number`);
  if (!Array.isArray(index.offsets)) throw new FieldError(`${name}.tzi has no offsets`);
  return index;
}
