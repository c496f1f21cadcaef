import { expect, test } from "vitest";
import { bookmarkKey } from "../../src/bookmarks.js";
import { sentencesOf } from "../../src/notice.js";
import { listed } from "../../src/words.js";

test("a fault of several textures is said once, and a sentence that names its file names it once", () => {
  const disk = "browsers do not load files beside a page from disk";
  const all = ["a", "b", "c", "d", "e"].map((title) => ({ title, sentence: disk }));
  expect(sentencesOf(all)).toEqual([`a, b, c and 2 more: ${disk}`]);
  expect(sentencesOf([{ title: null, sentence: "x.ptm: cannot be read" }, { title: "y", sentence: "is damaged" }])).toEqual(["x.ptm: cannot be read", "y: is damaged"]);
});

test("lists are said as people say them", () => {
  expect(["", "a", "ab", "abc", "abcd"].map((letters) => listed([...letters]))).toEqual(["", "a", "a and b", "a, b and c", "a, b, c and d"]);
});

test("bookmarks of pages with one title are kept apart", () => {
  const keys = [["/a/", "T", "x"], ["/b/", "T", "x"], ["/a/", "T", "y"], ["/a/", "U", "x"]].map(([pathname = "", title = "", name = ""]) => bookmarkKey({ pathname }, title, [name]));
  expect(new Set(keys).size).toBe(4);
});
