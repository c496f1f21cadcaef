import { expect, test } from "vitest";
import { History } from "../../src/history.js";
import { FIRST, MOST_STRENGTH, copyOf, fromHash, onDisk, toHash } from "../../src/state.js";

test("an address restores the view", () => {
  const state = copyOf(FIRST);
  Object.assign(state, { object: "torus", mode: "unsharp-normals", exposure: -1.5, x: 0.25, zoom: 12, wipe: 0.3, compare: "wipe", other: 1, cells: true });
  state.lights.push({ u: 0.1, v: -0.2, color: "#ff8000", strength: 0.5, softness: 12 });
  expect(fromHash(toHash(state), 2)).toEqual(state);
  expect(fromHash(toHash(FIRST), 2)).toEqual(FIRST);
});

test("anything in an address gives a view", () => {
  for (const hash of ["", "#", "x=NaN&y=1e400&zoom=-5", "object=cube&mode=%00", "lights=;;1,2,3", "lights=9,9,ffffff,1e9", "texture=99&other=-3", "&&==&"]) {
    const state = fromHash(hash, 2);
    expect(state.lights.length).toBeGreaterThan(0);
    expect(state.texture).toBeLessThan(2);
    expect(state.zoom).toBeGreaterThan(0);
    for (const { u, v } of state.lights) expect(Math.hypot(u, v)).toBeLessThan(1);
  }
});

test("an address that was encoded on its way is the same view", () => {
  const state = copyOf(FIRST), other = { u: 0.2, v: 0.1, color: "#00ff00", strength: MOST_STRENGTH, softness: 3 };
  Object.assign(state, { mode: "specular", zoom: 4, lights: [...state.lights, other] });
  const hash = toHash(state);
  for (const encoded of [hash.replaceAll(",", "%2C"), hash.replaceAll(";", "%3b").replaceAll("&", "%26"), encodeURIComponent(hash)]) expect(fromHash(encoded, 2)).toEqual(state);
  expect(fromHash("mode=specular&zoom=%zz", 1).mode).toBe("specular");
});

test("lights stay over the disk", () => {
  expect(onDisk(0.3, -0.4)).toEqual([0.3, -0.4]);
  const [u, v] = onDisk(30, -40);
  expect(Math.hypot(u, v)).toBeLessThan(1);
  expect(v / u).toBeCloseTo(-4 / 3);
});

test("undo goes back and forth", () => {
  const history = new History(), state = copyOf(FIRST);
  for (const zoom of [2, 3]) {
    history.keep(state);
    state.zoom = zoom;
  }
  const second = history.back(state);
  expect(second?.zoom).toBe(2);
  const first = history.back(second ?? state);
  expect(first?.zoom).toBe(1);
  expect(history.back(first ?? state)).toBeNull();
  expect(history.forth(first ?? state)?.zoom).toBe(2);
});

test("places far away on an endless plane come back to a hundredth of a texel", () => {
  const state = { ...FIRST, x: 123456789.125, y: -987654321.75, simple: true, cells: true };
  const again = fromHash(toHash(state), 1);
  expect([again.x, again.y, again.simple, again.cells]).toEqual([state.x, state.y, true, true]);
});

test("undo goes back over views and other changes in their order", () => {
  const history = new History(), said: string[] = [];
  const change = (name: string) => ({ undo: () => said.push(`-${name}`), redo: () => said.push(`+${name}`) });
  let state = copyOf(FIRST);
  history.record(change("a"));
  history.keep(state);
  state = { ...copyOf(state), zoom: 2 };
  history.record(change("b"));
  const back = (): void => void (state = history.back(state) ?? state), forth = (): void => void (state = history.forth(state) ?? state);
  back();
  expect([said.join(""), state.zoom]).toEqual(["-b", 2]);
  back();
  expect([said.join(""), state.zoom]).toEqual(["-b", 1]);
  back();
  back();
  expect(said.join("")).toBe("-b-a");
  forth();
  forth();
  forth();
  forth();
  expect([said.join(""), state.zoom]).toEqual(["-b-a+a+b", 2]);
});
