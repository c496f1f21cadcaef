// Two textures of other sizes beside each other: what is measured and written belongs to the one under the pointer.
import { readFileSync } from "node:fs";
import type { Page } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { decodePng } from "../../packages/relume-three/src/png.js";
import { ViewServer } from "../program.js";
import { at, drag, listed, textOf, textsIn } from "./hands.js";
import { USUAL, session } from "./opened.js";
import { difference, drawn, canvas, show } from "./pictures.js";

const SIZES = [[128, 128], [200, 90]] as const;
const SIDE = "texture=0&other=1&compare=side", WIPE = "texture=0&other=1&compare=wipe&wipe=0.3";
const MADE = [["square", SIZES[0]], ["wide", SIZES[1]]] as const;
const served = session(
  MADE.flatMap(([name, [width, height]]) => [`capture leather -o ${name} --lights 8 --size ${width}x${height} --feature 32`, `fit ${name} -o ${name}.ptm`]),
  ["square.ptm", "wide.ptm"],
), { place, opener } = served;
let measured: ViewServer;

beforeAll(async () => {
  measured = await ViewServer.start(place, ["square.ptm", "wide.ptm", "--mm-per-texel", "0.5"]);
});

afterAll(() => measured?.stop());

const labels = (page: Page): Promise<string[]> => page.locator(".overlay text").allTextContents();

/** Where both pictures are side by side, and the pixels of a texel, of textures that are fitted to their halves. */
async function halves(page: Page): Promise<{ width: number; middle: number; scales: number[] }> {
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  const width = box.width / 2;
  return { width, middle: box.height / 2, scales: SIZES.map(([w, h]) => Math.min(width / w, box.height / h)) };
}

test("the ruler and the scale bar measure each texture in its own texels", async () => {
  const page = await opener.open(`${served.url}#${SIDE}`), { width, middle, scales: [a = 1, b = 1] } = await halves(page);
  await page.keyboard.press("r");
  await drag(page, [0, middle], [width - 1, middle]);
  await drag(page, [width, middle + 20], [2 * width - 1, middle + 20]);
  const [left, right] = (await labels(page)).map(Number.parseFloat);
  expect(Math.abs((left ?? 0) - (width - 1) / a)).toBeLessThan(1);
  expect(Math.abs((right ?? 0) - (width - 1) / b)).toBeLessThan(1);
  const bars = await page.locator(".scale").evaluateAll((all) => all.map((bar) => [bar.getBoundingClientRect().left, bar.getBoundingClientRect().width, Number.parseFloat(bar.textContent ?? "")]));
  expect(bars.length).toBe(2);
  for (const [i, scale] of [a, b].entries()) {
    const [x = 0, wide = 0, length = 1] = bars[i] ?? [];
    expect(wide / length).toBeCloseTo(scale, 3);
    expect(x).toBeCloseTo(i * width + 16, 0);
  }
  await page.close();
});

test("in a wipe the second texture is measured in its own texels, and lines are cut off at the border", async () => {
  const page = await opener.open(`${served.url}#${WIPE}`), { width, middle } = await halves(page);
  await page.keyboard.press("r");
  await drag(page, [width, middle], [width + 100, middle]);
  const box = await page.locator("canvas").boundingBox(), scale = Math.min(2 * width / 200, (box?.height ?? 0) / 90);
  expect(Math.abs(Number.parseFloat((await labels(page))[0] ?? "") - 100 / scale)).toBeLessThan(1);
  const [cut, border] = await page.evaluate(() => [document.querySelectorAll(".overlay svg")[1]?.getAttribute("x"), document.querySelector("canvas")?.clientWidth]);
  expect(Number(cut)).toBe(Math.round(0.3 * Number(border)));
  await page.close();
});

