import { MODES, type Mode } from "relume-three";
import { D65 } from "./balance.js";

export const OBJECTS = ["flat", "plane", "sphere", "torus", "cloth", "mesh"] as const;
/** The object is the user's own where the page has one. */
export type ObjectName = (typeof OBJECTS)[number];
/** What lights the texture: lamps, the environment where the page has one, or both. */
export const SOURCES = ["lamps", "environment", "both"] as const;
export type LightSource = (typeof SOURCES)[number];
export const COMPARISONS = ["single", "wipe", "side", "plain"] as const;
export type Comparison = (typeof COMPARISONS)[number];

/**
 * A light over the unit disk of the picture: x right, y up; its colour in sRGB (#rrggbb), its strength, and the degrees from its
 * middle to its rim.
 */
export interface DiskLight {
  u: number;
  v: number;
  color: string;
  strength: number;
  softness: number;
}

export const MOST_SOFTNESS = 45;
/** The greatest strength of a lamp, and of the environment. */
export const MOST_STRENGTH = 8;

/** Everything that decides what is seen; it is what the address holds and what undo goes back to. */
export interface ViewState {
  texture: number;
  other: number;
  object: ObjectName;
  mode: Mode;
  gain: number;
  /** Stops. */
  exposure: number;
  gloss: number;
  roughness: number;
  /** Repetitions relative to the object's own. */
  repeat: number;
  lights: DiskLight[];
  source: LightSource;
  /** The environment: degrees to the right, and strength. */
  turn: number;
  sky: number;
  /** The chromaticity that is shown as neutral. */
  whiteX: number;
  whiteY: number;
  /** The middle of the flat view, in parts of the texture, and its magnification relative to the whole. */
  x: number;
  y: number;
  zoom: number;
  /** The camera around an object, in degrees, and its nearness. */
  azimuth: number;
  elevation: number;
  near: number;
  compare: Comparison;
  /** Where the wipe is, 0 to 1. */
  wipe: number;
  cells: boolean;
  /** The first tile alone; averages instead of noise. */
  simple: boolean;
}

export const FIRST: ViewState = {
  texture: 0, other: 1, object: "flat", mode: "default", gain: 2, exposure: 0, gloss: 0, roughness: 0.4, repeat: 1,
  lights: [{ u: -0.5, v: 0.5, color: "#ffffff", strength: 1, softness: 0 }],
  source: "lamps", turn: 0, sky: 1, whiteX: D65[0], whiteY: D65[1],
  x: 0.5, y: 0.5, zoom: 1, azimuth: 0, elevation: 0, near: 1, compare: "single", wipe: 0.5, cells: false, simple: false,
};

const NUMBERS: [keyof ViewState & string, number, number][] = [
  ["texture", 0, 15], ["other", 0, 15], ["gain", 0, 20], ["exposure", -8, 8], ["gloss", 0, 1], ["roughness", 0.05, 1],
  ["repeat", 0.1, 64], ["x", -1e9, 1e9], ["y", -1e9, 1e9], ["zoom", 0.02, 4096], ["azimuth", -1e6, 1e6],
  ["elevation", -90, 90], ["near", 0.05, 50], ["wipe", 0, 1], ["turn", -360, 360], ["sky", 0, MOST_STRENGTH], ["whiteX", 0.1, 0.7],
  ["whiteY", 0.05, 0.7],
];

export function copyOf(state: ViewState): ViewState {
  return { ...state, lights: state.lights.map((light) => ({ ...light })) };
}

/** The part of an address that restores a view: what differs from the first one. */
export function toHash(state: ViewState): string {
  const words: string[] = [];
  for (const [name] of NUMBERS) if (state[name] !== FIRST[name]) words.push(`${name}=${short(state[name] as number, name === "x" || name === "y" ? 14 : 6)}`);
  for (const name of ["object", "mode", "compare", "source"] as const) if (state[name] !== FIRST[name]) words.push(`${name}=${state[name]}`);
  for (const name of ["cells", "simple"] as const) if (state[name]) words.push(`${name}=1`);
  const lights = state.lights.map(({ u, v, color, strength, softness }) =>
    [short(u), short(v), color.slice(1), short(strength), ...(softness > 0 ? [short(softness)] : [])].join(","),
  );
  words.push(`lights=${lights.join(";")}`);
  return words.join("&");
}

/** A number with some digits: places far away need more than the others. */
function short(value: number, digits = 6): string {
  return String(Number(value.toPrecision(digits)));
}

/** The view of an address; whatever it has that is no view is left out. */
export function fromHash(hash: string, textures: number): ViewState {
  const state = copyOf(FIRST);
  const words = new Map(decoded(hash.replace(/^#/, "")).split("&").map((word) => [word.split("=")[0] ?? "", word.split("=").slice(1).join("=")]));
  for (const [name, least, most] of NUMBERS) {
    const value = Number.parseFloat(words.get(name) ?? "");
    if (Number.isFinite(value)) Object.assign(state, { [name]: Math.min(most, Math.max(least, value)) });
  }
  const member = <T extends string>(name: string, all: readonly T[], or: T): T => all.find((one) => one === words.get(name)) ?? or;
  state.object = member("object", OBJECTS, state.object);
  state.mode = member("mode", MODES, state.mode);
  state.source = member("source", SOURCES, state.source);
  state.compare = member("compare", COMPARISONS, state.compare);
  for (const name of ["cells", "simple"] as const) state[name] = words.get(name) === "1";
  state.texture = Math.min(Math.round(state.texture), textures - 1);
  state.other = Math.min(Math.round(state.other), textures - 1);
  const lights = (words.get("lights") ?? "").split(";").map(lightOf).filter((light) => light !== null);
  if (lights.length > 0) state.lights = lights.slice(0, 4);
  return state;
}

/** As it was before programs on its way wrote its signs as numbers. */
function decoded(text: string): string {
  try {
    return decodeURIComponent(text);
  } catch {
    return text;
  }
}

function lightOf(text: string): DiskLight | null {
  const [u, v, color, strength, softness] = text.split(",");
  const [x, y] = onDisk(Number(u), Number(v));
  if (!Number.isFinite(x) || !Number.isFinite(y) || !/^[0-9a-f]{6}$/i.test(color ?? "")) return null;
  const within = (text: string | undefined, most: number, usual: number): number => {
    const value = Number(text);
    return Number.isFinite(value) ? Math.min(most, Math.max(0, value)) : usual;
  };
  return { u: x, v: y, color: `#${color}`, strength: within(strength, MOST_STRENGTH, 1), softness: within(softness, MOST_SOFTNESS, 0) };
}

/** The nearest place for a light: a little inside the rim, which is the horizon. */
export function onDisk(u: number, v: number): [number, number] {
  const most = 0.995, radius = Math.hypot(u, v);
  return radius > most ? [(u * most) / radius, (v * most) / radius] : [u, v];
}
