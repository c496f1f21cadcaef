import { deflateSync, gzipSync } from "node:zlib";
import { describe, expect, test } from "vitest";
import { type FileSource, loadShare, parseHeader, weights, BasisTable, MeasuredBasis } from "../src/index.js";
import { contrastLayers, distanceLayers } from "../src/boundaries.js";
import { fromHalf, halvesFrom } from "../src/half.js";
import { decodePng } from "../src/png.js";

const HEADER = {
  relume: "share", version: 1, title: "wool", size: [3, 2], space: "srgb", layout: "lrgb", channels: 3,
  basis: { name: "ptm", functions: 6, channels: 1, depends_on_view: false },
  planes: [
    { file: "a.f16.gz", storage: "half", first: 0, count: 3 },
    { file: "b.f16.gz", storage: "half", first: 3, count: 3 },
    { file: "c.png", storage: "png", first: 6, count: 3, scale: [0.5, 1, 2], offset: [0, -1, 1] },
  ],
  error: 0, maps: [],
};

/** A PNG of 8 bits whose rows use every filter in turn, by the formulas of the standard. */
function png(width: number, height: number, channels: number, codes: number[]): Uint8Array {
  const stride = width * channels, raw: number[] = [];
  const at = (x: number, y: number): number => (x < 0 || y < 0 ? 0 : (codes[y * stride + x] ?? 0));
  for (let y = 0; y < height; y++) {
    const filter = y % 5;
    raw.push(filter);
    for (let x = 0; x < stride; x++) {
      const [a, b, c] = [at(x - channels, y), at(x, y - 1), x < channels ? 0 : at(x - channels, y - 1)];
      const p = a + b - c, nearest = [a, b, c].reduce((best, v) => (Math.abs(p - v) < Math.abs(p - best) ? v : best), a);
      raw.push((at(x, y) - ([0, a, b, (a + b) >> 1, nearest][filter] ?? 0)) & 255);
    }
  }
  const chunk = (name: string, data: Uint8Array): Uint8Array[] => {
    const head = new Uint8Array(8);
    new DataView(head.buffer).setUint32(0, data.length);
    head.set(new TextEncoder().encode(name), 4);
    return [head, data, new Uint8Array(4)];
  };
  const header = new Uint8Array(13);
  new DataView(header.buffer).setUint32(0, width);
  new DataView(header.buffer).setUint32(4, height);
  header.set([8, channels === 1 ? 0 : channels === 4 ? 6 : 2], 8);
  const parts = [...chunk("IHDR", header), ...chunk("IDAT", deflateSync(Uint8Array.from(raw))), ...chunk("IEND", new Uint8Array())];
  return Uint8Array.from([137, 80, 78, 71, 13, 10, 26, 10, ...parts.flatMap((part) => [...part])]);
}

function halves(count: number, value: (i: number) => number): Uint8Array {
  return gzipSync(new Uint8Array(halvesFrom(Float32Array.from({ length: count }, (_, i) => value(i))).buffer));
}

function files(header: object): Record<string, Uint8Array> {
  return {
    "share.json": new TextEncoder().encode(JSON.stringify(header)),
    "a.f16.gz": halves(18, (i) => i / 8),
    "b.f16.gz": halves(18, (i) => -i),
    "c.png": png(3, 2, 3, Array.from({ length: 18 }, (_, i) => 14 * i)),
  };
}

function source(files: Record<string, Uint8Array>): FileSource {
  return async (name) => {
    const bytes = files[name];
    if (!bytes) throw new Error(`${name} is missing`);
    return bytes;
  };
}

test("planes of both storages are read", async () => {
  const data = await loadShare(source(files(HEADER)));
  expect(data.planes).toHaveLength(9);
  expect([...(data.planes[1] ?? [])].map(fromHalf)).toEqual([6, 7, 8, 9, 10, 11].map((i) => i / 8));
  expect(fromHalf(data.planes[3]?.[5] ?? 0)).toBe(-5);
  const green = [...(data.planes[7] ?? [])].map(fromHalf);
  expect(green).toEqual([0, 1, 2, 3, 4, 5].map((i) => 14 * (3 * i + 1) - 1));
});

test("planes that are all stored as codes are also given as codes", async () => {
  const group = (first: number): object => ({ file: "c.png", storage: "png", first, count: 3, scale: [0.5, 1, 2], offset: [0, -1, 1] });
  const header = { ...HEADER, layout: "rgb", basis: { ...HEADER.basis, name: "constant", functions: 1 }, planes: [group(0)] };
  const { codes, planes } = await loadShare(source(files(header)));
  expect(codes?.planes.map((plane) => [...plane])).toEqual([0, 1, 2].map((c) => [0, 1, 2, 3, 4, 5].map((i) => 14 * (3 * i + c))));
  expect([codes?.scale, codes?.offset]).toEqual([[0.5, 1, 2], [0, -1, 1]]);
  expect(fromHalf(planes[2]?.[1] ?? 0)).toBe(2 * 14 * 5 + 1);
  expect((await loadShare(source(files(HEADER)))).codes).toBeNull();
});

