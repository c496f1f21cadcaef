// The tools of the page: own objects, annotations, white balance, pictures and films.
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import type { Download, Page } from "playwright-core";
import { expect, test } from "vitest";
import { decodePng } from "../../packages/relume-three/src/png.js";
import { writeShape } from "../shapes.js";
import { entry } from "./hands.js";
import { LEATHER, session } from "./opened.js";
import { canvas, difference, drawn, file, show } from "./pictures.js";

const served = session(LEATHER, ["leather.ptm", "--mesh", "shape.obj"], (place) => writeShape(place.path("shape.obj"))), { place, opener } = served;

test("an object of one's own is shown from a server, a folder and one file", async () => {
  const page = await opener.open(served.url);
  await page.getByRole("radio", { name: "shape.obj" }).click();
  await drawn(page);
  const shown = await canvas(page);
  await show(page, "object=flat");
  expect(difference(await canvas(page), shown).mean).toBeGreaterThan(2);
  place.run("share leather.ptm --mesh shape.obj --single-file -o shape.html");
  const single = await opener.open(`file://${place.path("shape.html")}#object=mesh`);
  expect(difference(await canvas(single), shown).mean).toBe(0);
  await single.close();
  await page.close();
});

test("a page without an object of one's own shows a plane instead", async () => {
  place.run("share leather.ptm --single-file -o plain.html");
  const page = await opener.open(`file://${place.path("plain.html")}#object=mesh`);
  expect(await page.getByRole("radio").count()).toBe(5);
  await page.close();
});

test("an object that is opened or dropped is the one of --mesh, and another file is refused in a sentence", async () => {
  const truth = await opener.open(`${served.url}#object=mesh`), expected = await canvas(truth);
  await truth.close();
  place.run("share leather.ptm --single-file -o empty.html");
  const page = await opener.open(`file://${place.path("empty.html")}`);
  const [chooser] = await Promise.all([page.waitForEvent("filechooser"), page.getByRole("button", { name: "Open an object" }).click()]);
  await chooser.setFiles(place.path("shape.obj"));
  await page.getByRole("radio", { name: "shape.obj", checked: true }).waitFor();
  await drawn(page);
  // The program writes its numbers as floats after other roundings.
  expect(difference(await canvas(page), expected).mean).toBeLessThan(0.05);
  await show(page, "object=flat");
  const drop = (name: string, text: string): Promise<void> =>
    page.evaluate(([name, text]) => {
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([text], name));
      document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
    }, [name, text] as const);
  await drop("again.obj", readFileSync(place.path("shape.obj"), "utf8"));
  await page.getByRole("radio", { name: "again.obj", checked: true }).waitFor();
  await drawn(page);
  expect(difference(await canvas(page), expected).mean).toBeLessThan(0.05);
  await drop("bad.obj", "v 0 0 0\nf 1/1 2/2 3/3\n");
  await expect.poll(() => page.locator(".said").textContent()).toContain("bad.obj: line 2: a face refers to texture coordinate 1");
  await drop("picture.png", "");
  await expect.poll(() => page.locator(".said").textContent()).toContain(".glb or .obj");
  await page.close();
});

const NAME = "leather.ptm.annotations.json";
const TEXT = "</script><b>a \"tear\"</b>\n& more";

async function annotate(page: Page, text: string, from: [number, number], to: [number, number]): Promise<void> {
  await page.getByRole("button", { name: "Add", exact: true }).last().click();
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  await page.mouse.move(box.x + from[0], box.y + from[1]);
  await page.mouse.down();
  await page.mouse.move(box.x + to[0], box.y + to[1], { steps: 3 });
  await page.mouse.up();
  await page.getByLabel("Text of the annotation").fill(text);
  await page.getByRole("button", { name: "Keep", exact: true }).click();
}

test("annotations are written beside the texture, read again, gone to, edited and removed", async () => {
  const page = await opener.open(served.url);
  await show(page, "mode=normals&zoom=2&x=0.4");
  const written = await canvas(page);
  await annotate(page, TEXT, [120, 100], [200, 180]);
  await expect.poll(() => existsSync(place.path(NAME))).toBe(true);
  await show(page, "mode=default");
  await annotate(page, "a point", [90, 90], [90, 90]);
  await expect.poll(() => JSON.parse(readFileSync(place.path(NAME), "utf8")).annotations.length).toBe(2);
  const kept = JSON.parse(readFileSync(place.path(NAME), "utf8")) as { annotations: { text: string; box: number[]; view: string }[] };
  expect(kept.annotations[0]?.text).toBe(TEXT);
  expect(kept.annotations[0]?.box[2]).toBeGreaterThan(5);
  expect(kept.annotations[1]?.box.slice(2)).toEqual([0, 0]);
  expect(kept.annotations[0]?.view).toContain("mode=normals");
  await page.close();
  const again = await opener.open(served.url);
  await again.getByRole("button", { name: "</script>" }).click();
  await drawn(again);
  expect(difference(await canvas(again), written).mean).toBe(0);
  expect(await again.locator(".overlay rect").count()).toBe(1);
  expect(await again.locator(".overlay circle").count()).toBe(1);
  await again.getByLabel("Edit annotation 2").click();
  await again.getByLabel("Text of the annotation").fill("another");
  await again.getByRole("button", { name: "Keep", exact: true }).click();
  await again.getByLabel("Remove annotation 1").click();
  await expect.poll(() => readFileSync(place.path(NAME), "utf8")).not.toContain("script");
  expect(readFileSync(place.path(NAME), "utf8")).toContain("another");
  await again.close();
});

