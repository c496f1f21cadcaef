import { MODES, type Mode, TiledShare, openShare } from "relume-three";
import type { BufferGeometry } from "three";
import { type Change, History } from "./history.js";
import type { DrawingTool } from "./pointer.js";
import { Lamps } from "./lamps.js";
import { Stage, knowsMode } from "./stage.js";
import { FIRST, type ViewState, copyOf, fromHash, toHash } from "./state.js";
import { type PageTexture, sourceOf } from "./page.js";
import { TileCache, levelsUpTo } from "./tiles.js";

/** Steps of the same gesture closer than this are undone together, in milliseconds. */
const GESTURE = 700;
/** The state goes to the address this long after it changed, in milliseconds. */
const ADDRESS_DELAY = 250;
/** Pictures that follow each other closer than this show a movement, in milliseconds. */
const MOVING = 600;
/** A picture that takes longer is slow. */
const SLOW_FRAME = 60;
/** What has not moved for so long rests. */
const REST = 250;
/** What could not be loaded or saved is tried again after so long, in milliseconds. */
const RETRY = 3000;
/** What an effect begins with: seen at once, and not overdone. */
const USUAL_AMOUNTS: Partial<Record<Mode, number>> = {
  "diffuse-gain": 2, specular: 1, "unsharp-luminance": 1, "unsharp-normals": 2, "unsharp-coefficients": 1, "multi-light": 1,
};

/** What is seen, and every way to change it. */
export class Viewer {
  readonly stage: Stage;
  readonly lamps = new Lamps(this);
  readonly titles: string[];
  state: ViewState;
  /** Whether dragging moves the view instead of the light. */
  movesView = false;
  /** Takes the next place of the picture that is pressed, in pixels of the canvas. */
  pick: ((x: number, y: number) => void) | null = null;
  private isFixed = false;
  private readonly history = new History();
  private readonly listeners: (() => void)[] = [];
  private gesture = { kind: "", time: 0 };
  private readonly isExact: boolean;
  private share = 1;
  private moved = false;
  private drawnAt = 0;
  private slowFrames = 0;
  private restTimer = 0;
  private addressTimer = 0;
  private pending = false;
  private retryTimer = 0;
  /** The tools that are on; the last one draws. */
  private readonly tools: DrawingTool[] = [];
  /** Until a texture is there: whether nothing was said of the light. */
  private isFree = !location.hash.includes("=");

