import { el, svg } from "./dom.js";
import { type FlatPlaces, flatPlaces, texelAt } from "./places.js";
import type { Viewer } from "./viewer.js";

/** A measured line in texels, y down. */
type Line = [number, number, number, number];

/** A scale bar and lines with their lengths over the flat view: in millimetres where the size of a texel is known. */
export class Ruler {
  readonly element: SVGElement;
  readonly bar: HTMLElement;
  private readonly lines: Line[] = [];
  private active = false;

  constructor(private readonly viewer: Viewer) {
    this.element = svg("svg", { class: "overlay", "aria-hidden": "true" });
    this.bar = el("div", { class: "scale" });
    this.element.addEventListener("pointerdown", (event) => this.start(event));
  }

  /** Lines are drawn by dragging while the ruler is on. Turned off, they go. */
  toggle(): void {
    this.active = !this.active;
    if (this.active && this.viewer.state.object !== "flat") this.viewer.change({ object: "flat" });
    if (!this.active) this.lines.length = 0;
    this.element.classList.toggle("active", this.active);
    this.refresh();
  }

  refresh(): void {
    const places = flatPlaces(this.viewer);
    this.bar.hidden = !places;
    this.element.replaceChildren(...(places ? this.lines.flatMap((line) => this.drawn(line, places)) : []));
    if (places) this.refreshBar(places);
  }

  private start(event: Event): void {
    const places = flatPlaces(this.viewer);
    if (!this.active || !places || !(event instanceof PointerEvent)) return;
    const [x, y] = texelAt(event, this.element, places);
    const line: Line = [x, y, x, y];
    this.lines.push(line);
    this.element.setPointerCapture(event.pointerId);
    const move = (event: Event): void => {
      if (event instanceof PointerEvent) [line[2], line[3]] = texelAt(event, this.element, places);
      this.refresh();
    };
    this.element.addEventListener("pointermove", move);
    this.element.addEventListener("pointerup", () => this.element.removeEventListener("pointermove", move), { once: true });
  }

  private drawn([x1, y1, x2, y2]: Line, places: FlatPlaces): SVGElement[] {
    const [ax, ay] = places.pixel(x1, y1), [bx, by] = places.pixel(x2, y2);
    const text = svg("text", { x: (ax + bx) / 2, y: (ay + by) / 2 - 8 });
    text.textContent = this.length(Math.hypot(x2 - x1, y2 - y1));
    return [svg("line", { x1: ax, y1: ay, x2: bx, y2: by }), text];
  }

  private length(texels: number): string {
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel;
    return mm ? `${Number((texels * mm).toPrecision(3))} mm` : `${Number(texels.toPrecision(3))} px`;
  }

  /** A bar of 1, 2 or 5 times a power of ten that is about 120 pixels long. */
  private refreshBar({ scale }: FlatPlaces): void {
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel ?? 1;
    const wanted = (120 / scale) * mm, power = 10 ** Math.floor(Math.log10(wanted));
    const length = ([5, 2, 1].find((n) => n * power <= wanted) ?? 1) * power;
    this.bar.style.width = `${(length / mm) * scale}px`;
    this.bar.textContent = this.length(length / mm);
  }
}
