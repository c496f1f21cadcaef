import { readFileSync } from "node:fs";
import { expect, test } from "vitest";
import { type Annotation, areSame, changedNotes, inverseOf, mergedNotes, parseAnnotations } from "../../src/annotations.js";
import { NoteSheet } from "../../src/sheet.js";

interface Case {
  what: string;
  annotation: string;
  times?: number;
}

test("program and page take and refuse the same annotations", () => {
  // The program's tests read this file as well (viewer/annotations.rs).
  const cases = JSON.parse(readFileSync(new URL("annotations.json", import.meta.url), "utf8")) as { good: Case[]; bad: Case[] };
  const read = ({ annotation, times = 1 }: Case): Annotation[] =>
    parseAnnotations(JSON.parse(`{"relume":"annotations","version":1,"annotations":[${new Array<string>(times).fill(annotation).join(",")}]}`));
  for (const one of cases.good) expect(read(one).length, one.what).toBe(one.times ?? 1);
  for (const one of cases.bad) expect(() => read(one), one.what).toThrow();
});

const notes = (letters: string): Annotation[] => [...letters].map((text) => ({ text, box: [1, 2, 0, 0], view: "" }));
const textOf = (list: Annotation[]): string => list.map(({ text }) => text).join("");

test("what either side changed is merged, and nothing that was written is lost", () => {
  for (const [before, mine, theirs, merged] of [
    ["", "a", "b", "ab"],
    ["ab", "ab", "ab", "ab"],
    ["ab", "a", "ab", "a"],
    ["ab", "ab", "b", "b"],
    ["ab", "Ab", "aB", "AB"],
    // Removed by one and edited by the other: the edited one stays.
    ["ab", "b", "Ab", "bA"],
    ["ab", "Ab", "b", "Ab"],
    ["a", "A", "Ä", "AÄ"],
    // The same addition by both is one, and two equal ones are two.
    ["a", "ab", "ab", "ab"],
    ["a", "abb", "a", "abb"],
    ["aa", "a", "aa", "a"],
  ] as const) {
    expect(textOf(mergedNotes(notes(before), notes(mine), notes(theirs))), `${before}: ${mine}, ${theirs}`).toBe(merged);
  }
});

test("a merge holds every annotation that one side added or both kept, for all small lists", () => {
  const lists = [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => [..."abc"].filter((_, i) => bits & (1 << i)).join(""));
  for (const before of lists) for (const mine of lists) for (const theirs of lists) {
    const merged = textOf(mergedNotes(notes(before), notes(mine), notes(theirs)));
    for (const one of "abc") {
      const [was, here, there] = [before, mine, theirs].map((list) => list.includes(one));
      expect([...merged].filter((other) => other === one).length, `${before}: ${mine}, ${theirs}`).toBe(Number(was ? here && there : here || there));
    }
  }
});

test("a change that is taken back leaves the list as it was", () => {
  const before = notes("abc");
  for (const change of [
    { taken: notes("b"), put: [], at: 1 },
    { taken: notes("b"), put: notes("B"), at: 1 },
    { taken: [], put: notes("xy"), at: 3 },
  ]) {
    const after = changedNotes(before, change);
    expect(areSame(after, before)).toBe(false);
    expect(textOf(changedNotes(after, inverseOf(change)))).toBe("abc");
  }
});

test("more than the program takes in all is refused, and leaves what was there", () => {
  const sheet = new NoteSheet(null, () => undefined, () => undefined), some = notes("ab");
  sheet.change({ taken: [], put: some, at: 0 });
  const long = Array.from({ length: 300 }, (): Annotation => ({ text: "x".repeat(4000), box: [1, 2, 0, 0], view: "" }));
  expect(() => sheet.change({ taken: [], put: long, at: 0 })).toThrow("at most 1048576 bytes in all");
  expect(sheet.notes).toEqual(some);
});
