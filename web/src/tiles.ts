import { ReflectanceMaterial, ReflectanceTexture, type TilePlace, type TiledShare } from "relume-three";

/** Requests at a time. */
const AT_ONCE = 4;
/** Memory on the graphics card for the tiles of a texture, in bytes. */
const MOST_BYTES = 384 << 20;

/** A tile on the graphics card. */
export interface PlacedTile {
  place: TilePlace;
  texture: ReflectanceTexture;
  material: ReflectanceMaterial;
}

/** A part of a texture: left, top, right, bottom, from 0 to 1. */
export type TextureWindow = [number, number, number, number];

/** The tiles of a large texture: loaded where the view needs them, dropped where it no longer does. */
export class TileCache {
  /** In the order of their last use; null for those that could not be loaded. */
  private readonly kept = new Map<string, PlacedTile | null>();
  private readonly loading = new Set<string>();
  private queue: TilePlace[] = [];
  private bytes = 0;
  private idle: (() => void)[] = [];
  private fault: string | null = null;

  constructor(readonly share: TiledShare, private readonly anisotropy: number, private readonly changed: () => void) {}

  /** Tiles that are asked for and have not come. */
  get pending(): number {
    return this.queue.length + this.loading.size;
  }

  /** Why tiles could not be loaded; null if none is missing for it. */
  get failure(): string | null {
    return this.fault;
  }

  /** Tiles that could not be loaded are asked for again when they are in view. */
  retry(): void {
    for (const [key, tile] of this.kept) if (!tile) this.kept.delete(key);
  }

  /** The tiles to draw over the coarse texture, coarse ones first; those that are missing are loaded. `step`: texels of the whole for each pixel. */
  shown(step: number, window: TextureWindow): PlacedTile[] {
    const wanted = Math.max(0, Math.round(Math.log2(step)));
    if (wanted >= this.share.whole) return [];
    const found: PlacedTile[] = [], missing: TilePlace[] = [];
    for (let level = this.share.whole - 1; level >= wanted; level--) {
      for (const place of this.within(level, window)) {
        const tile = this.kept.get(keyOf(place));
        if (tile) found.push(this.used(tile));
        else if (tile === undefined && level === wanted) missing.push(place);
      }
    }
    this.queue = missing.filter((place) => !this.loading.has(keyOf(place)));
    this.pump();
    return found;
  }

  /** When all tiles asked for have come. */
  async settled(): Promise<void> {
    if (this.pending > 0) await new Promise<void>((resolve) => this.idle.push(resolve));
  }

  /** The part of the texture that a tile shows. */
  windowOf({ level, column, row }: TilePlace): TextureWindow {
    const { side, levels } = this.share, [width, height] = levels[level]?.size ?? [1, 1];
    return [(column * side) / width, (row * side) / height, Math.min(1, ((column + 1) * side) / width), Math.min(1, ((row + 1) * side) / height)];
  }

  /** Those of a level that show something of a part, from its middle outwards. */
  private within(level: number, [left, top, right, bottom]: TextureWindow): TilePlace[] {
    const [width, height] = this.share.levels[level]?.size ?? [1, 1], { side } = this.share;
    const range = (from: number, to: number, whole: number): number[] => {
      const first = Math.max(0, Math.floor((from * whole) / side)), last = Math.min(Math.ceil(whole / side) - 1, Math.floor((to * whole) / side));
      return Array.from({ length: Math.max(0, last - first + 1) }, (_, i) => first + i);
    };
    const columns = range(left, right, width), rows = range(top, bottom, height);
    const places = rows.flatMap((row) => columns.map((column) => ({ level, column, row })));
    const far = ({ column, row }: TilePlace): number => Math.hypot(column + 0.5 - ((left + right) * width) / side / 2, row + 0.5 - ((top + bottom) * height) / side / 2);
    return places.sort((a, b) => far(a) - far(b));
  }

  private used(tile: PlacedTile): PlacedTile {
    const key = keyOf(tile.place);
    this.kept.delete(key);
    this.kept.set(key, tile);
    return tile;
  }

  private pump(): void {
    while (this.loading.size < AT_ONCE) {
      const place = this.queue.shift();
      if (!place) break;
      this.loading.add(keyOf(place));
      void this.load(place);
    }
    if (this.pending === 0) for (const resolve of this.idle.splice(0)) resolve();
  }

  private async load(place: TilePlace): Promise<void> {
    try {
      const texture = new ReflectanceTexture(await this.share.tile(place), this.anisotropy);
      this.kept.set(keyOf(place), { place, texture, material: new ReflectanceMaterial(texture) });
      this.bytes += bytesOf(texture);
      this.fault = null;
      this.trim();
    } catch (fault) {
      this.kept.set(keyOf(place), null);
      this.fault = fault instanceof Error ? fault.message : String(fault);
    }
    this.loading.delete(keyOf(place));
    this.changed();
    this.pump();
  }

  /** Drops those that were not used for the longest time. */
  private trim(): void {
    for (const [key, tile] of this.kept) {
      if (this.bytes <= MOST_BYTES) return;
      if (!tile) continue;
      this.kept.delete(key);
      this.bytes -= bytesOf(tile.texture);
      tile.texture.dispose();
      tile.material.dispose();
    }
  }
}

function keyOf({ level, column, row }: TilePlace): string {
  return `${level} ${column} ${row}`;
}

/** Half floats of four values, and a third more for the pyramid. */
function bytesOf({ layers, maps, width, height }: ReflectanceTexture): number {
  return ((layers + (maps ? 2 : 0)) * width * height * 8 * 4) / 3;
}

/** Every second level from the smallest to the one that is the largest to be taken as a whole. */
export function levelsUpTo(smallest: number, whole: number): number[] {
  const levels: number[] = [];
  for (let level = smallest; level > whole; level -= 2) levels.push(level);
  return [...levels, whole];
}
