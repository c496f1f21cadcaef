import { expect, test } from "vitest";
import { PlaneWindow } from "../src/window.js";
import { hash4 } from "../src/hash.js";
import { texelOf } from "../src/tilePlane.js";
import { tileLayout } from "../src/tiles.js";

test("a window takes what is missing, the middle first, and keeps what stays in view", () => {
  const window = new PlaneWindow(512, 256, 128);
  const first = window.take({ x: 10, y: 10, width: 300, height: 100 });
  expect(first.map(({ column, row }) => [column, row])).toEqual([[1, 0], [0, 0], [2, 0]]);
  expect(window.take({ x: 0, y: 0, width: 384, height: 128 })).toEqual([]);
  const next = window.take({ x: 200, y: -100, width: 300, height: 200 });
  expect(next.map(({ column, row }) => `${column},${row}`).sort()).toEqual(["1,-1", "2,-1", "3,-1", "3,0"]);
  expect(next.every((block) => window.holds(block))).toBe(true);
});

test("squares of one place in the texture replace each other, and places are inside it", () => {
  const window = new PlaneWindow(512, 256, 128);
  const [near] = window.take({ x: 0, y: 0, width: 1, height: 1 }), [far] = window.take({ x: -5120, y: 2560, width: 1, height: 1 });
  if (!near || !far) throw new Error("two squares");
  expect(window.placeOf(near)).toEqual(window.placeOf(far));
  expect([window.holds(near), window.holds(far)]).toEqual([false, true]);
  window.forget(near);
  expect(window.holds(far)).toBe(true);
  window.forget(far);
  expect(window.take({ x: -5120, y: 2560, width: 1, height: 1 })).toHaveLength(1);
  for (const block of window.take({ x: -1e9 - 77, y: 1e9 + 5, width: 300, height: 200 })) {
    const [x, y] = window.placeOf(block);
    expect(x >= 0 && x <= 384 && y >= 0 && y <= 128 && x % 128 === 0 && y % 128 === 0).toBe(true);
  }
});

test("a view larger than the window gets its middle", () => {
  const window = new PlaneWindow(256, 256, 128);
  const blocks = window.take({ x: 0, y: 0, width: 1000, height: 1000 });
  expect(blocks).toHaveLength(4);
  expect(new Set(blocks.map(({ slot }) => slot)).size).toBe(4);
});

test("what surrounds a tile of colours belongs to tiles with the same colours at the shared corners", () => {
  const cells = { tiles: 16, right: [20, 0] as [number, number], down: [0, 10] as [number, number], origin: [0, 0] as [number, number], corners: 2 };
  const layout = tileLayout(cells, 20, 10), at = (tile: number, x: number, y: number): number => {
    const source = layout.sources[(tile * layout.height + y + layout.padding) * layout.width + x + layout.padding] ?? 0;
    return Math.floor(source / 200);
  };
  expect([layout.width % 16, layout.height % 16]).toEqual([0, 0]);
  const corner = (tile: number, k: number): number => (tile >> k) & 1;
  for (let tile = 0; tile < 16; tile++) {
    expect(at(tile, 5, 5)).toBe(tile);
    const right = at(tile, 20, 5), left = at(tile, -1, 5), below = at(tile, 5, 10), above = at(tile, 5, -1);
    expect([corner(right, 0), corner(right, 2)]).toEqual([corner(tile, 1), corner(tile, 3)]);
    expect([corner(left, 1), corner(left, 3)]).toEqual([corner(tile, 0), corner(tile, 2)]);
    expect([corner(below, 0), corner(below, 1)]).toEqual([corner(tile, 2), corner(tile, 3)]);
    expect([corner(above, 2), corner(above, 3)]).toEqual([corner(tile, 0), corner(tile, 1)]);
    expect(corner(at(tile, 20, 10), 0)).toBe(corner(tile, 3));
  }
});

test("what surrounds an oblique tile continues it along its two steps", () => {
  const cells = { tiles: 1, right: [9, -2] as [number, number], down: [3, 8] as [number, number], origin: [0, -2] as [number, number], corners: 1 };
  const [width, height] = [12, 10], layout = tileLayout(cells, width, height);
  const source = (x: number, y: number): number => layout.sources[(y + layout.padding) * layout.width + x + layout.padding] ?? -1;
  expect(source(3, 4)).toBe(4 * width + 3);
  // One step to the left and one down of the rectangle's texel (2, 7) lies outside of it.
  const [x, y] = [2 + 9, 7 - 2 + 8];
  expect([x < width, y >= height]).toEqual([true, true]);
  const inside = source(x, y), column = inside % width, row = Math.floor(inside / width);
  const [dx, dy] = [x - column, y - row], area = 9 * 8 + 2 * 3;
  expect(Number.isInteger((dx * 8 - dy * 3) / area) && Number.isInteger((9 * dy + 2 * dx) / area)).toBe(true);
});

test("a tile is chosen by the hash of the library", () => {
  expect(hash4(1, 2, 3, 4)).toEqual([908_250_390, 4_044_648_920, 3_775_961_919, 45_698_095]);
});

test("the plane of oblique tiles repeats along the steps of one tile", () => {
  const cells = { tiles: 1, right: [9, -2] as [number, number], down: [3, 8] as [number, number], origin: [0, -2] as [number, number], corners: 1 };
  const texels = new Set<number>();
  for (let y = -20; y < 20; y++)
    for (let x = -20; x < 20; x++) {
      const here = texelOf(cells, 12, 10, x, y);
      expect([texelOf(cells, 12, 10, x + 9, y - 2), texelOf(cells, 12, 10, x + 3, y + 8)]).toEqual([here, here]);
      texels.add(here);
    }
  expect(texels.size).toBe(9 * 8 + 2 * 3);
});
