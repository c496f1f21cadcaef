import { hasClosedForm } from "./basis.js";
import { type FieldData, FieldError, type FieldLayout, fieldOf } from "./field.js";
import { halvesOfCodes } from "./half.js";
import type { FileSource } from "./share.js";
import { type JpegDecoder, planeReader } from "./tiling.js";

interface WebInfo {
  width: number;
  height: number;
  type: string;
  colorspace: string;
  nplanes: number;
  format?: string;
  colorprofile?: string;
  pixelSizeInMM?: number;
  materials: { scale: number[]; bias: number[] }[];
}

/** The stored functions 1, u, v, u^2, uv, v^2 in the order u^2, v^2, uv, u, v, 1. */
const PTM_ORDER = [3, 5, 4, 1, 2, 0];

/**
 * A web folder of Relight: `info.json` and JPEG planes, whole (`plain`) or in tiles (`deepzoom`, `tarzoom`, `itarzoom`), of the types
 * `ptm` (6 functions) and `hsh` (4, 9 or 16) and the colours `rgb` and `lrgb`. Other types are refused by name.
 */
export async function loadWebFolder(source: FileSource, decode: JpegDecoder = decodeInBrowser): Promise<FieldData> {
  const info = parse(new TextDecoder().decode(await source("info.json")));
  const { width, height, nplanes } = info, isProduct = info.colorspace === "lrgb";
  const functions = isProduct ? nplanes - 3 : nplanes / 3, basis = info.type === "ptm" ? "ptm" : `hsh${functions}`;
  if (info.type === "ptm" ? functions !== PTM_ORDER.length : !hasClosedForm(basis)) throw new FieldError(`folders of ${functions} functions of the type ${info.type} are not read here`);
  const count = Math.ceil(nplanes / 3), read = await planeReader(source, width, height, count, decode);
  const pictures = await Promise.all(Array.from({ length: count }, async (_, j) => coefficients(await read(j), j, info)));
  const stored = (k: number): Uint16Array => pictures[Math.floor(k / 3)]?.[k % 3] ?? new Uint16Array(width * height);
  const order = (k: number): number => (info.type === "ptm" ? (PTM_ORDER[k] ?? 0) : k);
  const range = Array.from({ length: functions }, (_, k) => order(k));
  const planes = isProduct
    ? [...range.map((k) => stored(3 + k)), ...[0, 1, 2].map(stored)]
    : [0, 1, 2].flatMap((channel) => range.map((k) => stored(3 * k + channel)));
  const layout: FieldLayout = isProduct ? "lrgb" : "rgb", space = info.colorprofile === "RGB" ? "linear" : "srgb";
  return fieldOf({ title: "", width, height, layout, basis, functions, planes, space, mmPerTexel: info.pixelSizeInMM || null });
}

function parse(text: string): WebInfo {
  let info: WebInfo;
  try {
    info = JSON.parse(text) as WebInfo;
  } catch {
    throw new FieldError("info.json is not JSON");
  }
  if (!["ptm", "hsh"].includes(info?.type)) throw new FieldError(`the folder holds functions of the type ${String(info?.type)}: expected ptm or hsh`);
  if (!["rgb", "lrgb"].includes(info.colorspace)) throw new FieldError(`the folder holds colours of the kind ${String(info.colorspace)}: expected rgb or lrgb`);
  if (!["jpg", "jpeg", undefined].includes(info.format)) throw new FieldError(`the planes of the folder are ${info.format} files: expected jpg`);
  const isSide = (n: unknown): boolean => Number.isInteger(n) && (n as number) >= 1 && (n as number) <= 1 << 20;
  if (!isSide(info.width) || !isSide(info.height) || !isSide(info.nplanes)) throw new FieldError("info.json has no width, height or nplanes");
  const { scale, bias } = info.materials?.[0] ?? {};
  const isList = (list: unknown): boolean => Array.isArray(list) && list.length >= info.nplanes && list.every(Number.isFinite);
  if (!isList(scale) || !isList(bias)) throw new FieldError(`info.json has no scale and bias for each of ${info.nplanes} coefficients`);
  return info;
}

/** The three coefficients of a picture as half floats: (texture - bias) scale. */
function coefficients(samples: Uint8Array, j: number, info: WebInfo): Uint16Array[] {
  return [0, 1, 2].map((c) => {
    const k = 3 * j + c, scale = info.materials[0]?.scale[k] ?? 1, values = halvesOfCodes(scale / 255, -scale * (info.materials[0]?.bias[k] ?? 0));
    const plane = new Uint16Array(info.width * info.height);
    for (let i = 0; i < plane.length; i++) plane[i] = values[samples[3 * i + c] ?? 0] ?? 0;
    return plane;
  });
}

/** The decoder of the browser, without a conversion of colours. */
async function decodeInBrowser(bytes: Uint8Array): ReturnType<JpegDecoder> {
  const image = await createImageBitmap(new Blob([bytes as Uint8Array<ArrayBuffer>], { type: "image/jpeg" }), { colorSpaceConversion: "none", premultiplyAlpha: "none" });
  const { width, height } = image, context = new OffscreenCanvas(width, height).getContext("2d");
  if (!context) throw new FieldError("this browser decodes no JPEG planes");
  context.drawImage(image, 0, 0);
  return { width, height, data: context.getImageData(0, 0, width, height).data };
}
