import { FieldError } from "./field.js";

/** Samples of a grey picture, rows from the top. */
export interface GreySamples {
  width: number;
  height: number;
  samples: Uint8Array;
}

/** A Huffman code: for each length the first code, and the place of its symbol. */
interface Code {
  symbols: Uint8Array;
  /** One more than the last code of each length, aligned to 16 bits. */
  limits: Int32Array;
  offsets: Int32Array;
}

interface Frame {
  width: number;
  height: number;
  /** The number of its table of steps. */
  table: number;
}

/**
 * Decodes a grey baseline JPEG (ITU-T T.81, 8 bits, Huffman codes) to the same samples as the library. Planes of texture maps are
 * predicted from one another modulo 256: one sample that another decoder rounds up instead of down may come out as 0 instead of 255.
 */
export function decodeGreyJpeg(bytes: Uint8Array): GreySamples {
  if (bytes[0] !== 0xff || bytes[1] !== 0xd8) throw new FieldError("the plane is not a JPEG picture");
  const steps: Uint16Array[] = [], codes: Code[][] = [[], []];
  let frame: Frame | null = null, interval = 0;
  for (let at = 2; ; ) {
    while (bytes[at] === 0xff && bytes[at + 1] === 0xff) at++;
    const marker = bytes[at + 1] ?? 0, length = word(bytes, at + 2), part = bytes.subarray(at + 4, at + 2 + length);
    if (bytes[at] !== 0xff || length < 2 || part.length !== length - 2) throw new FieldError("the JPEG picture ends early");
    if (marker === 0xdb) readSteps(part, steps);
    else if (marker === 0xc4) readCodes(part, codes);
    else if (marker === 0xc0 || marker === 0xc1) frame = frameOf(part);
    else if (marker >= 0xc2 && marker <= 0xcf && marker !== 0xcc && marker !== 0xc8) throw new FieldError("the JPEG picture is progressive or lossless: expected a baseline one");
    else if (marker === 0xdd) interval = word(part, 0);
    at += 2 + length;
    if (marker !== 0xda) continue;
    const [direct, alternating] = [codes[0]?.[(part[2] ?? 0) >> 4], codes[1]?.[(part[2] ?? 0) & 15]], table = steps[frame?.table ?? -1];
    if (!frame || !table || !direct || !alternating || part[0] !== 1) throw new FieldError("the JPEG picture lacks a part of its header");
    return scan(new ScanBits(bytes, at), frame, table, direct, alternating, interval);
  }
}

function word(bytes: Uint8Array, at: number): number {
  return ((bytes[at] ?? 0) << 8) | (bytes[at + 1] ?? 0);
}

/** The order in which the frequencies of a block are stored, as places row after row. */
const ZIGZAG = Uint8Array.from(Array.from({ length: 64 }, (_, i) => i).sort((a, b) => {
  const place = (i: number): number => {
    const x = i & 7, y = i >> 3;
    return (x + y) * 8 + ((x + y) % 2 ? y : x);
  };
  return place(a) - place(b);
}));

function readSteps(part: Uint8Array, steps: Uint16Array[]): void {
  for (let at = 0; at < part.length; ) {
    const kind = part[at++] ?? 0, wide = kind >> 4, table = new Uint16Array(64);
    for (let k = 0; k < 64; k++, at += 1 + wide) table[k] = wide ? word(part, at) : (part[at] ?? 0);
    steps[kind & 3] = table;
  }
}

function readCodes(part: Uint8Array, codes: Code[][]): void {
  for (let at = 0; at < part.length; ) {
    const kind = part[at] ?? 0, counts = part.subarray(at + 1, at + 17), total = counts.reduce((sum, n) => sum + n, 0);
    const limits = new Int32Array(17), offsets = new Int32Array(17);
    for (let length = 1, code = 0, first = 0; length <= 16; length++) {
      const count = counts[length - 1] ?? 0;
      offsets[length] = first - code;
      code += count;
      first += count;
      limits[length] = code << (16 - length);
      code <<= 1;
    }
    const table = codes[(kind >> 4) & 1];
    if (table) table[kind & 15] = { symbols: part.subarray(at + 17, at + 17 + total), limits, offsets };
    at += 17 + total;
  }
}

function frameOf(part: Uint8Array): Frame {
  const height = word(part, 1), width = word(part, 3);
  if (part[0] !== 8 || part[5] !== 1) throw new FieldError("the JPEG picture is not grey of 8 bits");
  if (!width || !height) throw new FieldError("the JPEG picture lacks a part of its header");
  return { width, height, table: part[8] ?? 0 };
}

/** Bits of a scan, where a 0 follows each byte of 255. */
class ScanBits {
  private window = 0;
  private count = 0;

  constructor(private readonly bytes: Uint8Array, private at: number) {}

