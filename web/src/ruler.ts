import { el, svg } from "./dom.js";
import { type FlatPlaces, flatPlaces, texelAt } from "./places.js";
import type { DrawingTool } from "./pointer.js";
import type { Viewer } from "./viewer.js";

/** Pixels of the scale bar, about. */
const LEAST_BAR = 120;

/** A measured line in texels, y down. */
type Line = [number, number, number, number];

/** A scale bar and lines with their lengths over the flat view: in millimetres where the size of a texel is known. */
export class Ruler implements DrawingTool {
  readonly element = svg("svg", { class: "overlay", "aria-hidden": "true" });
  readonly bar = el("div", { class: "scale" });
  private lines: readonly Line[] = [];
  private drawn: Line | null = null;

  constructor(private readonly viewer: Viewer) {}

  /** Lines are drawn by dragging while the ruler is on. Turned off, they go. */
  toggle(): void {
    const isOn = this.viewer.toggleTool(this);
    if (!isOn && this.lines.length > 0) this.put([]);
    this.refresh();
  }

  refresh(): void {
    const places = flatPlaces(this.viewer);
    this.bar.hidden = !places;
    const lines = this.drawn ? [...this.lines, this.drawn] : this.lines;
    this.element.replaceChildren(...(places ? lines.flatMap((line) => this.lineOf(line, places)) : []));
    if (places) this.refreshBar(places);
  }

  begin(event: PointerEvent): void {
    const places = flatPlaces(this.viewer);
    if (!places) return;
    const [x, y] = texelAt(event, this.viewer.canvas, places);
    this.drawn = [x, y, x, y];
    this.refresh();
  }

  move(event: PointerEvent): void {
    const places = flatPlaces(this.viewer);
    if (places && this.drawn) [this.drawn[2], this.drawn[3]] = texelAt(event, this.viewer.canvas, places);
    this.refresh();
  }

  end(): void {
    const { drawn } = this;
    this.drawn = null;
    if (drawn && (drawn[0] !== drawn[2] || drawn[1] !== drawn[3])) this.put([...this.lines, drawn]);
    this.refresh();
  }

  cancel(): void {
    this.drawn = null;
    this.refresh();
  }

  /** Other lines, so that it can be undone. */
  private put(lines: readonly Line[]): void {
    const before = this.lines;
    const show = (lines: readonly Line[]): void => {
      this.lines = lines;
      if (lines.length > 0 && !this.viewer.isOn(this)) this.viewer.toggleTool(this);
      this.viewer.redraw(false);
    };
    show(lines);
    this.viewer.record({ undo: () => show(before), redo: () => show(lines) });
  }

  private lineOf([x1, y1, x2, y2]: Line, places: FlatPlaces): SVGElement[] {
    const [ax, ay] = places.pixel(x1, y1), [bx, by] = places.pixel(x2, y2);
    // Above a level line, and beside a steep one.
    const x = (ax + bx) / 2, y = (ay + by) / 2, isSteep = Math.abs(by - ay) > Math.abs(bx - ax);
    const text = svg("text", isSteep ? { x: x + 10, y: y + 5, class: "beside" } : { x, y: y - 8 });
    text.textContent = this.length(Math.hypot(x2 - x1, y2 - y1));
    return [svg("line", { x1: ax, y1: ay, x2: bx, y2: by }), text];
  }

  private length(texels: number): string {
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel;
    return mm ? `${Number((texels * mm).toPrecision(3))} mm` : `${Number(texels.toPrecision(3))} px`;
  }

  /** A bar of 1, 2 or 5 times a power of ten that is about 120 pixels long, or as long as its label with large type. */
  private refreshBar({ scale }: FlatPlaces): void {
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel ?? 1;
    const pixels = Math.max(LEAST_BAR, 8 * Number.parseFloat(getComputedStyle(this.bar).fontSize)), wanted = (pixels / scale) * mm, power = 10 ** Math.floor(Math.log10(wanted));
    const length = ([5, 2, 1].find((n) => n * power <= wanted) ?? 1) * power;
    this.bar.style.width = `${(length / mm) * scale}px`;
    this.bar.textContent = this.length(length / mm);
  }
}
