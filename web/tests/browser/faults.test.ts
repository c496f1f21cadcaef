// Faults that the page once had, each under its name.
import { readFileSync } from "node:fs";
import type { BrowserContextOptions, Page } from "playwright-core";
import { expect, test } from "vitest";
import { type Codes, decodePng } from "../../packages/relume-three/src/png.js";
import { ViewServer } from "../program.js";
import { writePtm, writeStrip } from "../shapes.js";
import { at, drag, entry, listed, pinch, textOf, textsIn, write } from "./hands.js";
import { LEATHER, MARBLE, USUAL, session } from "./opened.js";
import { canvas, difference, drawn, settled, show } from "./pictures.js";

const PHONE: BrowserContextOptions = { viewport: { width: 390, height: 844 }, isMobile: true, hasTouch: true };
const NAME = "leather.ptm.annotations.json";
const served = session([...LEATHER, ...MARBLE], ["leather.ptm", "marble.rlm"]), { place, opener } = served;

const texts = (): string[] => textsIn(place.path(NAME));

test("a film of few pictures has them all, and one of many has each in its place", async () => {
  const page = await opener.open(served.url, { viewport: { width: 321, height: 241 } });
  await page.keyboard.press("h");
  await drawn(page);
  for (const count of [2, 3, 4, 40]) {
    const [film, zip] = [await made(page, "webm", count), await made(page, "zip", count)];
    const { pictures, length } = await played(film, count, 12);
    expect(length).toBeCloseTo(count / 12, 2);
    expect(zip.readUInt16LE(zip.length - 12)).toBe(count);
    for (const [i, picture] of pictures.entries()) {
      // Others of the film are further away than the losses of its codec.
      const truths = await Promise.all([i, (i + (count >> 1)) % count].map((k) => decodePng(entry(zip, k))));
      const [own, other] = truths.map((truth) => difference(picture, within(truth, picture)).mean);
      expect(own, `picture ${i} of ${count}`).toBeLessThan(6);
      expect(own, `picture ${i} of ${count}`).toBeLessThan((other ?? 0) / 2);
    }
  }
  await page.close();
});

/** The left upper part of a picture, as large as another. */
function within({ width, channels, codes }: Codes, { width: w, height: h }: Codes): Codes {
  const part = new Uint8Array(w * h * channels);
  for (let y = 0; y < h; y++) part.set(codes.subarray(y * width * channels, (y * width + w) * channels), y * w * channels);
  return { width: w, height: h, channels, codes: part };
}

async function made(page: Page, format: string, count: number): Promise<Buffer> {
  await page.getByRole("button", { name: "Record the light" }).click();
  await page.getByLabel("Pictures").fill(String(count));
  await page.getByLabel("Kind of file").selectOption(format);
  const [saved] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Make", exact: true }).click()]);
  return readFileSync(await saved.path());
}

/** The pictures of a film as the browser plays it, and its length in seconds. */
async function played(film: Buffer, count: number, rate: number): Promise<{ pictures: Codes[]; length: number }> {
  const page = await served.browser.newPage();
  const { urls, length } = await page.evaluate(async ({ film, count, rate }) => {
    const video = document.createElement("video"), canvas = document.createElement("canvas"), context = canvas.getContext("2d");
    const bytes = Uint8Array.from(atob(film), (c) => c.charCodeAt(0));
    video.src = URL.createObjectURL(new Blob([bytes], { type: "video/webm" }));
    video.muted = true;
    await new Promise((resolve, reject) => {
      video.onloadeddata = resolve;
      video.onerror = () => reject(new Error(video.error?.message));
    });
    [canvas.width, canvas.height] = [video.videoWidth, video.videoHeight];
    const urls: string[] = [];
    for (let i = 0; i < count; i++) {
      // A busy machine says that it found a picture before it shows it; one that is shown already is not shown again.
      const shown = new Promise((resolve) => {
        video.requestVideoFrameCallback(resolve);
        setTimeout(resolve, 1500);
      });
      const found = new Promise((resolve) => (video.onseeked = resolve));
      video.currentTime = (i + 0.5) / rate;
      await Promise.all([found, shown]);
      context?.drawImage(video, 0, 0);
      urls.push(canvas.toDataURL());
    }
    return { urls, length: video.duration };
  }, { film: film.toString("base64"), count, rate });
  await page.close();
  const pictures = await Promise.all(urls.map((url) => decodePng(new Uint8Array(Buffer.from(url.split(",")[1] ?? "", "base64")))));
  return { pictures, length };
}

