import { readFileSync } from "node:fs";
import type { Page } from "playwright-core";
import { type Codes, decodePng } from "../../packages/relume-three/src/png.js";

/** Waits until all textures are loaded, and the page has drawn them. */
export async function ready(page: Page): Promise<void> {
  await page.waitForFunction(() => document.documentElement.dataset["ready"] !== undefined, null, { timeout: 100_000 });
  await drawn(page);
}

/** Waits for the next frames, with all their pixels. */
export async function drawn(page: Page): Promise<void> {
  const frames = (): Promise<void> => page.evaluate(() => new Promise<void>((resolve) => requestAnimationFrame(() => requestAnimationFrame(() => resolve()))));
  await frames();
  await page.waitForFunction(() => document.documentElement.dataset["making"] === "false" && document.documentElement.dataset["coarse"] !== "true");
  await frames();
}

/** Waits until everything in view of an endless plane has come. */
export async function settled(page: Page): Promise<void> {
  await page.waitForFunction(() => document.documentElement.dataset["waiting"] === "0", null, { timeout: 100_000 });
  await drawn(page);
}

/** Shows the state of an address. */
export async function show(page: Page, hash: string): Promise<void> {
  await page.evaluate(
    (hash) =>
      new Promise<void>((resolve) => {
        if (location.hash === `#${hash}`) return resolve();
        addEventListener("hashchange", () => resolve(), { once: true });
        location.hash = hash;
      }),
    hash,
  );
  await drawn(page);
}

/** The canvas as codes. */
export async function canvas(page: Page): Promise<Codes> {
  const url = await page.evaluate(() => document.querySelector("canvas")?.toDataURL() ?? "");
  return decodePng(new Uint8Array(Buffer.from(url.split(",")[1] ?? "", "base64")));
}

export async function file(path: string): Promise<Codes> {
  return decodePng(new Uint8Array(readFileSync(path)));
}

/** The mean and the 99th percentile of the differences of red, green and blue, where the second picture has a place. */
export function difference(a: Codes, b: Codes, isShown: (rgb: number[]) => boolean = () => true): { mean: number; most: number; count: number } {
  if (a.width !== b.width || a.height !== b.height) throw new Error(`${a.width} x ${a.height} and ${b.width} x ${b.height}`);
  const counts = new Array<number>(256).fill(0);
  let count = 0;
  for (let i = 0; i < a.width * a.height; i++) {
    const [p, q] = [a, b].map((c) => [0, 1, 2].map((k) => c.codes[i * c.channels + (c.channels < 3 ? 0 : k)] ?? 0)) as [number[], number[]];
    if (!isShown(p) || !isShown(q)) continue;
    for (let k = 0; k < 3; k++) {
      const d = Math.abs((p[k] ?? 0) - (q[k] ?? 0));
      counts[d] = (counts[d] ?? 0) + 1;
    }
    count += 3;
  }
  const mean = counts.reduce((sum, n, d) => sum + n * d, 0) / count;
  let most = 255;
  for (let above = 0; most > 0; most--) {
    above += counts[most] ?? 0;
    if (above > count / 100) break;
  }
  return { mean, most, count };
}
