import { MODES, type Mode } from "relume-three";
import { el, icon } from "./dom.js";
import { objectButton } from "./dropped.js";
import { pickGrey } from "./grey.js";
import { LightBall } from "./ball.js";
import { D65, NEUTRAL, TEMPERATURES, type White, temperatureOf, whiteOf } from "./balance.js";
import { matchOf } from "./places.js";
import { COMPARISONS, type Comparison, type LightSource, MOST_SOFTNESS, MOST_STRENGTH, OBJECTS, type ObjectName, SOURCES, type ViewState } from "./state.js";
import type { Viewer } from "./viewer.js";

const MODE_NAMES: Record<Mode, string> = {
  default: "As photographed",
  "diffuse-gain": "Diffuse gain",
  specular: "Specular enhancement",
  "unsharp-luminance": "Unsharp luminance",
  "unsharp-normals": "Unsharp normals",
  "unsharp-coefficients": "Unsharp coefficients",
  "multi-light": "Multi-light still",
  normals: "Normals",
  albedo: "Albedo",
  height: "Height",
  slope: "Slope",
  shading: "Shading only",
  plain: "Plain photograph",
};
/** Modes with an amount: its range and what it is called. */
const AMOUNTS: Partial<Record<Mode, [number, number, string]>> = {
  "diffuse-gain": [0, 8, "Gain"],
  specular: [0, 3, "Strength"],
  "unsharp-luminance": [0, 4, "Amount"],
  "unsharp-normals": [0, 6, "Amount"],
  "unsharp-coefficients": [0, 4, "Amount"],
  "multi-light": [0, 4, "Selection"],
};
const OBJECT_NAMES: Record<ObjectName, [string, string]> = {
  flat: ["Flat", "M4 4h16v16H4z"],
  plane: ["Plane", "M3 16l4-9h10l4 9z"],
  sphere: ["Sphere", "M12 3a9 9 0 100 18 9 9 0 000-18M3 12c4 4 14 4 18 0"],
  torus: ["Torus", "M12 5c6 0 10 3 10 7s-4 7-10 7S2 16 2 12s4-7 10-7M8 11c2 2 6 2 8 0"],
  cloth: ["Cloth", "M4 6c4-3 5 3 9 0s5 1 7 0v12c-2 1-3-3-7 0s-5-3-9 0z"],
  mesh: ["Your object", "M12 3l8 4.5v9L12 21l-8-4.5v-9zM12 12l8-4.5M12 12v9M12 12L4 7.5"],
};
const SOURCE_NAMES: Record<LightSource, string> = { lamps: "Lamps", environment: "Environment", both: "Lamps and environment" };
const COMPARISON_NAMES: Record<Comparison, string> = { single: "One", wipe: "Wipe", side: "Side by side", plain: "Against photograph" };

/** The steps of colour temperatures, in kelvins. */
const KELVIN_STEP = 50;
/** What arrow keys do in a row of radio buttons. */
const STEPS: Record<string, number> = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };

/** The controls beside the picture. */
export class Panel {
  readonly element: HTMLElement;
  private readonly refreshers: ((state: ViewState) => void)[] = [];

  constructor(private readonly viewer: Viewer, private readonly say: (sentence: string) => void) {
    const ball = new LightBall(viewer);
    this.refreshers.push(() => ball.refresh());
    this.element = el("aside", { class: "panel", "aria-label": "Controls" });
    this.element.append(
      ...(viewer.titles.length > 1 ? [this.textures()] : []),
      this.objects(),
      objectButton(viewer, say),
      this.plane(),
      this.section("Light", this.sources(), ball.element, this.lightButtons()),
      this.section("Show", this.modes()),
      this.section("View", this.slider("Repeat", "repeat", 1, 8, 0.1), this.slider("Exposure", "exposure", -3, 3, 0.05), this.white(), this.slider("Gloss", "gloss", 0, 0.5, 0.01)),
      this.section("Compare", this.comparisons()),
    );
  }

  refresh(state: ViewState): void {
    for (const refresh of this.refreshers) refresh(state);
  }

  private section(name: string, ...children: Node[]): HTMLElement {
    const section = el("section", {}, el("h2", {}, name));
    section.append(...children);
    return section;
  }

  private textures(): HTMLElement {
    const select = el("select", { "aria-label": "Texture" });
    this.viewer.titles.forEach((title, i) => select.append(el("option", { value: i }, title)));
    select.addEventListener("change", () => this.viewer.change({ texture: Number(select.value) }));
    this.refreshers.push((state) => (select.value = String(state.texture)));
    return this.section("Texture", select);
  }

