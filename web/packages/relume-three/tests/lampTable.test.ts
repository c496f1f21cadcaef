import { expect, test } from "vitest";
import { EnvironmentLamps } from "../src/environment.js";
import { halvesFrom, fromHalf } from "../src/half.js";
import { LampTable } from "../src/lampTable.js";
import { MeasuredBasis } from "../src/measured.js";
import { between, directionAt } from "../src/table.js";

type Vector = [number, number, number];

/** Five functions in colour at three lights and three views, of which the first three surround every direction. */
function basis(): MeasuredBasis {
  const around: [number, number][] = [[0, 1.2], [-1.1, -0.7], [1.1, -0.7]], nodes = 5, groups = 6;
  const texels = halvesFrom(Float32Array.from({ length: 4 * groups * 9 }, (_, i) => ((i * 37) % 64) / 16 - 2));
  const corners = Uint16Array.from({ length: 8 * nodes ** 2 }, (_, i) => (i % 4 === 3 ? 0 : i % 4));
  return new MeasuredBasis(around, around, 5, 3, texels, nodes, corners);
}

/** Lamps of which only the directions matter. */
function lamps(directions: Vector[], flat: Vector[]): EnvironmentLamps {
  const header = { file: "e.gz", nodes: directions.length, functions: 1, side: 2, scale: 1, lamps: "texture" as const };
  const numbers = new Float32Array(EnvironmentLamps.bytes(header) / 4), n = header.nodes;
  numbers.set(directions.flat(), 0);
  numbers.set(flat.flat(), 3 * n + n);
  return new EnvironmentLamps(header, new Uint8Array(numbers.buffer));
}

const unit = (x: number, y: number, z: number): Vector => [x, y, z].map((v) => v / Math.hypot(x, y, z)) as Vector;

test("the nodes of the octahedral map lie where directions are looked up", () => {
  for (let row = 0; row < 7; row++)
    for (let column = 0; column < 7; column++) {
      const direction = directionAt(column, row, 7), places = between(direction, 7).map(([lower, fraction]) => lower + fraction);
      expect(Math.hypot(...direction)).toBeCloseTo(1, 12);
      expect(places[0]).toBeCloseTo(column, 9);
      expect(places[1]).toBeCloseTo(row, 9);
    }
});

test("functions at lamps are those for the lamps' directions, for all views of the table and for the flat texture", () => {
  const directions = [unit(0, 0, 1), unit(0.4, 0.3, 0.6), unit(-0.5, 0.2, 0.4)], flat = [unit(0.1, 0, 1), unit(0.2, -0.3, 0.5), unit(-0.6, 0.1, 0.3)];
  const functions = basis(), table = LampTable.of(functions, lamps(directions, flat)), { side, across } = table;
  const { data, width, height } = table.taken().image as { data: Uint16Array; width: number; height: number };
  const groups = Math.ceil(functions.functions / 4), seen: Vector = [0, 0, 1];
  const near = (x: number, y: number, lamp: number, channel: number, group: number, light: Vector, view: Vector): void =>
    functions.weights(channel, light, view).slice(4 * group, 4 * group + 4).forEach((value, k) => expect(fromHalf(data[4 * ((lamp * height + y) * width + x) + k] ?? NaN)).toBeCloseTo(value, 2));
  for (let lamp = 0; lamp < directions.length; lamp++)
    for (let channel = 0; channel < 3; channel++)
      for (let group = 0; group < groups; group++) {
        const square = channel * groups + group, [left, top] = [(square % across) * side, Math.floor(square / across) * side];
        near(square, height - 2, lamp, channel, group, flat[lamp] ?? seen, seen);
        near(square, height - 1, lamp, channel, group, directions[lamp] ?? seen, seen);
        for (const [x, y] of [[0, 0], [side - 1, 3], [16, 16], [5, 20]] as const) near(left + x, top + y, lamp, channel, group, directions[lamp] ?? seen, directionAt(x, y, side));
      }
});

test("the tiles of a texture have one table, until the last of them lets it go", () => {
  const functions = basis(), environment = lamps([unit(0, 0, 1)], [unit(0, 0, 1)]), [one, other] = [LampTable.of(functions, environment), LampTable.of(functions, environment)];
  const first = one.taken(), second = other.taken();
  let gone = 0;
  first.addEventListener("dispose", () => gone++);
  expect(second).toBe(first);
  one.letGo();
  expect(gone).toBe(0);
  other.letGo();
  expect(gone).toBe(1);
  expect(one.taken()).not.toBe(first);
});