test("lines of a texture are not shown on another", async () => {
  const page = await opener.open(served.url);
  await page.keyboard.press("r");
  await drag(page, [150, 150], [250, 150]);
  for (const [texture, count] of [["1", 0], ["0", 1]] as const) {
    await page.getByLabel("Texture", { exact: true }).selectOption(texture);
    await expect.poll(() => page.locator(".overlay line").count()).toBe(count);
  }
  await page.close();
});

test("an annotation on the second picture belongs to its texture", async () => {
  for (const view of [SIDE, WIPE]) {
    const page = await opener.open(`${served.url}#${view}`), { width, middle } = await halves(page);
    await page.getByRole("button", { name: "Add", exact: true }).click();
    await drag(page, [1.5 * width - 30, middle - 20], [1.5 * width + 30, middle + 20]);
    await page.getByLabel("Text of the annotation").fill("on the wide one");
    await page.getByRole("button", { name: "Keep", exact: true }).click();
    await expect.poll(() => textsIn(place.path("wide.ptm.annotations.json"))).toEqual(["on the wide one"]);
    expect(textsIn(place.path("square.ptm.annotations.json"))).toEqual([]);
    const { annotations: [note] } = JSON.parse(readFileSync(place.path("wide.ptm.annotations.json"), "utf8")) as { annotations: { box: [number, number, number, number]; view: string }[] };
    const [x = -1, y = -1, w = 0, h = 0] = note?.box ?? [];
    expect([x >= 0, y >= 0, x + w <= 200, y + h <= 90, w > 10]).toEqual([true, true, true, true, true]);
    // It is shown where it was drawn, listed under its texture, and its view shows it alone.
    const mark = await page.locator(".overlay rect").boundingBox(), [left, top] = await at(page, 1.5 * width - 30, middle - 20);
    expect(Math.abs((mark?.x ?? 0) - left) + Math.abs((mark?.y ?? 0) - top)).toBeLessThan(4);
    expect(await listed(page)).toEqual(["on the wide one"]);
    await page.getByRole("button", { name: "on the wide one", exact: true }).click();
    await expect.poll(() => page.getByLabel("Texture", { exact: true }).inputValue()).toBe("1");
    await expect.poll(() => page.getByLabel("Compare", { exact: true }).inputValue()).toBe("single");
    await page.getByLabel(/^Remove annotation 1/).click();
    await expect.poll(() => textsIn(place.path("wide.ptm.annotations.json"))).toEqual([]);
    await page.close();
  }
});

test("textures of known size are compared at one scale, and the page says how they are matched", async () => {
  const page = await opener.open(`${measured.url}#${SIDE}`), { width, middle, scales: [scale = 1] } = await halves(page);
  await page.getByText("Both are at the same scale in millimetres.").waitFor();
  await page.keyboard.press("r");
  for (const x of [10, width + 10]) await drag(page, [x, middle], [x + 100, middle]);
  const [left, right] = await labels(page);
  expect(left).toBe(right);
  expect(Math.abs(Number.parseFloat(left ?? "") - 50 / scale)).toBeLessThan(0.5);
  await page.close();
  const plain = await opener.open(`${served.url}#${SIDE}`);
  await plain.getByText("Each is fitted to its part: a texel of the second is drawn 0.64 times as large.").waitFor();
  await plain.close();
});

