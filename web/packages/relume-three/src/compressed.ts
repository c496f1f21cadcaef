import { FieldError } from "./field.js";
import { decodeGreyJpeg } from "./jpeg.js";
import type { HeaderWords } from "./words.js";

/** What the header of a compressed texture map says of its planes. */
export interface CompressedPlanes {
  /** The place of each plane in the order of decoding. */
  places: number[];
  /** The plane to which each is a difference, or -1; and whether that plane is inverted for it. */
  references: number[];
  inverted: boolean[];
  /** Bytes of the picture of each plane, and of its corrections. */
  pictures: number[];
  corrections: number[];
}

/** Bytes of a correction: the index of a texel in the order of the file, and its value. */
const CORRECTION = 5;

/** The lines after the biases of a texture map (HP Labs, version 1.2, compressed formats). */
export function compressedPlanes(words: HeaderWords, count: number): CompressedPlanes {
  words.whole("the quality", -1, 1000);
  const last = count - 1, transforms = words.wholes("a transform", count, 0, 255);
  const motion = words.wholes("a motion", 2 * count, -65536, 65536);
  if (transforms.some((t) => t > 1) || motion.some((m) => m !== 0)) throw new FieldError("the texture map predicts planes by motion, which is not read");
  const places = words.wholes("an order", count, 0, last), references = words.wholes("a reference", count, -1, last);
  if (new Set(places).size !== count) throw new FieldError("the order of the planes of the texture map names one twice");
  references.forEach((from, k) => {
    if (from >= 0 && (places[from] ?? 0) >= (places[k] ?? 0)) throw new FieldError(`plane ${k + 1} of the texture map is predicted from plane ${from + 1}, which is decoded after it`);
  });
  const sizes = (what: string): number[] => words.wholes(what, count, 0, 2 ** 32 - 1);
  const pictures = sizes("a compressed size"), corrections = sizes("a size of side information");
  if (corrections.some((n) => n % CORRECTION)) throw new FieldError(`the side information of the texture map is not a multiple of ${CORRECTION} bytes`);
  return { places, references, inverted: transforms.map((t) => t === 1), pictures, corrections };
}

/** The bytes of each plane, rows in the order of the file. */
export function decompressed(payload: Uint8Array, header: CompressedPlanes, width: number, height: number): Uint8Array[] {
  const { places, references, inverted, pictures, corrections } = header;
  const total = [...pictures, ...corrections].reduce((sum, n) => sum + n, 0);
  if (total !== payload.length) throw new FieldError(`the planes of the texture map need ${total} bytes, found ${payload.length}`);
  let at = 0;
  const take = (length: number): Uint8Array => payload.subarray(at, (at += length));
  const parts = pictures.map((length, k) => ({ picture: take(length), side: take(corrections[k] ?? 0) }));
  const planes: Uint8Array[] = [];
  for (const k of places.map((_, place) => places.indexOf(place))) {
    const decoded = decodeGreyJpeg(parts[k]?.picture ?? new Uint8Array());
    if (decoded.width !== width || decoded.height !== height) throw new FieldError(`plane ${k + 1} of the texture map has ${decoded.width} x ${decoded.height} texels: expected ${width} x ${height}`);
    const plane = decoded.samples, from = planes[references[k] ?? -1], flip = inverted[k] ? 255 : 0;
    // Bytes wrap around.
    if (from) for (let i = 0; i < plane.length; i++) plane[i] = (plane[i] ?? 0) - 128 + ((from[i] ?? 0) ^ flip);
    correct(plane, parts[k]?.side ?? new Uint8Array());
    planes[k] = plane;
  }
  return planes;
}

function correct(plane: Uint8Array, side: Uint8Array): void {
  const view = new DataView(side.buffer, side.byteOffset, side.byteLength);
  for (let at = 0; at < side.length; at += CORRECTION) {
    const texel = view.getUint32(at);
    if (texel >= plane.length) throw new FieldError(`the side information of the texture map names texel ${texel} of ${plane.length}`);
    plane[texel] = view.getUint8(at + 4);
  }
}
