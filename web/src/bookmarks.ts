import { el, iconButton } from "./dom.js";
import type { Notes } from "./notes.js";
import { toHash } from "./state.js";
import type { Viewer } from "./viewer.js";

/** A view under a name. */
interface Bookmark {
  name: string;
  hash: string;
}

/** A bookmark in the list. */
interface Entry {
  name: string;
  show(): void;
  remove(): void;
}

/** The views that were kept: with the annotations where the server writes these, otherwise in the browser. */
export class Bookmarks {
  readonly dialog: HTMLDialogElement;
  private readonly list = el("ul");
  private readonly place = el("p", { class: "dim" });

  /** `key` tells the page from others whose bookmarks the browser keeps. */
  constructor(private readonly viewer: Viewer, private readonly notes: Notes, private readonly key: string, private readonly say: (sentence: string) => void) {
    const name = el("input", { type: "text", "aria-label": "Name of the bookmark", placeholder: "Name", maxlength: 80 });
    const form = el("form", { method: "dialog" }, name, el("button", { type: "submit" }, "Keep this view"));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      this.add(name.value.trim() || `View ${this.entries().length + 1}`);
      name.value = "";
    });
    const close = el("button", { type: "button" }, "Close");
    this.dialog = el("dialog", { "aria-label": "Bookmarks" }, el("h2", {}, "Bookmarks"), this.list, form, this.place, close);
    close.addEventListener("click", () => this.dialog.close());
    viewer.onChange(() => this.dialog.open && this.refresh());
  }

  open(): void {
    this.refresh();
    this.dialog.showModal();
  }

  private add(name: string): void {
    const { state } = this.viewer, sheet = this.notes.sheetOf(state.texture), view = toHash(state);
    if (sheet?.isFiled) this.notes.change(state.texture, { taken: [], put: [{ text: name, view }], at: sheet.notes.length });
    else this.keep([...this.kept(), { name, hash: view }]);
  }

  private refresh(): void {
    const isFiled = this.notes.sheetOf(this.viewer.state.texture)?.isFiled === true;
    this.place.textContent = isFiled ? "Kept in the file of the annotations, beside the texture." : "Kept in this browser, for this page at this address.";
    this.list.replaceChildren(...this.entries().map(({ name, show, remove }) => {
      const go = el("button", { type: "button", class: "link" }, name);
      go.addEventListener("click", () => {
        this.dialog.close();
        show();
      });
      return el("li", {}, go, iconButton(`Remove ${name}`, "M6 6l12 12M18 6L6 18", remove));
    }));
  }

  private entries(): Entry[] {
    const kept = this.kept();
    return [
      ...this.notes.bookmarks.map(({ note, texture }) => ({
        name: note.text,
        show: () => this.viewer.show(note.view, texture),
        remove: () => this.notes.remove(texture, note),
      })),
      ...kept.map(({ name, hash }, i) => ({ name, show: () => this.viewer.show(hash), remove: () => this.keep(kept.filter((_, k) => k !== i)) })),
    ];
  }

  private kept(): Bookmark[] {
    try {
      const kept = JSON.parse(localStorage.getItem(this.key) ?? "[]") as unknown;
      return Array.isArray(kept) ? kept.filter((b): b is Bookmark => typeof b?.name === "string" && typeof b?.hash === "string") : [];
    } catch {
      return [];
    }
  }

  private keep(bookmarks: Bookmark[]): void {
    try {
      localStorage.setItem(this.key, JSON.stringify(bookmarks));
    } catch {
      this.say("The browser keeps nothing for this page");
    }
    this.refresh();
  }
}

/** The key of the bookmarks of a page: by its address, its title and its textures. */
export function bookmarkKey(address: { pathname: string }, title: string, textures: string[]): string {
  return `relume-bookmarks:${JSON.stringify([address.pathname, title, ...textures])}`;
}
