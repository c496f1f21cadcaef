import { flatScale } from "./stage.js";
import type { Viewer } from "./viewer.js";

/** Where texels of the flat view are on the screen; y down. */
export interface FlatPlaces {
  /** Texels from the left upper corner of the texture, of a place in CSS pixels from that of the canvas. */
  texel(x: number, y: number): [number, number];
  pixel(x: number, y: number): [number, number];
  /** Pixels of a texel. */
  scale: number;
}

/** The places of the view on the left; null without a texture, or on an object. */
export function flatPlaces(viewer: Viewer): FlatPlaces | null {
  const { state, stage, canvas } = viewer, texture = stage.texture(state.texture);
  if (!texture || state.object !== "flat") return null;
  const width = viewer.viewWidth(canvas.clientWidth), height = canvas.clientHeight;
  const scale = flatScale(state, texture, width, height), cx = state.x * texture.width, cy = state.y * texture.height;
  return {
    scale,
    texel: (x, y) => [cx + (x - width / 2) / scale, cy + (y - height / 2) / scale],
    pixel: (x, y) => [width / 2 + (x - cx) * scale, height / 2 + (y - cy) * scale],
  };
}

/** The texel under a pointer over the canvas. */
export function texelAt(event: PointerEvent, canvas: HTMLCanvasElement, places: FlatPlaces): [number, number] {
  const box = canvas.getBoundingClientRect();
  return places.texel(event.clientX - box.left, event.clientY - box.top);
}
