// Textures with a function for each of many photographs, without a graphics card.
import type { Page } from "playwright-core";
import { expect, test } from "vitest";
import { textOf } from "./hands.js";
import { session } from "./opened.js";
import { canvas, difference, drawn, ready, show } from "./pictures.js";

const KINDS = ["rbf", "shapes"];
const served = session(
  ["capture leather -o capture --lights 40 --size 96x96 --feature 32", ...KINDS.map((basis) => `fit capture -o ${basis}.exr --basis ${basis}`)],
  KINDS.map((basis) => `${basis}.exr`),
), { opener } = served;

/** The name of an extension, and the number by which a page asks whether a program is made. */
const PARALLEL = "KHR_parallel_shader_compile", COMPLETION_STATUS = 0x91b1;
const notice = (page: Page): Promise<string | null> => textOf(page, ".notice");

test("ways of showing that look around a place show textures of forty photographs within seconds", async () => {
  for (const texture of [0, 1]) {
    const page = await opener.open(`${served.url}#texture=${texture}`, { viewport: { width: 320, height: 200 } }), plain = await canvas(page);
    for (const mode of ["unsharp-luminance", "multi-light"]) {
      const before = performance.now();
      await show(page, `texture=${texture}&mode=${mode}&gain=1`);
      const seen = await canvas(page), seconds = (performance.now() - before) / 1000;
      console.log(`${KINDS[texture] ?? ""}, ${mode}: ${seconds.toFixed(1)} s`);
      expect(seconds).toBeLessThan(30);
      expect(difference(seen, plain).mean, mode).toBeGreaterThan(1);
    }
    await show(page, `texture=${texture}&mode=unsharp-luminance&gain=0`);
    expect(difference(await canvas(page), plain).most).toBeLessThanOrEqual(1);
    await page.close();
  }
});

test("the page says what it is about while a program is made, or its first picture is drawn, for long", async () => {
  const page = await opener.open(served.url), first = await canvas(page), making = "The first picture of this way of showing is being made";
  // As a card that takes its time to draw.
  await page.evaluate(() => {
    const prototype = WebGL2RenderingContext.prototype, { getSyncParameter } = prototype;
    Object.assign(globalThis, { goOn: () => Object.assign(prototype, { getSyncParameter }) });
    prototype.getSyncParameter = () => prototype.UNSIGNALED;
  });
  await show(page, "mode=normals");
  expect(await notice(page)).toBe("");
  await expect.poll(() => notice(page)).toContain(making);
  await page.evaluate(() => (globalThis as unknown as { goOn(): void }).goOn());
  await expect.poll(() => notice(page)).toBe("");
  await page.close();
  const slow = await opener.blank();
  // As one that makes programs beside the page: what was there stays until it has.
  await slow.addInitScript(([name, status]) => {
    const prototype = WebGL2RenderingContext.prototype, state = { isMade: true }, { getExtension, getProgramParameter, getSupportedExtensions } = prototype;
    Object.assign(globalThis, { state });
    prototype.getSupportedExtensions = function () { return [...(getSupportedExtensions.call(this) ?? []), name]; };
    prototype.getExtension = function (this: WebGL2RenderingContext, asked: string) { return asked === name ? { COMPLETION_STATUS_KHR: status } : (getExtension.call(this, asked as "OCULUS_multiview") as unknown); } as typeof getExtension;
    prototype.getProgramParameter = function (program, asked) { return asked === status ? state.isMade : (getProgramParameter.call(this, program, asked) as unknown); };
  }, [PARALLEL, COMPLETION_STATUS] as const);
  await slow.goto(served.url);
  await ready(slow);
  expect(difference(await canvas(slow), first).mean).toBe(0);
  const setMade = (isMade: boolean): Promise<void> => slow.evaluate((isMade) => void ((globalThis as unknown as { state: { isMade: boolean } }).state.isMade = isMade), isMade);
  await setMade(false);
  await slow.evaluate(() => (location.hash = "mode=normals"));
  await expect.poll(() => notice(slow)).toContain(making);
  expect(difference(await canvas(slow), first).mean).toBe(0);
  await setMade(true);
  await expect.poll(() => notice(slow)).toBe("");
  await drawn(slow);
  expect(difference(await canvas(slow), first).mean).toBeGreaterThan(2);
  await slow.close();
});
