import { flatScale } from "./parts.js";
import type { Viewer } from "./viewer.js";
import { type ViewState, copyOf } from "./state.js";

/** Pixels along the sides of the parts in which large pictures are drawn. */
const PART = 2048;
/** Pixels of the largest canvas that browsers take. */
const MOST_PIXELS = 1 << 28;

/** The mean colour around a place of the canvas, in linear light from 0 to 1. */
export function linearColorAt(canvas: HTMLCanvasElement, x: number, y: number): [number, number, number] {
  const reach = 2, codes = codesOf(canvas, x - reach, y - reach, 2 * reach + 1, 2 * reach + 1);
  const sum: [number, number, number] = [0, 0, 0];
  for (let i = 0; i < codes.length; i += 4) for (let c = 0; c < 3; c++) sum[c] = (sum[c] ?? 0) + linearOf((codes[i + c] ?? 0) / 255);
  return sum.map((value) => (4 * value) / codes.length) as [number, number, number];
}

/** The codes of a part of the canvas: red, green, blue, opacity. */
export function codesOf(canvas: HTMLCanvasElement, x: number, y: number, width: number, height: number): Uint8ClampedArray {
  const context = sheet(width, height);
  context.drawImage(canvas, -x, -y);
  return context.getImageData(0, 0, width, height).data;
}

function linearOf(code: number): number {
  return code <= 0.04045 ? code / 12.92 : ((code + 0.055) / 1.055) ** 2.4;
}

function sheet(width: number, height: number): CanvasRenderingContext2D {
  const context = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("the browser gives no canvas for the picture");
  return context;
}

/** The whole flat texture as the view lights it, a pixel for each texel, as a PNG. */
export async function textureSnapshot(viewer: Viewer): Promise<Blob> {
  const texture = viewer.stage.texture(viewer.state.texture);
  if (!texture) throw new Error("no texture is loaded");
  const { width, height } = texture;
  if (width * height > MOST_PIXELS) throw new Error(`a picture of ${width} x ${height} pixels is larger than browsers take`);
  const context = sheet(width, height);
  await viewer.withFixedSize(async () => {
    for (let top = 0; top < height; top += PART)
      for (let left = 0; left < width; left += PART) {
        const w = Math.min(PART, width - left), h = Math.min(PART, height - top);
        viewer.stage.resize(w, h, 1);
        const state = partOf(viewer.state, (left + w / 2) / width, (top + h / 2) / height, 1 / flatScale({ zoom: 1, repeat: 1 }, texture, w, h));
        await viewer.stage.settle(state);
        viewer.expectPicture();
        context.drawImage(viewer.canvas, left, top);
      }
  });
  return pngOf(context.canvas);
}

/** The view as it is on the screen, with what is painted over it, as a PNG. */
export async function screenSnapshot(viewer: Viewer, paint: (context: CanvasRenderingContext2D, ratio: number) => void): Promise<Blob> {
  viewer.expectPicture();
  viewer.sharpen(1);
  viewer.drawNow();
  const { canvas } = viewer, context = sheet(canvas.width, canvas.height);
  context.drawImage(canvas, 0, 0);
  paint(context, canvas.width / Math.max(1, canvas.clientWidth));
  return pngOf(context.canvas);
}

/** A state that shows the texture alone about a place, magnified so. */
function partOf(state: ViewState, x: number, y: number, zoom: number): ViewState {
  return { ...copyOf(state), object: "flat", compare: "single", repeat: 1, x, y, zoom };
}

export async function pngOf(canvas: HTMLCanvasElement): Promise<Blob> {
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve));
  if (!blob) throw new Error("the browser gives no picture");
  return blob;
}
