// Archives of files that are compressed already (PKWARE APPNOTE 6.3.3: stored entries).

const TABLE = Uint32Array.from({ length: 256 }, (_, n) => {
  let value = n;
  for (let bit = 0; bit < 8; bit++) value = value & 1 ? 0xedb88320 ^ (value >>> 1) : value >>> 1;
  return value;
});

/** CRC-32 (IEEE 802.3). */
export function crc32(bytes: Uint8Array): number {
  let value = 0xffffffff;
  for (const byte of bytes) value = (TABLE[(value ^ byte) & 255] ?? 0) ^ (value >>> 8);
  return (value ^ 0xffffffff) >>> 0;
}

/** The archive of files by their names. */
export function zipOf(files: [name: string, bytes: Uint8Array<ArrayBuffer>][]): Blob {
  const parts: Uint8Array<ArrayBuffer>[] = [], entries: Uint8Array<ArrayBuffer>[] = [];
  let at = 0;
  for (const [name, bytes] of files) {
    const text = new TextEncoder().encode(name);
    // Version 1.0, names in UTF-8, stored, 1 January 1980.
    const common = [10, 0x800, 0, 0, 0x21, crc32(bytes), bytes.length, bytes.length, text.length, 0];
    const widths = [2, 2, 2, 2, 2, 4, 4, 4, 2, 2];
    const local = numbers([0x04034b50, ...common], [4, ...widths]);
    entries.push(numbers([0x02014b50, 10, ...common, 0, 0, 0, 0, at], [4, 2, ...widths, 2, 2, 2, 4, 4]), text);
    parts.push(local, text, bytes);
    at += local.length + text.length + bytes.length;
  }
  const size = entries.reduce((sum, entry) => sum + entry.length, 0);
  const end = numbers([0x06054b50, 0, 0, files.length, files.length, size, at, 0], [4, 2, 2, 2, 2, 4, 4, 2]);
  return new Blob([...parts, ...entries, end], { type: "application/zip" });
}

/** Little-endian numbers of those widths. */
function numbers(values: number[], widths: number[]): Uint8Array<ArrayBuffer> {
  return Uint8Array.from(values.flatMap((value, i) => Array.from({ length: widths[i] ?? 0 }, (_, k) => (value >>> (8 * k)) & 255)));
}
