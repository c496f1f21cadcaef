// The page against the library's renderer: the same view within 1 of 255 on average and 4 at the 99th percentile.
import { writeFileSync } from "node:fs";
import type { Browser, Page } from "playwright-core";
import type { Codes } from "../../packages/relume-three/src/png.js";
import { directionsOf } from "../../packages/relume-three/src/softLight.js";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { launched } from "../chromium.js";
import { ViewServer, Workplace } from "../program.js";
import { writeShape } from "../shapes.js";
import { canvas, difference, drawn, file, ready, show } from "./pictures.js";

const SIDE = 160;
const LIGHT: [number, number] = [-0.45, 0.35];
const BACKGROUND = [255, 0, 255];
/** One texture of each basis and arrangement. */
const TEXTURES: [name: string, command: string][] = [
  ["lrgb.ptm", "fit capture -o lrgb.ptm"],
  ["rgb.ptm", "fit capture -o rgb.ptm --color rgb"],
  ["hsh.exr", "fit capture --basis hsh9 --color rgb -o hsh.exr"],
  ["hsh25.exr", "fit capture --basis hsh25 --color rgb -o hsh25.exr"],
  ["shapes.exr", "fit capture --basis shapes --color rgb -o shapes.exr"],
  ["zernike.exr", "fit capture --basis zernike -o zernike.exr"],
  ["maps/roughness.png", `procedural leather -o maps --size ${SIDE}`],
  ["picture.png", "relight lrgb.ptm --light 0,0,1 -o picture.png"],
  ["pairs.exr", "fit pairs -o pairs.exr"],
];

const place = new Workplace();
let browser: Browser, page: Page, server: ViewServer;

beforeAll(async () => {
  place.run(`capture leather -o capture --lights 40 --size ${SIDE}x${SIDE} --feature 64`);
  place.run(`capture sponge -o pairs --views 4 --size ${SIDE / 4}x${SIDE / 4} --feature 20`);
  for (const [, command] of TEXTURES) place.run(command);
  writeShape(place.path("shape.obj"));
  server = await ViewServer.start(place, [...TEXTURES.map(([name]) => name), "--mesh", "shape.obj", "--env", "sky"]);
  browser = await launched();
  page = await browser.newPage({ viewport: { width: SIDE, height: SIDE } });
  await page.goto(`${server.url}?exact`);
  await ready(page);
  await page.evaluate((ground) => {
    document.documentElement.style.setProperty("--ground", ground);
    document.querySelector(".panel")?.setAttribute("hidden", "");
  }, `rgb(${BACKGROUND.join(",")})`);
  await page.waitForTimeout(100);
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
  place.remove();
});

const light = [...LIGHT, Math.sqrt(1 - LIGHT[0] ** 2 - LIGHT[1] ** 2)].join(",");
const lights = `lights=${LIGHT.join(",")},ffffff,1`;

describe.each(TEXTURES.map(([name], i) => [name, i] as const))("%s", (name, index) => {
  test("flat", async () => {
    await show(page, `texture=${index}&${lights}`);
    place.run(`relight ${name} --light ${light} -o flat.png --force`);
    const truth = await file(place.path("flat.png"));
    const { mean, most } = difference(middles(await canvas(page), truth), truth);
    console.log(`${name} flat: mean ${mean.toFixed(3)}, 99 %: ${most}`);
    expect(mean).toBeLessThan(1);
    expect(most).toBeLessThanOrEqual(4);
  });

  test.each(["plane", "sphere", "torus", "cloth", "mesh"])("on a %s", async (object) => {
    await show(page, `texture=${index}&object=${object}&azimuth=20&elevation=15&${lights}`);
    place.run(
      `render ${name} --mesh ${object === "mesh" ? "shape.obj" : object} --camera 20,15 --light ${light} --size ${SIDE}x${SIDE} --samples 1 --specular 0 ` +
        `--no-cast-shadows --background 1,0,1 -o object.png --force`,
    );
    const isObject = (rgb: number[]): boolean => BACKGROUND.some((value, c) => value !== rgb[c]);
    const { mean, most, count } = difference(await canvas(page), await file(place.path("object.png")), isObject);
    console.log(`${name} ${object}: mean ${mean.toFixed(3)}, 99 %: ${most}, of ${count / 3} pixels`);
    expect(count).toBeGreaterThan(SIDE * SIDE);
    expect(mean).toBeLessThan(1);
    expect(most).toBeLessThanOrEqual(4);
  });

  test.each([["sphere", 20, 15, 0], ["torus", -130, 40, 0], ["cloth", 150, -20, 0], ["mesh", 0, 10, 70]])("under a sky on a %s", async (object, azimuth, elevation, turn) => {
    await show(page, `texture=${index}&object=${object}&azimuth=${azimuth}&elevation=${elevation}&source=environment&turn=${turn}&${lights}`);
    place.run(
      `render ${name} --mesh ${object === "mesh" ? "shape.obj" : object} --camera ${azimuth},${elevation} --env sky --env-rotate ${turn} --size ${SIDE}x${SIDE} ` +
        `--samples 1 --specular 0 --no-cast-shadows --background 1,0,1 -o object.png --force`,
    );
    const isObject = (rgb: number[]): boolean => BACKGROUND.some((value, c) => value !== rgb[c]);
    const { mean, most } = difference(await canvas(page), await file(place.path("object.png")), isObject);
    console.log(`${name} under a sky, ${object}: mean ${mean.toFixed(3)}, 99 %: ${most}`);
    expect(mean).toBeLessThan(1);
    expect(most).toBeLessThanOrEqual(4);
  });

  test("flat under a sky", async () => {
    await show(page, `texture=${index}&source=environment&${lights}`);
    place.run(`relight ${name} --env sky -o flat.png --force`);
    const truth = await file(place.path("flat.png"));
    const { mean, most } = difference(middles(await canvas(page), truth), truth);
    console.log(`${name} flat under a sky: mean ${mean.toFixed(3)}, 99 %: ${most}`);
    expect(mean).toBeLessThan(1);
    expect(most).toBeLessThanOrEqual(4);
  });
});

