import { el, iconButton } from "./dom.js";
import { listed } from "./words.js";

/** What could not be loaded, and why. */
export interface LoadFault {
  /** Null where the sentence names it. */
  title: string | null;
  sentence: string;
}

/** What goes on, what goes wrong and what went wrong, below the picture. */
export class Notice {
  readonly element = el("div", { class: "notice", role: "status" });
  private lines: string[] = [];
  private faults: LoadFault[] = [];
  private drawn = "";

  /** Says what goes on now, in place of what was said before. */
  say(lines: string[]): void {
    this.lines = lines;
    this.refresh();
  }

  /** Says what will not come, until it is closed. */
  fail(fault: LoadFault): void {
    this.faults.push(fault);
    this.refresh();
  }

  private close(): void {
    this.faults = [];
    this.refresh();
  }

  private refresh(): void {
    const drawn = JSON.stringify([this.faults, this.lines]);
    // Screen readers would say it again.
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const close = iconButton("Close these messages", "M6 6l12 12M18 6L6 18", () => this.close());
    const faults = el("div", { class: "faults" }, el("span", {}, sentencesOf(this.faults).join("\n")), close);
    const text = this.lines.join("\n");
    this.element.replaceChildren(...(this.faults.length > 0 ? [faults] : []), ...(text === "" ? [] : [text]));
  }
}

/** One sentence for all textures with the same fault. */
export function sentencesOf(faults: LoadFault[]): string[] {
  const titles = new Map<string, string[]>();
  for (const { title, sentence } of faults) titles.set(sentence, [...(titles.get(sentence) ?? []), ...(title === null ? [] : [title])]);
  return [...titles].map(([sentence, names]) => (names.length > 0 ? `${listed(names)}: ${sentence}` : sentence));
}
