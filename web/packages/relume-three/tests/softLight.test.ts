import { Vector3 } from "three";
import { expect, test } from "vitest";
import { MOST_DIRECTIONS, type ReflectanceLight, directionsOf } from "../src/softLight.js";

const light = (direction: [number, number, number], softness?: number): ReflectanceLight => ({ direction, color: [1, 0.5, 2], ...(softness === undefined ? {} : { softness }) });

test("the directions of a soft light lie evenly around its axis, and have its colour together", () => {
  for (const angle of [0.05, 0.4, 0.78])
    for (const axis of [[0, 0, 1], [1, 0, 0], [-0.4, 0.7, 0.2]] as [number, number, number][]) {
      const all = directionsOf([light(axis, angle)]), unit = new Vector3(...axis).normalize();
      const middle = all.reduce((sum, { direction }) => sum.add(direction), new Vector3()).divideScalar(all.length);
      // The centre of mass of a cap lies on its axis, half way from its rim to its top.
      expect(middle.clone().cross(unit).length()).toBeLessThan(1e-12);
      expect(middle.dot(unit)).toBeCloseTo((1 + Math.cos(angle)) / 2, 2);
      for (const { direction } of all) {
        expect(direction.length()).toBeCloseTo(1, 12);
        expect(direction.angleTo(unit)).toBeLessThan(angle);
      }
      const color = all.reduce((sum, { color }) => sum.add(color), new Vector3());
      expect(color.distanceTo(new Vector3(1, 0.5, 2))).toBeLessThan(1e-12);
    }
});

test("lights without softness stay as they are, and four lights fit whatever they are", () => {
  const [hard, ...others] = directionsOf([light([0, 3, 4])]);
  expect(others).toEqual([]);
  expect(hard?.direction.distanceTo(new Vector3(0, 0.6, 0.8))).toBeLessThan(1e-12);
  expect(hard?.color.toArray()).toEqual([1, 0.5, 2]);
  expect([directionsOf([light([0, 0, 1], 0.3)]).length, directionsOf([light([0, 0, 1], 0.3)], true).length]).toEqual([19, 7]);
  for (let soft = 0; soft <= 5; soft++) {
    const lights = Array.from({ length: 5 }, (_, i) => light([0, 0, 1], i < soft ? 0.3 : 0));
    expect(directionsOf(lights).length).toBeLessThanOrEqual(MOST_DIRECTIONS);
  }
});