test("a soft light is the mean of its directions", async () => {
  const decoded = (code: number): number => (code <= 10.31475 ? code / 255 / 12.92 : ((code / 255 + 0.055) / 1.055) ** 2.4);
  const encoded = (value: number): number => 255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055);
  await show(page, `texture=0&${lights},40`);
  const sums: number[] = [], all = directionsOf([{ direction: light.split(",").map(Number) as [number, number, number], color: [1, 1, 1], softness: (40 * Math.PI) / 180 }]);
  let truth: Codes = { width: 0, height: 0, channels: 3, codes: new Uint8Array() };
  for (const { direction } of all) {
    // What is below the horizon gives no light.
    if (direction.z <= 0) continue;
    place.run(`relight lrgb.ptm --light ${direction.toArray().join(",")} -o flat.png --force`);
    truth = await file(place.path("flat.png"));
    truth.codes.forEach((code, i) => (sums[i] = (sums[i] ?? 0) + decoded(code) / all.length));
  }
  truth.codes.set(sums.map((value) => Math.round(encoded(value))));
  const { mean, most } = difference(middles(await canvas(page), truth), truth);
  console.log(`a soft light: mean ${mean.toFixed(3)}, 99 %: ${most}`);
  expect(mean).toBeLessThan(1);
  expect(most).toBeLessThanOrEqual(4);
});

test("an object whose texture coordinates have no direction is lit as by the library", async () => {
  writeFileSync(place.path("still.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\nvt 0.3 0.4\nf 1/1 2/1 3/1 4/1\n");
  const own = await ViewServer.start(place, ["lrgb.ptm", "--mesh", "still.obj"]), fresh = await browser.newPage({ viewport: { width: SIDE, height: SIDE } });
  await fresh.goto(`${own.url}?exact#object=mesh&${lights}`);
  await ready(fresh);
  place.run(`render lrgb.ptm --mesh still.obj --light ${light} --size ${SIDE}x${SIDE} --samples 1 --specular 0 --no-cast-shadows -o object.png --force`);
  const truth = await file(place.path("object.png")), middle = (codes: Codes): number[] => [0, 1, 2].map((c) => codes.codes[codes.channels * (Math.floor(codes.height / 2) * codes.width + Math.floor(codes.width / 2)) + c] ?? 0);
  await fresh.evaluate(() => document.querySelector(".panel")?.setAttribute("hidden", ""));
  await drawn(fresh);
  const [found, expected] = [middle(await canvas(fresh)), middle(truth)];
  expect(Math.max(...expected)).toBeGreaterThan(20);
  expected.forEach((code, c) => expect(Math.abs((found[c] ?? 0) - code)).toBeLessThanOrEqual(2));
  await fresh.close();
  await own.stop();
});

test.each([["lrgb.ptm", "environment"], ["pairs.exr", "lamps"]])("a page of %s with light from all around begins under the %s", async (name, source) => {
  const own = await ViewServer.start(place, [name, "--env", "sky"]), fresh = await browser.newPage({ viewport: { width: 900, height: 500 } });
  await fresh.goto(own.url);
  await ready(fresh);
  expect(await fresh.getByLabel("Lit by").inputValue()).toBe(source);
  await fresh.close();
  await own.stop();
});

test("an address from a page with light from all around shows lamps in one without, and a file that is missing is named to the end", async () => {
  const own = await ViewServer.start(place, ["lrgb.ptm"]), fresh = await browser.newPage({ viewport: { width: 300, height: 300 } });
  const brightness = async (): Promise<number> => {
    const { codes } = await canvas(fresh);
    return codes.reduce((sum, code, i) => sum + (i % 4 < 3 ? code : 0), 0) / codes.length;
  };
  await fresh.goto(own.url);
  await ready(fresh);
  await show(fresh, lights);
  const lit = await brightness();
  await show(fresh, `source=environment&${lights}`);
  expect(Math.abs((await brightness()) - lit)).toBeLessThan(1);
  let asked = 0;
  await fresh.route(/\.(png|gz)(\?|$)/, async (route) => {
    if (asked++ === 0) return route.fulfill({ status: 404 });
    await new Promise((resolve) => setTimeout(resolve, 500));
    return route.continue();
  });
  await fresh.reload();
  await fresh.waitForFunction(() => document.documentElement.dataset["ready"] === "1");
  await fresh.waitForTimeout(1500);
  const said = (await fresh.locator(".notice").textContent()) ?? "";
  expect(said).toContain("lrgb");
  expect(said).not.toContain("%");
  await fresh.close();
  await own.stop();
});

/** The middles of the squares that show texels: a texel is a square of whole pixels here. */
function middles(shown: Codes, { width, height }: Codes): Codes {
  const scale = SIDE / width, codes = new Uint8Array(width * height * 4);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++)
      for (let c = 0; c < 4; c++) codes[4 * (y * width + x) + c] = shown.codes[4 * (Math.floor((y + 0.5) * scale) * SIDE + Math.floor((x + 0.5) * scale)) + c] ?? 0;
  return { width, height, channels: 4, codes };
}
