// Large textures: a picture after few bytes, and tiles where the view needs them.
import { createServer } from "node:http";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { gzipSync } from "node:zlib";
import { expect, test } from "vitest";
import { ViewServer } from "../program.js";
import { writePtm } from "../shapes.js";
import { session } from "./opened.js";
import { canvas, difference, drawn, file, show } from "./pictures.js";

const served = session([], [], (place) => writePtm(place.path("large.ptm"), 2048)), { place, opener } = served;

test("2048 x 2048 texels are seen within a second of opening", async () => {
  const server = await ViewServer.start(place, ["large.ptm"]);
  const page = await opener.open(server.url);
  const seen = Number(await page.evaluate(() => document.documentElement.dataset["seen"]));
  console.log(`a picture of 2048 x 2048 texels after ${Math.round(seen)} ms`);
  // A second on a machine that does nothing else; tests share theirs.
  expect(seen).toBeLessThan(4000);
  await page.close();
  await server.stop();
});

test("4096 x 4096 texels are seen after 300 kB", async () => {
  writePtm(place.path("huge.ptm"), 4096);
  place.run("share huge.ptm -o shared");
  const files = createServer((request, response) => {
    const name = (request.url ?? "/").replace(/[?#].*/, "").replace(/\/$/, "/index.html");
    if (name === "/favicon.ico") return response.writeHead(404).end();
    const bytes = readFileSync(join(place.path("shared"), name)), isText = /\.(html|js|css|json)$/.test(name);
    const body = isText ? gzipSync(bytes, { level: 9 }) : bytes;
    if (isText) response.setHeader("Content-Encoding", "gzip");
    response.setHeader("Content-Type", name.endsWith("html") ? "text/html" : name.endsWith("js") ? "text/javascript" : name.endsWith("css") ? "text/css" : "application/octet-stream");
    response.end(body);
  });
  await new Promise<void>((resolve) => files.listen(0, "127.0.0.1", resolve));
  const address = files.address(), page = await served.browser.newPage({ viewport: { width: 700, height: 440 } });
  await page.goto(`http://127.0.0.1:${typeof address === "object" ? address?.port : 0}/`);
  await page.waitForFunction(() => document.documentElement.dataset["seen"] !== undefined, null, { timeout: 100_000 });
  // What had begun to come by then.
  const bytes = await page.evaluate(() => {
    const seen = Number(document.documentElement.dataset["seen"]);
    const files = [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")] as PerformanceResourceTiming[];
    return files.filter((file) => file.requestStart < seen).reduce((sum, file) => sum + file.encodedBodySize, 0);
  });
  console.log(`a picture of 4096 x 4096 texels after ${Math.round(bytes / 1000)} kB, page and all`);
  expect(bytes).toBeLessThan(300_000);
  await page.close();
  files.close();
}, 600_000);

test("tiles show what the texture is, at every magnification, and objects its coarser level", async () => {
  const server = await ViewServer.start(place, ["large.ptm"]);
  const page = await opener.open(`${server.url}?exact`, { viewport: { width: 512, height: 512 } });
  await page.evaluate(() => document.querySelector(".panel")?.setAttribute("hidden", ""));
  await drawn(page);
  const settled = async (): Promise<void> => {
    await page.waitForFunction(() => document.documentElement.dataset["tiles"] === "0");
    await drawn(page);
  };
  place.run("relight large.ptm --light 0.3,0.2,0.933 -o truth.png --force");
  const truth = await file(place.path("truth.png"));
  // At four times the size of the window a texel is a pixel: across the corner of four tiles.
  await show(page, "zoom=4&x=0.5&y=0.5&lights=0.3,0.2,ffffff,1");
  await settled();
  const shown = await canvas(page), part = new Uint8Array(512 * 512 * 3);
  for (let y = 0; y < 512; y++) part.set(truth.codes.subarray(3 * ((y + 768) * 2048 + 768), 3 * ((y + 768) * 2048 + 1280)), 3 * y * 512);
  const { mean, most } = difference(shown, { width: 512, height: 512, channels: 3, codes: part });
  console.log(`tiles of ${truth.width} texels: mean ${mean.toFixed(3)}, 99 %: ${most}`);
  expect(mean).toBeLessThan(1);
  expect(most).toBeLessThanOrEqual(4);
  // Single texels as squares, and a blur that reaches over the borders of tiles.
  await show(page, "zoom=40&x=0.25&y=0.25&lights=0.3,0.2,ffffff,1");
  await settled();
  expect(difference(await canvas(page), shown).mean).toBeGreaterThan(1);
  await show(page, "zoom=4&mode=unsharp-luminance&gain=2&lights=0.3,0.2,ffffff,1");
  await settled();
  const sharp = await canvas(page), edges = [255, 256].map((x) => acrossRow(sharp, x)), others = [200, 300].map((x) => acrossRow(sharp, x));
  expect(Math.max(...edges)).toBeLessThan(2 * Math.max(...others));
  await show(page, "object=sphere&lights=0.3,0.2,ffffff,1");
  await settled();
  expect(difference(await canvas(page), shown).mean).toBeGreaterThan(2);
  await page.close();
  await server.stop();
});

/** The mean difference between a column and the next. */
function acrossRow({ codes, width, height }: { codes: Uint8Array; width: number; height: number }, x: number): number {
  let sum = 0;
  for (let y = 0; y < height; y++) sum += Math.abs((codes[4 * (y * width + x)] ?? 0) - (codes[4 * (y * width + x + 1)] ?? 0));
  return sum / height;
}
