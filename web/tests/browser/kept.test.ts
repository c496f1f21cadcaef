// What people keep of a page, and what it says when something is taken from it.
import { readFileSync } from "node:fs";
import type { Page } from "playwright-core";
import { expect, test } from "vitest";
import { ViewServer } from "../program.js";
import { entry, listed, textOf, textsIn, write } from "./hands.js";
import { LEATHER, MARBLE, session } from "./opened.js";
import { canvas, difference, drawn, settled, show } from "./pictures.js";

const NAME = "leather.ptm.annotations.json";
const served = session([...LEATHER, ...MARBLE], ["leather.ptm", "marble.rlm"]), { place, opener } = served;

const said = (page: Page): Promise<string | null> => textOf(page, ".said");
const notice = (page: Page): Promise<string | null> => textOf(page, ".notice");
const bookmarks = (page: Page): Promise<string[]> => page.locator("dialog[aria-label=Bookmarks] .link").allTextContents();

async function keep(page: Page, name: string): Promise<void> {
  await page.keyboard.press("b");
  await page.getByLabel("Name of the bookmark").fill(name);
  await page.getByText("Keep this view").click();
}

test("a picture that the graphics card takes away is said, not saved, and drawn again", async () => {
  const page = await opener.open(served.url);
  for (const view of ["texture=0&mode=normals", "texture=1&zoom=0.5"]) {
    await show(page, view);
    await settled(page);
    const before = await canvas(page);
    await page.evaluate(() => {
      const lost = document.querySelector("canvas")?.getContext("webgl2")?.getExtension("WEBGL_lose_context");
      Object.assign(globalThis, { lost });
      lost?.loseContext();
    });
    await expect.poll(() => notice(page)).toContain("The graphics card has taken the picture away");
    for (const button of ["Save a picture", "Save the whole texture"]) {
      await page.getByRole("button", { name: button, exact: true }).click();
      await expect.poll(() => said(page)).toMatch(/^No picture: the graphics card/);
      await page.evaluate(() => document.querySelector(".said")?.replaceChildren());
    }
    await page.evaluate(() => (globalThis as unknown as { lost: WEBGL_lose_context }).lost.restoreContext());
    await expect.poll(() => notice(page)).toBe("");
    await settled(page);
    expect(difference(await canvas(page), before).mean, view).toBe(0);
  }
  await page.close();
});

test("bookmarks are kept beside the texture, found by the next server, and shared", async () => {
  const page = await opener.open(served.url);
  await show(page, "mode=normals&zoom=2");
  const kept = await canvas(page);
  await keep(page, "the normals");
  expect(await page.getByText("Kept in the file of the annotations, beside the texture.").isVisible()).toBe(true);
  await expect.poll(() => textsIn(place.path(NAME))).toEqual(["the normals"]);
  expect(await bookmarks(page)).toEqual(["the normals"]);
  // It is no annotation of a place.
  expect(await listed(page)).toEqual([]);
  await page.close();
  const next = await ViewServer.start(place, ["marble.rlm", "leather.ptm"]), again = await opener.open(next.url);
  await again.keyboard.press("b");
  await again.getByRole("button", { name: "the normals", exact: true }).click();
  await drawn(again);
  expect(await again.getByLabel("Texture", { exact: true }).inputValue()).toBe("1");
  expect(difference(await canvas(again), kept).mean).toBe(0);
  place.run("share leather.ptm --single-file -o marked.html --force");
  const shared = await opener.open(`file://${place.path("marked.html")}`);
  await shared.keyboard.press("b");
  await expect.poll(() => bookmarks(shared)).toEqual(["the normals"]);
  await shared.close();
  await again.keyboard.press("b");
  await again.getByRole("button", { name: "Remove the normals" }).click();
  await expect.poll(() => textsIn(place.path(NAME))).toEqual([]);
  await again.keyboard.press("Escape");
  await again.keyboard.press("Control+z");
  await expect.poll(() => textsIn(place.path(NAME))).toEqual(["the normals"]);
  await again.close();
  await next.stop();
});

test("bookmarks of a shared page stay in the browser, and other pages of its title have none of them", async () => {
  for (const name of ["one", "two"]) place.run(`share leather.ptm --single-file --title Leather -o ${name}.html --force`);
  const context = await served.browser.newContext();
  const open = async (name: string): Promise<Page> => {
    const page = await context.newPage();
    await page.goto(`file://${place.path(`${name}.html`)}`);
    await page.waitForFunction(() => document.documentElement.dataset["ready"] !== undefined);
    return page;
  };
  const page = await open("one");
  await keep(page, "mine");
  expect(await page.getByText("Kept in this browser").isVisible()).toBe(true);
  await page.close();
  for (const [name, expected] of [["one", ["mine"]], ["two", []]] as const) {
    const other = await open(name);
    await other.keyboard.press("b");
    expect(await bookmarks(other)).toEqual(expected);
    await other.close();
  }
  await context.close();
});

