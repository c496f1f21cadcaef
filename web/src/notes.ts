import { type Annotation, type Box, MOST_BYTES, type NoteChange, type PlacedNote, annotationFile, inverseOf, isPlaced, parseAnnotations } from "./annotations.js";
import { download, el, fileName, iconButton, svg } from "./dom.js";
import type { PageTexture } from "./page.js";
import { type FlatPlaces, cutOff, flatPlaces, pictureAt, placesUnder, texelAt } from "./places.js";
import type { DrawingTool } from "./pointer.js";
import { NoteSheet } from "./sheet.js";
import { toHash } from "./state.js";
import type { Viewer } from "./viewer.js";

/** Screen pixels of a drag from which on it is a box. */
const LEAST_BOX = 6;

/** A box that is being drawn, and where it begins. */
interface Drawing {
  texture: number;
  from: [number, number];
  box: Box;
}

/** What the dialog is about. */
interface Writing {
  texture: number;
  box: Box;
  view: string;
  edited: Annotation | null;
}

/** Annotations of all textures: in the picture, in a list, and in the file beside the texture where the server writes it. */
export class Notes implements DrawingTool {
  /** Over the picture. */
  readonly element = svg("svg", { class: "overlay", "aria-hidden": "true" });
  readonly section = el("section", {}, el("h2", {}, "Annotations"));
  /** One for each texture; textures with one file share it. */
  private readonly sheets: NoteSheet[] = [];
  private readonly lists = el("div");
  private readonly row: HTMLElement;
  private readonly dialog: HTMLDialogElement;
  private readonly file = el("input", { type: "file", accept: ".json,application/json", class: "hidden", tabindex: -1, "aria-label": "File of annotations" });
  private readonly text = el("textarea", { rows: 4, maxlength: 4000, required: true, "aria-label": "Text of the annotation" });
  private readonly add = el("button", { type: "button", title: "Draw a box, or point, in the picture", "aria-pressed": "false" }, "Add");
  private drawn: Drawing | null = null;
  private written: Writing | null = null;
  private listed = "";
  /** The texture into which the file that is chosen is loaded. */
  private loaded: number | null = null;
  private readonly exchanges = new Map<string, HTMLElement[]>();

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
    this.file.addEventListener("change", () => void this.open());
    this.row = el("div", { class: "row" }, this.add);
    this.section.append(this.lists, this.row, this.file);
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

  /** Whether something could not be saved that may be saved later. */
  get isWaiting(): boolean {
    return this.files.some(({ failure, isCutOff }) => failure !== null && !isCutOff);
  }

  /** Saves again what could not be saved. */
  retry(): void {
    for (const sheet of this.files) if (sheet.failure !== null && !sheet.isCutOff) void sheet.save();
  }

  /** The next drag, or click, in the picture is a place to write about. */
  toggle(): void {
    if (!this.viewer.toggleTool(this)) return;
    this.say("Draw a box, or click on a point, in the picture");
  }

  /** Writes about the middle of the view: without a pointer. */
  writeAtMiddle(): void {
    if (this.viewer.state.object !== "flat") this.viewer.change({ object: "flat" });
    const { canvas } = this.viewer, places = flatPlaces(this.viewer), x = this.viewer.viewWidth(canvas.clientWidth) / 2;
    const picture = places[pictureAt(places, x)];
    if (picture) this.write(picture.state.texture, [...picture.texel(x, canvas.clientHeight / 2), 0, 0]);
  }

  refresh(): void {
    this.list();
    this.add.setAttribute("aria-pressed", String(this.viewer.tool === this));
    this.element.replaceChildren(...flatPlaces(this.viewer).map((picture) => this.marksIn(picture)));
  }

  begin(event: PointerEvent): void {
    const places = placesUnder(event, this.viewer);
    if (!places) return;
    const from = texelAt(event, this.viewer.canvas, places);
    this.drawn = { texture: places.state.texture, from, box: [...from, 0, 0] };
    this.refresh();
  }

  move(event: PointerEvent): void {
    const { drawn } = this, places = drawn && this.placesOf(drawn.texture);
    if (!drawn || !places) return;
    const [x, y] = drawn.from, [toX, toY] = texelAt(event, this.viewer.canvas, places);
    drawn.box = [Math.min(x, toX), Math.min(y, toY), Math.abs(toX - x), Math.abs(toY - y)];
    this.refresh();
  }

  end(): void {
    const { drawn } = this, scale = (drawn && this.placesOf(drawn.texture))?.scale ?? 1;
    this.drawn = null;
    this.viewer.toggleTool(this);
    if (drawn) this.write(drawn.texture, Math.max(drawn.box[2], drawn.box[3]) * scale < LEAST_BOX ? [...drawn.from, 0, 0] : drawn.box);
  }