  private objects(): HTMLElement {
    const group = el("div", { class: "segments", role: "radiogroup", "aria-label": "Shown on" });
    for (const object of OBJECTS) {
      const [name, path] = OBJECT_NAMES[object];
      const button = el("button", { type: "button", role: "radio", title: name, "aria-label": name });
      button.append(icon(path));
      button.addEventListener("click", () => this.viewer.change({ object }));
      // An address may name an object that the page does not have: it shows a plane.
      const shown = (state: ViewState): ObjectName => (state.object === "mesh" && this.viewer.objectName === null ? "plane" : state.object);
      this.refreshers.push((state) => {
        button.setAttribute("aria-checked", String(shown(state) === object));
        button.tabIndex = shown(state) === object ? 0 : -1;
      });
      if (object === "mesh") this.refreshers.push(() => this.nameObject(button));
      group.append(button);
    }
    group.addEventListener("keydown", (event) => stepRadio(event, group));
    return group;
  }

  /** The button of the user's own object, while there is one. */
  private nameObject(button: HTMLElement): void {
    const { objectName } = this.viewer;
    button.hidden = objectName === null;
    button.title = objectName ?? "";
    button.setAttribute("aria-label", objectName ?? "");
  }

  private lightButtons(): HTMLElement {
    const row = el("div", { class: "row" });
    const orbit = el("button", { type: "button", "aria-pressed": "false" }, "Orbit");
    orbit.addEventListener("click", () => this.viewer.lamps.toggleOrbit());
    this.refreshers.push(() => orbit.setAttribute("aria-pressed", String(this.viewer.lamps.orbiting)));
    const add = el("button", { type: "button", title: "Add a light, four at most" }, "Add light");
    add.addEventListener("click", () => this.viewer.lamps.add());
    const remove = el("button", { type: "button", title: "Remove the chosen light" }, "Remove");
    remove.addEventListener("click", () => this.viewer.lamps.remove());
    const raking = el("button", { type: "button", title: "Two raking lights in two colours" }, "Raking pair");
    raking.addEventListener("click", () => this.viewer.lamps.rakingPair());
    const color = el("input", { type: "color", "aria-label": "Colour of the light" });
    color.addEventListener("input", () => this.viewer.lamps.change({ color: color.value }));
    this.refreshers.push((state) => {
      remove.disabled = state.lights.length < 2;
      add.disabled = state.lights.length > 3;
      color.value = this.viewer.lamps.light.color;
    });
    row.append(orbit, add, remove, raking, color);
    const strength = this.range("Strength", 0, MOST_STRENGTH, 0.05, () => this.viewer.lamps.light.strength, (strength) => this.viewer.lamps.change({ strength }));
    const softness = this.range("Softness", 0, MOST_SOFTNESS, 1, () => this.viewer.lamps.light.softness, (softness) => this.viewer.lamps.change({ softness }));
    softness.title = "Degrees from the middle of the light to its rim";
    return el("div", {}, row, strength, softness);
  }

  /** What lights the texture, where the page has light from all around. */
  private sources(): HTMLElement {
    const select = el("select", { "aria-label": "Lit by" });
    for (const source of SOURCES) select.append(el("option", { value: source }, SOURCE_NAMES[source]));
    select.addEventListener("change", () => this.viewer.change({ source: select.value as LightSource }));
    const turn = this.range("Turn", -180, 180, 1, (state) => state.turn, (turn) => this.viewer.change({ turn }, "turn"));
    const sky = this.range("Strength", 0, MOST_STRENGTH, 0.05, (state) => state.sky, (sky) => this.viewer.change({ sky }, "sky"));
    const all = el("div", {}, select, turn, sky);
    this.refreshers.push((state) => {
      all.hidden = !this.viewer.hasEnvironment;
      select.value = state.source;
      turn.hidden = sky.hidden = state.source === "lamps";
    });
    return all;
  }

  private white(): HTMLElement {
    const set = ([whiteX, whiteY]: White): void => this.viewer.change({ whiteX, whiteY }, "white");
    const shown = ({ whiteX, whiteY }: ViewState): number => KELVIN_STEP * Math.round(temperatureOf([whiteX, whiteY]) / KELVIN_STEP);
    const temperature = this.range("White", ...TEMPERATURES, KELVIN_STEP, shown, (kelvins) => set(Math.abs(kelvins - NEUTRAL) < KELVIN_STEP / 2 ? D65 : whiteOf(kelvins)));
    temperature.title = "Colour temperature that is shown as neutral, in kelvins";
    const pick = el("button", { type: "button", title: "Press a place of the picture that is grey" }, "Pick grey");
    pick.addEventListener("click", () => pickGrey(this.viewer, this.say));
    this.refreshers.push(() => pick.setAttribute("aria-pressed", String(this.viewer.pick !== null)));
    const neutral = el("button", { type: "button" }, "Neutral");
    neutral.addEventListener("click", () => set(D65));
    this.refreshers.push(({ whiteX, whiteY }) => (neutral.disabled = whiteX === D65[0] && whiteY === D65[1]));
    return el("div", {}, temperature, el("div", { class: "row" }, pick, neutral));
  }