test("a server that ends is said, what was drawn stays, and annotations are kept until it answers", async () => {
  const own = await ViewServer.start(place, ["marble.rlm"]);
  const page = await opener.open(own.url);
  await show(page, "zoom=0.5");
  await settled(page);
  const here = await canvas(page);
  await own.stop();
  await show(page, "zoom=0.5&x=300");
  await expect.poll(() => textOf(page, ".notice")).toMatch(/^block_.* cannot be loaded: the server does not answer\. The page tries again\.$/);
  await show(page, "zoom=0.5");
  expect(difference(await canvas(page), here).mean).toBe(0);
  await write(page, "unsaved");
  await expect.poll(() => textOf(page, ".notice")).toContain("The annotations are not saved: relume view does not answer, or has ended.");
  await expect.poll(() => listed(page)).toEqual(["unsaved"]);
  await page.close();
  opener.forgiveFailedRequests();
});

test("squares, tiles and annotations come when the server answers again", async () => {
  // Large enough to come in tiles.
  writePtm(place.path("large.ptm"), 1472);
  const own = await ViewServer.start(place, ["marble.rlm", "large.ptm", "leather.ptm"]);
  const page = await opener.open(own.url);
  for (const view of ["texture=0&zoom=0.5&x=40&lights=-0.5,0.5,ffffff,1", "texture=1&zoom=12&x=0.3&lights=-0.5,0.5,ffffff,1"]) {
    await page.route(/block_|tile-/, (route) => route.abort());
    await show(page, view);
    await expect.poll(() => textOf(page, ".notice")).toContain("The page tries again.");
    await page.unroute(/block_|tile-/);
    await page.waitForFunction(() => document.querySelector(".notice")?.textContent === "" && document.documentElement.dataset["tiles"] === "0");
    await settled(page);
    const fresh = await opener.open(`${own.url}#${view}`);
    await fresh.waitForFunction(() => document.documentElement.dataset["tiles"] === "0");
    await settled(fresh);
    expect(difference(await canvas(page), await canvas(fresh)).mean).toBe(0);
    await fresh.close();
  }
  await show(page, "texture=2");
  await page.route(/annotations/, (route) => route.abort());
  await write(page, "later");
  await expect.poll(() => textOf(page, ".notice")).toContain("not saved");
  expect(texts()).toEqual([]);
  await page.unroute(/annotations/);
  await expect.poll(texts, { timeout: 10_000 }).toEqual(["later"]);
  await expect.poll(() => textOf(page, ".notice")).toBe("");
  await page.close();
  await own.stop();
  opener.forgiveFailedRequests();
});

test("the view moves and magnifies while the ruler or an annotation is drawn", async () => {
  const page = await opener.open(served.url, { ...USUAL, hasTouch: true });
  for (const start of [(): Promise<void> => page.keyboard.press("r"), (): Promise<void> => page.getByRole("button", { name: "Add", exact: true }).click()]) {
    await show(page, "zoom=2");
    await start();
    let before = await canvas(page);
    const moved = async (what: string): Promise<void> => {
      await drawn(page);
      const now = await canvas(page);
      expect(difference(now, before).mean, what).toBeGreaterThan(0.5);
      before = now;
    };
    await page.mouse.move(...(await at(page, 200, 200)));
    await page.mouse.wheel(0, -300);
    await moved("wheel");
    await drag(page, [200, 200], [260, 230], "right");
    await moved("second button");
    await page.keyboard.down("Shift");
    await drag(page, [200, 200], [260, 230]);
    await page.keyboard.up("Shift");
    await moved("Shift");
    await pinch(page);
    await moved("pinch");
    await page.getByRole("button", { name: "Drag moves the view" }).click();
    await drag(page, [200, 200], [240, 200]);
    await page.getByRole("button", { name: "Drag moves the view" }).click();
    await moved("moving mode");
    expect(await page.locator(".overlay line, .overlay rect").count()).toBe(0);
    await show(page, "object=sphere");
    await drag(page, [200, 200], [260, 230], "right");
    await moved("object");
    await show(page, "zoom=2");
    await drag(page, [200, 200], [260, 230]);
    await page.keyboard.press("Escape");
    if (await page.getByRole("dialog").isVisible()) continue;
    expect(await page.locator(".overlay line").count()).toBe(0);
  }
  expect(await page.getByRole("dialog", { name: "Annotation" }).isVisible()).toBe(false);
  await page.close();
});

