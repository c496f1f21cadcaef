import { hasClosedForm } from "./basis.js";
import { type FieldData, FieldError, fieldOf } from "./field.js";
import { halvesOfCodes } from "./half.js";

interface RtiHeader {
  width: number;
  height: number;
  terms: number;
  /** Whether a texel holds one luminance and then its colour, instead of three functions. */
  isProduct: boolean;
  scale: number[];
  bias: number[];
  payload: number;
}

/**
 * Hemispherical harmonics of 4, 9 or 16 terms in bytes: an `.rti` file of RTI viewers, or the older `.hsh`. Values are those
 * of the photographs, taken for sRGB-encoded.
 */
export function loadRti(bytes: Uint8Array, title = ""): FieldData {
  const start = afterComments(bytes), header = oldHeader(bytes, start) ?? textHeader(bytes, start);
  const { width, height, terms, isProduct, scale, bias, payload } = header, basis = `hsh${terms}`;
  if (!hasClosedForm(basis)) throw new FieldError(`${terms} harmonics are not read here: expected 4, 9 or 16`);
  const texel = isProduct ? terms + 3 : 3 * terms, texels = width * height, found = bytes.length - payload;
  if (found !== texels * texel) throw new FieldError(`${width} x ${height} texels of ${terms} terms need ${texels * texel} bytes, found ${found}`);
  const planes = Array.from({ length: texel }, (_, k) => {
    const isColor = isProduct && k >= terms;
    const values = halvesOfCodes(isColor ? 1 / 255 : (scale[k % terms] ?? 1) / 255, isColor ? 0 : (bias[k % terms] ?? 0));
    const plane = new Uint16Array(texels);
    for (let i = 0, at = payload + k; i < texels; i++, at += texel) plane[i] = values[bytes[at] ?? 0] ?? 0;
    return plane;
  });
  return fieldOf({ title, width, height, layout: isProduct ? "lrgb" : "rgb", basis, functions: terms, planes });
}

function afterComments(bytes: Uint8Array): number {
  let at = 0;
  while (bytes[at] === 35) {
    const end = bytes.indexOf(10, at);
    if (end < 0) throw new FieldError("the RTI file ends in its comments");
    at = end + 1;
  }
  return at;
}

/** Width, height, 3 and the number of bands as integers, then the least and the greatest values of the terms. */
function oldHeader(bytes: Uint8Array, at: number): RtiHeader | null {
  if (bytes.length < at + 16) return null;
  const view = viewOf(bytes), [width, height, channels, bands] = [0, 4, 8, 12].map((k) => view.getUint32(at + k, true)) as [number, number, number, number];
  const isSide = (n: number): boolean => n >= 1 && n < 1 << 17;
  if (!isSide(width) || !isSide(height) || channels !== 3 || bands < 1 || bands > 5) return null;
  const terms = bands * bands, [low, high] = floats(bytes, at + 16, terms);
  return { width, height, terms, isProduct: false, scale: high.map((value, k) => value - (low[k] ?? 0)), bias: low, payload: at + 16 + 8 * terms };
}

/** Three lines of whole numbers, then the scales and the biases of the terms. */
function textHeader(bytes: Uint8Array, start: number): RtiHeader {
  let at = start;
  const line = (what: string, count: number): number[] => {
    const end = bytes.indexOf(10, at);
    const words = end < 0 || end - at > 200 ? [] : new TextDecoder().decode(bytes.subarray(at, end)).trim().split(/\s+/).map(Number);
    if (words.length !== count || !words.every((n) => Number.isInteger(n) && n >= 0)) throw new FieldError(`the RTI file has no line of ${count} whole numbers, ${what}, at byte ${at}`);
    at = end + 1;
    return words;
  };
  const [type] = line("the type", 1), [width = 0, height = 0, channels] = line("the size", 3), [count = 0, color, element] = line("the terms", 3);
  if (type !== 3) throw new FieldError(`the RTI file has the type ${type}: expected 3, hemispherical harmonics`);
  if (channels !== 3 || element !== 1) throw new FieldError(`the RTI file has ${channels} channels of ${element} bytes a number: expected 3 of 1`);
  if (color !== 1 && color !== 2) throw new FieldError(`the RTI file has colours of kind ${color}: expected 2 (red, green and blue apart) or 1 (luminance times colour)`);
  if (width < 1 || height < 1) throw new FieldError(`the RTI file has ${width} x ${height} texels: expected at least one`);
  const isProduct = color === 1, terms = termsOf(count, bytes.length - at, width * height, isProduct);
  const [scale, bias] = floats(bytes, at, terms);
  return { width, height, terms, isProduct, scale, bias, payload: at + 8 * terms };
}

/** Some writers give the number of bands minus one where that of terms is meant: the length of the file decides. */
function termsOf(count: number, rest: number, texels: number, isProduct: boolean): number {
  const needed = (terms: number): number => 8 * terms + texels * (isProduct ? terms + 3 : 3 * terms);
  const fromBands = (count + 1) ** 2;
  return needed(count) !== rest && needed(fromBands) === rest ? fromBands : count;
}

function floats(bytes: Uint8Array, at: number, terms: number): [number[], number[]] {
  if (terms < 1 || bytes.length < at + 8 * terms) throw new FieldError("the RTI file ends in its scales and biases");
  const view = viewOf(bytes), list = (first: number): number[] => Array.from({ length: terms }, (_, k) => view.getFloat32(first + 4 * k, true));
  const lists: [number[], number[]] = [list(at), list(at + 4 * terms)];
  if (!lists.flat().every(Number.isFinite)) throw new FieldError("the RTI file has scales or biases that are not finite");
  return lists;
}

function viewOf(bytes: Uint8Array): DataView {
  return new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
}
