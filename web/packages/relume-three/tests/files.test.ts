import { expect, test } from "vitest";
import { type FileSource, type JpegDecoder, loadPtm, loadRti, loadShare, loadWebFolder, glbSource, weights } from "../src/index.js";
import { fromHalf } from "../src/half.js";

const text = (words: string): Uint8Array => new TextEncoder().encode(words);
const joined = (...parts: Uint8Array[]): Uint8Array => Uint8Array.from(parts.flatMap((part) => [...part]));

test("rows of texture maps run from the bottom, and old ones interleave their bytes", () => {
  const head = (version: string): Uint8Array => text(`${version}\nPTM_FORMAT_LRGB\n1\n2\n2 2 2 2 2 2\n0 0 0 0 0 128\n`);
  const texel = (n: number): number[] => [n, 0, 0, 0, 0, 200 + n], color = (n: number): number[] => [n, 2 * n, 3 * n];
  const blocks = loadPtm(joined(head("PTM_1.2"), Uint8Array.from([...texel(1), ...texel(2), ...color(10), ...color(20)])), "x");
  const interleaved = loadPtm(joined(head("PTM_1.1"), Uint8Array.from([...texel(1), ...color(10), ...texel(2), ...color(20)])));
  expect(interleaved.planes).toEqual(blocks.planes);
  expect([...(blocks.planes[0] ?? [])].map(fromHalf)).toEqual([2, 1].map((n) => expect.closeTo((2 * n) / 255, 4)));
  expect(fromHalf(blocks.planes[5]?.[0] ?? 0)).toBeCloseTo((2 * 74) / 255, 3);
  expect(fromHalf(blocks.planes[7]?.[1] ?? 0)).toBeCloseTo(20 / 255, 4);
});

test("luminance with colour differences becomes red, green and blue by its matrix", () => {
  const matrix = "1 0 0 0  0 1 0 0  0 0 2 51  0 0 0 1";
  const data = loadPtm(joined(text(`PTM_1.2\nPTM_FORMAT_LUM\n1 1\n1 1 1 1 1 1\n0 0 0 0 0 0\n${matrix}\n`), Uint8Array.from([10, 20, 30, 40, 50, 60, 70, 80])));
  const values = data.planes.map((plane) => 255 * fromHalf(plane[0] ?? 0));
  const expected = [10, 20, 30, 40, 50, 60, 0, 0, 0, 0, 0, 70, 0, 0, 0, 0, 0, 160 + 51];
  values.forEach((value, k) => expect(Math.abs(value - (expected[k] ?? NaN)), `plane ${k}`).toBeLessThan(0.1));
  expect(data.layout).toBe("rgb");
});

test("texture maps that are not read are refused in a sentence", () => {
  const head = "PTM_1.2\nPTM_FORMAT_RGB\n2 2\n1 1 1 1 1 1\n0 0 0 0 0 0\n";
  for (const [words, sentence] of [
    ["P6\n", "version"], ["PTM_1.2\nPTM_C_LUT\n", "PTM_C_LUT"], ["PTM_1.2\nPTM_FORMAT_RGB\n0 2\n", "width"],
    [head, "72 bytes"], [head.replace("1 1 1", "1 x 1"), "expected a number"], [head.slice(0, 30), "ends before"],
  ] as const)
    expect(() => loadPtm(text(words)), words).toThrow(sentence);
});

