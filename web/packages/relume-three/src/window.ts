/** A square of an endless plane by its column and row, and where it lies in the texture of a window. */
export interface PlaneBlock {
  column: number;
  row: number;
  slot: number;
}

/** A rectangle of an endless plane, in texels, y down. */
export interface PlaneRect {
  x: number;
  y: number;
  width: number;
  height: number;
}

/**
 * Which squares of an endless plane a texture holds that wraps around: texel (x, y) of the plane lies at the remainders of x and y
 * by its width and height. So what stays in view as the view moves stays in the texture.
 */
export class PlaneWindow {
  private readonly held: (PlaneBlock | null)[];
  private readonly columns: number;
  private readonly rows: number;

  /** Width and height are multiples of the side of a square. */
  constructor(readonly width: number, readonly height: number, readonly side: number) {
    this.columns = width / side;
    this.rows = height / side;
    this.held = new Array<PlaneBlock | null>(this.columns * this.rows).fill(null);
  }

  /** The squares that a rectangle needs and that are missing, the middle first; from now on they count as held. */
  take(rect: PlaneRect): PlaneBlock[] {
    const [left, right] = range(rect.x, rect.width, this.side, this.columns);
    const [top, bottom] = range(rect.y, rect.height, this.side, this.rows);
    const missing: PlaneBlock[] = [];
    for (let row = top; row < bottom; row++) {
      for (let column = left; column < right; column++) {
        const block = { column, row, slot: modulo(row, this.rows) * this.columns + modulo(column, this.columns) };
        if (this.holds(block)) continue;
        this.held[block.slot] = block;
        missing.push(block);
      }
    }
    const distance = (block: PlaneBlock): number => Math.hypot(2 * block.column + 1 - left - right, 2 * block.row + 1 - top - bottom);
    return missing.sort((a, b) => distance(a) - distance(b));
  }

  /** Whether a square is still wanted at its place. */
  holds({ column, row, slot }: PlaneBlock): boolean {
    const held = this.held[slot];
    return held?.column === column && held.row === row;
  }

  /** The first texel of a square in the texture. */
  placeOf({ slot }: PlaneBlock): [number, number] {
    return [(slot % this.columns) * this.side, Math.floor(slot / this.columns) * this.side];
  }

  /** Forgets a square, or all of them. */
  forget(block?: PlaneBlock): void {
    if (!block) this.held.fill(null);
    else if (this.holds(block)) this.held[block.slot] = null;
  }
}

/** The squares from the first to the one after the last that an interval touches, at most as many as there is room for. */
function range(start: number, length: number, side: number, most: number): [number, number] {
  const first = Math.floor(start / side), end = Math.ceil((start + length) / side);
  const over = Math.max(0, end - first - most), before = over >> 1;
  return [first + before, end - (over - before)];
}

/** The remainder that is not negative. */
export function modulo(value: number, by: number): number {
  return value - by * Math.floor(value / by);
}
