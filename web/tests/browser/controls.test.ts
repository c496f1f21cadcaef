// The controls of the page, one by one.
import type { Page } from "playwright-core";
import { expect, test } from "vitest";
import { decodePng } from "../../packages/relume-three/src/png.js";
import { at, drag, listed, textOf } from "./hands.js";
import { LEATHER, session } from "./opened.js";
import { canvas, difference, drawn, show } from "./pictures.js";

const served = session(LEATHER, ["leather.ptm"]), { opener } = served;

const button = (page: Page, name: string) => page.getByRole("button", { name, exact: true });
const checked = (page: Page): Promise<string | null> => page.locator("[role=radio][aria-checked=true]").getAttribute("aria-label");

test("undo takes back an orbit, and ends it", async () => {
  const page = await opener.open(served.url), first = await canvas(page);
  await button(page, "Orbit").click();
  await page.waitForTimeout(600);
  await page.keyboard.press("Control+z");
  await drawn(page);
  expect(await button(page, "Orbit").getAttribute("aria-pressed")).toBe("false");
  expect(difference(await canvas(page), first).mean).toBe(0);
  await button(page, "Orbit").click();
  await page.waitForTimeout(300);
  await button(page, "Orbit").click();
  await drawn(page);
  expect(difference(await canvas(page), first).mean).toBeGreaterThan(0.5);
  await page.keyboard.press("Control+z");
  await drawn(page);
  expect(difference(await canvas(page), first).mean).toBe(0);
  await page.close();
});

test("a light is removed after others were taken back", async () => {
  const page = await opener.open(served.url), lights = (): number => decodeURIComponent(page.url()).split(";").length;
  for (let i = 0; i < 2; i++) await button(page, "Add light").click();
  await expect.poll(lights).toBe(3);
  await page.keyboard.press("Control+z");
  await expect.poll(lights).toBe(2);
  await button(page, "Remove").click();
  await expect.poll(lights).toBe(1);
  expect(await button(page, "Remove").isDisabled()).toBe(true);
  await page.close();
});

test("in small frames the tools cover nothing, and the fitted texture is seen as a whole", async () => {
  for (const [width, height] of [[400, 300], [300, 300], [300, 200], [480, 320], [360, 640], [390, 844], [480, 600]] as const) {
    const page = await opener.open(served.url, { viewport: { width, height } });
    const [picture, tools] = [await page.locator("canvas").boundingBox(), await page.locator(".toolbar").boundingBox()];
    expect((picture?.y ?? 0) + (picture?.height ?? 0), `${width} x ${height}`).toBeLessThanOrEqual(tools?.y ?? 0);
    expect(tools?.height ?? 99).toBeLessThan(0.25 * height);
    // The last tool can be reached, and is as large as fingers need.
    await button(page, "Help").focus();
    const help = await button(page, "Help").boundingBox();
    expect((help?.x ?? 0) + (help?.width ?? 0)).toBeLessThanOrEqual(width);
    expect(Math.min(help?.width ?? 0, help?.height ?? 0)).toBeGreaterThanOrEqual(24);
    await page.close();
  }
});

test("a grey is taken from the texture in its own colours, and Esc ends the choice", async () => {
  const page = await opener.open(served.url), pick = button(page, "Pick grey"), said = (): Promise<string | null> => textOf(page, ".said");
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  const middle = [box.width / 2, box.height / 2] as const;
  const click = async (x: number, y: number): Promise<void> => page.mouse.click(...(await at(page, x, y)));
  await pick.click();
  expect(await pick.getAttribute("aria-pressed")).toBe("true");
  await page.keyboard.press("Escape");
  expect(await pick.getAttribute("aria-pressed")).toBe("false");
  await click(...middle);
  expect(await button(page, "Neutral").isDisabled()).toBe(true);
  for (const view of ["zoom=0.5", "object=sphere"]) {
    await show(page, view);
    await pick.click();
    await click(10, 60);
    await expect.poll(said).toContain("beside the texture");
    expect(await button(page, "Neutral").isDisabled()).toBe(true);
    await click(...middle);
    await expect.poll(() => button(page, "Neutral").isDisabled()).toBe(false);
    await button(page, "Neutral").click();
  }
  await show(page, "mode=normals");
  await pick.click();
  await expect.poll(said).toContain("The picture has false colours");
  expect(await pick.getAttribute("aria-pressed")).toBe("false");
  await show(page, "mode=normals&compare=plain");
  await pick.click();
  await click(0.3 * box.width, middle[1]);
  await expect.poll(said).toContain("There the colours are false");
  await click(0.7 * box.width, middle[1]);
  await expect.poll(() => button(page, "Neutral").isDisabled()).toBe(false);
  await page.close();
});