test("a way of showing that a texture does not know falls back, also beside another", async () => {
  const page = await opener.open(served.url), way = page.getByLabel("What is shown");
  const view = async (hash: string): Promise<Codes> => {
    await show(page, hash);
    await settled(page);
    return canvas(page);
  };
  for (const compare of ["single", "wipe", "side"]) {
    const other = compare === "single" ? "texture=1&zoom=0.5" : `other=1&compare=${compare}&zoom=0.5&wipe=0`;
    const [plain, normals] = [await view(other), await view(`${other}&mode=normals`)];
    const right = (x: number): boolean => compare !== "side" || x > plain.width / 2;
    let sum = 0, light = 0;
    for (let i = 0; i < plain.width * plain.height; i++) {
      if (!right(i % plain.width)) continue;
      sum += Math.abs((plain.codes[4 * i] ?? 0) - (normals.codes[4 * i] ?? 0));
      light += normals.codes[4 * i] ?? 0;
    }
    expect(sum, compare).toBe(0);
    expect(light / (plain.width * plain.height), compare).toBeGreaterThan(20);
  }
  await show(page, "mode=normals");
  await page.getByLabel("Texture", { exact: true }).selectOption("1");
  await expect.poll(() => way.inputValue()).toBe("default");
  await page.getByLabel("Texture", { exact: true }).selectOption("0");
  await expect.poll(() => way.inputValue()).toBe("normals");
  await page.close();
});

test("undo and redo take back lines and annotations", async () => {
  const page = await opener.open(served.url), lines = page.locator(".overlay line");
  await page.keyboard.press("r");
  await drag(page, [100, 100], [200, 150]);
  await drag(page, [150, 200], [250, 250]);
  await page.keyboard.press("Control+z");
  await expect.poll(() => lines.count()).toBe(1);
  await page.keyboard.press("Control+y");
  await expect.poll(() => lines.count()).toBe(2);
  await page.keyboard.press("r");
  await expect.poll(() => lines.count()).toBe(0);
  await page.keyboard.press("Control+z");
  await expect.poll(() => lines.count()).toBe(2);
  await page.keyboard.press("r");
  await write(page, "one");
  await write(page, "two");
  await expect.poll(texts).toEqual(["one", "two"]);
  await page.getByLabel("Remove annotation 1").click();
  await expect.poll(texts).toEqual(["two"]);
  await page.keyboard.press("Control+z");
  await expect.poll(texts).toEqual(["one", "two"]);
  await expect.poll(() => listed(page)).toEqual(["one", "two"]);
  await page.getByRole("button", { name: "Undo" }).click();
  await expect.poll(texts).toEqual(["one"]);
  await page.keyboard.press("Control+y");
  await expect.poll(texts).toEqual(["one", "two"]);
  await page.close();
});

test("keys undo while a control has the focus, and move the border of a wipe", async () => {
  const page = await opener.open(served.url), exposure = page.getByLabel("Exposure");
  await exposure.focus();
  await page.keyboard.press("ArrowRight");
  await expect.poll(() => exposure.inputValue()).toBe("0.05");
  await page.keyboard.press("Control+z");
  await expect.poll(() => exposure.inputValue()).toBe("0");
  await page.getByLabel("Compare", { exact: true }).selectOption("plain");
  await page.getByLabel("Border").focus();
  await page.keyboard.press("Home");
  await page.waitForFunction(() => location.hash.includes("wipe=0"));
  await page.close();
});

test("help opens at its beginning", async () => {
  for (const options of [PHONE, { viewport: { width: 700, height: 300 } }]) {
    const page = await opener.open(served.url, options);
    await page.getByRole("button", { name: "Help" }).click();
    const dialog = page.getByRole("dialog", { name: "Help" });
    expect(await dialog.evaluate((element) => element.scrollTop)).toBe(0);
    expect(await dialog.evaluate((element) => element.contains(document.activeElement))).toBe(true);
    await expect(dialog.getByRole("heading").evaluate((element) => element.getBoundingClientRect().top >= 0)).resolves.toBe(true);
    await page.close();
  }
});