  private modes(): HTMLElement {
    const select = el("select", { "aria-label": "What is shown" });
    const options = MODES.map((mode) => el("option", { value: mode }, MODE_NAMES[mode]));
    select.append(...options);
    select.addEventListener("change", () => this.viewer.showMode(select.value as Mode));
    const name = el("span", {}, "Amount"), input = el("input", { type: "range", min: 0, max: 8, step: 0.05 });
    input.addEventListener("input", () => this.viewer.change({ gain: Number(input.value) }, "gain"));
    const amount = el("label", { class: "slider" }, name, input);
    this.refreshers.push((state) => {
      const mode = this.viewer.modeOf(state.texture);
      select.value = mode;
      for (const option of options) option.disabled = !this.viewer.modes.includes(option.value as Mode);
      const range = AMOUNTS[mode];
      amount.hidden = range === undefined;
      if (range) [input.min, input.max, name.textContent] = [String(range[0]), String(range[1]), range[2]];
      input.value = String(state.gain);
    });
    return el("div", {}, select, amount);
  }

  private slider(name: string, key: "repeat" | "exposure" | "gloss", least: number, most: number, step: number): HTMLElement {
    return this.range(name, least, most, step, (state) => state[key], (value) => this.viewer.change({ [key]: value }, key));
  }

  private range(name: string, least: number, most: number, step: number, get: (state: ViewState) => number, set: (value: number) => void): HTMLElement {
    const input = el("input", { type: "range", min: least, max: most, step }), output = el("output");
    input.addEventListener("input", () => set(Number(input.value)));
    this.refreshers.push((state) => {
      input.value = String(get(state));
      output.value = get(state).toFixed(step < 0.1 ? 2 : step < 1 ? 1 : 0);
    });
    return el("label", { class: "slider" }, el("span", {}, name), input, output);
  }

  private comparisons(): HTMLElement {
    const select = el("select", { "aria-label": "Compare" });
    const several = this.viewer.titles.length > 1;
    for (const kind of COMPARISONS) {
      if (several || kind === "single" || kind === "plain") select.append(el("option", { value: kind }, COMPARISON_NAMES[kind]));
    }
    select.addEventListener("change", () => this.viewer.change({ compare: select.value as Comparison }));
    const other = el("select", { "aria-label": "Compared with" });
    this.viewer.titles.forEach((title, i) => other.append(el("option", { value: i }, title)));
    other.addEventListener("change", () => this.viewer.change({ other: Number(other.value) }));
    const match = el("p", { class: "dim" });
    const unlike = el("p", { class: "dim" }, "It has no normals, and is shown as photographed.");
    const border = this.range("Border", 0, 1, 0.01, (state) => state.wipe, (wipe) => this.viewer.change({ wipe }, "wipe"));
    border.title = "Where the second picture begins";
    this.refreshers.push((state) => {
      border.hidden = state.compare === "single" || state.compare === "side";
      select.value = state.compare;
      other.value = String(state.other);
      other.hidden = state.compare === "single" || state.compare === "plain";
      match.textContent = matchOf(this.viewer);
      unlike.hidden = other.hidden || this.viewer.modeOf(state.other) === state.mode;
    });
    return el("div", {}, select, other, border, match, unlike);
  }

  /** What endless planes have beside textures. */
  private plane(): HTMLElement {
    const cells = this.check("cells"), simple = this.check("simple");
    const far = el("button", { type: "button" }, "Far away"), place = el("output", { class: "dim" });
    far.addEventListener("click", () => this.viewer.goFar());
    const section = this.section("Endless plane", cells.label, simple.label, el("div", { class: "row" }, far, place));
    this.refreshers.push((state) => {
      const { plane } = this.viewer, texture = this.viewer.stage.texture(state.texture);
      section.hidden = plane === null;
      if (plane === null || !texture) return;
      cells.name.textContent = plane === "tiles" ? "Show the tiles" : "Show the triangles";
      simple.name.textContent = plane === "tiles" ? "The first tile only" : "Plain averages instead";
      cells.label.hidden = simple.label.hidden = plane === "model";
      place.value = state.object === "flat" ? `${Math.round(state.x * texture.width)}, ${Math.round(state.y * texture.height)}` : "";
    });
    return section;
  }

  private check(key: "cells" | "simple"): { label: HTMLElement; name: HTMLElement } {
    const box = el("input", { type: "checkbox" }), name = el("span");
    box.addEventListener("change", () => this.viewer.change({ [key]: box.checked }));
    this.refreshers.push((state) => (box.checked = state[key]));
    return { label: el("label", { class: "check" }, box, name), name };
  }
}

/** Moves the choice and the focus by an arrow key, around the ends. */
function stepRadio(event: KeyboardEvent, group: HTMLElement): void {
  const step = STEPS[event.key], buttons = [...group.querySelectorAll<HTMLButtonElement>("[role=radio]:not([hidden])")];
  if (step === undefined || event.shiftKey) return;
  event.preventDefault();
  event.stopPropagation();
  const next = buttons[(buttons.indexOf(event.target as HTMLButtonElement) + step + buttons.length) % buttons.length];
  next?.click();
  next?.focus();
}