test("forced colours show what is chosen", async () => {
  const page = await opener.open(served.url, { viewport: { width: 700, height: 440 }, forcedColors: "active" });
  await page.keyboard.press("r");
  for (const [on, off] of [["[role=radio][aria-checked=true]", "[role=radio][aria-checked=false]"], ["[aria-label=Ruler]", "[aria-label=Undo]"]] as const) {
    const grounds = [];
    for (const selector of [on, off]) {
      const { width, codes, channels } = await decodePng(new Uint8Array(await page.locator(selector).first().screenshot()));
      grounds.push(Math.max(...[0, 1, 2].map((c) => codes[channels * (4 * width + (width >> 1)) + c] ?? 0)));
    }
    expect(Math.abs((grounds[0] ?? 0) - (grounds[1] ?? 0))).toBeGreaterThan(60);
  }
  await page.close();
});

test("objects are one stop of the tab key, and arrows move through them", async () => {
  const page = await opener.open(served.url);
  expect(await page.locator("[role=radio]:not([hidden])").evaluateAll((all) => all.map((radio) => (radio as HTMLElement).tabIndex))).toEqual([0, -1, -1, -1, -1]);
  await page.getByRole("radio", { name: "Flat" }).focus();
  for (const [key, name] of [["ArrowRight", "Plane"], ["ArrowDown", "Sphere"], ["ArrowLeft", "Plane"], ["ArrowUp", "Flat"], ["ArrowLeft", "Cloth"], ["ArrowRight", "Flat"]] as const) {
    await page.keyboard.press(key);
    await expect.poll(() => checked(page)).toBe(name);
    expect(await page.evaluate(() => document.activeElement?.getAttribute("aria-label"))).toBe(name);
    expect(await page.locator("[role=radio][tabindex='0']").count()).toBe(1);
  }
  await page.close();
});

test("the ruler gives the object back", async () => {
  const page = await opener.open(`${served.url}#object=sphere`);
  await page.keyboard.press("r");
  await expect.poll(() => checked(page)).toBe("Flat");
  await drag(page, [150, 150], [250, 150]);
  await page.keyboard.press("r");
  await expect.poll(() => checked(page)).toBe("Sphere");
  // Unless another was chosen meanwhile.
  await page.keyboard.press("r");
  await page.getByRole("radio", { name: "Cloth" }).click();
  await page.getByRole("radio", { name: "Flat" }).click();
  await page.keyboard.press("r");
  await drawn(page);
  expect(await checked(page)).toBe("Flat");
  await page.close();
});

test("sliders show what they hold, and reach what addresses hold", async () => {
  const page = await opener.open(`${served.url}#lights=0,0,ffffff,8`);
  const slider = page.locator(".slider", { hasText: /^White/ }), white = slider.locator("input");
  expect(await slider.locator("output").textContent()).toBe(await white.inputValue());
  expect(await page.getByLabel("Strength").last().inputValue()).toBe("8");
  await white.focus();
  for (const key of ["ArrowRight", "ArrowLeft"]) await page.keyboard.press(key);
  await expect.poll(() => button(page, "Neutral").isDisabled()).toBe(true);
  await page.close();
});

test("an annotation without a text is not lost in silence", async () => {
  const page = await opener.open(served.url);
  await page.locator("canvas").focus();
  await page.keyboard.press("n");
  const text = page.getByLabel("Text of the annotation");
  for (const blank of ["", "  \n"]) {
    await text.fill(blank);
    await button(page, "Keep").click();
    expect(await page.getByRole("dialog", { name: "Annotation" }).isVisible()).toBe(true);
    expect(await text.evaluate((element) => (element as HTMLTextAreaElement).validationMessage)).toBe("Write a text, or press Cancel");
  }
  await text.fill("now");
  await button(page, "Keep").click();
  await expect.poll(() => listed(page)).toEqual(["now"]);
  await page.close();
});
