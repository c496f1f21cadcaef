import { type FieldData, FieldError, fieldOf } from "./field.js";
import { fromHalf, halvesFrom, halvesOfCodes } from "./half.js";

/** The bytes of a plane: `start`, `start + stride`, ... */
interface Comb {
  start: number;
  stride: number;
}

interface PtmHeader {
  format: string;
  interleaved: boolean;
  width: number;
  height: number;
  scale: number[];
  bias: number[];
  matrix: number[];
  payload: number;
}

const TERMS = 6;
const FORMATS: Record<string, number> = { PTM_FORMAT_RGB: 18, PTM_FORMAT_LRGB: 9, PTM_FORMAT_LUM: 8 };

/**
 * A polynomial texture map (`.ptm`, HP Labs, versions 1.0 to 1.2) of the formats RGB, LRGB and LUM. Values are those of the
 * photographs, taken for sRGB-encoded. Compressed formats are refused by name: `relume convert` makes plain ones of them.
 */
export function loadPtm(bytes: Uint8Array, title = ""): FieldData {
  const header = parse(bytes), { format, width, height } = header, texels = width * height, count = FORMATS[format] ?? 0;
  const found = bytes.length - header.payload;
  if (found !== texels * count) throw new FieldError(`${width} x ${height} texels need ${texels * count} bytes of coefficients, found ${found}`);
  const planes = Array.from({ length: count }, (_, k) => plane(bytes, header, k));
  if (format === "PTM_FORMAT_LUM") return fieldOf({ title, width, height, layout: "rgb", basis: "ptm", functions: TERMS, planes: colored(planes, header.matrix) });
  return fieldOf({ title, width, height, layout: format === "PTM_FORMAT_RGB" ? "rgb" : "lrgb", basis: "ptm", functions: TERMS, planes });
}

/** The words of the header, whatever white space is between them, and the byte after the line of the last one. */
function parse(bytes: Uint8Array): PtmHeader {
  let at = 0;
  const word = (what: string): string => {
    while (at < bytes.length && (bytes[at] ?? 0) <= 32) at++;
    const start = at;
    while (at < bytes.length && (bytes[at] ?? 0) > 32 && at - start < 80) at++;
    if (start === at) throw new FieldError(`the texture map ends before ${what}`);
    return String.fromCharCode(...bytes.subarray(start, at));
  };
  const number = (what: string): number => {
    const text = word(what), value = Number(text);
    if (!Number.isFinite(value)) throw new FieldError(`${what} of the texture map is '${text}': expected a number`);
    return value;
  };
  const numbers = (what: string, count: number): number[] => Array.from({ length: count }, () => number(what));
  const side = (what: string): number => {
    const value = number(what);
    if (!Number.isInteger(value) || value < 1 || value > 1 << 20) throw new FieldError(`${what} of the texture map is ${value}: expected a whole number from 1 on`);
    return value;
  };
  const version = word("the version");
  if (!/^PTM_1\.[012]$/.test(version)) throw new FieldError(`the texture map has version '${version}': expected PTM_1.0, PTM_1.1 or PTM_1.2`);
  const format = word("the format");
  if (!Object.hasOwn(FORMATS, format)) throw new FieldError(`texture maps of the format ${format} are not read here: relume convert makes one of PTM_FORMAT_RGB or PTM_FORMAT_LRGB`);
  const width = side("the width"), height = side("the height"), scale = numbers("a scale", TERMS), bias = numbers("a bias", TERMS);
  const matrix = format === "PTM_FORMAT_LUM" ? numbers("a matrix entry", 16) : [];
  while (at < bytes.length && bytes[at] !== 10) at++;
  return { format, interleaved: version !== "PTM_1.2", width, height, scale, bias, matrix, payload: at + 1 };
}

function combOf({ format, interleaved, width, height }: PtmHeader, k: number): Comb {
  const texels = width * height, count = FORMATS[format] ?? 0;
  if (format === "PTM_FORMAT_RGB") return { start: Math.floor(k / TERMS) * TERMS * texels + (k % TERMS), stride: TERMS };
  if (interleaved) return { start: k, stride: count };
  return k < TERMS ? { start: k, stride: TERMS } : { start: TERMS * texels + k - TERMS, stride: count - TERMS };
}

/** A plane as half floats with white at 1; the rows of a file run from the bottom. */
function plane(bytes: Uint8Array, header: PtmHeader, k: number): Uint16Array {
  const { format, width, height } = header, { start, stride } = combOf(header, k);
  const isColor = format !== "PTM_FORMAT_RGB" && k >= TERMS, term = k % TERMS;
  const scale = isColor ? 1 / 255 : (header.scale[term] ?? 1) / 255;
  const values = halvesOfCodes(scale, isColor ? 0 : -scale * (header.bias[term] ?? 0));
  const out = new Uint16Array(width * height);
  for (let y = 0, i = 0; y < height; y++) {
    let at = header.payload + start + (height - 1 - y) * width * stride;
    for (let x = 0; x < width; x++, at += stride) out[i++] = values[bytes[at] ?? 0] ?? 0;
  }
  return out;
}

/** Red, green and blue of luminance and two colour differences: the rows of the matrix times (L, Cr, Cb, 1). */
function colored(planes: Uint16Array[], matrix: number[]): Uint16Array[] {
  const [cr, cb] = [6, 7].map((k) => Float32Array.from(planes[k] ?? [], fromHalf));
  return [0, 1, 2].flatMap((channel) => {
    const [l = 0, r = 0, b = 0, one = 0] = matrix.slice(4 * channel, 4 * channel + 4);
    return planes.slice(0, TERMS).map((plane, k) => {
      const constant = (i: number): number => (k === TERMS - 1 ? r * (cr?.[i] ?? 0) + b * (cb?.[i] ?? 0) + one / 255 : 0);
      return halvesFrom(Float32Array.from(plane, (value, i) => l * fromHalf(value) + constant(i)));
    });
  });
}
