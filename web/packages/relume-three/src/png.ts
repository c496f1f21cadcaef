import { FieldError } from "./field.js";

/** Codes of a PNG of 8 bits: `channels` a texel, rows from the top. */
export interface Codes {
  width: number;
  height: number;
  channels: number;
  codes: Uint8Array;
}

const SIGNATURE = [137, 80, 78, 71, 13, 10, 26, 10];
const CHANNELS: Record<number, number> = { 0: 1, 2: 3, 4: 2, 6: 4 };

/**
 * Decodes a PNG (ISO/IEC 15948) of 8 bits without interlacing. The decoders of browsers convert colours, and canvases
 * may blur what is read from them; coefficients need the codes of the file. A PNG of more than `most` texels is not unpacked.
 */
export async function decodePng(bytes: Uint8Array, most = Infinity): Promise<Codes> {
  if (SIGNATURE.some((byte, i) => bytes[i] !== byte)) throw new FieldError("the file is not a PNG");
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const width = view.getUint32(16), height = view.getUint32(20);
  const channels = CHANNELS[bytes[25] ?? 255];
  if (bytes[24] !== 8 || channels === undefined || bytes[28] !== 0) {
    throw new FieldError("the PNG has other than 8 bits a sample, a palette, or is interlaced");
  }
  if (width * height > most) throw new FieldError(`the PNG is ${width} x ${height} texels: expected ${most} at most`);
  const parts: Uint8Array[] = [];
  for (let at = 8; at + 12 <= bytes.length; ) {
    const length = view.getUint32(at);
    if (at + 12 + length > bytes.length) throw new FieldError("the PNG ends early");
    const name = String.fromCharCode(...bytes.subarray(at + 4, at + 8));
    if (name === "IDAT") parts.push(bytes.subarray(at + 8, at + 8 + length));
    at += 12 + length;
  }
  const stride = width * channels, raw = await inflated(parts, "deflate", height * (stride + 1));
  if (raw.length !== height * (stride + 1)) throw new FieldError("the PNG ends early");
  return { width, height, channels, codes: unfiltered(raw, height, stride, channels) };
}

/**
 * Decompresses zlib (`deflate`) or gzip streams of at most some bytes: a small file may unpack to more than there is memory for.
 */
export async function inflated(parts: Uint8Array[], format: "deflate" | "gzip", most: number): Promise<Uint8Array> {
  const reader = new Blob(parts as Uint8Array<ArrayBuffer>[]).stream().pipeThrough(new DecompressionStream(format)).getReader();
  const chunks: Uint8Array[] = [];
  let length = 0;
  const next = async (): Promise<Uint8Array | undefined> => {
    try {
      return (await reader.read()).value;
    } catch {
      throw new FieldError("the compressed data is damaged");
    }
  };
  for (let chunk = await next(); chunk; chunk = await next()) {
    length += chunk.length;
    if (length > most) {
      await reader.cancel();
      throw new FieldError(`the compressed data unpacks to more than the ${most} bytes that it should have`);
    }
    chunks.push(chunk);
  }
  const out = new Uint8Array(length);
  for (let at = 0, i = 0; i < chunks.length; at += chunks[i]?.length ?? 0, i++) out.set(chunks[i] ?? [], at);
  return out;
}

function unfiltered(raw: Uint8Array, height: number, stride: number, step: number): Uint8Array {
  const out = new Uint8Array(height * stride);
  const none = new Uint8Array(stride);
  for (let y = 0; y < height; y++) {
    const filter = raw[y * (stride + 1)] ?? 0;
    const source = raw.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1));
    const row = out.subarray(y * stride, (y + 1) * stride);
    const above = y === 0 ? none : out.subarray((y - 1) * stride, y * stride);
    unfilterRow(filter, source, row, above, step);
  }
  return out;
}

function unfilterRow(filter: number, source: Uint8Array, row: Uint8Array, above: Uint8Array, step: number): void {
  const predict = PREDICTORS[filter];
  if (predict === undefined) throw new FieldError("the PNG has an unknown filter");
  for (let x = 0; x < row.length; x++) {
    const left = x < step ? 0 : (row[x - step] ?? 0);
    const corner = x < step ? 0 : (above[x - step] ?? 0);
    row[x] = (source[x] ?? 0) + predict(left, above[x] ?? 0, corner);
  }
}

type Predictor = (left: number, up: number, corner: number) => number;

const PREDICTORS: Predictor[] = [
  () => 0,
  (left) => left,
  (_, up) => up,
  (left, up) => (left + up) >> 1,
  paeth,
];

function paeth(left: number, up: number, corner: number): number {
  const estimate = left + up - corner;
  const a = Math.abs(estimate - left), b = Math.abs(estimate - up), c = Math.abs(estimate - corner);
  return a <= b && a <= c ? left : b <= c ? up : corner;
}
