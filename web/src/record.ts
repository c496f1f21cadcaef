import { download, el, fileName } from "./dom.js";
import { GifWriter } from "./gif.js";
import { codesOf, pngOf } from "./pixels.js";
import type { DiskLight } from "./state.js";
import type { Viewer } from "./viewer.js";
import { WebmEncoder, encodesFilms } from "./webm.js";
import { zipOf } from "./zip.js";

/** The lights at a time in seconds. */
interface Moment {
  time: number;
  lights: DiskLight[];
}

const FORMATS = { gif: "Animated GIF", zip: "PNG frames (zip)", webm: "WebM film" } as const;
type Format = keyof typeof FORMATS;

/** The lights of each picture, going once around the middle. */
export function orbitOf(lights: DiskLight[], chosen: number, count: number): DiskLight[][] {
  return Array.from({ length: count }, (_, i) => {
    const angle = (2 * Math.PI * i) / count, cos = Math.cos(angle), sin = Math.sin(angle);
    return lights.map((light, k) => {
      if (k !== chosen) return light;
      const { u, v } = Math.hypot(light.u, light.v) < 0.05 ? { u: 0.6, v: 0 } : light;
      return { ...light, u: u * cos + v * sin, v: v * cos - u * sin };
    });
  });
}

/** The lights of each picture along a recorded path, evenly spaced in time. */
export function pathOf(path: Moment[], count: number): DiskLight[][] {
  const first = path[0]?.time ?? 0, length = (path[path.length - 1]?.time ?? 0) - first;
  let at = 0;
  return Array.from({ length: count }, (_, i) => {
    const time = first + (length * i) / Math.max(1, count - 1);
    while (at + 1 < path.length && (path[at + 1]?.time ?? Infinity) <= time) at++;
    const from = path[at], to = path[Math.min(at + 1, path.length - 1)];
    if (!from || !to || from.lights.length !== to.lights.length || to.time <= from.time) return from?.lights ?? [];
    const share = (time - from.time) / (to.time - from.time);
    const mix = (a: number, b: number): number => a + share * (b - a);
    return from.lights.map((light, k) => ({ ...light, u: mix(light.u, to.lights[k]?.u ?? light.u), v: mix(light.v, to.lights[k]?.v ?? light.v) }));
  });
}

/** Records a path of the light, and makes moving pictures of it. */
export class Recorder {
  private path: Moment[] = [];
  private recording = false;
  private readonly dialog: HTMLDialogElement;
  private readonly form: { path: HTMLSelectElement; format: HTMLSelectElement; count: HTMLInputElement; rate: HTMLInputElement };
  private readonly record = el("button", { type: "button" }, "Record a drag");

  constructor(private readonly viewer: Viewer, private readonly say: (sentence: string) => void, private readonly shown: (recording: boolean) => void) {
    const path = el("select", { "aria-label": "Path of the light" }, el("option", { value: "orbit" }, "Once around"), el("option", { value: "drag", disabled: true }, "As recorded"));
    const format = el("select", { "aria-label": "Kind of file" });
    for (const [value, name] of Object.entries(FORMATS)) {
      const isMade = value !== "webm" || encodesFilms();
      format.append(el("option", { value, disabled: !isMade }, isMade ? name : `${name} (this browser encodes none${isSecureContext ? "" : " without https"})`));
    }
    const number = (value: number, max: number): HTMLInputElement => el("input", { type: "number", min: 2, max, value, required: true });
    this.form = { path, format, count: number(36, 360), rate: number(12, 50) };
    this.dialog = this.made();
    document.body.append(this.dialog);
    viewer.onChange(() => this.recording && this.path.push({ time: performance.now() / 1000, lights: viewer.state.lights.map((light) => ({ ...light })) }));
  }

  /** Opens the dialog, or ends a recording. */
  press(): void {
    if (this.recording) {
      this.recording = false;
      this.shown(false);
      const drag = this.form.path.options[1];
      if (drag) drag.disabled = this.path.length < 2;
      if (this.path.length > 1) this.form.path.value = "drag";
    }
    this.dialog.showModal();
  }

  private made(): HTMLDialogElement {
    const { path, format, count, rate } = this.form;
    const cancel = el("button", { type: "button" }, "Cancel");
    const field = (name: string, input: HTMLElement): HTMLElement => el("label", { class: "field" }, el("span", {}, name), input);
    const form = el("form", { method: "dialog", class: "tall" }, path, field("Pictures", count), field("A second", rate), format, el("div", { class: "row" }, el("button", { type: "submit" }, "Make"), this.record, cancel));
    const dialog = el("dialog", { "aria-label": "Record the light" }, el("h2", {}, "Record the light"), form);
    cancel.addEventListener("click", () => dialog.close());
    this.record.addEventListener("click", () => {
      dialog.close();
      this.path = [];
      this.recording = true;
      this.shown(true);
      this.say("Move the light; press the button again at the end");
    });
    form.addEventListener("submit", () => void this.make().catch((error: unknown) => this.say(`No film: ${(error as Error).message}`)));
    return dialog;
  }

  private async make(): Promise<void> {
    const { viewer, form } = this, name = fileName(viewer.shownTitle), count = Number(form.count.value), rate = Number(form.rate.value);
    const frames = form.path.value === "drag" ? pathOf(this.path, count) : orbitOf(viewer.state.lights, viewer.lamps.chosen, count);
    const format = form.format.value as Format, kept = viewer.state.lights;
    try {
      const blob = await viewer.withFixedSize(() => MAKERS[format](viewer, frames, rate, (i) => this.say(`Picture ${i + 1} of ${frames.length}`)));
      download(`${name}.${format}`, blob);
      this.say("Film saved");
    } finally {
      viewer.state.lights = kept;
      viewer.redraw();
    }
  }
}

type Maker = (viewer: Viewer, frames: DiskLight[][], rate: number, progress: (i: number) => void) => Promise<Blob>;

const MAKERS: Record<Format, Maker> = {
  gif: async (viewer, frames, rate, progress) => {
    const { width, height } = viewer.canvas, writer = new GifWriter(width, height, Math.max(2, Math.round(100 / rate)));
    await each(viewer, frames, progress, () => writer.add(codesOf(viewer.canvas, 0, 0, width, height)));
    return writer.finish();
  },
  zip: async (viewer, frames, _rate, progress) => {
    const files: [string, Uint8Array<ArrayBuffer>][] = [];
    await each(viewer, frames, progress, async (i) => {
      const png = await (await pngOf(viewer.canvas)).arrayBuffer();
      files.push([`${String(i + 1).padStart(4, "0")}.png`, new Uint8Array(png)]);
    });
    return zipOf(files);
  },
  webm: async (viewer, frames, rate, progress) => {
    const encoder = await WebmEncoder.open(viewer.canvas, rate);
    await each(viewer, frames, progress, () => encoder.add());
    return encoder.finish();
  },
};

/** Draws each picture, gives it to `take`, and lets the page breathe. */
async function each(viewer: Viewer, frames: DiskLight[][], progress: (i: number) => void, take: (i: number) => void | Promise<void>): Promise<void> {
  for (const [i, lights] of frames.entries()) {
    viewer.state.lights = lights;
    viewer.expectPicture();
    viewer.drawNow();
    await take(i);
    progress(i);
    await new Promise((resolve) => setTimeout(resolve));
  }
}