test("a window that is resized leaves the pictures of a film as they are", async () => {
  const page = await opener.open(served.url, { viewport: { width: 420, height: 500 } }), count = 24;
  for (const format of ["zip", "gif"] as const) {
    await page.setViewportSize({ width: 420, height: 500 });
    await drawn(page);
    const size = await page.evaluate(() => `${document.querySelector("canvas")?.width} x ${document.querySelector("canvas")?.height}`);
    await page.getByRole("button", { name: "Record the light" }).click();
    await page.getByLabel("Pictures").fill(String(count));
    await page.getByLabel("Kind of file").selectOption(format);
    const saving = page.waitForEvent("download", { timeout: 200_000 });
    await page.getByRole("button", { name: "Make", exact: true }).click();
    await page.waitForFunction(() => document.querySelector(".said")?.textContent?.startsWith("Picture "));
    await page.getByRole("button", { name: "Save the whole texture" }).click();
    await page.setViewportSize({ width: 380, height: 460 });
    const saved = await saving, film = readFileSync(await saved.path());
    // The picture of the whole texture was refused: it has another size.
    expect(saved.suggestedFilename()).toBe(`leather.${format}`);
    expect(size).toMatch(/^420 x /);
    if (format === "zip") {
      const sizes = Array.from({ length: count }, (_, i) => Buffer.from(entry(film, i))).map((png) => `${png.readUInt32BE(16)} x ${png.readUInt32BE(20)}`);
      expect(new Set(sizes)).toEqual(new Set([size]));
    }
    // Afterwards the picture has the size of the window.
    await expect.poll(() => page.evaluate(() => document.querySelector("canvas")?.width)).toBe(380);
  }
  await page.close();
});

test("a server that took the address of another is named, and what was written can be brought there", async () => {
  const first = await ViewServer.start(place, ["leather.ptm"]), port = new URL(first.url).port;
  const page = await opener.open(first.url);
  await first.stop();
  const second = await ViewServer.start(place, ["leather.ptm", "--port", port]);
  await write(page, "left behind");
  await expect.poll(() => notice(page)).toBe(
    "The annotations are not saved: another relume view runs at this address now. Download them, open the page that it printed, and load them there.",
  );
  const [file] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Download", exact: true }).click()]);
  const next = await opener.open(second.url);
  await next.getByLabel("File of annotations").setInputFiles(await file.path());
  await expect.poll(() => textsIn(place.path(NAME))).toEqual(["left behind"]);
  await Promise.all([page.close(), next.close()]);
  await second.stop();
  opener.forgiveFailedRequests();
});

test("what no server gives at first is asked for again", async () => {
  const page = await served.browser.newPage({ viewport: { width: 500, height: 600 } });
  await page.route(/textures\/0\/|annotations/, (route) => route.abort());
  await page.goto(served.url);
  await expect.poll(() => notice(page), { timeout: 20_000 }).toContain("leather: share.json cannot be loaded: the server does not answer. The page tries again.");
  await page.unroute(/textures\/0\/|annotations/);
  await expect.poll(() => notice(page), { timeout: 20_000 }).toBe("");
  const fresh = await opener.open(served.url, { viewport: { width: 500, height: 600 } });
  await drawn(page);
  expect(difference(await canvas(page), await canvas(fresh)).mean).toBe(0);
  await Promise.all([page.close(), fresh.close()]);
});

test("faults at the beginning are said once, and can be closed", async () => {
  place.run("share leather.ptm marble.rlm -o folder --force");
  const page = await served.browser.newPage({ viewport: { width: 700, height: 440 } });
  await page.goto(`file://${place.path("folder/index.html")}`);
  await page.waitForFunction(() => document.documentElement.dataset["ready"] !== undefined);
  expect((await notice(page))?.match(/--single-file/g)?.length).toBe(1);
  expect(await notice(page)).toMatch(/^leather and marble: /);
  await page.getByRole("button", { name: "Close these messages" }).click();
  expect(await notice(page)).toBe("");
  await page.close();
  const broken = await ViewServer.start(place, ["leather.ptm", "no-such-file.ptm"]), other = await opener.open(broken.url);
  expect((await notice(other))?.match(/no-such-file\.ptm/g)?.length).toBe(1);
  await other.close();
  await broken.stop();
});

test("two pages that write in turn cause no conflicts", async () => {
  const [one, two] = [await opener.open(served.url), await opener.open(served.url)];
  for (const [page, text] of [[one, "a"], [two, "b"], [one, "c"]] as const) {
    await write(page, text);
    await expect.poll(() => textsIn(place.path(NAME))).toContain(text);
  }
  expect(textsIn(place.path(NAME)).sort()).toEqual(["a", "b", "c"]);
  await Promise.all([one.close(), two.close()]);
});