test("shared pages hold annotations, and download and load them", async () => {
  writeFileSync(place.path(NAME), '{"relume":"annotations","version":1,"annotations":[{"text":"a point","box":[90,90,0,0],"view":""}]}');
  place.run("share leather.ptm --single-file -o noted.html");
  const page = await opener.open(`file://${place.path("noted.html")}`);
  expect(await page.locator(".notes li").count()).toBe(1);
  const saved = await pressed(page, "Download");
  expect(saved.suggestedFilename()).toBe("leather.annotations.json");
  await page.getByLabel("File of annotations").setInputFiles(await saved.path());
  await expect.poll(() => page.locator(".notes li").count()).toBe(2);
  await page.locator("canvas").focus();
  await page.keyboard.press("n");
  expect(await page.getByLabel("Text of the annotation").inputValue()).toBe("");
  await page.keyboard.type("by keys");
  await page.getByRole("button", { name: "Keep", exact: true }).click();
  expect(await page.locator(".notes li").last().textContent()).toContain("by keys");
  await page.close();
});

async function pressed(page: Page, name: string): Promise<Download> {
  const [saved] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name, exact: true }).click()]);
  return saved;
}

test("a picked place becomes grey, and neutral takes it back", async () => {
  const page = await opener.open(served.url);
  await show(page, "mode=default");
  const first = await canvas(page), box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  const at = [Math.round(box.width / 2), Math.round(box.height / 2)] as const;
  const mean = (picture: typeof first): number[] => [0, 1, 2].map((c) => {
    let sum = 0;
    for (let y = -2; y <= 2; y++) for (let x = -2; x <= 2; x++) sum += picture.codes[4 * ((at[1] + y) * picture.width + at[0] + x) + c] ?? 0;
    return sum / 25;
  });
  const spread = (rgb: number[]): number => Math.max(...rgb) - Math.min(...rgb);
  expect(spread(mean(first))).toBeGreaterThan(8);
  await page.getByRole("button", { name: "Pick grey" }).click();
  await page.mouse.click(box.x + at[0], box.y + at[1]);
  await drawn(page);
  expect(spread(mean(await canvas(page)))).toBeLessThan(4);
  await page.waitForTimeout(400);
  expect(page.url()).toContain("whiteX=");
  await page.getByRole("button", { name: "Neutral" }).click();
  await drawn(page);
  expect(difference(await canvas(page), first).mean).toBe(0);
  await page.close();
});

test("the whole texture is saved with a pixel for each texel", async () => {
  const page = await opener.open(served.url);
  await show(page, "zoom=5&x=0.2&lights=0.3,0.2,ffffff,1");
  const before = await canvas(page);
  const saved = await pressed(page, "Save the whole texture");
  const picture = await decodePng(new Uint8Array(readFileSync(await saved.path())));
  place.run(`relight leather.ptm --light 0.3,0.2,${Math.sqrt(1 - 0.09 - 0.04)} -o truth.png --force`);
  const { mean, most } = difference(picture, await file(place.path("truth.png")));
  expect(mean).toBeLessThan(1);
  expect(most).toBeLessThanOrEqual(4);
  await drawn(page);
  expect(difference(await canvas(page), before).mean).toBe(0);
  await page.close();
});

