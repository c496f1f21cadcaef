import type { FieldCells, FieldData } from "./field.js";
import { hash4 } from "./hash.js";

/** The side of a square in texels. */
const SIDE = 128;

/**
 * A set of tiles as the endless plane that it covers, in squares. From afar the levels of detail of single tiles begin at other
 * texels than those of the plane, and know nothing of the neighbours.
 */
export class TilePlane {
  readonly data: FieldData;
  /** The row of the plane at which the squares begin, and so its levels of detail; `forget` the squares after a change. */
  firstRow = 0;

  constructor(tiles: FieldData, cells: FieldCells) {
    const { planes, width } = tiles, height = tiles.height / cells.tiles;
    const load = async (column: number, row: number): Promise<Uint16Array[]> => {
      const [left, top] = [column * SIDE, row * SIDE + this.firstRow];
      const sources = Uint32Array.from({ length: SIDE * SIDE }, (_, i) => texelOf(cells, width, height, left + (i % SIDE), top + Math.floor(i / SIDE)));
      return planes.map((plane) => Uint16Array.from(sources, (source) => plane[source] ?? 0));
    };
    this.data = { ...tiles, height, planes: [], codes: null, normals: null, heights: null, albedo: null, cells: null, blocks: { side: SIDE, load } };
  }
}

/** The texel of the stacked tiles that lies at a place of the plane (the library's numeric/endless.rs). */
export function texelOf(cells: FieldCells, width: number, height: number, x: number, y: number): number {
  const [w, t] = cells.right, [s, h] = cells.down, [left, top] = cells.origin, area = w * h - s * t;
  const i = Math.floor((x * h - y * s) / area), j = Math.floor((w * y - t * x) / area);
  return (tileAt(cells, i, j) * height + y - i * t - j * h - top) * width + x - i * w - j * s - left;
}

/** The tile of a cell: by the hash of the cell, and of its corners where these have colours. */
function tileAt({ tiles, corners }: FieldCells, column: number, row: number): number {
  const hashed = (i: number, j: number): number => (hash4(i, j, 0, 0)[0] ?? 0) >>> 16;
  if (corners < 2) return hashed(column, row) % tiles;
  let kind = 0, power = 1;
  for (let corner = 0; corner < 4; corner++, power *= corners) kind += power * (hashed(column + (corner & 1), row + (corner >> 1)) % corners);
  const alike = Math.floor((tiles - kind + power - 1) / power);
  return kind + power * (((hash4(column, row, 0, 0)[1] ?? 0) >>> 16) % alike);
}