  cancel(): void {
    this.drawn = null;
    this.refresh();
  }

  /** The annotations of a texture, and its bookmarks. */
  sheetOf(texture: number): NoteSheet | undefined {
    return this.sheets[texture];
  }

  /** The bookmarks among them, each with the texture that it shows. */
  get bookmarks(): { note: Annotation; texture: number }[] {
    return this.files.flatMap((sheet) => {
      const texture = this.sheets.indexOf(sheet);
      return sheet.notes.filter((note) => !isPlaced(note)).map((note) => ({ note, texture }));
    });
  }

  /** Changes annotations of a texture, so that it can be undone. */
  change(texture: number, change: NoteChange): void {
    const make = (change: NoteChange): boolean => {
      try {
        this.sheets[texture]?.change(change);
        return true;
      } catch (error) {
        this.say(`Not kept: ${(error as Error).message}`);
        return false;
      }
    };
    if (make(change)) this.viewer.record({ undo: () => make(inverseOf(change)), redo: () => make(change) });
  }

  /** Takes an annotation away. */
  remove(texture: number, note: Annotation): void {
    this.change(texture, { taken: [note], put: [], at: this.sheets[texture]?.notes.indexOf(note) ?? 0 });
  }

  private get files(): NoteSheet[] {
    return [...new Set(this.sheets)];
  }

  /** The annotations of places of a texture. */
  private placed(texture: number): PlacedNote[] {
    return this.sheets[texture]?.notes.filter(isPlaced) ?? [];
  }

  private placesOf(texture: number): FlatPlaces | undefined {
    return flatPlaces(this.viewer).find(({ state }) => state.texture === texture);
  }

  /** The textures that are shown, without those whose annotations another one has. */
  private shown(): number[] {
    const { texture, other, compare } = this.viewer.state, isBeside = ["side", "wipe"].includes(compare);
    return isBeside && this.sheets[other] !== this.sheets[texture] ? [texture, other] : [texture];
  }

  /** The annotation at a place of the picture. */
  private under(event: PointerEvent): Annotation | undefined {
    const places = placesUnder(event, this.viewer);
    if (!places) return undefined;
    const [x, y] = texelAt(event, this.viewer.canvas, places), reach = LEAST_BOX / places.scale;
    const isThere = ({ box: [left, top, width, height] }: PlacedNote): boolean => x > left - reach && x < left + width + reach && y > top - reach && y < top + height + reach;
    return this.placed(places.state.texture).findLast(isThere);
  }

  /** A list for each texture that is shown, made again when it has changed. */
  private list(): void {
    const shown = this.shown(), listed = JSON.stringify(shown.map((texture) => [texture, this.placed(texture)]));
    if (listed === this.listed) return;
    this.listed = listed;
    const focused = document.activeElement, isAlone = shown.length === 1;
    this.lists.replaceChildren(...shown.flatMap((texture) => {
      const title = this.viewer.titles[texture] ?? "", of = isAlone ? "" : ` of ${title}`;
      const list = el("ol", { class: "notes" }, ...this.placed(texture).map((note, i) => this.entry(texture, note, i, of)));
      return isAlone ? [list] : [el("p", { class: "dim" }, title), list, el("div", { class: "row" }, ...this.exchange(texture, of))];
    }));
    this.row.replaceChildren(this.add, ...(isAlone ? this.exchange(shown[0] ?? 0, "") : []));
    // What was taken out and put in again has lost it.
    if (focused instanceof HTMLElement && this.section.contains(focused)) focused.focus();
  }

  /** The buttons that load and save annotations of a texture: where two are shown, each has its own. */
  private exchange(texture: number, of: string): HTMLElement[] {
    const key = `${texture}${of}`, known = this.exchanges.get(key);
    if (known) return known;
    const button = (name: string, press: () => void): HTMLElement => {
      const made = el("button", { type: "button", "aria-label": of === "" ? undefined : `${name} annotations${of}` }, name);
      made.addEventListener("click", press);
      return made;
    };
    const load = button("Load", () => {
      this.loaded = texture;
      this.file.click();
    });
    const made = [load, button("Download", () => this.download(texture))];
    this.exchanges.set(key, made);
    return made;
  }

