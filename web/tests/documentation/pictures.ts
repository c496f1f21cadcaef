// Writes the pictures of docs/viewing.md, and the page docs/sponge.html, from our own material: npm run pictures.
import { writeFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import type { Browser, Page } from "playwright-core";
import { afterAll, beforeAll, test } from "vitest";
import { MODES } from "relume-three";
import { launched } from "../chromium.js";
import { ViewServer, Workplace } from "../program.js";
import { writeShape } from "../shapes.js";
import { drawn, ready, show } from "../browser/pictures.js";

const SIDE = 280;
const place = new Workplace();
let browser: Browser, server: ViewServer;

beforeAll(async () => {
  place.run("capture sponge -o sponge --lights 60 --size 256x256 --feature 64");
  place.run("fit sponge -o sponge.ptm");
  place.run("capture weave -o weave --lights 40 --size 256x256");
  place.run("fit weave -o weave.ptm");
  writeShape(place.path("shape.obj"));
  server = await ViewServer.start(place, ["sponge.ptm", "weave.ptm", "--mesh", "shape.obj", "--env", "sky", "--mm-per-texel", "0.1"]);
  browser = await launched();
});

afterAll(async () => {
  await browser?.close();
  await server?.stop();
  place.remove();
});

function documentation(name: string): string {
  return fileURLToPath(new URL(`../../../docs/${name}`, import.meta.url));
}

async function opened(width: number, height: number, query = ""): Promise<Page> {
  const page = await browser.newPage({ viewport: { width, height }, colorScheme: "dark" });
  await page.goto(`${server.url}${query}`);
  await ready(page);
  return page;
}

/** Views in a grid with their names below, as a JPEG. */
async function sheet(name: string, columns: number, views: [label: string, hash: string][]): Promise<void> {
  const page = await opened(SIDE, SIDE), pictures: string[] = [];
  await page.evaluate(() => document.querySelector(".panel")?.setAttribute("hidden", ""));
  await drawn(page);
  for (const [, hash] of views) {
    await show(page, hash);
    pictures.push(await page.evaluate(() => document.querySelector("canvas")?.toDataURL() ?? ""));
  }
  await page.close();
  const bare = await browser.newPage();
  const jpeg = await bare.evaluate(async ({ pictures, labels, columns, side }) => {
    const canvas = document.createElement("canvas"), context = canvas.getContext("2d"), row = side + 26;
    canvas.width = columns * side;
    canvas.height = Math.ceil(pictures.length / columns) * row;
    if (!context) return "";
    context.fillStyle = "#fff";
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.fillStyle = "#222";
    context.font = "15px sans-serif";
    context.textAlign = "center";
    for (const [i, picture] of pictures.entries()) {
      const image = new Image();
      image.src = picture;
      await image.decode();
      const x = (i % columns) * side, y = Math.floor(i / columns) * row;
      context.drawImage(image, x, y, side - 4, side - 4);
      context.fillText(labels[i] ?? "", x + side / 2, y + side + 14);
    }
    return canvas.toDataURL("image/jpeg", 0.85);
  }, { pictures, labels: views.map(([label]) => label), columns, side: SIDE });
  writeFileSync(documentation(`pictures/${name}`), Buffer.from(jpeg.split(",")[1] ?? "", "base64"));
  await bare.close();
}

/** The page as it is on the screen. */
async function screen(name: string, hash: string, prepare: (page: Page) => Promise<void> = async () => undefined): Promise<void> {
  const page = await opened(1000, 640);
  await show(page, hash);
  await prepare(page);
  await drawn(page);
  await page.screenshot({ path: documentation(`pictures/${name}`), type: "jpeg", quality: 80 });
  await page.close();
}

const LIGHT = "lights=-0.6,0.45,ffffff,1";

test("ways of showing", () => sheet("viewer-modes.jpg", 5, MODES.map((mode) => [mode.replaceAll("-", " "), `mode=${mode}&gain=${mode === "multi-light" ? 1 : 2}&zoom=1.3&${LIGHT}`])));

test("objects", () => sheet("viewer-objects.jpg", 3, ["flat", "plane", "sphere", "torus", "cloth", "mesh"].map((object) => [object === "mesh" ? "your own" : object, `object=${object}&azimuth=25&elevation=20&${LIGHT}`])));

test("light from all around", () => sheet("viewer-environment.jpg", 3, [
  ["lamp", `object=sphere&${LIGHT}`],
  ["sky", "object=sphere&source=environment"],
  ["sky, turned by 120 degrees", "object=sphere&source=environment&turn=120"],
]));

test("the page", async () => {
  await screen("viewer.jpg", `object=sphere&azimuth=20&elevation=10&${LIGHT}`);
  await screen("viewer-compare.jpg", `texture=0&compare=plain&wipe=0.5&zoom=1.4&${LIGHT}`);
  await screen("viewer-annotations.jpg", `zoom=2&${LIGHT}`, async (page) => {
    for (const [text, from, to] of [["A deep pore", [400, 90], [625, 370]], ["Worn here", [560, 400], [560, 400]]] as [string, number[], number[]][]) {
      await page.getByRole("button", { name: "Add", exact: true }).last().click();
      await page.mouse.move(from[0] ?? 0, from[1] ?? 0);
      await page.mouse.down();
      await page.mouse.move(to[0] ?? 0, to[1] ?? 0);
      await page.mouse.up();
      await page.getByLabel("Text of the annotation").fill(text);
      await page.getByRole("button", { name: "Keep", exact: true }).click();
    }
    await page.locator(".notes").scrollIntoViewIfNeeded();
    await page.waitForTimeout(3500);
  });
});

test("a page to open from disk", () => {
  place.run("capture sponge -o small --lights 60 --size 144x144 --feature 48");
  place.run("fit small -o small.ptm");
  place.run(`share small.ptm --single-file --title Sponge -o ${documentation("sponge.html")} --force`);
});
