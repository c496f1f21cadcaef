// What a state says of materials, lights and the camera.
import { Color, Vector2, Vector3 } from "three";
import { NoiseBlocks, type ReflectanceMaterial, type ReflectanceTexture } from "relume-three";
import { balanceFor } from "./balance.js";
import { type DiskLight, type ViewState, onDisk } from "./state.js";

/** What a state says of any material. */
export function applyState(state: ViewState, material: ReflectanceMaterial): void {
  material.setMode(state.mode, state.gain);
  material.set("exposure", 2 ** state.exposure);
  material.set("gloss", state.gloss);
  material.set("roughness", state.roughness);
  material.set("showCells", state.cells ? 1 : 0);
  material.setBalance(balanceFor([state.whiteX, state.whiteY]));
  material.setEnvironment(state.source === "lamps" ? 0 : state.sky, (state.turn * Math.PI) / 180);
}

/** The lamps that light the texture, those of the state as well where the texture knows no light from all around. */
export function lampsOf({ source, lights }: ViewState, { knowsEnvironment }: ReflectanceMaterial): DiskLight[] {
  return source === "environment" && knowsEnvironment ? [] : lights;
}

/** Shows the first tile alone, or averages instead of noise. */
export function simplify(texture: ReflectanceTexture, material: ReflectanceMaterial, simple: boolean): void {
  material.set("oneTile", simple ? 1 : 0);
  const maker = texture.endless?.maker;
  if (!(maker instanceof NoiseBlocks) || maker.averages === simple) return;
  maker.averages = simple;
  texture.endless?.window.forget();
}

/** The cell of the middle of the view as integers, and the middle relative to it in parts of a tile. */
export function inCells(state: ViewState, texture: ReflectanceTexture, material: ReflectanceMaterial): [number, number] {
  const { right, down } = texture.data.cells ?? { right: [1, 0], down: [0, 1] };
  const [w, t] = right as [number, number], [s, h] = down as [number, number], area = w * h - s * t;
  const x = state.x * texture.width, y = state.y * texture.height;
  const i = Math.floor((x * h - y * s) / area), j = Math.floor((w * y - t * x) / area);
  (material.uniforms["baseCell"]?.value as Vector2).set(i, j);
  return [(x - i * w - j * s) / texture.width, (y - i * t - j * h) / texture.height];
}

/** The unit vector over a place of the disk. */
export function directionOf(light: DiskLight): [number, number, number] {
  const [u, v] = onDisk(light.u, light.v);
  return [u, v, Math.sqrt(1 - u * u - v * v)];
}

export function lamp(light: DiskLight, direction: [number, number, number]) {
  const color = new Color(light.color).multiplyScalar(light.strength);
  return { direction, color: [color.r, color.g, color.b] as [number, number, number], softness: (light.softness * Math.PI) / 180 };
}

/** Right and up in the picture, and the way to the camera (render/scene.rs). */
export function cameraFrame(state: ViewState): { right: Vector3; up: Vector3; back: Vector3 } {
  const a = (state.azimuth * Math.PI) / 180, e = (state.elevation * Math.PI) / 180;
  const back = new Vector3(Math.sin(a) * Math.cos(e), Math.sin(e), Math.cos(a) * Math.cos(e));
  const right = new Vector3(Math.cos(a), 0, -Math.sin(a));
  return { right, up: back.clone().cross(right), back };
}
