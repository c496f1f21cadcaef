import { expect, test } from "vitest";
import { D65, NEUTRAL, balanceFor, chromaticityOf, temperatureOf, whiteOf } from "../../src/balance.js";

const times = (m: readonly number[], v: number[]): number[] => [0, 3, 6].map((row) => [0, 1, 2].reduce((sum, k) => sum + (m[row + k] ?? 0) * (v[k] ?? 0), 0));
const luminance = (v: number[]): number => 0.2126729 * (v[0] ?? 0) + 0.7151522 * (v[1] ?? 0) + 0.072175 * (v[2] ?? 0);

test("a balanced colour is grey, and as light as before", () => {
  for (const color of [[0.5, 0.4, 0.2], [0.2, 0.3, 0.6], [0.9, 0.9, 0.89]] as [number, number, number][]) {
    const white = chromaticityOf(color);
    if (!white) throw new Error("the colour is not black");
    const shown = times(balanceFor(white), color), mean = luminance(color);
    for (const value of shown) expect(value).toBeCloseTo(mean, 3);
  }
});

test("neutral changes nothing, and black has no colour", () => {
  expect(balanceFor(D65)).toEqual([1, 0, 0, 0, 1, 0, 0, 0, 1]);
  expect(chromaticityOf([0, 0, 0])).toBeNull();
});

test("temperatures come back, and those of CIE illuminants are near", () => {
  for (const kelvins of [2500, 3200, 5000, NEUTRAL, 9000]) expect(Math.abs(temperatureOf(whiteOf(kelvins)) / kelvins - 1)).toBeLessThan(0.01);
  expect(whiteOf(NEUTRAL)).toEqual(D65);
  // A, D50 and D75.
  for (const [kelvins, white] of [[2856, [0.4476, 0.4074]], [5003, [0.3457, 0.3585]], [7504, [0.299, 0.3149]]] as [number, [number, number]][]) {
    expect(Math.abs(temperatureOf(white) / kelvins - 1)).toBeLessThan(0.02);
  }
});

test("warm light is shown colder", () => {
  const [red = 0, , blue = 0] = times(balanceFor(whiteOf(3000)), [1, 1, 1]);
  expect(blue).toBeGreaterThan(1.5 * red);
});
