import { type FieldData, FieldError, type FieldMap, fieldOf, planeCount } from "./field.js";
import { fromHalf, halvesOfCodes } from "./half.js";
import type { ShareHeader, ShareLevel, SharePyramid } from "./header.js";
import { decodePng, inflated } from "./png.js";
import type { FileSource } from "./share.js";

/** Texels of the largest level that is taken as a whole. */
export const MOST_WHOLE = 1 << 21;

/** A tile of a level: its column and row. */
export interface TilePlace {
  level: number;
  column: number;
  row: number;
}

/** A large texture, whose tiles are loaded as they are needed (the library's format/share/pyramid.rs). */
export class TiledShare {
  readonly levels: ShareLevel[];
  readonly side: number;
  readonly border: number;

  constructor(
    private readonly header: ShareHeader,
    private readonly pyramid: SharePyramid,
    private readonly shared: Pick<FieldData, "table" | "environment">,
    private readonly source: FileSource,
  ) {
    this.levels = pyramid.levels;
    this.side = pyramid.side;
    this.border = pyramid.border;
  }

  /** The size of the whole texture. */
  get size(): [number, number] {
    return this.header.size;
  }

  /** The finest level that can be taken as a whole. */
  get whole(): number {
    return Math.max(0, this.levels.findIndex(({ size: [width, height] }) => width * height <= MOST_WHOLE));
  }

  /** A tile with its border, as a texture. */
  async tile(place: TilePlace): Promise<FieldData> {
    const level = this.level(place.level), [width, height] = this.spanOf(place, this.border);
    return this.fieldOf(level, width, height, await this.planesOf(place, 0));
  }

  /** A level as one texture; `progress` gets the share of its tiles that has arrived. */
  async wholeLevel(index: number, progress: (share: number) => void = () => undefined): Promise<FieldData> {
    const level = this.level(index), [width, height] = level.size;
    const places = this.placesOf(index), count = level.planes + this.mapChannels(level).reduce((sum, { channels }) => sum + channels, 0);
    const planes = Array.from({ length: count }, () => new Uint16Array(width * height));
    let done = 0;
    await Promise.all(places.map(async (place) => {
      const [w, h] = this.spanOf(place, 0), left = place.column * this.side, top = place.row * this.side;
      (await this.planesOf(place, this.border)).forEach((plane, k) => {
        for (let y = 0; y < h; y++) planes[k]?.set(plane.subarray(y * w, (y + 1) * w), (top + y) * width + left);
      });
      progress(++done / places.length);
    }));
    return this.fieldOf(level, width, height, planes);
  }

  /** All tiles of a level. */
  placesOf(index: number): TilePlace[] {
    const [columns, rows] = this.level(index).size.map((side) => Math.ceil(side / this.side)) as [number, number];
    return Array.from({ length: columns * rows }, (_, i) => ({ level: index, column: i % columns, row: Math.floor(i / columns) }));
  }

  /** The size of a tile with so many texels around it. */
  spanOf({ level, column, row }: TilePlace, around: number): [number, number] {
    const [width, height] = this.level(level).size;
    return [Math.min(this.side, width - column * this.side) + 2 * around, Math.min(this.side, height - row * this.side) + 2 * around];
  }

  private level(index: number): ShareLevel {
    const level = this.levels[index];
    if (!level) throw new FieldError(`the texture has no level ${index}`);
    return level;
  }

  /** Coefficients and maps as half floats, without so many texels of the border. */
  private async planesOf(place: TilePlace, cut: number): Promise<Uint16Array[]> {
    const level = this.level(place.level), isPng = level.storage === "png";
    const name = `tile-${place.level}-${place.column}-${place.row}.${isPng ? "png" : "f16.gz"}`;
    const [width, height] = this.spanOf(place, this.border), [w, h] = this.spanOf(place, this.border - cut);
    const count = level.planes + this.mapChannels(level).reduce((sum, { channels }) => sum + channels, 0);
    const bytes = await this.source(name);
    const numbers = count * width * height;
    const raw = isPng ? (await decodePng(bytes, numbers)).codes : halvesIn(await inflated([bytes], "gzip", 2 * numbers));
    if (raw.length !== numbers) throw new FieldError(`${name} has ${raw.length} numbers: expected ${numbers}`);
    return Array.from({ length: count }, (_, k) => {
      const values = isPng ? halvesOfCodes(level.scale?.[k] ?? 1 / 255, level.offset?.[k] ?? 0) : null, plane = new Uint16Array(w * h);
      for (let y = 0; y < h; y++) {
        const from = (k * height + y + cut) * width + cut;
        for (let x = 0; x < w; x++) plane[y * w + x] = values ? (values[raw[from + x] ?? 0] ?? 0) : (raw[from + x] ?? 0);
      }
      return plane;
    });
  }

  private mapChannels(level: ShareLevel): { role: string; channels: 1 | 3 }[] {
    const grey = level.layout === "luminance";
    return this.pyramid.maps.map((role) => ({ role, channels: role === "height" || (role === "albedo" && grey) ? 1 : 3 }));
  }

  private fieldOf(level: ShareLevel, width: number, height: number, planes: Uint16Array[]): FieldData {
    const { header } = this, { basis } = header;
    if (level.planes !== planeCount(level.layout, basis.functions)) throw new FieldError("a level of the texture has another number of planes than its layout");
    const maps = new Map<string, FieldMap>();
    let at = level.planes;
    for (const { role, channels } of this.mapChannels(level)) {
      const values = new Float32Array(channels * width * height);
      for (let c = 0; c < channels; c++) values.set(Float32Array.from(planes[at + c] ?? [], fromHalf), c * width * height);
      at += channels;
      maps.set(role, role === "height" && this.pyramid.height_range ? { channels, values, range: this.pyramid.height_range } : { channels, values });
    }
    return fieldOf({
      title: header.title, width, height, space: header.space, layout: level.layout, channels: header.channels, basis: basis.name,
      functions: basis.functions, dependsOnView: basis.depends_on_view, lowestLight: basis.lowest_light ?? 0, ...this.shared, planes: planes.slice(0, level.planes),
      normals: maps.get("normals") ?? null, heights: maps.get("height") ?? null, albedo: maps.get("albedo") ?? null,
      mmPerTexel: header.mm_per_texel ?? null,
    });
  }
}

function halvesIn(bytes: Uint8Array): Uint16Array {
  return new Uint16Array(bytes.buffer, bytes.byteOffset, bytes.byteLength >> 1);
}
