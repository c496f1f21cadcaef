// The page as people use it.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import type { Page } from "playwright-core";
import { expect, test } from "vitest";
import { MODES } from "relume-three";
import { drawingSeconds } from "../chromium.js";
import { ViewServer } from "../program.js";
import { writeStrip } from "../shapes.js";
import { session } from "./opened.js";
import { canvas, difference, drawn, show } from "./pictures.js";

const served = session(
  [
    "capture leather -o capture --lights 16 --size 128x128 --feature 32", "fit capture -o leather.ptm",
    "capture weave -o weave --lights 12 --size 128x128", "fit weave -o weave.ptm", "roll weave.ptm -k 4 -o tiles.ptm",
  ],
  ["leather.ptm", "weave.ptm", "tiles.ptm"],
), { place, opener } = served;

test("every mode differs from the default, and every object from the others", async () => {
  const page = await opener.open(served.url);
  await show(page, "mode=default");
  const plain = await canvas(page);
  for (const mode of MODES.slice(1)) {
    await show(page, `mode=${mode}&gain=2`);
    expect(difference(await canvas(page), plain).mean, mode).toBeGreaterThan(0.5);
  }
  const seen = [plain];
  for (const object of ["plane", "sphere", "torus", "cloth"]) {
    await show(page, `object=${object}`);
    const picture = await canvas(page);
    for (const other of seen) expect(difference(picture, other).mean, object).toBeGreaterThan(2);
    seen.push(picture);
  }
  await page.close();
});

test("diffuse gain of 1 and effects without an amount change nothing", async () => {
  const page = await opener.open(served.url);
  await show(page, "mode=default");
  const plain = await canvas(page);
  for (const word of ["mode=diffuse-gain&gain=1", "mode=unsharp-luminance&gain=0", "mode=unsharp-coefficients&gain=0"]) {
    await show(page, word);
    expect(difference(await canvas(page), plain).most, word).toBeLessThanOrEqual(1);
  }
  await page.close();
});

test("the still under many lights is the same wherever the light is, and shows more of the relief", async () => {
  const page = await opener.open(served.url), still: [string, string] = ["mode=multi-light&gain=1&lights=-0.5,0.5,ffffff,1", "mode=multi-light&gain=1&lights=0.7,-0.1,ffffff,1"];
  await show(page, still[0]);
  const first = await canvas(page);
  await show(page, still[1]);
  expect(difference(await canvas(page), first).mean).toBe(0);
  await show(page, "lights=0,0,ffffff,1");
  const above = await canvas(page);
  // The mean difference of neighbours, relative to the mean.
  const contrast = ({ codes, width, height }: typeof above): number => {
    let sum = 0, steps = 0;
    for (let y = 0; y < height; y++)
      for (let x = 1; x < width; x++) {
        const at = 4 * (y * width + x);
        sum += codes[at] ?? 0;
        steps += Math.abs((codes[at] ?? 0) - (codes[at - 4] ?? 0));
      }
    return steps / sum;
  };
  expect(contrast(first)).toBeGreaterThan(1.3 * contrast(above));
  await page.close();
});

test("the light follows pointer, touch, keys and ball, and undo takes it back", async () => {
  const page = await opener.open(served.url, { viewport: { width: 700, height: 440 }, hasTouch: true });
  const first = await canvas(page);
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 100, box.y + box.height / 2 - 60, { steps: 4 });
  await page.mouse.up();
  await drawn(page);
  await page.waitForTimeout(400);
  const half = Math.min(box.width, box.height) / 2;
  const lights = /lights=([-\d.]+),([-\d.]+)/.exec(page.url());
  expect(Number(lights?.[1])).toBeCloseTo(100 / half, 2);
  expect(Number(lights?.[2])).toBeCloseTo(60 / half, 2);
  const dragged = await canvas(page);
  expect(difference(dragged, first).mean).toBeGreaterThan(1);
  await page.keyboard.press("Control+z");
  await drawn(page);
  expect(difference(await canvas(page), first).mean).toBe(0);
  await page.keyboard.press("Control+y");
  await drawn(page);
  expect(difference(await canvas(page), dragged).mean).toBe(0);
  await page.locator("canvas").focus();
  await page.keyboard.press("ArrowLeft");
  await drawn(page);
  expect(difference(await canvas(page), dragged).mean).toBeGreaterThan(0.01);
  await page.touchscreen.tap(box.x + 30, box.y + box.height - 80);
  await drawn(page);
  const tapped = await canvas(page);
  expect(difference(tapped, dragged).mean).toBeGreaterThan(1);
  const ball = await page.locator(".pad").boundingBox();
  if (!ball) throw new Error("no ball");
  await page.mouse.click(ball.x + ball.width / 2, ball.y + ball.height / 2);
  await drawn(page);
  expect(difference(await canvas(page), tapped).mean).toBeGreaterThan(1);
  await page.close();
});