test("RTI files: terms given as bands, old files, and what is not read", () => {
  const floats = (...values: number[]): Uint8Array => new Uint8Array(Float32Array.from(values).buffer);
  const numbers = floats(1, 2, 3, 4, 0, 0.5, 0, -1), texel = Uint8Array.from({ length: 12 }, (_, i) => 20 * i);
  for (const said of [4, 1]) {
    const data = loadRti(joined(text(`#HSH1.2\r\n3\r\n1 1 3\r\n${said} 2 1\r\n`), numbers, texel));
    expect([data.basis, data.layout]).toEqual(["hsh4", "rgb"]);
    expect(fromHalf(data.planes[5]?.[0] ?? 0)).toBeCloseTo((100 / 255) * 2 + 0.5, 2);
  }
  const old = loadRti(joined(text("# a\n"), new Uint8Array(Uint32Array.from([1, 1, 3, 2]).buffer), floats(0, 0.5, 0, -1, 1, 2.5, 3, 3), texel));
  expect(fromHalf(old.planes[5]?.[0] ?? 0)).toBeCloseTo((100 / 255) * 2 + 0.5, 2);
  for (const [head, sentence] of [["#\n1\n1 1 3\n6 2 1\n", "type 1"], ["#\n3\n1 1 3\n4 3 1\n", "kind 3"], ["#\n3\n1 1\n", "line of 3"], ["#\n3\n9 9 3\n4 2 1\n", "need"]] as const)
    expect(() => loadRti(joined(text(head), numbers, texel)), head).toThrow(sentence);
});

test("harmonics of sixteen terms are the customary ones", () => {
  const [x, y, c] = [0.36, -0.48, 0.8], p = Math.atan2(y, x), s = Math.sqrt(c - c * c), t = 2 * c - 1, cc = c * c - c;
  const root = (n: number): number => Math.sqrt(n / Math.PI);
  const customary = [
    2 * root(35) * Math.cos(3 * p) * s ** 3, root(210) * Math.cos(2 * p) * t * cc, 2 * root(21) * Math.cos(p) * s * (1 + 5 * cc),
    root(3.5) * (-1 + 12 * c - 30 * c * c + 20 * c ** 3), 2 * root(21) * s * (1 + 5 * cc) * Math.sin(p), root(210) * t * cc * Math.sin(2 * p),
    2 * root(35) * s ** 3 * Math.sin(3 * p),
  ];
  const found = weights("hsh16", [x, y, c]);
  customary.forEach((value, k) => expect(found[9 + k], `H${9 + k}`).toBeCloseTo(value, 12));
  expect(weights("hsh4", [x, y, c])).toEqual(found.slice(0, 4));
});

const PLANES = { scale: Array<number>(18).fill(1), bias: Array<number>(18).fill(0) };

/** A folder of files in memory; its pictures are their texels, red, green, blue and opacity, after width and height. */
function folder(files: Record<string, Uint8Array>): FileSource {
  return async (name) => {
    const bytes = files[name];
    if (!bytes) throw new Error("none");
    return bytes;
  };
}

const decode: JpegDecoder = async (bytes) => ({ width: bytes[0] ?? 0, height: bytes[1] ?? 0, data: bytes.subarray(2) });

test("web folders of other types, and incomplete ones, are refused by name", async () => {
  const info = { width: 2, height: 2, type: "ptm", colorspace: "rgb", nplanes: 18, materials: [PLANES] };
  const load = (change: object, files: Record<string, Uint8Array> = {}): Promise<unknown> => loadWebFolder(folder({ "info.json": text(JSON.stringify({ ...info, ...change })), ...files }), decode);
  await expect(load({})).rejects.toThrow("planes.tzi");
  await expect(load({ type: "rbf" })).rejects.toThrow("rbf");
  await expect(load({ colorspace: "mycc" })).rejects.toThrow("mycc");
  await expect(load({ nplanes: 12 })).rejects.toThrow("4 functions");
  await expect(load({ materials: [] })).rejects.toThrow("scale");
  await expect(load({}, Object.fromEntries([0, 1, 2, 3, 4, 5].map((k) => [`plane_${k}.jpg`, Uint8Array.from([1, 2])])))).rejects.toThrow("plane_0.jpg has 1 x 2");
  await expect(load({}, { "plane_0.dzi": text('<Image TileSize="16" Overlap="0"><Size Width="2" Height="3"/></Image>') })).rejects.toThrow("2 x 3");
  await expect(load({}, { "plane_0.dzi": text('<Image TileSize="16" Overlap="0"><Size Width="2" Height="2"/></Image>') })).rejects.toThrow("plane_0_files");
  await expect(load({}, { "planes.tzi": text('{"tilesize":16,"width":2,"height":2,"stride":2,"offsets":[0,0,0]}'), "planes.tzb": text("") })).rejects.toThrow("2 planes");
  await expect(load({}, Object.fromEntries([0, 1, 2, 3, 4, 5].flatMap((k) => [[`plane_${k}.tzi`, text('{"tilesize":16,"width":2,"height":2,"offsets":[0,9]}')], [`plane_${k}.tzb`, text("x")]])))).rejects.toThrow("offsets");
  await expect(load({}, { "plane_0.tzi": text("[") })).rejects.toThrow("not JSON");
});

