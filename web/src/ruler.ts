import { el, svg } from "./dom.js";
import { type FlatPlaces, flatPlaces, texelAt } from "./places.js";
import type { DrawingTool } from "./pointer.js";
import type { Viewer } from "./viewer.js";

/** Pixels of the scale bar, about. */
const LEAST_BAR = 120;

/** A measured line in texels, y down. */
type Line = [number, number, number, number];

/** A line on the screen, and its label. */
interface PlacedLine {
  from: [number, number];
  to: [number, number];
  label: { x: number; y: number; isBeside: boolean; text: string };
}

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

  /** Draws lines and scale bar into a picture of the view, of so many pixels for each of the screen. */
  paint(context: CanvasRenderingContext2D, ratio: number): void {
    const places = flatPlaces(this.viewer);
    if (!places || !this.viewer.isOn(this)) return;
    context.scale(ratio, ratio);
    context.font = "14px system-ui, sans-serif";
    const write = (text: string, x: number, y: number, align: CanvasTextAlign): void => {
      context.textAlign = align;
      [context.lineWidth, context.strokeStyle, context.fillStyle] = [3, "#000b", "#fff"];
      context.strokeText(text, x, y);
      context.fillText(text, x, y);
    };
    for (const line of this.lines) {
      const { from, to, label } = this.placed(line, places);
      strokeLine(context, [from, to]);
      write(label.text, label.x, label.y, label.isBeside ? "left" : "center");
    }
    const { width, text } = this.barOf(places), [left, right, low] = [16, 16 + width, 36];
    strokeLine(context, [[left, low - 6], [left, low], [right, low], [right, low - 6]]);
    write(text, (left + right) / 2, low - 8, "center");
  }

  private lineOf(line: Line, places: FlatPlaces): SVGElement[] {
    const { from, to, label } = this.placed(line, places);
    const text = svg("text", { x: label.x, y: label.y, class: label.isBeside ? "beside" : undefined });
    text.textContent = label.text;
    return [svg("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1] }), text];
  }

  /** Where a line and its label are on the screen: above a level line, and beside a steep one. */
  private placed([x1, y1, x2, y2]: Line, places: FlatPlaces): PlacedLine {
    const from = places.pixel(x1, y1), to = places.pixel(x2, y2), x = (from[0] + to[0]) / 2, y = (from[1] + to[1]) / 2;
    const isBeside = Math.abs(to[1] - from[1]) > Math.abs(to[0] - from[0]), text = this.length(Math.hypot(x2 - x1, y2 - y1));
    return { from, to, label: isBeside ? { x: x + 10, y: y + 5, isBeside, text } : { x, y: y - 8, isBeside, text } };
  }

  private length(texels: number): string {
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel;
    return mm ? `${Number((texels * mm).toPrecision(3))} mm` : `${Number(texels.toPrecision(3))} px`;
  }

  private refreshBar(places: FlatPlaces): void {
    const { width, text } = this.barOf(places);
    this.bar.style.width = `${width}px`;
    this.bar.textContent = text;
  }

  /** A bar of 1, 2 or 5 times a power of ten that is about 120 pixels long, or as long as its label with large type. */
  private barOf({ scale }: FlatPlaces): { width: number; text: string } {
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel ?? 1;
    const pixels = Math.max(LEAST_BAR, 8 * Number.parseFloat(getComputedStyle(this.bar).fontSize));
    const wanted = (pixels / scale) * mm, power = 10 ** Math.floor(Math.log10(wanted));
    const length = ([5, 2, 1].find((n) => n * power <= wanted) ?? 1) * power;
    return { width: (length / mm) * scale, text: this.length(length / mm) };
  }
}

/** In white over a wider black: seen on any texture. */
function strokeLine(context: CanvasRenderingContext2D, points: [number, number][]): void {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  for (const [width, color] of [[3.5, "#000b"], [1.5, "#fff"]] as const) {
    [context.lineWidth, context.strokeStyle] = [width, color];
    context.stroke();
  }
}