test("a strip of one texel by thousands is seen, at first and magnified, and saved as it is", async () => {
  writeStrip(place.path("tall.ptm"), 1, 4000);
  writeStrip(place.path("wide.ptm"), 4000, 1);
  const own = await ViewServer.start(place, ["tall.ptm", "wide.ptm"]);
  for (const [texture, size] of [[0, [1, 4000]], [1, [4000, 1]]] as const) {
    const page = await opener.open(own.url), lit: number[] = [];
    for (const zoom of [1, 4]) {
      await show(page, `texture=${texture}&zoom=${zoom}`);
      const { codes, width, height } = await canvas(page);
      const ground = [codes[0] ?? 0, codes[1] ?? 0, codes[2] ?? 0];
      let count = 0;
      for (let i = 0; i < width * height; i++) count += Number(ground.some((code, c) => Math.abs(code - (codes[4 * i + c] ?? 0)) > 12));
      lit.push(count);
    }
    expect(lit[0]).toBeGreaterThan(2000);
    expect(lit[1]).toBeGreaterThan(3 * (lit[0] ?? 0));
    const [saved] = await Promise.all([page.waitForEvent("download"), page.getByLabel("Save the whole texture").click()]);
    const picture = await decodePng(new Uint8Array(readFileSync(await saved.path())));
    expect([picture.width, picture.height]).toEqual(size);
    const values = new Set(Array.from({ length: 4000 }, (_, i) => picture.codes[picture.channels * i] ?? 0));
    expect(values.size).toBeGreaterThan(10);
    await page.close();
  }
  await own.stop();
});

test("a picture saved while the ruler is on has its lines and the scale bar", async () => {
  const page = await opener.open(served.url, { ...USUAL, deviceScaleFactor: 2 });
  const saved = async (): Promise<Codes> => {
    const [file] = await Promise.all([page.waitForEvent("download"), page.getByLabel("Save a picture").click()]);
    return decodePng(new Uint8Array(readFileSync(await file.path())));
  };
  const bare = await saved();
  expect(difference(bare, await canvas(page)).mean).toBe(0);
  await page.keyboard.press("r");
  await drag(page, [100, 200], [300, 200]);
  const measured = await saved();
  const code = (x: number, y: number): number => measured.codes[measured.channels * (2 * y * measured.width + 2 * x)] ?? 0;
  for (const [x, y] of [[110, 200], [290, 200], [20, 36]] as const) expect(Math.max(code(x, y), code(x, y - 1)), `${x}, ${y}`).toBeGreaterThan(200);
  // Elsewhere nothing is other than without it.
  const changed = difference(measured, bare);
  expect(changed.mean).toBeGreaterThan(0.01);
  expect(changed.mean).toBeLessThan(2);
  expect(changed.most).toBeLessThan(255);
  await page.close();
});

test("the text of an annotation is shown under the pointer", async () => {
  const page = await opener.open(served.url);
  await write(page, "under the pointer");
  // Marks are drawn again once the annotation is saved.
  await expect.poll(() => textOf(page, ".said")).toBe("Annotations saved beside the texture");
  const box = await page.locator(".overlay circle").boundingBox();
  if (!box) throw new Error("no mark");
  // Browsers tell of movements with the next frame.
  const over = async (x: number, y: number, text: string): Promise<void> => {
    await page.mouse.move(x, y);
    await page.waitForFunction((text) => document.querySelector("canvas")?.title === text, text, { timeout: 5000 });
  };
  await over(box.x + box.width / 2, box.y + box.height / 2, "under the pointer");
  await over(box.x - 60, box.y, "");
  await page.close();
});

test("lights that are added lie apart", async () => {
  const page = await opener.open(served.url);
  for (let i = 0; i < 3; i++) await page.getByRole("button", { name: "Add light" }).click();
  await page.waitForFunction(() => location.hash.split(";").length === 4);
  const places = (/lights=([^&]*)/.exec(page.url())?.[1] ?? "").split(";").map((light) => light.split(",").map(Number));
  for (const [i, a] of places.entries()) for (const b of places.slice(i + 1)) expect(Math.hypot((a[0] ?? 0) - (b[0] ?? 0), (a[1] ?? 0) - (b[1] ?? 0))).toBeGreaterThan(0.5);
  await page.close();
});

test("a phone with large type shows all tools, none cut off or covered", async () => {
  for (const size of [14, 24, 32]) {
    const page = await opener.open(served.url, PHONE);
    await page.evaluate((size) => (document.documentElement.style.fontSize = `${size}px`), size);
    for (const isOpen of [false, true]) {
      if (isOpen) await page.getByRole("button", { name: "Controls", exact: true }).tap();
      await drawn(page);
      const hidden = await page.locator(".toolbar button").evaluateAll((buttons) => buttons.filter((button) => {
        const box = button.getBoundingClientRect();
        const seen = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2);
        return box.left < 0 || box.right > innerWidth || box.top < 0 || !button.contains(seen);
      }).map((button) => button.getAttribute("aria-label")));
      expect(hidden, `type of ${size} pixels`).toEqual([]);
      expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390);
    }
    await page.close();
  }
});
