// The pages of `relume demo`, opened from disk.
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, expect, test } from "vitest";
import { launched } from "../chromium.js";
import { Workplace } from "../program.js";
import { canvas, difference, ready, settled, show } from "./pictures.js";

const place = new Workplace();
/** The folder of the demo; DEMO names one that is there already. */
const folder = process.env["DEMO"] ?? place.path("demo");
let browser: Browser;
const complaints: string[] = [];

beforeAll(async () => {
  if (!process.env["DEMO"]) place.run("demo -o demo --lights 24");
  browser = await launched();
});

afterAll(async () => {
  await browser?.close();
  place.remove();
});

async function open(name: string): Promise<Page> {
  const page = await browser.newPage({ viewport: { width: 1000, height: 562 } });
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && !/GPU stall|software WebGL|performance/i.test(message.text()) && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  page.on("request", (request) => /^(file|data|blob):/.test(request.url()) || complaints.push(`asked for ${request.url()}`));
  await page.goto(`file://${folder}/${name}`);
  return page;
}

test("the page shows its pictures and all four viewers", async () => {
  const page = await open("index.html");
  for (const name of ["texture.html", "tiles.html", "noise.html", "light_view.html"]) {
    await page.locator(`iframe[src^="${name}"]`).scrollIntoViewIfNeeded();
    await expect.poll(() => page.frames().some((frame) => frame.url().includes(name)), { timeout: 60_000 }).toBe(true);
    const frame = page.frames().find((frame) => frame.url().includes(name));
    await frame?.waitForFunction(() => document.documentElement.dataset["ready"] === "0", null, { timeout: 100_000 });
  }
  const broken = await page.evaluate(() => [...document.images].filter((image) => image.naturalWidth === 0).length);
  expect(broken).toBe(0);
  expect(await page.locator("img").count()).toBeGreaterThan(10);
  expect(complaints.splice(0)).toEqual([]);
  await page.close();
});

test.each([["texture.html", ["mode=normals", "object=sphere", "compare=plain"]], ["tiles.html", ["cells=1&zoom=0.3", "simple=1&zoom=0.3"]], ["noise.html", ["cells=1", "simple=1"]], ["light_view.html", ["object=cloth", "cells=1&zoom=0.3", "simple=1&zoom=0.3"]]] as const)(
  "%s follows the light and shows what its controls say",
  async (name, views) => {
    const page = await open(`${name}#lights=-0.5,0.5,ffffff,1&zoom=0.3`);
    await ready(page);
    await settled(page);
    const first = await canvas(page);
    await show(page, "lights=0.6,-0.3,ffffff,1&zoom=0.3");
    await settled(page);
    expect(difference(await canvas(page), first).mean).toBeGreaterThan(1);
    for (const view of views) {
      await show(page, `${view}&lights=-0.5,0.5,ffffff,1${view.includes("zoom") ? "" : "&zoom=0.3"}`);
      await settled(page);
      expect(difference(await canvas(page), first).mean, view).toBeGreaterThan(0.5);
    }
    if (name !== "texture.html") {
      await page.getByText("Far away").click();
      await settled(page);
      expect(difference(await canvas(page), first).mean).toBeGreaterThan(1);
      expect(await page.locator(".panel output.dim").allTextContents()).toEqual(expect.arrayContaining([expect.stringMatching(/-?\d{3,}, -?\d{3,}/)]));
    }
    expect(complaints.splice(0)).toEqual([]);
    await page.close();
  },
);

test("the cloth of light and view follows the view", async () => {
  const page = await open("light_view.html#object=cloth&repeat=2&azimuth=-30&lights=0,0.3,ffffff,1");
  await ready(page);
  await settled(page);
  const first = await canvas(page);
  await show(page, "object=cloth&repeat=2&azimuth=40&lights=0,0.3,ffffff,1");
  await settled(page);
  expect(difference(await canvas(page), first).mean).toBeGreaterThan(5);
  expect(complaints.splice(0)).toEqual([]);
  await page.close();
});
