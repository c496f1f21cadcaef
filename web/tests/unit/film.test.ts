import { expect, test } from "vitest";
import { GifWriter, lzw, quantized } from "../../src/gif.js";
import { annotationFile, parseAnnotations } from "../../src/annotations.js";
import { orbitOf, pathOf } from "../../src/record.js";
import { crc32, zipOf } from "../../src/zip.js";

/** The indices of packed bytes (GIF89a, appendix F). */
function unpacked(bytes: number[]): number[] {
  const out: number[] = [];
  let table: number[][] = [], size = 9, held = 0, bits = 0, before: number[] | null = null;
  const clear = (): void => {
    table = Array.from({ length: 258 }, (_, i) => (i < 256 ? [i] : []));
    [size, before] = [9, null];
  };
  clear();
  for (const byte of bytes) {
    held |= byte << bits;
    bits += 8;
    if (bits < size) continue;
    const code = held & ((1 << size) - 1);
    held >>>= size;
    bits -= size;
    if (code === 257) break;
    if (code === 256) {
      clear();
      continue;
    }
    const known: number[] = table[code] ?? [...(before ?? []), before?.[0] ?? 0];
    out.push(...known);
    if (before && table.length < 4096) table.push([...before, known[0] ?? 0]);
    if (table.length === 1 << size && size < 12) size++;
    before = known;
  }
  return out;
}

test("packed indices come back, over more codes than the table holds", () => {
  let seed = 7;
  const random = (): number => (seed = (seed * 1103515245 + 12345) & 0x7fffffff) >> 16;
  for (const [length, colors] of [[1, 2], [10, 1], [5000, 3], [40_000, 256]] as const) {
    const indices = Uint8Array.from({ length }, () => random() % colors);
    expect(unpacked(lzw(indices))).toEqual([...indices]);
  }
});

test("few colours are kept, and many are near", () => {
  const few = new Uint8ClampedArray([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 0, 0, 255]);
  const { palette, indices } = quantized(few);
  const color = (i: number): number[] => palette.slice(3 * (indices[i] ?? 0), 3 * (indices[i] ?? 0) + 3);
  expect([0, 1, 2, 3].map(color)).toEqual([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 0, 0]]);
  const many = Uint8ClampedArray.from({ length: 4 * 64 * 64 }, (_, i) => [(i >> 2) % 64 * 4, Math.floor((i >> 2) / 64) * 4, 128, 255][i % 4] ?? 0);
  const made = quantized(many);
  expect(made.palette.length).toBe(3 * 256);
  let sum = 0;
  for (let i = 0; i < many.length; i += 4) for (let c = 0; c < 3; c++) sum += Math.abs((many[i + c] ?? 0) - (made.palette[3 * (made.indices[i / 4] ?? 0) + c] ?? 0));
  expect(sum / (many.length * 0.75)).toBeLessThan(4);
});

test("a film has its pictures", async () => {
  const writer = new GifWriter(2, 1, 8);
  for (let i = 0; i < 3; i++) writer.add(new Uint8ClampedArray([i, 2, 3, 255, 4, 5, 6, 255]));
  const bytes = new Uint8Array(await writer.finish().arrayBuffer());
  expect(new TextDecoder().decode(bytes.subarray(0, 6))).toBe("GIF89a");
  expect(bytes[bytes.length - 1]).toBe(0x3b);
});

test("an archive is stored as its format says", async () => {
  expect(crc32(new TextEncoder().encode("123456789"))).toBe(0xcbf43926);
  const bytes = new Uint8Array(await zipOf([["a.txt", Uint8Array.from([104, 105])]]).arrayBuffer());
  const view = new DataView(bytes.buffer);
  expect(view.getUint32(0, true)).toBe(0x04034b50);
  expect(new TextDecoder().decode(bytes.subarray(30, 37))).toBe("a.txthi");
  const end = bytes.length - 22;
  expect(view.getUint32(end, true)).toBe(0x06054b50);
  expect(view.getUint32(view.getUint32(end + 16, true), true)).toBe(0x02014b50);
});

const light = (u: number, v: number) => ({ u, v, color: "#ffffff", strength: 1, softness: 0 });

test("an orbit has as many places as pictures, the last one before the first", () => {
  const frames = orbitOf([light(0.5, 0), light(0.1, 0.1)], 0, 4).map((lights) => lights.map(({ u, v }) => [u, v]));
  [[0.5, 0], [0, -0.5], [-0.5, 0], [0, 0.5]].forEach(([u = 0, v = 0], i) => {
    expect(frames[i]?.[0]?.[0]).toBeCloseTo(u);
    expect(frames[i]?.[0]?.[1]).toBeCloseTo(v);
    expect(frames[i]?.[1]).toEqual([0.1, 0.1]);
  });
});

test("a recorded path is divided evenly in time", () => {
  const path = [[0, 0], [1, 0.1], [4, 0.4]].map(([time = 0, u = 0]) => ({ time, lights: [light(u, 0)] }));
  const places = pathOf(path, 5).map((lights) => lights[0]?.u ?? NaN);
  [0, 0.1, 0.2, 0.3, 0.4].forEach((u, i) => expect(places[i]).toBeCloseTo(u));
});

test("annotations come back, and a file of something else is refused", () => {
  const notes = [{ text: "</script>\n<b>", box: [1, 2, 3, 4] as [number, number, number, number], view: "mode=normals" }];
  expect(parseAnnotations(JSON.parse(annotationFile(notes)))).toEqual(notes);
  for (const bad of [null, {}, [], { relume: "annotations", version: 2, annotations: [] }, { relume: "annotations", version: 1, annotations: [{ text: 1 }] }]) {
    expect(() => parseAnnotations(bad)).toThrow(/annotation/);
  }
});
