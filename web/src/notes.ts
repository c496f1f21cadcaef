import { type Annotation, MOST_BYTES, type NoteChange, annotationFile, inverseOf, parseAnnotations } from "./annotations.js";
import { download, el, fileName, iconButton, svg } from "./dom.js";
import type { PageTexture } from "./page.js";
import { flatPlaces, texelAt } from "./places.js";
import type { DrawingTool } from "./pointer.js";
import { NoteSheet } from "./sheet.js";
import { toHash } from "./state.js";
import type { Viewer } from "./viewer.js";

/** Screen pixels of a drag from which on it is a box. */
const LEAST_BOX = 6;
const NONE: Annotation[] = [];

/** Annotations of all textures: in the picture, in a list, and in the file beside the texture where the server writes it. */
export class Notes implements DrawingTool {
  /** Over the picture. */
  readonly element = svg("svg", { class: "overlay", "aria-hidden": "true" });
  readonly section = el("section", {}, el("h2", {}, "Annotations"));
  /** One for each texture; textures with one file share it. */
  private readonly sheets: NoteSheet[] = [];
  private readonly list = el("ol", { class: "notes" });
  private readonly dialog: HTMLDialogElement;
  private readonly text = el("textarea", { rows: 4, maxlength: 4000, "aria-label": "Text of the annotation" });
  private readonly add = el("button", { type: "button", title: "Draw a box, or point, in the picture", "aria-pressed": "false" }, "Add");
  private from: [number, number] = [0, 0];
  private drawn: Annotation["box"] | null = null;
  /** What the dialog is about. */
  private written: { sheet: NoteSheet; box: Annotation["box"]; edited: Annotation | null } | null = null;
  private listed: Annotation[] | null = null;

