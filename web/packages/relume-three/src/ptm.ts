import { type CompressedPlanes, compressedPlanes, decompressed } from "./compressed.js";
import { type FieldData, FieldError, fieldOf } from "./field.js";
import { fromHalf, halvesFrom, halvesOfPlane } from "./half.js";
import { HeaderWords } from "./words.js";

/** The bytes of a plane: `start`, `start + stride`, ... of some. */
interface Comb {
  bytes: Uint8Array;
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
  compressed: CompressedPlanes | null;
  payload: number;
}

const TERMS = 6, RGB = 18;
/** Planes of bytes of the formats. */
const FORMATS: Record<string, number> = { PTM_FORMAT_RGB: RGB, PTM_FORMAT_LRGB: 9, PTM_FORMAT_LUM: 8, PTM_FORMAT_JPEG_RGB: RGB, PTM_FORMAT_JPEG_LRGB: 9 };

/**
 * A polynomial texture map (`.ptm`, HP Labs, versions 1.0 to 1.2) of the formats RGB, LRGB, LUM, JPEG_RGB and JPEG_LRGB. Values are
 * those of the photographs, taken for sRGB-encoded. Other compressed formats are refused by name.
 */
export function loadPtm(bytes: Uint8Array, title = ""): FieldData {
  const header = parse(bytes), { format, width, height } = header, count = FORMATS[format] ?? 0;
  const combs = combsOf(header, bytes.subarray(header.payload), count);
  const stored = combs.map((comb) => plane(comb, width, height)), range = stored.map((_, k) => steps(header, k, count));
  const planes = stored.map((codes, k) => halvesOfPlane(codes, ...(range[k] ?? [1, 0])));
  const of = { title, width, height, basis: "ptm", functions: TERMS };
  if (format === "PTM_FORMAT_LUM") return fieldOf({ ...of, layout: "rgb", planes: colored(planes, header.matrix) });
  const codes = { planes: stored, scale: range.map(([scale]) => scale), offset: range.map(([, offset]) => offset) };
  return fieldOf({ ...of, layout: count === RGB ? "rgb" : "lrgb", planes, codes });
}

function parse(bytes: Uint8Array): PtmHeader {
  const words = new HeaderWords(bytes), version = words.word("the version");
  if (!/^PTM_1\.[012]$/.test(version)) throw new FieldError(`the texture map has version '${version}': expected PTM_1.0, PTM_1.1 or PTM_1.2`);
  const format = words.word("the format");
  if (!Object.hasOwn(FORMATS, format)) throw new FieldError(`texture maps of the format ${format} are not read: expected PTM_FORMAT_RGB or PTM_FORMAT_LRGB, plain or as JPEG, or PTM_FORMAT_LUM`);
  const width = words.whole("the width", 1, 1 << 20), height = words.whole("the height", 1, 1 << 20);
  const scale = words.numbers("a scale", TERMS), bias = words.numbers("a bias", TERMS);
  const matrix = format === "PTM_FORMAT_LUM" ? words.numbers("a matrix entry", 16) : [];
  const compressed = format.includes("JPEG") ? compressedPlanes(words, FORMATS[format] ?? 0) : null;
  return { format, interleaved: version !== "PTM_1.2", width, height, scale, bias, matrix, compressed, payload: words.endOfLine() };
}

function combsOf(header: PtmHeader, payload: Uint8Array, count: number): Comb[] {
  const { width, height, compressed } = header, texels = width * height;
  if (compressed) return decompressed(payload, compressed, width, height).map((bytes) => ({ bytes, start: 0, stride: 1 }));
  if (payload.length !== texels * count) throw new FieldError(`${width} x ${height} texels need ${texels * count} bytes of coefficients, found ${payload.length}`);
  return Array.from({ length: count }, (_, k) => ({ bytes: payload, ...combOf(header, k, count) }));
}

function combOf({ interleaved, width, height }: PtmHeader, k: number, count: number): Pick<Comb, "start" | "stride"> {
  const texels = width * height;
  if (count === RGB) return { start: Math.floor(k / TERMS) * TERMS * texels + (k % TERMS), stride: TERMS };
  if (interleaved) return { start: k, stride: count };
  return k < TERMS ? { start: k, stride: TERMS } : { start: TERMS * texels + k - TERMS, stride: count - TERMS };
}

/** The codes of a plane; the rows of a file run from the bottom. */
function plane({ bytes, start, stride }: Comb, width: number, height: number): Uint8Array {
  const out = new Uint8Array(width * height);
  for (let y = 0, i = 0; y < height; y++) {
    let at = start + (height - 1 - y) * width * stride;
    for (let x = 0; x < width; x++, at += stride) out[i++] = bytes[at] ?? 0;
  }
  return out;
}

/** Scale and offset of the codes of a plane, with white at 1. */
function steps(header: PtmHeader, k: number, count: number): [scale: number, offset: number] {
  if (count !== RGB && k >= TERMS) return [1 / 255, 0];
  const scale = (header.scale[k % TERMS] ?? 1) / 255;
  return [scale, -scale * (header.bias[k % TERMS] ?? 0)];
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
