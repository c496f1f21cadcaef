// An object of its own for tests.
import { writeFileSync } from "node:fs";

/** A bent sheet whose halves mirror the texture at a seam with shared vertices, as OBJ. */
export function writeShape(path: string): void {
  const lines: string[] = [], columns = 24, rows = 12;
  for (let j = 0; j <= rows; j++)
    for (let i = 0; i <= columns; i++) {
      const s = (2 * i) / columns - 1, t = (2 * j) / rows - 1, angle = 1.1 * s;
      lines.push(`v ${Math.sin(angle)} ${0.7 * t + 0.1 * Math.sin(3 * s)} ${Math.cos(angle) + 0.15 * t * t}`);
      lines.push(`vt ${Math.abs(s) * 1.5} ${(t + 1) / 2}`);
    }
  for (let j = 0; j < rows; j++)
    for (let i = 0; i < columns; i++) {
      const a = j * (columns + 1) + i + 1, b = a + 1, d = a + columns + 1, c = d + 1;
      lines.push(`f ${a}/${a} ${b}/${b} ${c}/${c} ${d}/${d}`);
    }
  writeFileSync(path, `${lines.join("\n")}\n`);
}

/** A square texture of bumps, grain and four colours as a polynomial texture map (LRGB). */
export function writePtm(path: string, side: number): void {
  const head = Buffer.from(`PTM_1.2\nPTM_FORMAT_LRGB\n${side}\n${side}\n1 1 1 1 1 1\n128 128 128 128 128 0\n`, "latin1");
  const texels = side * side, bytes = Buffer.alloc(head.length + 9 * texels);
  head.copy(bytes);
  let seed = 1;
  for (let i = 0; i < texels; i++) {
    const x = i % side, y = Math.floor(i / side), at = head.length + 6 * i, color = head.length + 6 * texels + 3 * i;
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    const grain = (seed >>> 24) / 255 - 0.5, a = Math.cos(x / 9) * Math.sin(y / 31), b = Math.sin(x / 23) * Math.cos(y / 7);
    bytes.set([110, 112, 128 + 10 * a * b, 128 + 50 * a + 12 * grain, 128 + 50 * b - 12 * grain, 150 + 20 * a], at);
    const light = x % 500 < 230, red = y % 380 < 190;
    bytes.set([light ? 230 : 150, red ? 120 : 210, 140 + 60 * b], color);
  }
  writeFileSync(path, bytes);
}

/** A strip whose texels differ along it, as a polynomial texture map (RGB). */
export function writeStrip(path: string, width: number, height: number): void {
  const head = Buffer.from(`PTM_1.2\nPTM_FORMAT_RGB\n${width}\n${height}\n1 1 1 1 1 1\n128 128 128 128 128 0\n`, "latin1");
  const texels = width * height, bytes = Buffer.alloc(head.length + 18 * texels);
  head.copy(bytes);
  for (let i = 0; i < texels; i++)
    for (let c = 0; c < 3; c++) bytes.set([128, 128, 128, 128, 128, 120 + ((c === 0 ? i : 7 * i) % 100)], head.length + 6 * (c * texels + i));
  writeFileSync(path, bytes);
}