  constructor(private readonly viewer: Viewer, private readonly textures: PageTexture[], private readonly say: (sentence: string) => void) {
    const byPlace = new Map<string, NoteSheet>();
    for (const { notes } of textures) {
      const sheet = (notes && byPlace.get(notes)) || new NoteSheet(notes ?? null, () => viewer.redraw(false), say);
      if (notes) byPlace.set(notes, sheet);
      this.sheets.push(sheet);
    }
    this.dialog = this.textDialog();
    document.body.append(this.dialog);
    this.add.addEventListener("click", () => this.toggle());
    const file = el("input", { type: "file", accept: ".json,application/json", class: "hidden", tabindex: -1, "aria-label": "File of annotations" });
    file.addEventListener("change", () => void this.open(file));
    const load = el("button", { type: "button" }, "Load"), save = el("button", { type: "button" }, "Download");
    load.addEventListener("click", () => file.click());
    save.addEventListener("click", () => this.download());
    this.section.append(this.list, el("div", { class: "row" }, this.add, load, save, file));
    viewer.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons === 0) viewer.canvas.title = this.under(event)?.text ?? "";
    });
    // What others wrote is seen by whoever comes back to the page.
    addEventListener("focus", () => void Promise.allSettled(this.files.map((sheet) => sheet.load())));
    addEventListener("beforeunload", (event) => this.files.some((sheet) => sheet.isUnsaved) && event.preventDefault());
  }

  /** Reads what was written before. */
  async load(): Promise<void> {
    for (const [i, { notes, annotations }] of this.textures.entries()) if (!notes && annotations) this.sheets[i]?.begin(parseAnnotations(annotations));
    await Promise.all(this.files.map((sheet) => sheet.load()));
    this.refresh();
  }

  /** What could not be saved, in sentences. */
  get failures(): string[] {
    return this.files.flatMap(({ failure }) => failure ?? []);
  }

  /** Saves again what could not be saved. */
  retry(): void {
    for (const sheet of this.files) if (sheet.failure !== null) void sheet.save();
  }

  /** The next drag, or click, in the picture is a place to write about. */
  toggle(): void {
    if (!this.viewer.toggleTool(this)) return;
    this.say("Draw a box, or click on a point, in the picture");
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
    this.add.setAttribute("aria-pressed", String(this.viewer.tool === this));
    const places = flatPlaces(this.viewer);
    this.element.replaceChildren(...(places ? notes : []).flatMap(({ box }, i) => this.mark(box, String(i + 1))));
    if (this.drawn) this.element.append(...this.mark(this.drawn, ""));
  }

  begin(event: PointerEvent): void {
    const places = flatPlaces(this.viewer);
    if (!places) return;
    this.from = texelAt(event, this.viewer.canvas, places);
    this.move(event);
  }

  move(event: PointerEvent): void {
    const places = flatPlaces(this.viewer);
    if (!places) return;
    const [x, y] = this.from, [toX, toY] = texelAt(event, this.viewer.canvas, places);
    this.drawn = [Math.min(x, toX), Math.min(y, toY), Math.abs(toX - x), Math.abs(toY - y)];
    this.refresh();
  }

  end(): void {
    const { drawn, from } = this, scale = flatPlaces(this.viewer)?.scale ?? 1;
    this.drawn = null;
    this.viewer.toggleTool(this);
    if (drawn) this.write(Math.max(drawn[2], drawn[3]) * scale < LEAST_BOX ? [...from, 0, 0] : drawn);
  }

  cancel(): void {
    this.drawn = null;
    this.refresh();
  }

  private get files(): NoteSheet[] {
    return [...new Set(this.sheets)];
  }

  private get sheet(): NoteSheet | undefined {
    return this.sheets[this.viewer.state.texture];
  }

  private here(): Annotation[] {
    return this.sheet?.notes ?? NONE;
  }

  /** The annotation at a place of the picture. */
  private under(event: PointerEvent): Annotation | undefined {
    const places = flatPlaces(this.viewer);
    if (!places) return undefined;
    const [x, y] = texelAt(event, this.viewer.canvas, places), reach = LEAST_BOX / places.scale;
    return this.here().findLast(({ box: [left, top, width, height] }) => x > left - reach && x < left + width + reach && y > top - reach && y < top + height + reach);
  }

  private entry(note: Annotation, i: number): HTMLElement {
    const go = el("button", { type: "button", class: "link" }, note.text);
    go.addEventListener("click", () => this.viewer.show(note.view, this.viewer.state.texture));
    const edit = iconButton(`Edit annotation ${i + 1}`, "M5 19l1-4L16 5l3 3L9 18z", () => this.write(note.box, note));
    const remove = iconButton(`Remove annotation ${i + 1}`, "M6 6l12 12M18 6L6 18", () => {
      this.change(this.sheet, { taken: [note], put: [], at: i });
      // The button is gone, and with it the place of the keyboard.
      (this.list.children[Math.min(i, this.list.children.length - 1)]?.querySelector("button") ?? this.add).focus();
    });
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

  /** Asks for the text of a place, or for another one. */
  private write(box: Annotation["box"], edited: Annotation | null = null): void {
    const { sheet } = this;
    if (!sheet) return;
    this.written = { sheet, box, edited };
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
    form.addEventListener("submit", () => this.keepText());
    return dialog;
  }

  private keepText(): void {
    const text = this.text.value.trim(), { written } = this;
    if (text === "" || !written) return;
    const { sheet, edited } = written, at = edited ? sheet.notes.indexOf(edited) : -1;
    const box = written.box.map((n) => Number(n.toFixed(2))) as Annotation["box"];
    const made = { text, box, view: edited?.view ?? toHash(this.viewer.state) };
    this.change(sheet, { taken: edited ? [edited] : [], put: [made], at: at < 0 ? sheet.notes.length : at });
  }

  /** Changes annotations, so that it can be undone. */
  private change(sheet: NoteSheet | undefined, change: NoteChange): void {
    const make = (change: NoteChange): boolean => {
      try {
        sheet?.change(change);
        return true;
      } catch (error) {
        this.say(`Not kept: ${(error as Error).message}`);
        return false;
      }
    };
    if (make(change)) this.viewer.record({ undo: () => make(inverseOf(change)), redo: () => make(change) });
  }

  private download(): void {
    const title = this.textures[this.viewer.state.texture]?.title ?? "texture";
    download(`${fileName(title)}.annotations.json`, new Blob([annotationFile(this.here())], { type: "application/json" }));
    this.sheet?.wasDownloaded();
  }

  private async open(input: HTMLInputElement): Promise<void> {
    const [file] = input.files ?? [], { sheet } = this;
    input.value = "";
    if (!file) return;
    try {
      if (file.size > MOST_BYTES) throw new Error("the file is larger than annotations are");
      const put = parseAnnotations(JSON.parse(await file.text()));
      this.change(sheet, { taken: [], put, at: this.here().length });
    } catch (error) {
      this.say(`${file.name}: ${error instanceof SyntaxError ? "the file holds no annotations" : (error as Error).message}`);
    }
  }
}
