// Endless planes: the page's shaders against the library's windows of the same plane, near and far away.
import { writeFileSync } from "node:fs";
import { deflateSync } from "node:zlib";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, describe, expect, test } from "vitest";
import { launched } from "../chromium.js";
import { ViewServer, Workplace } from "../program.js";
import { canvas, difference, file, ready, settled, show } from "./pictures.js";

const SIDE = 192;
const BACKGROUND = [255, 0, 255];
const LIGHT: [number, number] = [-0.45, 0.35];
const light = [...LIGHT, Math.sqrt(1 - LIGHT[0] ** 2 - LIGHT[1] ** 2)].join(",");
const lights = `lights=${LIGHT.join(",")},ffffff,1`;

/** Planes: the name of their file, how the program draws windows, and the size of what the page takes for one repetition. */
const PLANES: [name: string, options: string, width: number, height: number][] = [];
const place = new Workplace();
let browser: Browser, page: Page;
const servers: ViewServer[] = [];
let opened = "";

/** A picture that repeats along two slanted vectors, so that the program cuts oblique tiles. */
function slanted(side: number): Uint8Array {
  const rows = Array.from({ length: side }, (_, y) => {
    const row = Array.from({ length: 3 * side }, (_, i) => {
      const x = Math.floor(i / 3), c = i % 3;
      // Coordinates in the lattice of (24, 8) and (-8, 24), whose cells lie in squares of 32: levels of detail are whole.
      const a = (x * 24 + y * 8) / (24 * 24 + 8 * 8), b = (y * 24 - x * 8) / (24 * 24 + 8 * 8);
      return Math.round(128 + 60 * Math.sin(2 * Math.PI * (a + 0.1 * c)) + 50 * Math.cos(2 * Math.PI * (b + a * 2)) * Math.sin(2 * Math.PI * b));
    });
    return [0, ...row];
  });
  const chunk = (name: string, data: Uint8Array): Buffer => {
    const body = Buffer.concat([Buffer.from(name), data]), head = Buffer.alloc(4), tail = Buffer.alloc(4);
    head.writeUInt32BE(data.length);
    tail.writeUInt32BE(crc32(body));
    return Buffer.concat([head, body, tail]);
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(side, 0);
  header.writeUInt32BE(side, 4);
  header.set([8, 2], 8);
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  return Buffer.concat([signature, chunk("IHDR", header), chunk("IDAT", deflateSync(Uint8Array.from(rows.flat()))), chunk("IEND", Buffer.alloc(0))]);
}

function crc32(bytes: Uint8Array): number {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let i = 0; i < 8; i++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

/** The sides of the rectangle around a tile. */
function tileSize(name: string): [number, number] {
  const { right, down } = JSON.parse(place.run(`info ${name} --json`)).tiles.cells as { right: [number, number]; down: [number, number] };
  return [right[0] + Math.abs(down[0]), down[1] + Math.abs(right[1])];
}

/** Opens a plane, unless it is there. */
async function open(name: string, options: string): Promise<void> {
  if (opened === `${name} ${options}`) return;
  opened = "";
  const server = await ViewServer.start(place, [name, ...options.split(" ").filter(Boolean)]);
  servers.push(server);
  await page.goto(`${server.url}?exact`);
  await ready(page);
  await page.evaluate((ground) => {
    document.documentElement.style.setProperty("--ground", ground);
    document.querySelector(".panel")?.setAttribute("hidden", "");
  }, `rgb(${BACKGROUND.join(",")})`);
  await page.waitForTimeout(100);
  opened = `${name} ${options}`;
}

beforeAll(async () => {
  place.run("capture sponge -o sponge --lights 12 --size 128x128 --feature 20");
  place.run("fit sponge -o sponge.ptm --color rgb");
  place.run("fit sponge --basis hsh9 --color rgb -o sponge.exr");
  place.run("fit sponge -o product.ptm");
  place.run("capture weave -o weave --lights 12 --size 128x128");
  place.run("fit weave -o weave.ptm");
  place.run("roll weave.ptm -k 4 -o tiles.ptm");
  place.run("roll sponge.ptm -k 16 -o corners.ptm");
  writeFileSync(place.path("slanted.png"), slanted(256));
  place.run("roll slanted.png -k 4 -o oblique.png");
  place.run("model sponge.ptm -o sponge.rlm");
  browser = await launched();
  page = await browser.newPage({ viewport: { width: SIDE, height: SIDE } });
});

afterAll(async () => {
  await browser?.close();
  for (const server of servers) await server.stop();
  place.remove();
});

for (const name of ["tiles.ptm", "corners.ptm", "oblique.png"]) PLANES.push([name, "", 0, 0]);
for (const name of ["sponge.ptm", "sponge.exr", "product.ptm"]) PLANES.push([name, "--noise", 128, 128]);
PLANES.push(["sponge.rlm", "", 128, 128]);

describe.each(PLANES)("%s %s", (name, options, width, height) => {
  test("every texel is that of the library, near and far away", async () => {
    await open(name, options);
    const [w, h] = width > 0 ? [width, height] : tileSize(name);
    for (const [x, y] of [[0, 0], [-300, 123456], [400_000_011, -300_000_007]] as const) {
      const zoom = 1 / Math.min(SIDE / w, SIDE / h);
      await show(page, `zoom=${zoom}&x=${(x + SIDE / 2) / w}&y=${(y + SIDE / 2) / h}&${lights}`);
      await settled(page);
      const method = options === "--noise" ? "--method noise " : "";
      place.run(`synth ${name} ${method}--window=${x},${y},${SIDE},${SIDE} -o part.exr --force`);
      place.run(`relight part.exr --light ${light} -o part.png --force`);
      const { mean, most } = difference(await canvas(page), await file(place.path("part.png")));
      console.log(`${name} ${options} at ${x}, ${y}: mean ${mean.toFixed(3)}, 99 %: ${most}`);
      expect(mean).toBeLessThan(1);
      expect(most).toBeLessThanOrEqual(4);
    }
  });

  test("on a sphere it is the library's rendering of the same window", async () => {
    await open(name, options);
    const [w, h] = width > 0 ? [width, height] : tileSize(name);
    await show(page, `object=sphere&azimuth=20&elevation=15&${lights}`);
    await settled(page);
    const method = options === "--noise" ? "--method noise " : "";
    // Four repetitions around and two up, as on the page.
    place.run(`synth ${name} ${method}--window=0,${-h},${4 * w},${2 * h} -o part.exr --force`);
    place.run(
      `render part.exr --mesh sphere --tiling 1 --camera 20,15 --light ${light} --size ${SIDE}x${SIDE} --samples 1 --specular 0 ` +
        "--no-cast-shadows --background 1,0,1 -o object.png --force",
    );
    const isObject = (rgb: number[]): boolean => BACKGROUND.some((value, c) => value !== rgb[c]);
    const { mean, most, count } = difference(await canvas(page), await file(place.path("object.png")), isObject);
    console.log(`${name} ${options} on a sphere: mean ${mean.toFixed(3)}, 99 %: ${most}`);
    expect(count).toBeGreaterThan(SIDE * SIDE);
    expect(mean).toBeLessThan(1);
    expect(most).toBeLessThanOrEqual(4);
  });
});
