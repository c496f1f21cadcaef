// What people do with a page, and what they see of it.
import { existsSync, readFileSync } from "node:fs";
import type { Page } from "playwright-core";

/** The place of a point in the canvas. */
export async function at(page: Page, x: number, y: number): Promise<[number, number]> {
  const box = await page.locator("canvas").boundingBox();
  if (!box) throw new Error("no canvas");
  return [box.x + x, box.y + y];
}

export async function drag(page: Page, from: [number, number], to: [number, number], button: "left" | "right" = "left"): Promise<void> {
  await page.mouse.move(...(await at(page, ...from)));
  await page.mouse.down({ button });
  await page.mouse.move(...(await at(page, ...to)), { steps: 3 });
  await page.mouse.up({ button });
}

/** Writes an annotation on the middle of the view. */
export async function write(page: Page, text: string): Promise<void> {
  await page.locator("canvas").focus();
  await page.keyboard.press("n");
  await page.getByLabel("Text of the annotation").fill(text);
  await page.getByRole("button", { name: "Keep", exact: true }).click();
}

/** Two fingers that part. */
export async function pinch(page: Page): Promise<void> {
  const session = await page.context().newCDPSession(page);
  const [x, y] = await at(page, 200, 200);
  const send = (type: "touchStart" | "touchMove" | "touchEnd", ...touches: number[]): Promise<unknown> =>
    session.send("Input.dispatchTouchEvent", { type, touchPoints: touches.map((dx, id) => ({ x: x + dx, y, id })) });
  await send("touchStart", -20);
  await send("touchMove", -25);
  await send("touchStart", -25, 20);
  for (const d of [30, 50, 70]) await send("touchMove", -d, d);
  await send("touchEnd");
}

/** The texts in the list of annotations. */
export const listed = (page: Page): Promise<string[]> => page.locator(".notes .link").allTextContents();
export const textOf = (page: Page, selector: string): Promise<string | null> => page.locator(selector).textContent();

/** The bytes of a stored entry. */
export function entry(zip: Buffer, index: number): Uint8Array {
  let at = 0;
  for (let i = 0; i < index; i++) at += 30 + zip.readUInt16LE(at + 26) + zip.readUInt32LE(at + 18);
  const start = at + 30 + zip.readUInt16LE(at + 26);
  return new Uint8Array(zip.subarray(start, start + zip.readUInt32LE(at + 18)));
}

/** The texts of a file of annotations; none where there is no file. */
export function textsIn(path: string): string[] {
  if (!existsSync(path)) return [];
  return (JSON.parse(readFileSync(path, "utf8")) as { annotations: { text: string }[] }).annotations.map(({ text }) => text);
}