test("overlapping tiles of a web folder come to their places, whatever level is the finest", async () => {
  const [width, height, side, overlap] = [37, 21, 16, 1], info = { width, height, type: "hsh", colorspace: "rgb", nplanes: 12, materials: [PLANES] };
  const files: Record<string, Uint8Array> = { "info.json": text(JSON.stringify(info)) };
  const value = (x: number, y: number, plane: number): number => (7 * x + 13 * y + 31 * plane) % 251;
  for (let plane = 0; plane < 4; plane++)
    for (let ty = 0; ty < 2; ty++)
      for (let tx = 0; tx < 3; tx++) {
        const left = Math.max(0, tx * side - overlap), right = Math.min(width, (tx + 1) * side + overlap), top = Math.max(0, ty * side - overlap), bottom = Math.min(height, (ty + 1) * side + overlap);
        const texels: number[] = [];
        for (let y = top; y < bottom; y++) for (let x = left; x < right; x++) texels.push(value(x, y, plane), 0, 0, 255);
        files[`plane_${plane}_files/3/${tx}_${ty}.jpg`] = Uint8Array.from([right - left, bottom - top, ...texels]);
      }
  files["plane_0.dzi"] = text(`<Image Format="jpg" Overlap="${overlap}" TileSize="${side}"><Size Height="${height}" Width="${width}"/></Image>`);
  const data = await loadWebFolder(folder(files), decode);
  const found = Array.from(data.planes[2] ?? [], (half) => Math.round(255 * fromHalf(half)));
  expect(found).toEqual(Array.from({ length: width * height }, (_, i) => value(i % width, Math.floor(i / width), 2)));
});

test("functions of light are found in binary glTF", async () => {
  const share = {
    relume: "share", version: 1, title: "t", size: [1, 1], space: "srgb", layout: "rgb", channels: 3, error: 0, maps: [],
    basis: { name: "constant", functions: 1, channels: 1, depends_on_view: false }, planes: [{ file: "planes-0.f16.gz", storage: "half", first: 0, count: 3 }],
  };
  const packed = new Uint8Array(await new Response(new Blob([Uint8Array.from([0, 0x3c, 0, 0x38, 0, 0x34])]).stream().pipeThrough(new CompressionStream("gzip"))).arrayBuffer());
  const extension = { share, files: { "planes-0.f16.gz": 1 } };
  const json = JSON.stringify({ materials: [{ name: "m", extensions: { RELUME_reflectance: extension } }], bufferViews: [{ byteLength: 0 }, { byteOffset: 4, byteLength: packed.length }] });
  const chunk = (kind: number, data: Uint8Array): Uint8Array => joined(new Uint8Array(Uint32Array.from([data.length, kind]).buffer), data);
  const body = joined(chunk(0x4e4f534a, text(json)), chunk(0x004e4942, joined(new Uint8Array(4), packed)));
  const glb = joined(new Uint8Array(Uint32Array.from([0x46546c67, 2, 12 + body.length]).buffer), body);
  const data = await loadShare(glbSource(glb));
  expect(data.planes.map((plane) => fromHalf(plane[0] ?? 0))).toEqual([1, 0.5, 0.25]);
  expect(() => glbSource(glb, 1)).toThrow("material 1");
  expect(() => glbSource(glb.slice(0, 40))).toThrow("early");
  await expect(glbSource(glb)("other.png")).rejects.toThrow("missing");
});
