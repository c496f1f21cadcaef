// Chromium of the system, with WebGL 2 by software.
import { existsSync, readFileSync, readdirSync } from "node:fs";
import { type Browser, chromium } from "playwright-core";

const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const FLAGS = [
  "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run",
  "--disable-background-networking", "--disable-component-update", "--disable-sync", "--force-color-profile=srgb",
];

/** The browser, or null where there is none. */
async function launch(): Promise<Browser | null> {
  const executablePath = process.env["CHROMIUM"] ?? PLACES.find((place) => existsSync(place));
  if (executablePath === undefined) return null;
  return chromium.launch({ executablePath, headless: true, args: FLAGS });
}

/** The browser, without which a test cannot be run. */
export async function launched(): Promise<Browser> {
  const browser = await launch();
  if (!browser) throw new Error("no Chromium was found: install it, or name it in CHROMIUM");
  return browser;
}

/** Processor seconds that browsers of this kind have drawn so far, of this process's children; null where the system does not tell. */
export function drawingSeconds(): number | null {
  if (!existsSync("/proc/self/stat")) return null;
  const parents = new Map<number, number>(), drawn = new Map<number, number>();
  for (const pid of readdirSync("/proc").map(Number).filter(Number.isInteger)) {
    try {
      const fields = readFileSync(`/proc/${pid}/stat`, "utf8").split(") ")[1]?.split(" ") ?? [];
      parents.set(pid, Number(fields[1]));
      if (readFileSync(`/proc/${pid}/cmdline`, "utf8").includes("--type=gpu-process")) drawn.set(pid, (Number(fields[11]) + Number(fields[12])) / 100);
    } catch {
      // It has ended.
    }
  }
  const isOwn = (pid: number | undefined): boolean => pid !== undefined && pid > 1 && (pid === process.pid || isOwn(parents.get(pid)));
  return [...drawn].filter(([pid]) => isOwn(pid)).reduce((sum, [, seconds]) => sum + seconds, 0);
}
