import type { StagedTexture } from "./stage.js";
import type { ViewState } from "./state.js";

/** Screen pixels across a strip that would be narrower as a whole: its middle is shown. */
const LEAST_STRIP = 8;

/** A part of the canvas across, in CSS pixels from its left. */
export interface Part {
  x: number;
  width: number;
}

/** A picture in a part of the canvas. */
export interface Shown {
  /** What it shows, and where: its own texture, place and magnification. */
  state: ViewState;
  /** The part for which it is made, and that of it which is seen. */
  view: Part;
  seen: Part;
  /** How far it moves, in parts of its texture, while the first picture moves by one of its own. */
  pace: [number, number];
}

type Textures = (index: number) => StagedTexture | null;
type TextureShape = Pick<StagedTexture, "width" | "height" | "endless">;

/** The pictures of a state: one, or two that are compared. */
export function shownParts(state: ViewState, textures: Textures, width: number, height: number): Shown[] {
  const whole = { x: 0, width };
  if (state.compare === "single") return [{ state, view: whole, seen: whole, pace: [1, 1] }];
  const border = state.compare === "side" ? Math.floor(width / 2) : Math.round(state.wipe * width);
  const [left, right] = [{ x: 0, width: border }, { x: border, width: width - border }];
  const [first, second] = state.compare === "side" ? [left, right] : [whole, whole];
  const beside = state.compare === "plain" ? { state: { ...state, mode: "plain" as const }, pace: [1, 1] as [number, number] } : viewOfOther(state, textures, [first, second], height);
  return [{ state, view: first, seen: left, pace: [1, 1] }, { ...beside, view: second, seen: right }];
}

/** The other texture: at the scale of the first in millimetres where both sizes are known, else as the same part of its whole. */
function viewOfOther(state: ViewState, textures: Textures, [left, right]: [Part, Part], height: number): Pick<Shown, "state" | "pace"> {
  const first = textures(state.texture), other = textures(state.other), asWhole = { ...state, texture: state.other };
  const [mm, mmOfOther] = [first?.data.mmPerTexel, other?.data.mmPerTexel];
  if (!first || !other || !mm || !mmOfOther || state.object !== "flat") return { state: asWhole, pace: [1, 1] };
  const pace: [number, number] = [(first.width * mm) / (other.width * mmOfOther), (first.height * mm) / (other.height * mmOfOther)];
  const { width, height: tall } = other, unit = flatScale({ zoom: 1, repeat: state.repeat }, { width, height: tall, endless: null }, right.width, height);
  const zoom = (flatScale(state, first, left.width, height) * mmOfOther) / mm / unit;
  const [x, y] = [0.5 + (state.x - 0.5) * pace[0], 0.5 + (state.y - 0.5) * pace[1]];
  return { state: { ...asWhole, x, y, zoom }, pace };
}

/** CSS pixels of a texel in the flat view; of an endless plane no more is shown than there is room for, and of a strip no less than can be seen. */
export function flatScale(state: Pick<ViewState, "zoom" | "repeat">, texture: TextureShape, width: number, height: number): number {
  const [across, down] = [width / texture.width, height / texture.height], seen = LEAST_STRIP / Math.min(texture.width, texture.height);
  const whole = Math.max(Math.min(across, down), Math.min(across, seen), Math.min(down, seen));
  const scale = (state.zoom / Math.max(1, state.repeat)) * whole;
  const reach = texture.endless?.reach;
  return reach ? Math.max(scale, width / reach[0], height / reach[1]) : scale;
}
