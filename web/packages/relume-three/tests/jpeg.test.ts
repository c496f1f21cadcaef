// The decoder of grey JPEG pictures against the formula of the inverse cosine transform, on pictures written here.
import { expect, test } from "vitest";
import { decodeGreyJpeg } from "../src/jpeg.js";

const STEP = 3;

/** Bits, with a 0 after each byte of 255. */
class Writer {
  readonly bytes: number[] = [];
  private bits = "";

  put(value: number, length: number): void {
    if (length > 0) this.bits += value.toString(2).padStart(length, "0");
  }

  /** Fills the last byte with ones. */
  end(): void {
    for (let i = 0; i < this.bits.length; i += 8) {
      const byte = parseInt(this.bits.slice(i, i + 8).padEnd(8, "1"), 2);
      this.bytes.push(...(byte === 255 ? [255, 0] : [byte]));
    }
    this.bits = "";
  }
}

/** The frequencies along a block's diagonals, walked forth and back. */
function diagonals(): [x: number, y: number][] {
  const out: [number, number][] = [];
  for (let sum = 0; sum < 15; sum++)
    for (let i = 0; i <= sum; i++) {
      const [x, y] = sum % 2 ? [sum - i, i] : [i, sum - i];
      if (x < 8 && y < 8) out.push([x, y]);
    }
  return out;
}

/** A picture of blocks of frequencies, each `frequencies[y][x]`, with codes of 8 bits and a new start after each row of blocks. */
function picture(width: number, height: number, blocks: number[][][], kind = 0xc0): Uint8Array {
  const across = Math.ceil(width / 8), writer = new Writer();
  const segment = (marker: number, data: number[]): number[] => [0xff, marker, (data.length + 2) >> 8, (data.length + 2) & 255, ...data];
  // 255 symbols of 8 bits: the one of ones alone is never used.
  const codes = (table: number): number[] => [table, 0, 0, 0, 0, 0, 0, 0, 255, ...Array<number>(8).fill(0), ...Array.from({ length: 255 }, (_, i) => i)];
  const number = (run: number, value: number): void => {
    const size = value === 0 ? 0 : Math.floor(Math.log2(Math.abs(value))) + 1;
    writer.put(run * 16 + size, 8);
    writer.put(value < 0 ? value + (1 << size) - 1 : value, size);
  };
  let mean = 0;
  blocks.forEach((block, i) => {
    if (i && i % across === 0) {
      writer.end();
      writer.bytes.push(0xff, 0xd0 + ((i / across - 1) % 8));
      mean = 0;
    }
    const values = diagonals().map(([x, y]) => block[y]?.[x] ?? 0);
    number(0, (values[0] ?? 0) - mean);
    mean = values[0] ?? 0;
    let run = 0;
    for (const value of values.slice(1)) {
      if (value === 0) run++;
      else {
        for (; run > 15; run -= 16) writer.put(0xf0, 8);
        number(run, value);
        run = 0;
      }
    }
    if (run) writer.put(0, 8);
  });
  writer.end();
  const size = [height >> 8, height & 255, width >> 8, width & 255];
  return Uint8Array.from([
    0xff, 0xd8, ...segment(0xfe, [1, 2, 3]), ...segment(0xdb, [0, ...Array<number>(64).fill(STEP)]), ...segment(kind, [8, ...size, 1, 1, 0x11, 0]),
    ...segment(0xc4, codes(0)), ...segment(0xc4, codes(16)), ...segment(0xdd, [0, across]), ...segment(0xda, [1, 1, 0, 0, 63, 0]), ...writer.bytes, 0xff, 0xd9,
  ]);
}

/** The sample of a block by the formula. */
function sample(block: number[][], x: number, y: number): number {
  const wave = (k: number, at: number): number => (k === 0 ? Math.SQRT1_2 : 1) * Math.cos(((2 * at + 1) * k * Math.PI) / 16);
  let sum = 128;
  for (let v = 0; v < 8; v++) for (let u = 0; u < 8; u++) sum += 0.25 * STEP * (block[v]?.[u] ?? 0) * wave(u, x) * wave(v, y);
  return Math.min(255, Math.max(0, sum));
}

let seed = 7;
function random(below: number): number {
  seed = (Math.imul(seed, 1103515245) + 12345) >>> 0;
  return (seed >>> 8) % below;
}

function blocksOf(width: number, height: number): number[][][] {
  const few = (): number => (random(4) === 0 ? random(41) - 20 : 0);
  return Array.from({ length: Math.ceil(width / 8) * Math.ceil(height / 8) }, () => Array.from({ length: 8 }, () => Array.from({ length: 8 }, few)));
}

test("grey pictures of any size come out as the formula says", () => {
  for (const [width, height] of [[8, 8], [1, 1], [21, 19], [9, 40]] as const) {
    const blocks = blocksOf(width, height), found = decodeGreyJpeg(picture(width, height, blocks));
    expect([found.width, found.height]).toEqual([width, height]);
    found.samples.forEach((value, i) => {
      const [x, y] = [i % width, Math.floor(i / width)], block = blocks[(y >> 3) * Math.ceil(width / 8) + (x >> 3)] ?? [];
      expect(Math.abs(value - sample(block, x & 7, y & 7)), `${x}, ${y} of ${width} x ${height}`).toBeLessThan(0.75);
    });
  }
});

test("pictures that are cut, damaged or of another kind are refused in a sentence", () => {
  const whole = picture(21, 19, blocksOf(21, 19));
  for (let length = 0; length < whole.length - 3; length++) expect(() => decodeGreyJpeg(whole.subarray(0, length)), `${length} bytes`).toThrow(/picture/);
  expect(() => decodeGreyJpeg(picture(8, 8, blocksOf(8, 8), 0xc2))).toThrow("progressive");
  const damaged = whole.slice();
  damaged[whole.findIndex((byte, i) => byte === 0xd0 && whole[i - 1] === 0xff)] = 0xd9;
  expect(() => decodeGreyJpeg(damaged)).toThrow("interval");
});
