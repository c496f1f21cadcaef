import { download, el, fileName, iconButton } from "./dom.js";
import type { Bookmarks } from "./bookmarks.js";
import { Recorder } from "./record.js";
import { screenSnapshot, textureSnapshot } from "./pixels.js";
import type { Ruler } from "./ruler.js";
import { toHash } from "./state.js";
import type { Viewer } from "./viewer.js";

/** Milliseconds in which a letter of a sentence is read. */
const READING = 50;

/** The buttons over the picture, and what they open. */
export class Toolbar {
  readonly element: HTMLElement;
  private readonly said: HTMLElement;
  private readonly help: HTMLDialogElement;
  private readonly controls: HTMLElement;
  private sayTimer = 0;

  constructor(private readonly viewer: Viewer, private readonly panel: HTMLElement, private readonly ruler: Ruler, bookmarks: Bookmarks) {
    this.said = el("div", { class: "said", role: "status", "aria-live": "polite" });
    this.help = helpDialog();
    const hand = iconButton("Drag moves the view", "M9 11V5a1.5 1.5 0 013 0v5m0 0V4a1.5 1.5 0 013 0v6m0 0V6a1.5 1.5 0 013 0v9a6 6 0 01-6 6h-1c-2 0-3-1-4-3l-3-5a1.4 1.4 0 012-2l2 2", () => {
      viewer.movesView = !viewer.movesView;
      viewer.redraw(false);
    });
    const measure = iconButton("Ruler", "M3 16L16 3l5 5L8 21zM7 12l2 2M10 9l3 3M13 6l2 2", () => ruler.toggle());
    this.controls = iconButton("Controls", "M4 7h10m4 0h2M4 17h2m4 0h10M16 5v4M8 15v4", () => this.toggleControls());
    this.controls.setAttribute("aria-expanded", String(!panel.hidden));
    this.controls.classList.add("controls");
    const film = iconButton("Record the light", "M3 6h12v12H3zM15 11l6-3v8l-6-3", () => recorder.press());
    film.setAttribute("aria-pressed", "false");
    const recorder = new Recorder(viewer, (sentence) => this.say(sentence), (recording) => film.setAttribute("aria-pressed", String(recording)));
    this.element = el("nav", { class: "toolbar", "aria-label": "Tools" });
    this.element.append(
      hand,
      iconButton("Fit to the window", "M5 5h14v14H5zM9 12h6M12 9v6", () => viewer.fit()),
      iconButton("Undo", "M9 7L4 12l5 5M4 12h10a6 6 0 016 6", () => viewer.undo()),
      iconButton("Redo", "M15 7l5 5-5 5M20 12H10a6 6 0 00-6 6", () => viewer.redo()),
      measure,
      iconButton("Save a picture", "M4 8h3l2-3h6l2 3h3v11H4zM12 17a4 4 0 100-8 4 4 0 000 8", () => void this.snapshot()),
      iconButton("Save the whole texture", "M4 4h16v16H4zM12 7v8M8.5 12l3.5 3.5 3.5-3.5M8 18h8", () => void this.snapshot(true)),
      film,
      iconButton("Bookmarks", "M7 4h10v16l-5-4-5 4z", () => bookmarks.open()),
      iconButton("Copy the address of this view", "M10 14a4 4 0 006 0l3-3a4 4 0 00-6-6l-1 1M14 10a4 4 0 00-6 0l-3 3a4 4 0 006 6l1-1", () => void this.copyAddress()),
      iconButton("Full screen", "M8 3H3v5M16 3h5v5M8 21H3v-5M16 21h5v-5", () => void toggleFullScreen()),
      iconButton("Help", "M9 9a3 3 0 116 0c0 2-3 2-3 5M12 18v.5", () => this.help.showModal()),
      this.controls,
    );
    document.body.append(this.said, bookmarks.dialog, this.help);
    viewer.onChange(() => {
      hand.setAttribute("aria-pressed", String(viewer.movesView));
      measure.setAttribute("aria-pressed", String(viewer.isOn(ruler)));
    });
  }

  /** Shows or hides the panel. */
  toggleControls(): void {
    this.panel.hidden = !this.panel.hidden;
    this.controls.setAttribute("aria-expanded", String(!this.panel.hidden));
  }

  /** Says a sentence for a moment. */
  say(sentence: string): void {
    this.said.textContent = sentence;
    this.said.classList.add("shown");
    clearTimeout(this.sayTimer);
    this.sayTimer = window.setTimeout(() => this.said.classList.remove("shown"), 2000 + READING * sentence.length);
  }

  /** Saves the picture as it is on the screen, with lines and scale bar while the ruler is on, or the whole flat texture with a pixel for each texel. */
  async snapshot(whole = false): Promise<void> {
    const { viewer } = this, { texture } = viewer.state;
    const name = whole ? `${fileName(viewer.titles[texture] ?? "")}-texture` : fileName(viewer.shownTitle);
    try {
      const blob = await (whole ? textureSnapshot(viewer) : screenSnapshot(viewer, (context, ratio) => this.ruler.paint(context, ratio)));
      download(`${name}.png`, blob);
      this.say("Picture saved");
    } catch (error) {
      this.say(`No picture: ${(error as Error).message}`);
    }
  }

  async copyAddress(): Promise<void> {
    history.replaceState(null, "", `#${toHash(this.viewer.state)}`);
    try {
      await navigator.clipboard.writeText(location.href);
      this.say("Address copied");
    } catch {
      this.say("The address of this view is in the address bar");
    }
  }
}

function helpDialog(): HTMLDialogElement {
  const rows: [string, string][] = [
    ["Drag", "moves the light"],
    ["Shift-drag, right button, two fingers", "moves the texture, turns the object"],
    ["Wheel, pinch, + and -", "magnifies, down to single texels"],
    ["Arrow keys", "move the light; with Shift the view"],
    ["1 to 5", "flat, plane, sphere, torus, cloth"],
    ["M", "next way of showing"],
    ["O", "the light goes round"],
    ["R", "ruler, on the flat texture; off again, its lines go and the object comes back"],
    ["S", "saves a picture, with lines and scale bar while the ruler is on"],
    ["N", "writes an annotation on the middle of the view"],
    ["B", "bookmarks"],
    ["0 or double click", "the whole texture"],
    ["Ctrl-Z, Ctrl-Y", "undo, redo, also of lines and annotations"],
    ["Esc", "ends drawing of lines and annotations, and the choice of a grey"],
    ["H", "hides the controls"],
  ];
  // Above the list: what has the focus is in sight, and so is the beginning.
  const close = el("button", { type: "button" }, "Close");
  const list = el("dl", {}, ...rows.flatMap(([keys, does]) => [el("dt", {}, keys), el("dd", {}, does)]));
  const dialog = el("dialog", { "aria-label": "Help" }, el("div", { class: "head" }, el("h2", {}, "Keys and pointer"), close), list);
  close.addEventListener("click", () => dialog.close());
  return dialog;
}

async function toggleFullScreen(): Promise<void> {
  if (document.fullscreenElement) await document.exitFullscreen();
  else await document.documentElement.requestFullscreen().catch(() => undefined);
}
