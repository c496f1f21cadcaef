import { readMesh } from "relume-three";
import { el } from "./dom.js";
import type { Viewer } from "./viewer.js";

/** The largest file that is read, in bytes. */
const MOST_BYTES = 256 << 20;
const KINDS = ".glb,.obj";

/** Puts a file of the user's own on the stage, as `--mesh` does; says what is wrong with it. */
export async function openObject(file: File, viewer: Viewer, say: (sentence: string) => void): Promise<void> {
  try {
    if (!/\.(glb|obj)$/i.test(file.name)) throw new Error("expected an object, .glb or .obj");
    if (file.size > MOST_BYTES) throw new Error(`it has ${file.size >> 20} MB, and at most ${MOST_BYTES >> 20} are read`);
    viewer.setObject(file.name, readMesh(new Uint8Array(await file.arrayBuffer())));
    viewer.change({ object: "mesh" });
    say(`${file.name} is shown until the page is left`);
  } catch (error) {
    say(`${file.name}: ${(error as Error).message}`);
  }
}

/** Takes files that are dropped anywhere on the page. */
export function listenForFiles(viewer: Viewer, say: (sentence: string) => void): void {
  addEventListener("dragover", (event) => {
    if (event.dataTransfer?.types.includes("Files")) event.preventDefault();
  });
  addEventListener("drop", (event) => {
    const file = event.dataTransfer?.files[0];
    if (!file) return;
    event.preventDefault();
    void openObject(file, viewer, say);
  });
}

/** A button that asks for such a file. */
export function objectButton(viewer: Viewer, say: (sentence: string) => void): HTMLElement {
  const input = el("input", { type: "file", accept: KINDS, hidden: "" });
  const button = el("button", { type: "button", title: "A .glb or .obj file of your own; or drop it on the page" }, "Open an object");
  button.addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    const file = input.files?.[0];
    input.value = "";
    if (file) void openObject(file, viewer, say);
  });
  return el("div", { class: "row under" }, button, input);
}
