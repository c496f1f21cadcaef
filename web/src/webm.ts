/** The codec of the pictures, as WebCodecs and as WebM name it. */
const CODEC = "vp09.00.51.08", TRACK_CODEC = "V_VP9";
/** Bits a second. */
const BITRATE = 12e6;
/** Pictures from one that needs no other to the next. */
const KEY_DISTANCE = 30;
/** Pictures that wait for the encoder. */
const MOST_WAITING = 4;

/** Numbers of colour spaces (ISO/IEC 23091-2) by the names that WebCodecs has for them. */
const MATRICES: Record<string, number> = { rgb: 0, bt709: 1, bt470bg: 5, smpte170m: 6, "bt2020-ncl": 9 };
const TRANSFERS: Record<string, number> = { bt709: 1, smpte170m: 6, linear: 8, "iec61966-2-1": 13 };
const PRIMARIES: Record<string, number> = { bt709: 1, bt470bg: 5, smpte170m: 6, bt2020: 9, smpte432: 12 };
/** The number for what is not said. */
const UNKNOWN = 2;

/** A picture of a film: its bytes, and when it is shown, in milliseconds. */
export interface FilmPicture {
  bytes: Uint8Array;
  time: number;
  isKey: boolean;
}

/** Whether the browser encodes films in this page; it does only where pages are secure. */
export function encodesFilms(): boolean {
  return "VideoEncoder" in window;
}

/** Encodes pictures as a WebM film that has each of them once. */
export class WebmEncoder {
  private readonly pictures: FilmPicture[] = [];
  private fault: Error | null = null;
  private readonly encoder = new VideoEncoder({
    output: (chunk, metadata) => {
      this.colors = metadata?.decoderConfig?.colorSpace ?? this.colors;
      const bytes = new Uint8Array(chunk.byteLength);
      chunk.copyTo(bytes);
      this.pictures.push({ bytes, time: Math.round(chunk.timestamp / 1000), isKey: chunk.type === "key" });
    },
    error: (fault) => (this.fault = fault),
  });
  private given = 0;
  /** How the encoder turned colours into its own. */
  private colors: VideoColorSpaceInit = {};

  private constructor(private readonly canvas: HTMLCanvasElement, private readonly rate: number, private readonly config: VideoEncoderConfig) {
    this.encoder.configure(config);
  }

  /** The film of a canvas without its last column and row where there are odd numbers of them: its colours have half as many. */
  static async open(canvas: HTMLCanvasElement, rate: number): Promise<WebmEncoder> {
    const width = canvas.width & ~1, height = canvas.height & ~1;
    if (width === 0 || height === 0) throw new Error("the picture is too small for a film");
    const config: VideoEncoderConfig = { codec: CODEC, width, height, bitrate: BITRATE, framerate: rate, latencyMode: "quality" };
    const { supported } = await VideoEncoder.isConfigSupported(config);
    if (!supported) throw new Error("this browser encodes no VP9 of this size: choose another kind of file");
    return new WebmEncoder(canvas, rate, config);
  }

  /** Adds what the canvas shows. */
  async add(): Promise<void> {
    const { canvas, rate, config: { width, height } } = this, picture = await createImageBitmap(canvas, 0, 0, width, height);
    const frame = new VideoFrame(picture, { timestamp: Math.round((this.given * 1e6) / rate), duration: Math.round(1e6 / rate) });
    picture.close();
    if (this.encoder.state === "configured") this.encoder.encode(frame, { keyFrame: this.given++ % KEY_DISTANCE === 0 });
    frame.close();
    while (this.encoder.state === "configured" && this.encoder.encodeQueueSize > MOST_WAITING) await new Promise((resolve) => setTimeout(resolve, 5));
    if (this.fault) throw this.fault;
  }

  async finish(): Promise<Blob> {
    if (this.encoder.state === "configured") await this.encoder.flush();
    if (this.fault) throw this.fault;
    this.encoder.close();
    if (this.pictures.length !== this.given) throw new Error(`the browser encoded ${this.pictures.length} of ${this.given} pictures`);
    const { config: { width, height }, colors } = this, length = (1000 * this.given) / this.rate;
    return webmOf(this.pictures, { width, height, length, colors });
  }
}

