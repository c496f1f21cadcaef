import { el, svg } from "./dom.js";
import { onDisk } from "./state.js";
import type { Viewer } from "./viewer.js";

const SIDE = 132;
const RADIUS = 58;

/** A ball under the lights: each is a dot where the ball faces it. Dots are dragged, or moved by the arrow keys. */
export class LightBall {
  readonly element: HTMLElement;
  private readonly dots: SVGElement;
  private readonly gradient: SVGElement;
  private readonly said: HTMLOutputElement;

  constructor(private readonly viewer: Viewer) {
    this.gradient = svg("radialGradient", { id: "ball-shade", r: "1.05" }, svg("stop", { offset: 0, class: "ball-lit" }), svg("stop", { offset: 1, class: "ball-dark" }));
    this.dots = svg("g");
    const drawing = svg(
      "svg",
      { viewBox: `0 0 ${SIDE} ${SIDE}`, width: SIDE, height: SIDE, "aria-hidden": "true" },
      svg("defs", {}, this.gradient),
      svg("circle", { cx: SIDE / 2, cy: SIDE / 2, r: RADIUS, fill: "url(#ball-shade)", class: "ball" }),
      svg("circle", { cx: SIDE / 2, cy: SIDE / 2, r: RADIUS * Math.SQRT1_2, class: "ball-ring" }),
      this.dots,
    );
    this.said = el("output", { class: "dim" });
    const pad = el("div", { class: "pad", tabindex: 0, role: "application", "aria-label": "Direction of the light: drag, or press the arrow keys" });
    pad.append(drawing);
    pad.addEventListener("pointerdown", (event) => {
      pad.setPointerCapture(event.pointerId);
      this.viewer.begin();
      this.choose(event, pad);
      this.drag(event, pad);
    });
    pad.addEventListener("pointermove", (event) => event.buttons && this.drag(event, pad));
    pad.addEventListener("keydown", (event) => this.viewer.lamps.moveByKey(event));
    this.element = el("div", { class: "ball-box" }, pad, this.said);
  }

  refresh(): void {
    const { lights } = this.viewer.state;
    this.dots.replaceChildren(
      ...lights.map(({ u, v, color }, i) =>
        svg("circle", { cx: SIDE / 2 + RADIUS * u, cy: SIDE / 2 - RADIUS * v, r: i === this.viewer.lamps.chosen ? 7 : 5, fill: color, class: "ball-dot" }),
      ),
    );
    const { u, v } = this.viewer.lamps.light;
    this.gradient.setAttribute("cx", String(0.5 + 0.5 * u));
    this.gradient.setAttribute("cy", String(0.5 - 0.5 * v));
    const height = (Math.acos(Math.min(1, Math.hypot(u, v))) * 180) / Math.PI;
    this.said.value = `${Math.round((Math.atan2(v, u) * 180) / Math.PI + 360) % 360}° azimuth, ${Math.round(height)}° elevation`;
  }

  private place(event: PointerEvent, pad: HTMLElement): [number, number] {
    const box = pad.getBoundingClientRect(), scale = SIDE / box.width;
    const x = (event.clientX - box.left) * scale, y = (event.clientY - box.top) * scale;
    return [(x - SIDE / 2) / RADIUS, (SIDE / 2 - y) / RADIUS];
  }

  /** Chooses the light whose dot was taken. */
  private choose(event: PointerEvent, pad: HTMLElement): void {
    const [u, v] = this.place(event, pad);
    const distance = this.viewer.state.lights.map((light) => Math.hypot(light.u - u, light.v - v));
    const nearest = distance.indexOf(Math.min(...distance));
    if ((distance[nearest] ?? 1) < 0.25) this.viewer.lamps.chosen = nearest;
  }

  private drag(event: PointerEvent, pad: HTMLElement): void {
    const [u, v] = onDisk(...this.place(event, pad));
    this.viewer.lamps.change({ u, v }, false);
  }
}
