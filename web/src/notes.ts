import { download, el, iconButton, svg } from "./dom.js";
import { type PageTexture, besidePage } from "./page.js";
import { flatPlaces, texelAt } from "./places.js";
import { toHash } from "./state.js";
import type { Viewer } from "./viewer.js";

/** A point or a box of the texture with a text, and the view in which it was written. */
export interface Annotation {
  text: string;
  /** Left upper corner, width and height, in texels. */
  box: [number, number, number, number];
  view: string;
}

/** Screen pixels of a drag from which on it is a box. */
const LEAST_BOX = 6;
const MOST_BYTES = 1 << 20;
const NONE: Annotation[] = [];

/** The annotations of a file; what is none is an error. */
export function parseAnnotations(value: unknown): Annotation[] {
  const file = value as { relume?: unknown; version?: unknown; annotations?: unknown } | null;
  if (file?.relume !== "annotations" || file.version !== 1 || !Array.isArray(file.annotations)) throw new Error("the file holds no annotations");
  return file.annotations.map((one: Partial<Annotation> | null) => {
    const { text, box, view } = one ?? {};
    if (typeof text !== "string" || typeof view !== "string" || !Array.isArray(box) || box.length !== 4 || !box.every((n) => Number.isFinite(n))) {
      throw new Error("an annotation of the file is damaged");
    }
    return { text, box, view };
  });
}

export function annotationFile(annotations: Annotation[]): string {
  return JSON.stringify({ relume: "annotations", version: 1, annotations }, null, 2);
}

/** Annotations of all textures: in the picture, in a list, and in the file beside the texture where the server writes it. */
export class Notes {
  /** Over the picture. */
  readonly element = svg("svg", { class: "overlay", "aria-hidden": "true" });
  readonly section = el("section", {}, el("h2", {}, "Annotations"));
  private readonly kept: Annotation[][];
  private readonly list = el("ol", { class: "notes" });
  private readonly dialog: HTMLDialogElement;
  private readonly text = el("textarea", { rows: 4, maxlength: 4000, "aria-label": "Text of the annotation" });
  private drawn: [number, number, number, number] = [0, 0, 0, 0];
  private edited: Annotation | null = null;
  private active = false;
  private listed: Annotation[] | null = null;

  constructor(private readonly viewer: Viewer, private readonly textures: PageTexture[], private readonly say: (sentence: string) => void) {
    this.kept = textures.map(() => []);
    this.dialog = this.textDialog();
    document.body.append(this.dialog);
    this.element.addEventListener("pointerdown", (event) => event instanceof PointerEvent && this.start(event));
    const add = el("button", { type: "button", title: "Draw a box, or point, in the picture" }, "Add");
    add.addEventListener("click", () => this.toggle());
    const file = el("input", { type: "file", accept: ".json,application/json", class: "hidden", tabindex: -1, "aria-label": "File of annotations" });
    file.addEventListener("change", () => void this.open(file));
    const load = el("button", { type: "button" }, "Load"), save = el("button", { type: "button" }, "Download");
    load.addEventListener("click", () => file.click());
    save.addEventListener("click", () => this.download());
    this.section.append(this.list, el("div", { class: "row" }, add, load, save, file));
  }

  /** Reads what was written before. */
  async load(): Promise<void> {
    await Promise.all(this.textures.map(async (texture, i) => {
      if (texture.notes) {
        const response = await fetch(besidePage(texture.notes));
        if (response.ok) this.kept[i] = parseAnnotations(await response.json());
      } else if (texture.annotations) this.kept[i] = parseAnnotations(texture.annotations);
    }));
    this.refresh();
  }

  /** The next drag, or click, in the picture is a place to write about. */
  toggle(): void {
    this.active = !this.active;
    if (this.active && this.viewer.state.object !== "flat") this.viewer.change({ object: "flat" });
    this.element.classList.toggle("active", this.active);
    if (this.active) this.say("Draw a box, or click on a point, in the picture");
  }

  /** Writes about the middle of the view: without a pointer. */
  writeAtMiddle(): void {
    if (this.viewer.state.object !== "flat") this.viewer.change({ object: "flat" });
    const { canvas } = this.viewer;
    const middle = flatPlaces(this.viewer)?.texel(this.viewer.viewWidth(canvas.clientWidth) / 2, canvas.clientHeight / 2);
    if (middle) this.write([...middle, 0, 0]);
  }

  refresh(): void {
    const notes = this.here();
    if (notes !== this.listed) this.list.replaceChildren(...notes.map((note, i) => this.entry(note, i)));
    this.listed = notes;
    const places = flatPlaces(this.viewer);
    this.element.replaceChildren(...(places ? notes : []).flatMap(({ box }, i) => this.mark(box, String(i + 1))));
  }

  private here(): Annotation[] {
    return this.kept[this.viewer.state.texture] ?? NONE;
  }