test("the view moves and magnifies down to single texels", async () => {
  const page = await opener.open(served.url);
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  for (let i = 0; i < 6; i++) await page.mouse.wheel(0, -400);
  await page.waitForFunction(() => Number(/zoom=([\d.]+)/.exec(location.href)?.[1]) > 50);
  await drawn(page);
  // Texels are squares of one colour: neighbours on the screen are equal for the most part.
  const { codes, width, height } = await canvas(page);
  let same = 0;
  for (let i = 0; i + 1 < width * height; i++) same += Number([0, 1, 2].every((c) => codes[4 * i + c] === codes[4 * i + 4 + c]));
  expect(same / (width * height)).toBeGreaterThan(0.9);
  const before = await canvas(page);
  await page.mouse.down({ button: "right" });
  await page.mouse.move(box.x + box.width / 2 + 150, box.y + box.height / 2 + 20, { steps: 3 });
  await page.mouse.up({ button: "right" });
  await drawn(page);
  expect(difference(await canvas(page), before).mean).toBeGreaterThan(0.5);
  await page.close();
});

test("a wipe shows one texture on each side, and an address restores the view", async () => {
  const page = await opener.open(served.url);
  const pictures = [];
  for (const hash of ["texture=0", "texture=1", "texture=0&other=1&compare=wipe&wipe=0.4"]) {
    await show(page, hash);
    pictures.push(await canvas(page));
  }
  const [left, right, both] = pictures;
  if (!left || !right || !both) throw new Error("three pictures");
  const part = (from: number, to: number, other: typeof left): number => {
    let sum = 0;
    for (let y = 0; y < both.height; y++)
      for (let x = Math.round(from * both.width); x < to * both.width; x++) sum += Math.abs((both.codes[4 * (y * both.width + x)] ?? 0) - (other.codes[4 * (y * both.width + x)] ?? 0));
    return sum;
  };
  expect(part(0, 0.39, left)).toBe(0);
  expect(part(0.41, 1, right)).toBe(0);
  expect(part(0, 0.39, right)).toBeGreaterThan(1000);
  const again = await opener.open(page.url());
  expect(difference(await canvas(again), both).mean).toBe(0);
  await again.close();
  await page.close();
});

test("tiles cover a plane as sharply far away as near", async () => {
  const page = await opener.open(served.url);
  for (const hash of ["texture=2&zoom=0.5", "texture=2&zoom=0.5&x=1000000.5&y=-300000.5"]) {
    await show(page, hash);
    const { codes, width, height } = await canvas(page);
    const distinct = new Set<number>();
    for (let i = 0; i < width * height; i++) distinct.add((codes[4 * i] ?? 0) * 65536 + (codes[4 * i + 1] ?? 0) * 256 + (codes[4 * i + 2] ?? 0));
    expect(distinct.size, hash).toBeGreaterThan(1000);
  }
  await page.close();
});

test("ruler, bookmarks, snapshot and help work", async () => {
  const page = await opener.open(served.url);
  await page.keyboard.press("r");
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  const scale = Math.min(box.width, box.height) / 128;
  await page.mouse.move(box.x + 150, box.y + 150);
  await page.mouse.down();
  await page.mouse.move(box.x + 150 + 64 * scale, box.y + 150, { steps: 3 });
  await page.mouse.up();
  expect(await page.locator(".overlay text").textContent()).toBe("64 px");
  await page.keyboard.press("r");
  expect(await page.locator(".overlay text").count()).toBe(0);
  await show(page, "mode=normals");
  const normals = await canvas(page);
  await page.keyboard.press("b");
  await page.getByLabel("Name of the bookmark").fill("<b>normals</b>");
  await page.getByText("Keep this view").click();
  await page.keyboard.press("Escape");
  await show(page, "mode=default");
  await page.keyboard.press("b");
  await page.getByText("<b>normals</b>").click();
  await drawn(page);
  expect(difference(await canvas(page), normals).mean).toBe(0);
  const [saved] = await Promise.all([page.waitForEvent("download"), page.getByLabel("Save a picture").click()]);
  expect(saved.suggestedFilename()).toBe("leather.png");
  expect(readFileSync(await saved.path()).subarray(1, 4).toString()).toBe("PNG");
  await page.getByRole("button", { name: "Help" }).click();
  expect(await page.getByRole("dialog", { name: "Help" }).isVisible()).toBe(true);
  await page.close();
});

test("a phone and a dense screen show everything within their width", async () => {
  for (const options of [
    { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true },
    { viewport: { width: 800, height: 600 }, deviceScaleFactor: 2 },
  ]) {
    const page = await opener.open(served.url, options);
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(options.viewport.width);
    const width = await page.evaluate(() => document.querySelector("canvas")?.width ?? 0);
    expect(width).toBe(2 * Math.round((await page.locator("canvas").boundingBox())?.width ?? 0));
    await page.getByLabel("Controls", { exact: true }).first().click();
    await page.close();
  }
});