/** What holds for all pictures of a film. */
export interface FilmShape {
  width: number;
  height: number;
  /** In milliseconds. */
  length: number;
  colors: VideoColorSpaceInit;
}

/** A WebM file (Matroska, RFC 9559) of pictures in the order of their times. */
export function webmOf(pictures: FilmPicture[], { width, height, length, colors }: FilmShape): Blob {
  const head = element(0x1a45dfa3, [
    element(0x4286, number(1)), element(0x42f7, number(1)), element(0x42f2, number(4)), element(0x42f3, number(8)),
    element(0x4282, text("webm")), element(0x4287, number(2)), element(0x4285, number(2)),
  ]);
  // Times count milliseconds.
  const info = element(0x1549a966, [element(0x2ad7b1, number(1e6)), element(0x4489, float(length)), element(0x4d80, text("relume")), element(0x5741, text("relume"))]);
  const video = element(0xe0, [element(0xb0, number(width)), element(0xba, number(height)), colorsOf(colors)]);
  const track = element(0xae, [element(0xd7, number(1)), element(0x73c5, number(1)), element(0x83, number(1)), element(0x86, text(TRACK_CODEC)), video]);
  const segment = element(0x18538067, [info, element(0x1654ae6b, [track]), ...clustersOf(pictures)]);
  return new Blob([head, segment], { type: "video/webm" });
}

function colorsOf({ matrix, transfer, primaries, fullRange }: VideoColorSpaceInit): Bytes {
  const of = (names: Record<string, number>, name: string | null | undefined): Bytes => number(names[name ?? ""] ?? UNKNOWN);
  return element(0x55b0, [
    element(0x55b1, of(MATRICES, matrix)), element(0x55b9, number(fullRange == null ? 0 : fullRange ? 2 : 1)),
    element(0x55ba, of(TRANSFERS, transfer)), element(0x55bb, of(PRIMARIES, primaries)),
  ]);
}

/** A cluster from each picture that needs no other: the times within are differences of 16 bits. */
function clustersOf(pictures: FilmPicture[]): Bytes[] {
  const groups: FilmPicture[][] = [];
  for (const picture of pictures) {
    const group = groups[groups.length - 1];
    if (group && !picture.isKey) group.push(picture);
    else groups.push([picture]);
  }
  return groups.map((group) => {
    const start = group[0]?.time ?? 0;
    return element(0x1f43b675, [element(0xe7, number(start)), ...group.map((picture) => blockOf(picture, picture.time - start))]);
  });
}

function blockOf({ bytes, isKey }: FilmPicture, time: number): Bytes {
  return element(0xa3, joined([Uint8Array.of(0x81, time >> 8, time & 0xff, isKey ? 0x80 : 0), bytes]));
}

type Bytes = Uint8Array<ArrayBuffer>;

/** An element of EBML (RFC 8794): its number, the length of its content in eight bytes, its content. */
function element(id: number, content: Uint8Array | Uint8Array[]): Bytes {
  const bytes = Array.isArray(content) ? joined(content) : content, head = new DataView(new ArrayBuffer(8));
  head.setUint32(0, 0x01000000 + Math.floor(bytes.length / 2 ** 32));
  head.setUint32(4, bytes.length % 2 ** 32);
  return joined([number(id), new Uint8Array(head.buffer), bytes]);
}

/** A whole number in as few bytes as it needs. */
function number(value: number): Bytes {
  const bytes: number[] = [];
  for (let left = value; left > 0 || bytes.length === 0; left = Math.floor(left / 256)) bytes.unshift(left % 256);
  return Uint8Array.from(bytes);
}

function float(value: number): Bytes {
  const view = new DataView(new ArrayBuffer(8));
  view.setFloat64(0, value);
  return new Uint8Array(view.buffer);
}

function text(letters: string): Bytes {
  return new TextEncoder().encode(letters) as Bytes;
}

function joined(parts: Uint8Array[]): Bytes {
  const bytes = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}