test("distances and contrasts of moved boundaries come to the layers in which shaders look them up", async () => {
  const [lights, texels] = [5, 6], basis = { ...HEADER.basis, name: "constant", functions: lights };
  const shapes = { file: "shapes.gz", strengths: [0.5, 0.2], steps: [10, 40], most: [1, 0.6], softness: 1.7 };
  const codes = Uint8Array.from({ length: 2 * lights * texels }, (_, i) => i), contrasts = halvesFrom(Float32Array.from({ length: 8 * texels }, (_, i) => i));
  const header = { ...HEADER, layout: "luminance", channels: 1, basis, shapes, planes: [0, 3].map((first) => ({ file: first ? "e.f16.gz" : "a.f16.gz", storage: "half", first, count: first ? 2 : 3 })) };
  const all = { ...files(header), "e.f16.gz": halves(12, () => 0), "shapes.gz": gzipSync(Buffer.concat([codes, new Uint8Array(contrasts.buffer)])) };
  const { boundaries } = await loadShare(source(all));
  if (!boundaries) throw new Error("no boundaries");
  const layers = distanceLayers(boundaries), terms = contrastLayers(boundaries);
  // Two groups of lights for shadows, then for highlights; what is missing to four lies on the boundary.
  expect(layers.map((layer) => [...layer.subarray(4, 8)])).toEqual([[1, 7, 13, 19], [25, 128, 128, 128], [31, 37, 43, 49], [55, 128, 128, 128]]);
  expect(terms.map((layer) => [...layer.subarray(4, 8)].map(fromHalf))).toEqual([[1, 7, 13, 19], [25, 31, 37, 43]]);
  await expect(loadShare(source({ ...all, "shapes.gz": gzipSync(codes) }))).rejects.toThrow("shapes.gz has 60 bytes: expected 156");
  expect(() => parseHeader(JSON.stringify({ ...header, shapes: { ...shapes, steps: [0, 40] } }))).toThrow("damaged shapes");
});

test("PNG rows of every filter are decoded", async () => {
  for (const channels of [1, 3, 4]) {
    const codes = Array.from({ length: 7 * 11 * channels }, (_, i) => (i * i * 31 + 7 * i) & 255);
    const { codes: found } = await decodePng(png(7, 11, channels, codes));
    expect([...found]).toEqual(codes);
  }
});

test("what unpacks to more than its header says is not unpacked to its end", async () => {
  const bomb = gzipSync(new Uint8Array(1 << 26));
  await expect(loadShare(source({ ...files(HEADER), "a.f16.gz": bomb }))).rejects.toThrow("unpacks to more than the 36 bytes");
  const large = png(64, 64, 1, new Array<number>(64 * 64).fill(0));
  await expect(loadShare(source({ ...files(HEADER), "c.png": large }))).rejects.toThrow("64 x 64 texels: expected 6 at most");
});

describe("files that are not as they should be are refused in a sentence", () => {
  const wrong: [string, object][] = [
    ["version", { ...HEADER, version: 2 }],
    ["mark", { ...HEADER, relume: "else" }],
    ["size", { ...HEADER, size: [0, 2] }],
    ["planes", { ...HEADER, planes: HEADER.planes.slice(1) }],
    ["number of planes", { ...HEADER, planes: HEADER.planes.slice(0, 2) }],
    ["table", { ...HEADER, basis: { ...HEADER.basis, name: "rbf" } }],
    ["layout", { ...HEADER, layout: "cmyk" }],
    ["texels", { ...HEADER, size: [4, 2] }],
    ["title", { ...HEADER, title: { toString: 1 } }],
    ["channels", { ...HEADER, channels: 1 }],
    ["millimetres", { ...HEADER, mm_per_texel: -1 }],
    ["millimetres in words", { ...HEADER, mm_per_texel: "two" }],
    ["scale", { ...HEADER, planes: HEADER.planes.map((group) => ({ ...group, scale: ["1", 1, 1] })) }],
    ["offsets", { ...HEADER, planes: HEADER.planes.map((group) => ({ ...group, offset: [0] })) }],
    ["storage", { ...HEADER, planes: HEADER.planes.map((group) => ({ ...group, storage: "jpeg" })) }],
    ["maps", { ...HEADER, maps: {} }],
    ["a map", { ...HEADER, maps: [null] }],
    ["tiles", { ...HEADER, cells: { tiles: 3, corners: 1, right: [3, 0], down: [0, 1], origin: [0, 0] } }],
    ["steps of tiles", { ...HEADER, cells: { tiles: 2, corners: 1, right: [3, 0], down: [6, 0], origin: [0, 0] } }],
    ["nodes of a table", { ...HEADER, basis: { ...HEADER.basis, table: { file: "t.gz", light_nodes: 1e9, view_nodes: 1e9 } } }],
    ["directions", { ...HEADER, basis: { ...HEADER.basis, measured: { file: "t.gz", corners: "c.gz", map_nodes: 3, lights: [[0, "1"]], views: [] } } }],
  ];
  test.each(wrong)("%s", async (_, header) => {
    await expect(loadShare(source(files(header)))).rejects.toThrow(/^[a-z].*(texture|table|planes|header|numbers)/);
  });
  test("damaged data", async () => {
    const damaged = { ...files(HEADER), "a.f16.gz": Uint8Array.from([31, 139, 8, 0, 1, 2, 3]) };
    await expect(loadShare(source(damaged))).rejects.toThrow("damaged");
    for (const cut of [3, 20, 40, 60]) {
      const short = { ...files(HEADER), "c.png": (files(HEADER)["c.png"] ?? new Uint8Array()).slice(0, cut) };
      await expect(loadShare(source(short)), `cut at ${cut}`).rejects.toThrow();
    }
  });
  test("no JSON", () => expect(() => parseHeader("<html>")).toThrow("not JSON"));
});

