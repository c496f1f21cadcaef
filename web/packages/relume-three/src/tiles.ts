import type { FieldCells } from "./field.js";
import { modulo } from "./window.js";

/** Texels around a tile that filtering may touch. */
const PADDING = 8;
/** Sides are multiples of this, so that levels of detail down to a sixteenth are means of whole squares. */
const MULTIPLE = 16;

/** The layout of tiles with what lies around them, for filtering beyond their borders. */
export interface TileLayout {
  width: number;
  height: number;
  padding: number;
  /** For each texel of each tile with its surroundings, the texel of the stacked tiles. */
  sources: Uint32Array;
}

/** Surrounds each tile, of `width` x `height` texels in its rectangle, by texels of tiles that may lie beside it. */
export function tileLayout(cells: FieldCells, width: number, height: number): TileLayout {
  const across = rounded(width), down = rounded(height);
  const sources = new Uint32Array(cells.tiles * across * down);
  let at = 0;
  for (let tile = 0; tile < cells.tiles; tile++)
    for (let y = 0; y < down; y++)
      for (let x = 0; x < across; x++) {
        const [source, column, row] = texelBeside(cells, width, height, tile, x - PADDING, y - PADDING);
        sources[at++] = (source * height + row) * width + column;
      }
  return { width: across, height: down, padding: PADDING, sources };
}

function rounded(side: number): number {
  return Math.ceil((side + 2 * PADDING) / MULTIPLE) * MULTIPLE;
}

/** A tile and its texel that may lie at (x, y) of the rectangle of another tile. */
function texelBeside(cells: FieldCells, width: number, height: number, tile: number, x: number, y: number): [number, number, number] {
  if (x >= 0 && y >= 0 && x < width && y < height) return [tile, x, y];
  const [w, t] = cells.right, [s, h] = cells.down, [left, top] = cells.origin, area = w * h - s * t;
  const px = x + left, py = y + top;
  const i = Math.floor((px * h - py * s) / area), j = Math.floor((w * py - t * px) / area);
  const source = i === 0 && j === 0 ? tile : neighbour(cells, tile, i, j);
  return [source, modulo(px - i * w - j * s - left, width), modulo(py - i * t - j * h - top, height)];
}

/** A tile that fits beside another, some cells to the right and down: by the colours of the corners that both have. */
function neighbour({ corners }: FieldCells, tile: number, right: number, down: number): number {
  if (corners < 2) return tile;
  const color = (corner: number): number => Math.floor(tile / corners ** corner) % corners;
  let found = 0;
  for (let corner = 0; corner < 4; corner++) {
    const x = right + (corner & 1), y = down + (corner >> 1);
    if (x >= 0 && x <= 1 && y >= 0 && y <= 1) found += color(2 * y + x) * corners ** corner;
  }
  return found;
}
