// Annotations that several people, pages and programs change.
import { lstatSync, mkdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { expect, test } from "vitest";
import { ViewServer } from "../program.js";
import { listed, textOf, textsIn, write } from "./hands.js";
import { LEATHER, session } from "./opened.js";
import { show } from "./pictures.js";

const NAME = "leather.ptm.annotations.json";
const served = session(LEATHER, ["leather.ptm"]), { place, opener } = served;

const texts = (): string[] => textsIn(place.path(NAME));

test("annotations of two pages do not overwrite each other", async () => {
  const [one, two] = [await opener.open(served.url), await opener.open(served.url)];
  await write(one, "of one");
  await expect.poll(texts).toEqual(["of one"]);
  await write(two, "of two");
  await expect.poll(() => texts().sort()).toEqual(["of one", "of two"]);
  expect((await listed(two)).sort()).toEqual(["of one", "of two"]);
  // One removes what the other edits: the edited one stays.
  await one.evaluate(() => dispatchEvent(new Event("focus")));
  await expect.poll(async () => (await listed(one)).length).toBe(2);
  await two.getByRole("button", { name: "of one" }).locator("xpath=..").getByLabel(/^Edit/).click();
  await two.getByLabel("Text of the annotation").fill("edited by two");
  await two.getByRole("button", { name: "Keep", exact: true }).click();
  await expect.poll(() => texts().sort()).toEqual(["edited by two", "of two"]);
  await one.getByRole("button", { name: "of one" }).locator("xpath=..").getByLabel(/^Remove/).click();
  await expect.poll(async () => (await listed(one)).sort()).toEqual(["edited by two", "of two"]);
  expect(texts().sort()).toEqual(["edited by two", "of two"]);
  await Promise.all([one.close(), two.close()]);
  opener.forgiveFailedRequests();
});

test("what three pages write at once is all kept", async () => {
  const pages = await Promise.all([1, 2, 3].map(() => opener.open(served.url)));
  await Promise.all(pages.map(async (page, i) => {
    for (const k of [1, 2, 3]) await write(page, `${i} ${k}`);
  }));
  await expect.poll(() => texts().sort(), { timeout: 20_000 }).toEqual([0, 1, 2].flatMap((i) => [1, 2, 3].map((k) => `${i} ${k}`)));
  for (const page of pages) await page.close();
  opener.forgiveFailedRequests();
});

test("a texture that is shown twice has one list of annotations, and an edited file stays", async () => {
  const twice = await ViewServer.start(place, ["leather.ptm", "./leather.ptm"]);
  const page = await opener.open(twice.url);
  expect(await page.getByLabel("Texture", { exact: true }).locator("option").allTextContents()).toEqual(["leather (1)", "leather (2)"]);
  await write(page, "first");
  await show(page, "texture=1");
  await expect.poll(() => listed(page)).toEqual(["first"]);
  await write(page, "second");
  await expect.poll(texts).toEqual(["first", "second"]);
  writeFileSync(place.path(NAME), readFileSync(place.path(NAME), "utf8").replace("first", "by hand"));
  await write(page, "third");
  await expect.poll(() => texts().sort()).toEqual(["by hand", "second", "third"]);
  expect((await listed(page)).sort()).toEqual(["by hand", "second", "third"]);
  // A file that is gone is written with everything that the page has.
  rmSync(place.path(NAME));
  await write(page, "fourth");
  await expect.poll(() => texts().length).toBe(4);
  await page.close();
  await twice.stop();
  opener.forgiveFailedRequests();
});

test("annotations are written through a link", async () => {
  mkdirSync(place.path("kept"));
  symlinkSync("kept/notes.json", place.path(NAME));
  const page = await opener.open(served.url);
  await write(page, "linked");
  await expect.poll(() => textsIn(place.path("kept/notes.json"))).toEqual(["linked"]);
  expect(lstatSync(place.path(NAME)).isSymbolicLink()).toBe(true);
  await page.close();
});

test("annotations that the program refuses are refused by the page, in a sentence", async () => {
  const page = await opener.open(served.url);
  const load = (box: string, count = 1): Promise<void> => {
    const one = `{"text":"a","box":${box},"view":""}`;
    const bytes = `{"relume":"annotations","version":1,"annotations":[${new Array<string>(count).fill(one).join(",")}]}`;
    return page.getByLabel("File of annotations").setInputFiles({ name: "some.json", mimeType: "application/json", buffer: Buffer.from(bytes) });
  };
  const said = (): Promise<string | null> => textOf(page, ".said");
  for (const box of ["[1e999,0,1,1]", "[0,0,-4,4]", "[0,0,1e300,4]"]) {
    await load(box);
    await expect.poll(said).toMatch(/^some\.json: annotation 1: expected a box of four numbers/);
    await page.evaluate(() => document.querySelector(".said")?.replaceChildren());
  }
  await load("[0,0,NaN,1]");
  await expect.poll(said).toBe("some.json: the file holds no annotations");
  await load("[1,2,3,4]", 1001);
  await expect.poll(said).toContain("there may be 1000 annotations of a texture: found 1001");
  expect(await page.locator(".notes li").count()).toBe(0);
  await load("[1,2,3,4]", 1000);
  await expect.poll(() => texts().length).toBe(1000);
  await write(page, "one more");
  await expect.poll(said).toContain("Not kept: there may be 1000");
  expect(texts().length).toBe(1000);
  await page.close();
});