test("functions with formulas have the values of the library", () => {
  // relume::field::Basis::weights at (0.36, -0.48, 0.8).
  expect(weights("ptm", [0.36, -0.48, 0.8])).toEqual([0.36 * 0.36, 0.48 * 0.48, 0.36 * -0.48, 0.36, -0.48, 1]);
  const c = 0.8, p = Math.atan2(-0.48, 0.36), s = Math.sqrt(c - c * c), a = Math.sqrt(6 / Math.PI), b = Math.sqrt(30 / Math.PI);
  const customary = [
    1 / Math.sqrt(2 * Math.PI), a * Math.cos(p) * s, Math.sqrt(1.5 / Math.PI) * (2 * c - 1), a * Math.sin(p) * s,
    b * Math.cos(2 * p) * (c * c - c), b * Math.cos(p) * (2 * c - 1) * s, Math.sqrt(2.5 / Math.PI) * (1 - 6 * c + 6 * c * c),
    b * (2 * c - 1) * s * Math.sin(p), b * (c * c - c) * Math.sin(2 * p),
  ];
  weights("hsh9", [0.36, -0.48, 0.8]).forEach((value, k) => expect(value).toBeCloseTo(customary[k] ?? NaN, 12));
});

test("tables are exact at their nodes and continuous in between", () => {
  const nodes = 5, texels = halvesFrom(Float32Array.from({ length: 4 * nodes * nodes }, (_, i) => (i & 3) + (i >> 2)));
  const table = new BasisTable(nodes, 1, 3, 1, texels);
  expect(table.weights(0, [0, 0, 1])).toEqual([12, 13, 14]);
  // The corner (4, 4) of the map is x = 1 on the horizon.
  expect(table.weights(0, [1, 0, 0])).toEqual([24, 25, 26]);
  const near = table.weights(0, [Math.sqrt(1 - 1e-8), 0, 1e-4]);
  near.forEach((value, k) => expect(Math.abs(value - 24 - k)).toBeLessThan(0.2));
});

test("measured functions are linear in triangles, and constant beyond an edge", () => {
  const lights: [number, number][] = [[0, 0], [0.5, 0], [0, 0.5]], texels = halvesFrom([1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0]);
  const nodes = 3, triangle = Uint16Array.from({ length: 8 * nodes * nodes }, (_, i) => (i < 4 * nodes * nodes ? ([0, 1, 2, 0][i % 4] ?? 0) : 0));
  const direction = (x: number, y: number): [number, number, number] => {
    const square = x * x + y * y;
    return [(2 * x) / (1 + square), (2 * y) / (1 + square), (1 - square) / (1 + square)];
  };
  const inside = new MeasuredBasis(lights, [[0, 0]], 1, 1, texels, nodes, triangle);
  expect(inside.weights(0, direction(0.25, 0.125))[0]).toBeCloseTo(0.25 + 2 * 0.5 + 4 * 0.25, 9);
  const edge = triangle.map((value, i) => (i % 4 === 2 ? 0 : value));
  const beyond = new MeasuredBasis(lights, [[0, 0]], 1, 1, texels, nodes, edge);
  expect(beyond.weights(0, direction(0.25, -0.3))[0]).toBeCloseTo(1.5, 9);
  expect(beyond.weights(0, direction(0.9, 0.1))[0]).toBeCloseTo(2, 9);
  expect(() => new MeasuredBasis(lights.slice(1), [[0, 0]], 1, 1, texels.slice(4), nodes, triangle)).toThrow("directions");
});
