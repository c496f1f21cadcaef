import { el, svg } from "./dom.js";
import { flatScale } from "./stage.js";
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
    const flat = this.viewer.state.object === "flat" && this.viewer.stage.texture(this.viewer.state.texture);
    this.bar.hidden = !flat;
    this.element.replaceChildren(...(flat ? this.lines.flatMap((line) => this.drawn(line)) : []));
    if (flat) this.refreshBar();
  }

  private start(event: Event): void {
    if (!this.active || !(event instanceof PointerEvent)) return;
    const [x, y] = this.texelAt(event);
    const line: Line = [x, y, x, y];
    this.lines.push(line);
    this.element.setPointerCapture(event.pointerId);
    const move = (event: Event): void => {
      if (event instanceof PointerEvent) [line[2], line[3]] = this.texelAt(event);
      this.refresh();
    };
    this.element.addEventListener("pointermove", move);
    this.element.addEventListener("pointerup", () => this.element.removeEventListener("pointermove", move), { once: true });
  }

  private geometry(): { scale: number; width: number; height: number; cx: number; cy: number } | null {
    const { state, stage, canvas } = this.viewer, texture = stage.texture(state.texture);
    if (!texture) return null;
    const width = this.viewer.viewWidth(canvas.clientWidth), height = canvas.clientHeight;
    const scale = flatScale(state, texture, width, height);
    return { scale, width, height, cx: state.x * texture.width, cy: state.y * texture.height };
  }

  private texelAt(event: PointerEvent): [number, number] {
    const g = this.geometry(), box = this.element.getBoundingClientRect();
    if (!g) return [0, 0];
    return [g.cx + (event.clientX - box.left - g.width / 2) / g.scale, g.cy + (event.clientY - box.top - g.height / 2) / g.scale];
  }

  private drawn([x1, y1, x2, y2]: Line): SVGElement[] {
    const g = this.geometry();
    if (!g) return [];
    const x = (value: number): number => g.width / 2 + (value - g.cx) * g.scale;
    const y = (value: number): number => g.height / 2 + (value - g.cy) * g.scale;
    const text = svg("text", { x: (x(x1) + x(x2)) / 2, y: (y(y1) + y(y2)) / 2 - 8 });
    text.textContent = this.length(Math.hypot(x2 - x1, y2 - y1));
    return [svg("line", { x1: x(x1), y1: y(y1), x2: x(x2), y2: y(y2) }), text];
  }

  private length(texels: number): string {
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel;
    return mm ? `${Number((texels * mm).toPrecision(3))} mm` : `${Number(texels.toPrecision(3))} px`;
  }

  /** A bar of 1, 2 or 5 times a power of ten that is about 120 pixels long. */
  private refreshBar(): void {
    const g = this.geometry();
    if (!g) return;
    const mm = this.viewer.stage.texture(this.viewer.state.texture)?.data.mmPerTexel ?? 1;
    const wanted = (120 / g.scale) * mm, power = 10 ** Math.floor(Math.log10(wanted));
    const length = ([5, 2, 1].find((n) => n * power <= wanted) ?? 1) * power;
    this.bar.style.width = `${(length / mm) * g.scale}px`;
    this.bar.textContent = this.length(length / mm);
  }
}