test("a path of the light becomes a film with as many pictures as asked for", async () => {
  const page = await opener.open(served.url, { viewport: { width: 320, height: 240 } });
  await page.keyboard.press("h");
  const make = async (format: string): Promise<Buffer> => {
    await page.getByRole("button", { name: "Record the light" }).click();
    await page.getByLabel("Pictures").fill("5");
    await page.getByLabel("Kind of file").selectOption(format);
    const saved = await pressed(page, "Make");
    expect(saved.suggestedFilename()).toBe(`leather.${format}`);
    return readFileSync(await saved.path());
  };
  const gif = await make("gif");
  expect(gif.subarray(0, 6).toString()).toBe("GIF89a");
  expect(gif.toString("latin1").split("\x21\xf9\x04").length - 1).toBe(5);
  expect(await make("gif")).toEqual(gif);
  await page.getByRole("button", { name: "Record the light" }).click();
  await page.getByRole("button", { name: "Record a drag" }).click();
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  await page.mouse.move(box.x + 100, box.y + 100);
  await page.mouse.down();
  await page.mouse.move(box.x + 200, box.y + 60, { steps: 6 });
  await page.mouse.up();
  const zip = await make("zip");
  expect(zip.readUInt16LE(zip.length - 12)).toBe(5);
  const [first, last] = [0, 4].map((i) => entry(zip, i)), [a, b] = await Promise.all([decodePng(first ?? zip), decodePng(last ?? zip)]);
  expect(difference(a, b).mean).toBeGreaterThan(1);
  const film = await make("webm");
  expect(film.subarray(0, 4)).toEqual(Buffer.from([0x1a, 0x45, 0xdf, 0xa3]));
  await page.close();
});

test("axe finds no fault in the dialogs of the tools, and a phone holds them", async () => {
  const axe = readFileSync(new URL("../../node_modules/axe-core/axe.min.js", import.meta.url), "utf8");
  const page = await opener.open(served.url, { viewport: { width: 390, height: 844 }, deviceScaleFactor: 2, isMobile: true, hasTouch: true });
  await page.evaluate(axe);
  const faults = (): Promise<string[]> => page.evaluate(async () => {
    const { violations } = await (globalThis as unknown as { axe: { run(): Promise<{ violations: { id: string; nodes: { html: string }[] }[] }> } }).axe.run();
    return violations.map(({ id, nodes }) => `${id}: ${nodes.map((node) => node.html).join(" ")}`);
  });
  await page.getByRole("button", { name: "Record the light" }).tap();
  expect(await faults()).toEqual([]);
  expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390);
  await page.getByRole("button", { name: "Cancel" }).first().tap();
  await page.getByRole("button", { name: "Controls", exact: true }).tap();
  expect(await faults()).toEqual([]);
  const before = await page.locator(".notes li").count();
  await page.getByRole("button", { name: "Add", exact: true }).last().tap();
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  await page.touchscreen.tap(box.x + box.width / 2, box.y + box.height / 2);
  expect(await faults()).toEqual([]);
  await page.getByLabel("Text of the annotation").fill("by touch");
  await page.getByRole("button", { name: "Keep", exact: true }).tap();
  expect(await page.locator(".notes li").count()).toBe(before + 1);
  await page.close();
});

test("an element shows a shared page within another one", async () => {
  place.run("share leather.ptm -o element --force");
  const files = createServer((request, response) => {
    const name = (request.url ?? "/").replace(/[?#].*/, "").replace(/\/$/, "/index.html");
    const host = '<!doctype html><html lang="en"><title>Host</title><script src="element/relume-view.js"></script><relume-view src="element/" view="mode=normals" title="Leather"></relume-view>';
    const kind = name.endsWith("html") ? "text/html" : name.endsWith("js") ? "text/javascript" : name.endsWith("css") ? "text/css" : "application/octet-stream";
    if (name === "/favicon.ico") return response.writeHead(404).end();
    response.setHeader("Content-Type", kind).end(name === "/index.html" ? host : readFileSync(place.path(name.slice(1))));
  });
  await new Promise<void>((resolve) => files.listen(0, "127.0.0.1", resolve));
  const address = files.address(), page = await served.browser.newPage({ viewport: { width: 600, height: 400 } });
  await page.goto(`http://127.0.0.1:${typeof address === "object" ? address?.port : 0}/`);
  const frame = page.frameLocator("relume-view iframe");
  await frame.locator("html[data-ready]").waitFor({ timeout: 60_000 });
  expect(await page.locator("relume-view iframe").getAttribute("title")).toBe("Leather");
  const shown = (): Promise<string> => frame.locator("select[aria-label='What is shown']").inputValue();
  expect(await shown()).toBe("normals");
  const size = await page.locator("relume-view").boundingBox();
  expect((size?.width ?? 0) / (size?.height ?? 1)).toBeCloseTo(1.5, 2);
  await page.evaluate(() => document.querySelector("relume-view")?.setAttribute("view", "mode=albedo"));
  await expect.poll(shown).toBe("albedo");
  // Scripts in place of an address do not run, and what is no address is nothing.
  for (const src of ["javascript:parent.document.title='run'", "http://"]) {
    await page.evaluate((src) => document.querySelector("relume-view")?.setAttribute("src", src), src);
    expect(await page.locator("relume-view iframe").getAttribute("src")).toBeNull();
  }
  expect(await page.title()).toBe("Host");
  await page.close();
  files.close();
});