test("axe finds no fault, in dark and light", async () => {
  const axe = readFileSync(new URL("../../node_modules/axe-core/axe.min.js", import.meta.url), "utf8");
  for (const colorScheme of ["dark", "light"] as const) {
    const page = await opener.open(served.url, { viewport: { width: 900, height: 700 }, colorScheme });
    await page.evaluate(axe);
    const found = await page.evaluate(async () => {
      const { violations } = await (globalThis as unknown as { axe: { run(): Promise<{ violations: { id: string; nodes: { html: string }[] }[] }> } }).axe.run();
      return violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(" ")}`);
    });
    expect(found).toEqual([]);
    await page.close();
  }
});

test("one file opens from disk, a folder from a server, and both show what the server shows", async () => {
  place.run("share leather.ptm --single-file -o leather.html");
  place.run("share leather.ptm -o shared");
  const page = await opener.open(served.url);
  await show(page, "texture=0");
  const truth = await canvas(page);
  await page.close();
  const options = { viewport: { width: 700, height: 440 } };
  const single = await opener.open(`file://${place.path("leather.html")}`, options);
  await show(single, "texture=0");
  expect(difference(await canvas(single), truth).mean).toBe(0);
  await single.close();
  const files = createServer((request, response) => {
    const name = (request.url ?? "/").replace(/[?#].*/, "").replace(/\/$/, "/index.html");
    const kind = name.endsWith("html") ? "text/html" : name.endsWith("js") ? "text/javascript" : name.endsWith("css") ? "text/css" : "application/octet-stream";
    response.setHeader("Content-Type", kind).end(readFileSync(join(place.path("shared"), name)));
  });
  await new Promise<void>((resolve) => files.listen(0, "127.0.0.1", resolve));
  const address = files.address();
  const folder = await opener.open(`http://127.0.0.1:${typeof address === "object" ? address?.port : 0}/`, options);
  await show(folder, "texture=0");
  expect(difference(await canvas(folder), truth).mean).toBe(0);
  await folder.close();
  files.close();
});

test("a folder opened from disk, and a damaged file, say what is wrong", async () => {
  place.run("share leather.ptm -o disk");
  const page = await served.browser.newPage();
  await page.goto(`file://${place.path("disk/index.html")}`);
  await page.waitForFunction(() => document.documentElement.dataset["ready"] !== undefined);
  expect(await page.locator(".notice").textContent()).toContain("--single-file");
  await page.close();
  place.run("completions bash");
  const broken = await ViewServer.start(place, ["leather.ptm", "relume-no-such-file.ptm"]);
  const other = await opener.open(broken.url);
  expect(await other.locator(".notice").textContent()).toContain("relume-no-such-file.ptm");
  await other.close();
  await broken.stop();
});

test("the picture follows the light by software at ten frames a second on two processors", async () => {
  writeStrip(place.path("large.ptm"), 1024, 1024);
  place.run("share large.ptm --single-file -o large.html");
  for (const query of ["", "?exact"]) {
    const page = await opener.open(`file://${place.path("large.html")}${query}`, { viewport: { width: 640, height: 400 } });
    await page.waitForTimeout(500);
    const before = drawingSeconds(), times = await followed(page);
    const seconds = ((drawingSeconds() ?? 0) - (before ?? 0)) / times.length, [best = 0, median = 0] = [times[0], times[times.length >> 1]];
    const said = before === null ? "" : `${(1000 * seconds).toFixed(0)} ms of processors a frame, `;
    console.log(`1024 x 1024 texels on 640 x 400 pixels, ${query === "" ? "as the page chooses" : "with all pixels"}: ${said}${(1000 / median).toFixed(1)} frames a second, ${(1000 / best).toFixed(1)} at best`);
    // Processor time, since the machine may be busy with other work; and never a page that hangs.
    expect(seconds).toBeLessThan(0.2);
    expect(best).toBeLessThan(1000);
    expect(median).toBeLessThan(5000);
    await page.waitForFunction(() => document.documentElement.dataset["coarse"] === "false");
    expect(await page.evaluate(() => document.querySelector("canvas")?.width)).toBe(640);
    await page.close();
  }
});

/** The milliseconds of frames in which the light moves, in order. */
async function followed(page: Page): Promise<number[]> {
  return page.evaluate(async () => {
    const times: number[] = [], pixels = new Uint8Array(4);
    const view = document.querySelector("canvas") as HTMLCanvasElement, gl = view.getContext("webgl2") as WebGL2RenderingContext;
    for (let i = 0; i < 24; i++) {
      const begun = performance.now();
      view.dispatchEvent(new KeyboardEvent("keydown", { key: i % 2 ? "ArrowLeft" : "ArrowRight" }));
      await new Promise((resolve) => requestAnimationFrame(resolve));
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      times.push(performance.now() - begun);
    }
    return times.sort((a, b) => a - b);
  });
}