  private entry(texture: number, note: PlacedNote, i: number, of: string): HTMLElement {
    const go = el("button", { type: "button", class: "link" }, note.text);
    go.addEventListener("click", () => this.viewer.show(note.view, texture));
    const edit = iconButton(`Edit annotation ${i + 1}${of}`, "M5 19l1-4L16 5l3 3L9 18z", () => this.write(texture, note.box, note));
    const remove = iconButton(`Remove annotation ${i + 1}${of}`, "M6 6l12 12M18 6L6 18", () => {
      const list = this.shown().indexOf(texture);
      this.remove(texture, note);
      // The button is gone, and with it the place of the keyboard.
      const left = this.lists.querySelectorAll("ol")[list]?.children;
      (left?.[Math.min(i, left.length - 1)]?.querySelector("button") ?? this.add).focus();
    });
    return el("li", {}, el("span", { class: "number", "aria-hidden": "true" }, String(i + 1)), go, edit, remove);
  }

  /** The marks of a picture, cut off where it ends. */
  private marksIn(picture: FlatPlaces): SVGElement {
    const { texture } = picture.state, marks = this.placed(texture).flatMap(({ box }, i) => markOf(box, String(i + 1), picture));
    if (this.drawn?.texture === texture) marks.push(...markOf(this.drawn.box, "", picture));
    return cutOff(picture, this.viewer.canvas.clientHeight, marks);
  }

  /** Asks for the text of a place of a texture, or for another one. */
  private write(texture: number, box: Box, edited: Annotation | null = null): void {
    this.written = { texture, box, view: edited?.view ?? this.viewOf(texture), edited };
    this.text.value = edited?.text ?? "";
    this.check();
    this.dialog.showModal();
    this.text.focus();
  }

  /** The view in which a texture is seen now: one that is shown as the second is the first of its own. */
  private viewOf(texture: number): string {
    const { state } = this.viewer, own = this.placesOf(texture)?.state;
    return toHash(own && texture !== state.texture ? { ...own, compare: "single" } : state);
  }

  private textDialog(): HTMLDialogElement {
    const cancel = el("button", { type: "button" }, "Cancel");
    const form = el("form", { method: "dialog", class: "tall" }, this.text, el("div", { class: "row" }, el("button", { type: "submit" }, "Keep"), cancel));
    const dialog = el("dialog", { "aria-label": "Annotation" }, el("h2", {}, "Annotation"), form);
    cancel.addEventListener("click", () => dialog.close());
    dialog.addEventListener("close", () => this.refresh());
    this.text.addEventListener("input", () => this.check());
    form.addEventListener("submit", () => this.keepText());
    return dialog;
  }

  /** Lets the browser say why a text without letters is not kept. */
  private check(): void {
    this.text.setCustomValidity(this.text.value.trim() === "" ? "Write a text, or press Cancel" : "");
  }

  private keepText(): void {
    const { written } = this, sheet = this.sheets[written?.texture ?? -1];
    if (!written || !sheet) return;
    const { edited, view } = written, at = edited ? sheet.notes.indexOf(edited) : -1;
    const box = written.box.map((n) => Number(n.toFixed(2))) as Box;
    this.change(written.texture, { taken: edited ? [edited] : [], put: [{ text: this.text.value.trim(), box, view }], at: at < 0 ? sheet.notes.length : at });
  }

  private download(texture: number): void {
    const sheet = this.sheets[texture];
    download(`${fileName(this.textures[texture]?.title ?? "")}.annotations.json`, new Blob([annotationFile(sheet?.notes ?? [])], { type: "application/json" }));
    sheet?.wasDownloaded();
  }

  private async open(): Promise<void> {
    const [file] = this.file.files ?? [], texture = this.loaded ?? this.viewer.state.texture;
    this.file.value = "";
    this.loaded = null;
    if (!file) return;
    try {
      if (file.size > MOST_BYTES) throw new Error("the file is larger than annotations are");
      const put = parseAnnotations(JSON.parse(await file.text()));
      this.change(texture, { taken: [], put, at: this.sheets[texture]?.notes.length ?? 0 });
    } catch (error) {
      this.say(`${file.name}: ${error instanceof SyntaxError ? "the file holds no annotations" : (error as Error).message}`);
    }
  }
}

/** The mark of a point or a box in a picture. */
function markOf([x, y, width, height]: Box, number: string, { pixel }: FlatPlaces): SVGElement[] {
  const [left, top] = pixel(x, y), [right, bottom] = pixel(x + width, y + height);
  const text = svg("text", { x: right, y: top - 7 });
  text.textContent = number;
  const point = width === 0 && height === 0;
  const shape = point ? svg("circle", { cx: left, cy: top, r: 6 }) : svg("rect", { x: left, y: top, width: right - left, height: bottom - top });
  return [shape, text];
}
