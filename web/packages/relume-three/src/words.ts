import { FieldError } from "./field.js";

/** The words of the header of a texture map, whatever white space is between them. */
export class HeaderWords {
  private at = 0;

  constructor(private readonly bytes: Uint8Array) {}

  word(what: string): string {
    const { bytes } = this;
    while (this.at < bytes.length && (bytes[this.at] ?? 0) <= 32) this.at++;
    const start = this.at;
    while (this.at < bytes.length && (bytes[this.at] ?? 0) > 32 && this.at - start < 80) this.at++;
    if (start === this.at) throw new FieldError(`the texture map ends before ${what}`);
    return String.fromCharCode(...bytes.subarray(start, this.at));
  }

  number(what: string): number {
    const text = this.word(what), value = Number(text);
    if (!Number.isFinite(value)) throw new FieldError(`${what} of the texture map is '${text}': expected a number`);
    return value;
  }

  numbers(what: string, count: number): number[] {
    return Array.from({ length: count }, () => this.number(what));
  }

  /** A whole number within a range. */
  whole(what: string, least: number, most: number): number {
    const value = this.number(what);
    if (!Number.isInteger(value) || value < least || value > most) throw new FieldError(`${what} of the texture map is ${value}: expected a whole number from ${least} to ${most}`);
    return value;
  }

  wholes(what: string, count: number, least: number, most: number): number[] {
    return Array.from({ length: count }, () => this.whole(what, least, most));
  }

  /** The byte after the line of the last word. */
  endOfLine(): number {
    while (this.at < this.bytes.length && this.bytes[this.at] !== 10) this.at++;
    return this.at + 1;
  }
}