  private entry(note: Annotation, i: number): HTMLElement {
    const go = el("button", { type: "button", class: "link" }, note.text);
    go.addEventListener("click", () => this.viewer.show(note.view, this.viewer.state.texture));
    const edit = iconButton(`Edit annotation ${i + 1}`, "M5 19l1-4L16 5l3 3L9 18z", () => this.write(note.box, note));
    const remove = iconButton(`Remove annotation ${i + 1}`, "M6 6l12 12M18 6L6 18", () => this.keep(this.here().filter((one) => one !== note)));
    return el("li", {}, el("span", { class: "number", "aria-hidden": "true" }, String(i + 1)), go, edit, remove);
  }

  private mark([x, y, width, height]: Annotation["box"], number: string): SVGElement[] {
    const places = flatPlaces(this.viewer);
    if (!places) return [];
    const [left, top] = places.pixel(x, y), [right, bottom] = places.pixel(x + width, y + height);
    const text = svg("text", { x: right, y: top - 7 });
    text.textContent = number;
    const point = width === 0 && height === 0;
    const shape = point ? svg("circle", { cx: left, cy: top, r: 6 }) : svg("rect", { x: left, y: top, width: right - left, height: bottom - top });
    return [shape, text];
  }

  private start(event: PointerEvent): void {
    const places = flatPlaces(this.viewer);
    if (!this.active || !places) return;
    const [x, y] = texelAt(event, this.element, places);
    this.element.setPointerCapture(event.pointerId);
    const move = (event: Event): void => {
      if (!(event instanceof PointerEvent)) return;
      const [toX, toY] = texelAt(event, this.element, places);
      this.drawn = [Math.min(x, toX), Math.min(y, toY), Math.abs(toX - x), Math.abs(toY - y)];
      this.refresh();
      this.element.append(...this.mark(this.drawn, ""));
    };
    move(event);
    this.element.addEventListener("pointermove", move);
    this.element.addEventListener("pointerup", () => {
      this.element.removeEventListener("pointermove", move);
      if (this.active) this.toggle();
      const small = Math.max(this.drawn[2], this.drawn[3]) * places.scale < LEAST_BOX;
      this.write(small ? [x, y, 0, 0] : this.drawn);
    }, { once: true });
  }

  /** Asks for the text of a place, or for another one. */
  private write(box: Annotation["box"], edited: Annotation | null = null): void {
    this.drawn = box;
    this.edited = edited;
    this.text.value = edited?.text ?? "";
    this.dialog.showModal();
    this.text.focus();
  }

  private textDialog(): HTMLDialogElement {
    const cancel = el("button", { type: "button" }, "Cancel");
    const form = el("form", { method: "dialog", class: "tall" }, this.text, el("div", { class: "row" }, el("button", { type: "submit" }, "Keep"), cancel));
    const dialog = el("dialog", { "aria-label": "Annotation" }, el("h2", {}, "Annotation"), form);
    cancel.addEventListener("click", () => dialog.close());
    dialog.addEventListener("close", () => this.refresh());
    form.addEventListener("submit", () => {
      const text = this.text.value.trim(), { edited } = this;
      if (text === "") return;
      const box = this.drawn.map((n) => Number(n.toFixed(2))) as Annotation["box"];
      const made = { text, box, view: edited?.view ?? toHash(this.viewer.state) };
      this.keep(edited ? this.here().map((one) => (one === edited ? made : one)) : [...this.here(), made]);
    });
    return dialog;
  }

  /** Replaces those of the texture shown, here and in the file. */
  private keep(notes: Annotation[]): void {
    this.kept[this.viewer.state.texture] = notes;
    this.refresh();
    void this.save(notes);
  }

  private async save(notes: Annotation[]): Promise<void> {
    const place = this.textures[this.viewer.state.texture]?.notes;
    if (!place) return this.say("Kept until the page is closed: download them to keep them");
    try {
      const response = await fetch(besidePage(place), { method: "POST", headers: { "Content-Type": "application/json" }, body: annotationFile(notes) });
      if (response.ok) return this.say("Annotations saved beside the texture");
      const said = response.headers.get("Content-Type") === "application/json" ? ((await response.json()) as { error?: string }) : {};
      this.say(`Not saved: ${said.error ?? `the server answers ${response.status}`}`);
    } catch {
      this.say("Not saved: relume view has ended");
    }
  }

  private download(): void {
    const title = this.textures[this.viewer.state.texture]?.title ?? "texture";
    download(`${title}.annotations.json`, new Blob([annotationFile(this.here())], { type: "application/json" }));
  }

  private async open(input: HTMLInputElement): Promise<void> {
    const [file] = input.files ?? [];
    input.value = "";
    if (!file) return;
    try {
      if (file.size > MOST_BYTES) throw new Error("the file is larger than annotations are");
      this.keep([...this.here(), ...parseAnnotations(JSON.parse(await file.text()))]);
    } catch (error) {
      this.say(error instanceof SyntaxError ? "The file holds no annotations" : String((error as Error).message));
    }
  }
}