test("each of two textures has its own size of a texel, and its own file of annotations", async () => {
  const own = await ViewServer.start(place, ["square.ptm", "wide.ptm", "--mm-per-texel", "0.5,0.25"]);
  const page = await opener.open(`${own.url}#${SIDE}`);
  expect(await page.locator(".scale").count()).toBe(2);
  const [left, right] = await page.locator(".scale").evaluateAll((bars) => bars.map((bar) => bar.getBoundingClientRect().width / Number.parseFloat(bar.textContent ?? "")));
  expect(left).toBeCloseTo(right ?? 0, 3);
  const button = (name: string) => page.getByRole("button", { name, exact: true });
  expect(await button("Load").count()).toBe(0);
  const [chooser] = await Promise.all([page.waitForEvent("filechooser"), button("Load annotations of wide").click()]);
  const bytes = `{"relume":"annotations","version":1,"annotations":[{"text":"loaded","box":[1,2,3,4],"view":""}]}`;
  await chooser.setFiles({ name: "some.json", mimeType: "application/json", buffer: Buffer.from(bytes) });
  await expect.poll(() => textsIn(place.path("wide.ptm.annotations.json"))).toEqual(["loaded"]);
  expect(textsIn(place.path("square.ptm.annotations.json"))).toEqual([]);
  for (const [title, texts] of [["square", []], ["wide", ["loaded"]]] as const) {
    const [saved] = await Promise.all([page.waitForEvent("download"), button(`Download annotations of ${title}`).click()]);
    expect(saved.suggestedFilename()).toBe(`${title}.annotations.json`);
    expect(textsIn(await saved.path())).toEqual(texts);
  }
  await show(page, "texture=1&compare=single");
  expect(await button("Load").count()).toBe(1);
  await page.close();
  await own.stop();
});

test("what is dragged and magnified in the second picture stays under the pointer", async () => {
  for (const url of [served.url, measured.url]) {
    const page = await opener.open(`${url}#${SIDE}`), { width, middle } = await halves(page);
    await page.keyboard.press("r");
    await drag(page, [1.4 * width, middle], [1.6 * width, middle]);
    const end = async (): Promise<[number, number]> => {
      await drawn(page);
      return page.locator(".overlay line").evaluate((line) => [Number(line.getAttribute("x1")), Number(line.getAttribute("y1"))]);
    };
    const [x, y] = await end();
    await drag(page, [1.4 * width, middle], [1.4 * width + 40, middle + 10], "right");
    const [x2, y2] = await end();
    expect(Math.abs(x2 - x - 40) + Math.abs(y2 - y - 10)).toBeLessThan(1);
    await page.mouse.move(...(await at(page, x2, y2)));
    await page.mouse.wheel(0, -300);
    const [x3, y3] = await end();
    expect(Math.abs(x3 - x2) + Math.abs(y3 - y2)).toBeLessThan(1);
    await page.close();
  }
});

test("what is saved has the name of what is shown", async () => {
  const page = await opener.open(`${served.url}#texture=1`);
  const saved = async (button: string): Promise<string> => {
    const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: button, exact: true }).click()]);
    return file.suggestedFilename();
  };
  expect(await saved("Save a picture")).toBe("wide.png");
  expect(await saved("Save the whole texture")).toBe("wide-texture.png");
  await show(page, SIDE);
  expect(await saved("Save a picture")).toBe("square-and-wide.png");
  await page.getByRole("button", { name: "Record the light" }).click();
  await page.getByLabel("Pictures").fill("2");
  expect(await saved("Make")).toBe("square-and-wide.gif");
  await page.close();
});

test("a picture of a comparison has the lines and the scale bar of both textures", async () => {
  const page = await opener.open(`${served.url}#${SIDE}`, { ...USUAL, colorScheme: "dark" }), { width, middle } = await halves(page), bare = await canvas(page);
  await page.keyboard.press("r");
  await drag(page, [width + 40, middle], [width + 140, middle]);
  const [file] = await Promise.all([page.waitForEvent("download"), page.getByLabel("Save a picture").click()]);
  const picture = await decodePng(new Uint8Array(readFileSync(await file.path())));
  const code = (x: number, y: number): number => picture.codes[picture.channels * (y * picture.width + Math.round(x))] ?? 0;
  for (const [x, y] of [[width + 50, Math.round(middle)], [width + 20, 36], [20, 36]] as const) expect(Math.max(...[-1, 0, 1].map((dy) => code(x, y + dy))), `${x}, ${y}`).toBeGreaterThan(190);
  expect(difference(picture, bare).mean).toBeLessThan(2);
  expect(await textOf(page, ".said")).toBe("Picture saved");
  await page.close();
});
