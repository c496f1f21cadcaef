import { el, svg } from "./dom.js";
import { type FlatPlaces, cutOff, flatPlaces, placesUnder, texelAt } from "./places.js";
import type { DrawingTool } from "./pointer.js";
import type { ObjectName } from "./state.js";
import type { Viewer } from "./viewer.js";

/** Pixels of the scale bar, about. */
const LEAST_BAR = 120;
/** Pixels from a picture to its scale bar. */
const MARGIN = 16;

/** A measured line in texels of a texture, y down. */
interface Line {
  texture: number;
  from: [number, number];
  to: [number, number];
}

/** A line on the screen, and its label. */
interface PlacedLine {
  from: [number, number];
  to: [number, number];
  label: { x: number; y: number; isBeside: boolean; text: string };
}

/** A scale bar on the screen. */
interface PlacedBar {
  x: number;
  width: number;
  text: string;
}

/** Scale bars, and lines with their lengths, over the flat view: in millimetres where the size of a texel is known. */
export class Ruler implements DrawingTool {
  readonly element = svg("svg", { class: "overlay", "aria-hidden": "true" });
  /** A scale bar for each texture that is shown. */
  readonly bars = el("div", { class: "scales" });
  private lines: readonly Line[] = [];
  private drawn: Line | null = null;
  /** What the texture was on before it was measured. */
  private left: ObjectName | null = null;

  constructor(private readonly viewer: Viewer) {}

  /** Lines are drawn by dragging while the ruler is on. Turned off, they go, and the object comes back. */
  toggle(): void {
    const { viewer } = this, { object } = viewer.state;
    const isOn = viewer.toggleTool(this);
    if (!isOn && this.lines.length > 0) this.put([]);
    if (isOn) this.left = object;
    else if (this.left !== null && this.left !== viewer.state.object) viewer.change({ object: this.left });
    this.refresh();
  }

  refresh(): void {
    const places = flatPlaces(this.viewer);
    // Whoever chose another object meanwhile wants that one.
    if (places.length === 0) this.left = null;
    this.element.replaceChildren(...places.map((picture) => this.linesIn(picture)));
    this.bars.replaceChildren(...this.barsOf(places).map(({ x, width, text }) => {
      const bar = el("div", { class: "scale" }, text);
      [bar.style.left, bar.style.width] = [`${x}px`, `${width}px`];
      return bar;
    }));
  }

  begin(event: PointerEvent): void {
    const places = placesUnder(event, this.viewer);
    if (!places) return;
    const from = texelAt(event, this.viewer.canvas, places);
    this.drawn = { texture: places.state.texture, from, to: from };
    this.refresh();
  }

  move(event: PointerEvent): void {
    const { drawn } = this, places = drawn && flatPlaces(this.viewer).find(({ state }) => state.texture === drawn.texture);
    if (drawn && places) drawn.to = texelAt(event, this.viewer.canvas, places);
    this.refresh();
  }

  end(): void {
    const { drawn } = this;
    this.drawn = null;
    if (drawn && lengthOf(drawn) > 0) this.put([...this.lines, drawn]);
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

  /** Draws lines and scale bars into a picture of the view, of so many pixels for each of the screen. */
  paint(context: CanvasRenderingContext2D, ratio: number): void {
    if (!this.viewer.isOn(this)) return;
    const places = flatPlaces(this.viewer);
    context.scale(ratio, ratio);
    context.font = "14px system-ui, sans-serif";
    for (const picture of places) {
      context.save();
      context.beginPath();
      context.rect(picture.seen.x, 0, picture.seen.width, this.viewer.canvas.clientHeight);
      context.clip();
      for (const { from, to, label } of this.placedIn(picture)) {
        strokeLine(context, [from, to]);
        write(context, label.text, label.x, label.y, label.isBeside ? "left" : "center");
      }
      context.restore();
    }
    for (const { x, width, text } of this.barsOf(places)) {
      const right = x + width, low = 36;
      strokeLine(context, [[x, low - 6], [x, low], [right, low], [right, low - 6]]);
      write(context, text, (x + right) / 2, low - 8, "center");
    }
  }

  private linesIn(picture: FlatPlaces): SVGElement {
    const lines = this.placedIn(picture).flatMap(({ from, to, label }) => {
      const text = svg("text", { x: label.x, y: label.y, class: label.isBeside ? "beside" : undefined });
      text.textContent = label.text;
      return [svg("line", { x1: from[0], y1: from[1], x2: to[0], y2: to[1] }), text];
    });
    return cutOff(picture, this.viewer.canvas.clientHeight, lines);
  }

  /** Where the lines of a picture and their labels are on the screen: above a level line, and beside a steep one. */
  private placedIn({ state: { texture }, pixel }: FlatPlaces): PlacedLine[] {
    const all = this.drawn ? [...this.lines, this.drawn] : this.lines;
    return all.filter((line) => line.texture === texture).map((line) => {
      const from = pixel(...line.from), to = pixel(...line.to), x = (from[0] + to[0]) / 2, y = (from[1] + to[1]) / 2;
      const isBeside = Math.abs(to[1] - from[1]) > Math.abs(to[0] - from[0]), text = this.said(lengthOf(line), texture);
      return { from, to, label: isBeside ? { x: x + 10, y: y + 5, isBeside, text } : { x, y: y - 8, isBeside, text } };
    });
  }

  /** A length in millimetres, or in texels. */
  private said(texels: number, texture: number): string {
    const mm = this.viewer.stage.texture(texture)?.data.mmPerTexel;
    return mm ? `${Number((texels * mm).toPrecision(3))} mm` : `${Number(texels.toPrecision(3))} px`;
  }

  /** A bar for each texture whose picture has room for it. */
  private barsOf(places: FlatPlaces[]): PlacedBar[] {
    const isFirst = ({ state }: FlatPlaces, i: number): boolean => places.findIndex((other) => other.state.texture === state.texture) === i;
    return places.filter(isFirst).flatMap((picture, _, shown) => {
      const bar = { x: picture.seen.x + MARGIN, ...this.barOf(picture) };
      return shown.length > 1 && bar.width + 2 * MARGIN > picture.seen.width ? [] : bar;
    });
  }

  /** A bar of 1, 2 or 5 times a power of ten that is about 120 pixels long, or as long as its label with large type. */
  private barOf({ scale, state: { texture } }: FlatPlaces): { width: number; text: string } {
    const mm = this.viewer.stage.texture(texture)?.data.mmPerTexel ?? 1;
    const pixels = Math.max(LEAST_BAR, 8 * Number.parseFloat(getComputedStyle(this.bars).fontSize));
    const wanted = (pixels / scale) * mm, power = 10 ** Math.floor(Math.log10(wanted));
    const length = ([5, 2, 1].find((n) => n * power <= wanted) ?? 1) * power;
    return { width: (length / mm) * scale, text: this.said(length / mm, texture) };
  }
}

function lengthOf({ from, to }: Line): number {
  return Math.hypot(to[0] - from[0], to[1] - from[1]);
}

/** White letters with a black border: read on any texture. */
function write(context: CanvasRenderingContext2D, text: string, x: number, y: number, align: CanvasTextAlign): void {
  context.textAlign = align;
  [context.lineWidth, context.strokeStyle, context.fillStyle] = [3, "#000b", "#fff"];
  context.strokeText(text, x, y);
  context.fillText(text, x, y);
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