  constructor(readonly canvas: HTMLCanvasElement, textures: PageTexture[]) {
    const parameters = new URLSearchParams(location.search);
    this.isExact = parameters.has("exact");
    document.documentElement.classList.toggle("exact", this.isExact);
    this.stage = new Stage(canvas, this.isExact, () => this.redraw(false), () => this.tell());
    this.titles = textures.map((texture) => texture.title);
    this.state = fromHash(location.hash, textures.length);
    // The address asked for: by the time of the event, the page may have written its own state again.
    addEventListener("hashchange", (event) => this.readAddress(new URL(event.newURL).hash));
    for (const event of ["webglcontextlost", "webglcontextrestored"]) canvas.addEventListener(event, () => this.drawAgain());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement ?? canvas);
    this.resize();
  }

  /** Loads a texture into its place. */
  async load(index: number, texture: PageTexture, progress: (share: number) => void): Promise<void> {
    const opened = await openShare(sourceOf(texture), progress);
    if (!(opened instanceof TiledShare)) {
      this.stage.add(index, opened);
      this.lightFirst(index);
      return this.redraw();
    }
    const tiles = new TileCache(opened, this.stage.anisotropy, () => this.redraw(false));
    // Small levels first: a picture at once.
    for (const level of levelsUpTo(opened.levels.length - 1, opened.whole)) {
      this.stage.add(index, await opened.wholeLevel(level, progress), tiles);
      this.lightFirst(index);
      this.redraw();
      document.documentElement.dataset["seen"] ??= String(performance.now());
      // The screen shows it before the next level is unpacked.
      await new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve)));
    }
  }

  /** Whoever gives light from all around wants to see it; functions of light and view take seconds for it without a graphics card. */
  private lightFirst(index: number): void {
    if (!this.isFree || index !== this.state.texture) return;
    this.isFree = false;
    if (this.hasEnvironment && !this.stage.texture(index)?.data.dependsOnView) this.state.source = "environment";
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }

  onChange(listener: () => void): void {
    this.listeners.push(listener);
  }

  /** The titles of what is shown: both where two textures are compared. */
  get shownTitle(): string {
    const { texture, other, compare } = this.state, isBeside = ["side", "wipe"].includes(compare) && other !== texture;
    return (isBeside ? [texture, other] : [texture]).map((index) => this.titles[index] ?? "").join(" and ");
  }

  /** What covers an endless plane, if the texture is one. */
  get plane(): "tiles" | "noise" | "model" | null {
    const data = this.stage.texture(this.state.texture)?.data;
    if (data?.cells) return "tiles";
    return data?.noise ? "noise" : data?.blocks ? "model" : null;
  }

  /** The ways of showing the texture: some need normals. */
  get modes(): readonly Mode[] {
    const texture = this.stage.texture(this.state.texture);
    return MODES.filter((mode) => knowsMode(texture, mode));
  }

  /** The way of showing a texture: the one chosen where it knows that. */
  modeOf(index: number): Mode {
    return knowsMode(this.stage.texture(index), this.state.mode) ? this.state.mode : "default";
  }

  /** The tool that draws, if one does. */
  get tool(): DrawingTool | null {
    return this.tools[this.tools.length - 1] ?? null;
  }

  isOn(tool: DrawingTool): boolean {
    return this.tools.includes(tool);
  }

  /** Turns a tool on, over others that are, or off; tells which. It draws flat, and with what moved the view or the light. */
  toggleTool(tool: DrawingTool): boolean {
    const at = this.tools.indexOf(tool);
    if (at >= 0) this.tools.splice(at, 1);
    else this.tools.push(tool);
    if (at < 0) this.movesView = false;
    if (at < 0 && this.state.object !== "flat") this.change({ object: "flat" });
    else this.redraw(false);
    return at < 0;
  }

  /** What could not be loaded, in sentences. */
  get failures(): string[] {
    return this.stage.failures;
  }

  /** Calls a function while something has failed, again and again. */
  retryWhile(hasFailed: () => boolean, retry: () => void): void {
    this.onChange(() => {
      if (this.retryTimer !== 0 || !hasFailed()) return;
      this.retryTimer = window.setTimeout(() => {
        this.retryTimer = 0;
        retry();
        this.redraw(false);
      }, RETRY);
    });
  }

  /** Another part of an endless plane, up to a thousand million texels away. */
  goFar(): void {
    const texture = this.stage.texture(this.state.texture);
    const place = (side: number): number => Math.round((Math.random() - 0.5) * 2e9) / side;
    if (texture) this.change({ object: "flat", x: place(texture.width), y: place(texture.height) });
  }

  get hasEnvironment(): boolean {
    return this.stage.texture(this.state.texture)?.data.environment != null;
  }

  /** Whether the graphics card has taken the picture away. */
  get isLost(): boolean {
    return this.stage.isLost;
  }

  /** Before something is made of the picture. */
  expectPicture(): void {
    if (this.isLost) throw new Error("the graphics card has taken the picture away, and the browser has not given it back yet");
  }

  /** Makes something of pictures of one size, whatever becomes of the window. */
  async withFixedSize<T>(make: () => Promise<T>): Promise<T> {
    if (this.isFixed) throw new Error("another film or picture is being made");
    this.expectPicture();
    this.sharpen(1);
    this.isFixed = true;
    try {
      return await make();
    } finally {
      this.isFixed = false;
      this.resize();
    }
  }

  /** After the graphics card has taken the picture away, or given it back. */
  private drawAgain(): void {
    if (!this.isLost) this.stage.forget();
    this.redraw(false);
  }

  /** The name of the user's own object, if there is one. */
  objectName: string | null = null;

  setObject(name: string, geometry: BufferGeometry): void {
    this.objectName = name;
    this.stage.setMesh(geometry);
    this.redraw();
  }

  /** The width of one of the views. */
  viewWidth(width: number): number {
    return this.state.compare === "side" ? width / 2 : width;
  }

  /** Begins a change that can be undone. */
  begin(): void {
    this.history.keep(this.state);
    this.gesture = { kind: "", time: 0 };
  }

  /** Changes the state; changes of the same kind that follow each other closely are one step of undo. */
  change(patch: Partial<ViewState>, kind = ""): void {
    const now = performance.now();
    if (kind === "" || kind !== this.gesture.kind || now - this.gesture.time > GESTURE) this.history.keep(this.state);
    this.gesture = { kind, time: now };
    Object.assign(this.state, patch);
    this.redraw();
  }

  fit(): void {
    const { x, y, zoom, azimuth, elevation, near } = FIRST;
    this.change({ x, y, zoom, azimuth, elevation, near });
  }

  /** Keeps a change of something else than the view, for undo. */
  record(change: Change): void {
    this.history.record(change);
  }

  undo(): void {
    this.restore(this.history.back(this.state));
  }

  redo(): void {
    this.restore(this.history.forth(this.state));
  }

  /** Shows another state, which can be undone; of a texture other than its own where one is given. */
  show(hash: string, texture?: number): void {
    this.history.keep(this.state);
    const state = fromHash(hash, this.titles.length);
    this.restore(texture === undefined ? state : { ...state, texture });
  }

  /** Another way of showing, with its usual amount. */
  showMode(mode: Mode): void {
    this.change({ mode, gain: USUAL_AMOUNTS[mode] ?? this.state.gain });
  }

  nextMode(): void {
    const { modes } = this;
    this.showMode(modes[(modes.indexOf(this.modeOf(this.state.texture)) + 1) % modes.length] ?? "default");
  }

  /** Draws before the next frame of the screen; `moves`: because what is shown changes. */
  redraw(moves = true): void {
    this.moved ||= moves;
    this.tell();
    clearTimeout(this.addressTimer);
    this.addressTimer = window.setTimeout(() => this.writeAddress(), ADDRESS_DELAY);
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame((now) => {
      this.pending = false;
      if (this.moved) this.paceAt(now);
      this.moved = false;
      this.drawIfMade();
    });
  }

  /** Draws half as many pixels across while things move slowly, or a third, and all again when they rest. */
  private paceAt(now: number): void {
    const since = now - this.drawnAt;
    this.drawnAt = now;
    if (this.isExact) return;
    this.slowFrames = since < MOVING ? this.slowFrames + (since > SLOW_FRAME ? 1 : 0) : 0;
    clearTimeout(this.restTimer);
    if (this.slowFrames >= 2) this.sharpen(this.slowFrames < 8 ? 1 / 2 : 1 / 3);
    if (this.share === 1) return;
    this.restTimer = window.setTimeout(() => {
      this.slowFrames = 0;
      this.sharpen(1);
    }, REST);
  }

  /** Pixels of the picture for each of the screen, across: all of them for pictures that are kept. */
  sharpen(share: number): void {
    if (this.share === share) return;
    this.share = share;
    this.resize();
  }

  /** Draws, unless the card still makes what it draws with: then it is asked for another picture when that is there. */
  private drawIfMade(): void {
    const isMade = this.isLost || this.stage.isMade(this.state);
    document.documentElement.dataset["making"] = String(!isMade);
    if (isMade) this.drawNow();
  }

  drawNow(): void {
    if (this.isLost) return;
    const background = getComputedStyle(document.documentElement).getPropertyValue("--ground").trim() || "#101010";
    this.stage.draw(this.state, background);
    document.documentElement.dataset["waiting"] = String(this.stage.waiting);
    document.documentElement.dataset["tiles"] = String(this.stage.pending);
    document.documentElement.dataset["drawn"] = String(Number(document.documentElement.dataset["drawn"] ?? 0) + 1);
  }

  private restore(state: ViewState | null): void {
    if (!state) return;
    this.lamps.orbiting = false;
    this.state = copyOf(state);
    this.redraw();
  }

  resize(): void {
    const box = this.canvas.parentElement?.getBoundingClientRect();
    if (!box || this.isFixed) return;
    this.stage.resize(Math.max(1, box.width), Math.max(1, box.height), Math.min(devicePixelRatio, 2) * this.share);
    document.documentElement.dataset["coarse"] = String(this.share < 1);
    this.redraw(false);
  }

  private writeAddress(): void {
    history.replaceState(null, "", `#${toHash(this.state)}`);
  }

  private readAddress(hash: string): void {
    if (hash === `#${toHash(this.state)}`) return;
    this.show(hash);
  }
}
