// Animated GIF (GIF89a): 256 colours for each picture by median cut (Heckbert 1982), packed by LZW (Welch 1984).

/** Bits of a channel that tell colours apart. */
const BITS = 5;
const COLORS = 256;

/** A box of colours: indices into the list of the picture's colours. */
interface Box {
  cells: number[];
  /** The longest side: its channel, and its length times the pixels within. */
  axis: number;
  weight: number;
}

/** Pictures of one size, one after another, without end; codes are red, green, blue, opacity. */
export class GifWriter {
  private readonly bytes: number[] = [];

  constructor(private readonly width: number, private readonly height: number, private readonly centiseconds: number) {
    this.text("GIF89a");
    this.words(width, height);
    this.bytes.push(0x70, 0, 0, 0x21, 0xff, 11);
    this.text("NETSCAPE2.0");
    this.bytes.push(3, 1, 0, 0, 0);
  }

  add(codes: Uint8ClampedArray): void {
    const { palette, indices } = quantized(codes);
    this.bytes.push(0x21, 0xf9, 4, 0);
    this.words(this.centiseconds);
    this.bytes.push(0, 0, 0x2c);
    this.words(0, 0, this.width, this.height);
    this.bytes.push(0x87);
    for (let i = 0; i < 3 * COLORS; i++) this.bytes.push(palette[i] ?? 0);
    this.bytes.push(8);
    const packed = lzw(indices);
    for (let at = 0; at < packed.length; at += 255) {
      const part = packed.slice(at, at + 255);
      this.bytes.push(part.length);
      for (const byte of part) this.bytes.push(byte);
    }
    this.bytes.push(0);
  }

  finish(): Blob {
    this.bytes.push(0x3b);
    return new Blob([Uint8Array.from(this.bytes)], { type: "image/gif" });
  }

  private text(letters: string): void {
    for (const letter of letters) this.bytes.push(letter.charCodeAt(0));
  }

  private words(...values: number[]): void {
    for (const value of values) this.bytes.push(value & 255, value >> 8);
  }
}

/** A palette, and the index of each pixel in it. */
export function quantized(codes: Uint8ClampedArray): { palette: number[]; indices: Uint8Array } {
  const high = (code: number | undefined): number => (code ?? 0) >> (8 - BITS);
  const cellOf = (i: number): number => (high(codes[i]) << (2 * BITS)) | (high(codes[i + 1]) << BITS) | high(codes[i + 2]);
  // Pixels and sums of red, green and blue of each cell.
  const sums = new Float64Array(4 << (3 * BITS));
  for (let i = 0; i < codes.length; i += 4) {
    const at = 4 * cellOf(i);
    sums[at] = (sums[at] ?? 0) + 1;
    for (let c = 0; c < 3; c++) sums[at + 1 + c] = (sums[at + 1 + c] ?? 0) + (codes[i + c] ?? 0);
  }
  const used = Array.from({ length: sums.length / 4 }, (_, cell) => cell).filter((cell) => sums[4 * cell]);
  const palette: number[] = [], index = new Uint8Array(sums.length / 4);
  medianCut(used, sums).forEach((cells, i) => {
    const total = [0, 1, 2, 3].map((k) => cells.reduce((sum, cell) => sum + (sums[4 * cell + k] ?? 0), 0));
    palette.push(...[1, 2, 3].map((c) => Math.round((total[c] ?? 0) / (total[0] ?? 1))));
    for (const cell of cells) index[cell] = i;
  });
  return { palette, indices: Uint8Array.from({ length: codes.length / 4 }, (_, i) => index[cellOf(4 * i)] ?? 0) };
}

/** Cells in at most 256 boxes: the one with the most pixels times its side is halved by pixels. */
function medianCut(cells: number[], sums: Float64Array): number[][] {
  const channel = (cell: number, c: number): number => (cell >> (BITS * (2 - c))) & ((1 << BITS) - 1);
  const count = (cell: number): number => sums[4 * cell] ?? 0;
  const boxOf = (cells: number[]): Box => {
    const sides = [0, 1, 2].map((c) => {
      const values = cells.map((cell) => channel(cell, c));
      return values.reduce((a, b) => Math.max(a, b), 0) - values.reduce((a, b) => Math.min(a, b), 255);
    });
    const axis = sides.indexOf(Math.max(...sides));
    return { cells, axis, weight: (sides[axis] ?? 0) * cells.reduce((sum, cell) => sum + count(cell), 0) };
  };
  const boxes = [boxOf(cells)];
  while (boxes.length < COLORS) {
    const at = boxes.reduce((best, box, i) => (box.weight > (boxes[best]?.weight ?? 0) ? i : best), 0), box = boxes[at];
    if (!box || box.weight === 0) break;
    const sorted = box.cells.sort((a, b) => channel(a, box.axis) - channel(b, box.axis));
    let rest = sorted.reduce((sum, cell) => sum + count(cell), 0) / 2, cut = 0;
    while (cut < sorted.length - 1 && (rest > 0 || cut === 0)) rest -= count(sorted[cut++] ?? 0);
    boxes.splice(at, 1, boxOf(sorted.slice(0, cut)), boxOf(sorted.slice(cut)));
  }
  return boxes.map((box) => box.cells);
}

/** Codes of 9 to 12 bits, the lowest bit first. */
export function lzw(indices: Uint8Array): number[] {
  const clear = 256, end = 257, bytes: number[] = [];
  let known = new Map<number, number>(), next = end + 1, size = 9, held = 0, bits = 0;
  const put = (code: number): void => {
    held |= code << bits;
    for (bits += size; bits >= 8; bits -= 8, held >>>= 8) bytes.push(held & 255);
  };
  put(clear);
  let code = indices[0] ?? 0;
  for (let i = 1; i < indices.length; i++) {
    const index = indices[i] ?? 0, longer = known.get((code << 8) | index);
    if (longer !== undefined) {
      code = longer;
      continue;
    }
    put(code);
    if (next === 4096) {
      put(clear);
      [known, next, size] = [new Map(), end + 1, 9];
    } else {
      if (next === 1 << size) size++;
      known.set((code << 8) | index, next++);
    }
    code = index;
  }
  put(code);
  put(end);
  if (bits > 0) bytes.push(held & 255);
  return bytes;
}
