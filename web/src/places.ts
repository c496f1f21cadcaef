import { svg } from "./dom.js";
import { type Part, flatScale, shownParts } from "./parts.js";
import type { ViewState } from "./state.js";
import type { Viewer } from "./viewer.js";

/** Where texels of a picture of the flat view are on the screen; y down. */
export interface FlatPlaces {
  /** What the picture shows, and where. */
  state: ViewState;
  /** The part of the canvas in which it is seen, in CSS pixels. */
  seen: Part;
  /** The size of its texture in texels. */
  size: [number, number];
  /** As that of pictures in general. */
  pace: [number, number];
  /** Texels from the left upper corner of the texture, of a place in CSS pixels from that of the canvas. */
  texel(x: number, y: number): [number, number];
  pixel(x: number, y: number): [number, number];
  /** Pixels of a texel. */
  scale: number;
}

/** The places of all pictures of a view, from the left; none on an object. */
export function flatPlaces({ state: shown, stage, canvas }: Viewer, state: ViewState = shown): FlatPlaces[] {
  if (state.object !== "flat") return [];
  const { clientWidth: width, clientHeight: height } = canvas;
  const parts = shownParts(state, (index) => stage.texture(index), width, height);
  // A texture and its photograph lie on each other.
  const pictures = state.compare === "plain" ? parts.slice(0, 1).map((part) => ({ ...part, seen: part.view })) : parts;
  return pictures.flatMap(({ state: own, view, seen, pace }) => {
    const texture = stage.texture(own.texture);
    if (!texture) return [];
    const scale = flatScale(own, texture, view.width, height);
    const [cx, cy] = [own.x * texture.width, own.y * texture.height], [mx, my] = [view.x + view.width / 2, height / 2];
    return {
      state: own, seen, size: [texture.width, texture.height] as [number, number], pace, scale,
      texel: (x: number, y: number): [number, number] => [cx + (x - mx) / scale, cy + (y - my) / scale],
      pixel: (x: number, y: number): [number, number] => [mx + (x - cx) * scale, my + (y - cy) * scale],
    };
  });
}

/** The number of the picture at a place across the canvas; of none beside them, the nearest. */
export function pictureAt(places: FlatPlaces[], x: number): number {
  const found = places.findIndex(({ seen }) => x < seen.x + seen.width);
  return found < 0 ? places.length - 1 : found;
}

/** The places of the picture under a pointer. */
export function placesUnder(event: { clientX: number }, viewer: Viewer): FlatPlaces | null {
  const places = flatPlaces(viewer);
  return places[pictureAt(places, event.clientX - viewer.canvas.getBoundingClientRect().left)] ?? null;
}

/** The texel under a pointer over the canvas. */
export function texelAt(event: { clientX: number; clientY: number }, canvas: HTMLCanvasElement, places: FlatPlaces): [number, number] {
  const box = canvas.getBoundingClientRect();
  return places.texel(event.clientX - box.left, event.clientY - box.top);
}

/** Drawings over a picture, cut off where it ends. */
export function cutOff({ seen: { x, width } }: FlatPlaces, height: number, drawings: SVGElement[]): SVGElement {
  const [w, h] = [Math.max(1, width), Math.max(1, height)];
  return svg("svg", { x, y: 0, width: w, height: h, viewBox: `${x} 0 ${w} ${h}` }, ...drawings);
}

/** How two textures that are compared are matched, in a sentence; empty where there is nothing to say. */
export function matchOf(viewer: Viewer): string {
  const [first, second] = flatPlaces(viewer);
  if (!first || !second || first.state.texture === second.state.texture) return "";
  const mm = [first, second].map(({ state }) => viewer.stage.texture(state.texture)?.data.mmPerTexel ?? 0), ratio = second.scale / first.scale;
  if (mm[0] && mm[1] && Math.abs(ratio * mm[0] / mm[1] - 1) < 0.005) return "Both are at the same scale in millimetres.";
  if (Math.abs(ratio - 1) < 0.005) return "";
  return `Each is fitted to its part: a texel of the second is drawn ${Number(ratio.toPrecision(3))} times as large.`;
}
