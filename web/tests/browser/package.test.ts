// The package as it is published: what is in it, and the example of its README as people run it.
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { createServer } from "node:http";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "vite";
import { afterAll, beforeAll, expect, test } from "vitest";
import { launched } from "../chromium.js";
import { Workplace } from "../program.js";
import { canvas } from "./pictures.js";

const WEB = fileURLToPath(new URL("../../", import.meta.url)), PACKAGE = join(WEB, "packages/relume-three");
const place = new Workplace();

beforeAll(() => {
  place.run("capture sponge -o capture --lights 12 --size 64x64 --feature 20");
  place.run("fit capture -o sponge.ptm");
  place.run("share sponge.ptm -o site");
});

afterAll(() => place.remove());

test("the package holds its code, its types and its README, and nothing else", () => {
  const text = execFileSync("npm", ["pack", "--dry-run", "--json"], { cwd: PACKAGE, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
  const [packed] = JSON.parse(text.slice(text.indexOf("["))) as { files: { path: string; size: number }[]; unpackedSize: number }[];
  const paths = packed?.files.map(({ path }) => path) ?? [];
  expect(paths).toEqual(expect.arrayContaining(["README.md", "package.json", "dist/index.js", "dist/index.d.ts"]));
  expect(paths.filter((path) => !/^(README\.md|package\.json|dist\/\w+\.(js|d\.ts))$/.test(path))).toEqual([]);
  expect(packed?.unpackedSize).toBeLessThan(200_000);
});

test("unused loaders are left out of a bundle", async () => {
  const whole = await bundled("export * from 'relume-three';"), part = await bundled("export { loadPtm } from 'relume-three';");
  expect(whole).toContain("expected ptm or hsh");
  expect(part).toContain("PTM_FORMAT_RGB");
  expect(part).not.toContain("expected ptm or hsh");
  expect(part).not.toContain("gl_Position");
});

/** The package packed for a browser, without three.js. */
async function bundled(code: string): Promise<string> {
  const entry = place.path("entry.js");
  writeFileSync(entry, code);
  const made = await build({
    configFile: false, logLevel: "silent", root: place.folder,
    resolve: { alias: { "relume-three": join(PACKAGE, "dist/index.js") } },
    build: { write: false, minify: false, lib: { entry, formats: ["es"] }, rollupOptions: { external: ["three"] } },
  });
  const [first] = Array.isArray(made) ? made : [made];
  return first && "output" in first ? first.output.map((chunk) => ("code" in chunk ? chunk.code : "")).join("") : "";
}

test("the example of the README runs as it stands", async () => {
  const example = /```ts\n([\s\S]*?)```/.exec(readFileSync(join(PACKAGE, "README.md"), "utf8"))?.[1] ?? "";
  expect(example.split("\n").filter((line) => line && !line.startsWith("import"))).toHaveLength(9);
  const app = place.path("app"), out = place.path("site");
  mkdirSync(join(app, "node_modules"), { recursive: true });
  symlinkSync(join(WEB, "node_modules/three"), join(app, "node_modules/three"));
  symlinkSync(PACKAGE, join(app, "node_modules/relume-three"));
  writeFileSync(join(app, "main.ts"), example);
  writeFileSync(join(app, "index.html"), '<!doctype html><link rel="icon" href="data:,"><canvas width="256" height="256"></canvas><script type="module" src="./main.ts"></script>');
  rmSync(join(out, "index.html"));
  await build({ configFile: false, logLevel: "silent", root: app, build: { target: "es2022", outDir: out, emptyOutDir: false }, resolve: { preserveSymlinks: true } });
  const kinds: Record<string, string> = { html: "text/html", js: "text/javascript" };
  const files = createServer((request, response) => {
    const name = (request.url ?? "/").replace(/\/$/, "/index.html"), kind = kinds[name.split(".").pop() ?? ""] ?? "application/octet-stream";
    response.setHeader("Content-Type", kind).end(readFileSync(join(out, name)));
  });
  await new Promise<void>((resolve) => files.listen(0, "127.0.0.1", resolve));
  const address = files.address(), browser = await launched();
  const page = await browser.newPage(), complaints: string[] = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && !/GPU stall|software WebGL|performance/i.test(message.text()) && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(error.message));
  // The example draws once: its picture is kept for the test.
  await page.addInitScript(() => {
    const original = HTMLCanvasElement.prototype.getContext as (this: HTMLCanvasElement, kind: string, options?: object) => unknown;
    HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string, options?: object) {
      return original.call(this, kind, { ...options, preserveDrawingBuffer: true });
    } as typeof HTMLCanvasElement.prototype.getContext;
  });
  await page.goto(`http://127.0.0.1:${typeof address === "object" ? address?.port : 0}/`);
  await expect.poll(async () => {
    const { codes } = await canvas(page), colors = new Set<number>();
    for (let i = 0; i < codes.length; i += 4) colors.add((codes[i] ?? 0) * 65536 + (codes[i + 1] ?? 0) * 256 + (codes[i + 2] ?? 0));
    return colors.size;
  }, { timeout: 30_000 }).toBeGreaterThan(500);
  expect(complaints).toEqual([]);
  await browser.close();
  files.close();
});