  private fill(): void {
    while (this.count <= 16) {
      const byte = this.bytes[this.at] ?? 0, isMarker = byte === 0xff && this.bytes[this.at + 1] !== 0;
      // Past the end come zeros; a block that needs them is refused.
      if (isMarker || this.at >= this.bytes.length) this.window <<= 8;
      else {
        this.window = (this.window << 8) | byte;
        this.at += byte === 0xff ? 2 : 1;
        this.real += 8;
      }
      this.count += 8;
    }
  }

  /** Bits of the file that are left in the window. */
  private real = 0;

  bits(length: number): number {
    if (length === 0) return 0;
    this.fill();
    return this.take(length, (this.window >> (this.count - length)) & ((1 << length) - 1));
  }

  symbol({ symbols, limits, offsets }: Code): number {
    this.fill();
    const next = (this.window >> (this.count - 16)) & 0xffff;
    for (let length = 1; length <= 16; length++)
      if (next < (limits[length] ?? 0)) return this.take(length, symbols[(next >> (16 - length)) + (offsets[length] ?? 0)] ?? 0);
    throw new FieldError("the JPEG picture is damaged: it has a code that it does not define");
  }

  private take(length: number, value: number): number {
    this.count -= length;
    this.real -= length;
    if (this.real < 0) throw new FieldError("the JPEG picture ends early");
    return value;
  }

  /** Goes on after the next marker, which should be that of an interval. */
  restart(): void {
    if (this.bytes[this.at] !== 0xff || ((this.bytes[this.at + 1] ?? 0) & 0xf8) !== 0xd0) throw new FieldError("the JPEG picture is damaged: a marker of an interval is missing");
    this.at += 2;
    this.window = this.count = this.real = 0;
  }
}

function scan(bits: ScanBits, { width, height }: Frame, steps: Uint16Array, direct: Code, alternating: Code, interval: number): GreySamples {
  const across = (width + 7) >> 3, down = (height + 7) >> 3;
  const samples = new Uint8Array(width * height), block = new Int32Array(64);
  const signed = (size: number): number => {
    const value = bits.bits(size);
    return size > 0 && value < 1 << (size - 1) ? value - (1 << size) + 1 : value;
  };
  for (let i = 0, mean = 0; i < across * down; i++) {
    if (interval && i && i % interval === 0) {
      bits.restart();
      mean = 0;
    }
    block.fill(0);
    mean += signed(bits.symbol(direct) & 15);
    block[0] = mean * (steps[0] ?? 0);
    for (let k = 1; k < 64; k++) {
      const symbol = bits.symbol(alternating), size = symbol & 15;
      if (size === 0 && symbol !== 0xf0) break;
      k += symbol >> 4;
      block[ZIGZAG[k] ?? 63] = signed(size) * (steps[k] ?? 0);
    }
    transform(block);
    store(block, samples, width, height, 8 * (i % across), 8 * Math.floor(i / across));
  }
  return { width, height, samples };
}

function store(block: Int32Array, samples: Uint8Array, width: number, height: number, left: number, top: number): void {
  const right = Math.min(8, width - left), bottom = Math.min(8, height - top);
  for (let y = 0; y < bottom; y++)
    for (let x = 0; x < right; x++) samples[(top + y) * width + left + x] = Math.min(255, Math.max(0, block[8 * y + x] ?? 0));
}

/** sqrt 2 cos(k pi / 16) in 4096ths, for the odd frequencies at four places, with the roundings of the library's decoder. */
const ODD = [[5683, 4816, 3219, 1131], [4816, -1129, -5681, -3218], [3219, -5681, 1132, 4816], [1131, -3218, 4816, -5680]] as const;

/** The inverse cosine transform: columns to an eighth of a step, then rows to whole ones around 128. */
function transform(block: Int32Array): void {
  for (let x = 0; x < 8; x++) line(block, x, 8, 512, 10);
  for (let y = 0; y < 8; y++) line(block, 8 * y, 1, 65536 + (128 << 17) + 512, 17);
}

function line(block: Int32Array, at: number, step: number, half: number, shift: number): void {
  const value = (k: number): number => block[at + k * step] ?? 0;
  const [c1, c3, c5, c7] = [value(1), value(3), value(5), value(7)], [c2, c6] = [value(2), value(6)];
  const sum = ((value(0) + value(4)) << 12) + half, difference = ((value(0) - value(4)) << 12) + half;
  const wide = 5352 * c2 + 2217 * c6, narrow = 2217 * c2 - 5350 * c6;
  const even = [sum + wide, difference + narrow, difference - narrow, sum - wide];
  ODD.forEach(([a, b, c, d], i) => {
    const odd = a * c1 + b * c3 + c * c5 + d * c7, of = even[i] ?? 0;
    block[at + i * step] = (of + odd) >> shift;
    block[at + (7 - i) * step] = (of - odd) >> shift;
  });
}
