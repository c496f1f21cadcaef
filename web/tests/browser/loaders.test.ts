// The package's loaders against the library's own reading of the same files: `relume share` of a file is the library's decoding.
import { copyFileSync, existsSync, readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { type FieldData, type FileSource, type JpegDecoder, loadPtm, loadRti, loadShare, loadWebFolder } from "relume-three";
import { fromHalf } from "../../packages/relume-three/src/half.js";
import { launched } from "../chromium.js";
import { Workplace } from "../program.js";

const place = new Workplace(), TILED = ["deepzoom", "tarzoom", "itarzoom"];
/** A file of HP Labs, where the data for tests on real captures is there. */
const TABLET = `${process.env["RELUME_DATA"] ?? fileURLToPath(new URL("../../../../shared/data", import.meta.url))}/ptm/tablet1.ptm`;
let browser: Browser, page: Page;

beforeAll(async () => {
  place.run("capture leather -o capture --lights 12 --size 40x28 --feature 20");
  place.run("fit capture -o lrgb.ptm");
  place.run("fit capture -o rgb.ptm --color rgb");
  for (const name of ["lrgb", "rgb"]) place.run(`convert ${name}.ptm -o jpeg-${name}.ptm --jpeg 80`);
  for (const basis of ["hsh4", "hsh9"]) place.run(`fit capture --basis ${basis} --color rgb -o ${basis}.exr`);
  place.run("convert hsh4.exr -o hsh4.rti");
  place.run("convert hsh9.exr -o hsh9.rti");
  place.run("convert hsh9.exr -o hsh9.hsh");
  for (const name of ["lrgb.ptm", "rgb.ptm", "hsh9.exr"]) place.run(`convert ${name} --web -o web-${name.replace(/\..*/, "")}`);
  place.run("synth rgb.ptm --size 290x262 --block 12 -o wide.ptm");
  for (const layout of TILED) place.run(`convert wide.ptm --web ${layout} -o web-${layout}`);
  browser = await launched();
  page = await browser.newPage();
});

afterAll(async () => {
  await browser?.close();
  place.remove();
});

function read(name: string): Uint8Array {
  return new Uint8Array(readFileSync(place.path(name)));
}

function folder(name: string): FileSource {
  return async (file) => read(`${name}/${file}`);
}

/** The file as the library reads it. */
async function truth(name: string): Promise<FieldData> {
  const shared = `shared-${name.replace(".", "-")}`;
  place.run(`share ${name} --planes half -o ${shared}`);
  return loadShare(folder(`${shared}/textures/0`));
}

/** The largest difference of two planes. */
function largest(found: FieldData, expected: FieldData): number {
  const shape = ({ width, height, basis, layout, functions, space, planes }: FieldData): unknown => [width, height, basis, layout, functions, space, planes.length];
  expect(shape(found)).toEqual(shape(expected));
  let most = 0;
  expected.planes.forEach((plane, k) => plane.forEach((value, i) => (most = Math.max(most, Math.abs(fromHalf(value) - fromHalf(found.planes[k]?.[i] ?? 0))))));
  return most;
}

// Less than half of the difference of neighbouring codes, so that all are the same.
test.each(["lrgb.ptm", "rgb.ptm", "jpeg-lrgb.ptm", "jpeg-rgb.ptm"])("%s", async (name) => {
  expect(largest(loadPtm(read(name)), await truth(name))).toBeLessThan(2e-3);
});

test.skipIf(!existsSync(TABLET))("a compressed texture map of the time, with predicted and inverted planes", async () => {
  copyFileSync(TABLET, place.path("tablet.ptm"));
  expect(largest(loadPtm(read("tablet.ptm")), await truth("tablet.ptm"))).toBeLessThan(2e-3);
});

test.each(["hsh4.rti", "hsh9.rti", "hsh9.hsh"])("%s", async (name) => {
  expect(largest(loadRti(read(name)), await truth(name))).toBeLessThan(4e-3);
});

/** As the package decodes in a browser, for a test outside of it. */
const decode: JpegDecoder = async (bytes) => {
  const { width, height, text } = await page.evaluate(async (text) => {
    const blob = new Blob([Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0))], { type: "image/jpeg" });
    const image = await createImageBitmap(blob, { colorSpaceConversion: "none", premultiplyAlpha: "none" });
    const { width, height } = image, context = new OffscreenCanvas(width, height).getContext("2d");
    if (!context) throw new Error("no canvas");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    let out = "";
    for (let at = 0; at < data.length; at += 8192) out += String.fromCharCode(...data.subarray(at, at + 8192));
    return { width, height, text: btoa(out) };
  }, Buffer.from(bytes).toString("base64"));
  return { width, height, data: Buffer.from(text, "base64") };
};

test.each(["web-lrgb", "web-rgb", "web-hsh9", ...TILED.map((layout) => `web-${layout}`)])("%s", async (name) => {
  const found = await loadWebFolder(folder(name), decode), expected = await truth(name);
  // Up to three codes of the largest scale: decoders of JPEG round differently, and convert colours differently.
  const scales = (JSON.parse(readFileSync(place.path(`${name}/info.json`), "utf8")) as { materials: { scale: number[] }[] }).materials[0]?.scale ?? [];
  expect(largest(found, expected)).toBeLessThan((3.5 / 255) * Math.max(...scales.map(Math.abs)));
});
