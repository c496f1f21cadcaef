import { UnansweredError, sentenceOf } from "relume-three";
import { type Annotation, MOST_BYTES, type NoteChange, annotationFile, areSame, changedNotes, checkedNotes, mergedNotes, parseAnnotations } from "./annotations.js";
import { besidePage } from "./page.js";

/** The tag of a file that is not there. */
const NO_FILE = '"none"';
/** How often a file may change while it is being written, before that is an error. */
const MOST_TRIES = 20;
/** What is left to do where nothing can be saved any more. */
const REOPEN = "Download them, open the page that it printed, and load them there.";

/** The annotations of a texture, and the file in which the server keeps them, which others may change as well. */
export class NoteSheet {
  notes: Annotation[] = [];
  /** Why they could not be saved, in sentences; null if nothing went wrong. */
  failure: string | null = null;
  /** Whether the server of this page has made way for another: nothing can be saved any more. */
  isCutOff = false;
  /** What the file holds, as far as this page knows, and the server's tag of it. */
  private known: Annotation[] = [];
  private tag: string | null = null;
  private isSaving = false;

  /** `place` is null where the page writes none. */
  constructor(private readonly place: string | null, private readonly changed: () => void, private readonly say: (sentence: string) => void) {}

  /** Whether the server keeps them in a file. */
  get isFiled(): boolean {
    return this.place !== null;
  }

  /** Takes annotations that came with the page, beside those written since it opened. */
  begin(notes: Annotation[]): void {
    this.notes = mergedNotes(this.known, this.notes, notes);
    this.known = notes;
  }

  /** Whether there is something that closing the page would lose. */
  get isUnsaved(): boolean {
    return !areSame(this.notes, this.known);
  }

  /** They are in a file of the user's own. */
  wasDownloaded(): void {
    if (this.place === null) this.known = this.notes;
  }

  /** Reads what is in the file, and keeps what was changed here. */
  async load(): Promise<void> {
    if (this.place === null) return;
    const response = await answerTo(this.place);
    if (!response.ok) throw await this.errorOf(response);
    const tag = response.headers.get("ETag");
    if (tag === this.tag) return;
    const theirs = parseAnnotations(await response.json());
    this.tag = tag;
    if (tag === NO_FILE) {
      // A file that is gone says nothing about what was in it.
      this.known = [];
      return;
    }
    this.notes = mergedNotes(this.known, this.notes, theirs);
    this.known = theirs;
    this.changed();
  }

  /** Changes them here and in the file; an error says why they cannot be changed so. */
  change(change: NoteChange): void {
    const notes = checkedNotes(changedNotes(this.notes, change)), bytes = new Blob([annotationFile(notes)]).size;
    if (bytes > MOST_BYTES) throw new Error(`annotations have at most ${MOST_BYTES} bytes in all: found ${bytes}`);
    this.notes = notes;
    this.changed();
    if (this.place === null) return this.say("Kept until the page is closed: download them to keep them");
    void this.save();
  }

  /** Writes what is not in the file yet; what others wrote meanwhile stays. */
  async save(): Promise<void> {
    if (this.isSaving || this.place === null || !this.isUnsaved) return;
    this.isSaving = true;
    try {
      const isAlone = await this.write(this.place);
      this.failure = null;
      this.say(isAlone ? "Annotations saved beside the texture" : "Annotations saved, with those that were written elsewhere meanwhile");
    } catch (error) {
      const before = this.failure;
      this.failure = `The annotations are not saved: ${(error as Error).message}. ${this.isCutOff ? REOPEN : "The page tries again."}`;
      if (this.failure !== before) this.say(this.failure);
    }
    this.isSaving = false;
    this.changed();
  }

  /** Whether nobody else had changed the file. */
  private async write(place: string): Promise<boolean> {
    const before = this.tag;
    // What others wrote before is no conflict, but part of what is written now.
    await this.load();
    let isAlone = before === null || this.tag === before;
    for (let tries = 0; this.isUnsaved; tries++) {
      const sent = this.notes;
      const headers = { "Content-Type": "application/json", "If-Match": this.tag ?? NO_FILE };
      const response = await answerTo(place, { method: "POST", headers, body: annotationFile(sent) });
      if (response.ok) {
        [this.known, this.tag] = [sent, response.headers.get("ETag")];
        continue;
      }
      if (response.status !== 412 || tries === MOST_TRIES) throw await this.errorOf(response);
      isAlone = false;
      await this.load();
    }
    return isAlone;
  }

  /** What an answer says that is none; a server that does not know the file is another one. */
  private async errorOf(response: Response): Promise<Error> {
    if (![404, 405].includes(response.status)) return new Error(await sentenceOf(response));
    this.isCutOff = true;
    return new Error("another relume view runs at this address now");
  }
}

async function answerTo(place: string, request: RequestInit = {}): Promise<Response> {
  try {
    return await fetch(besidePage(place), request);
  } catch {
    throw new UnansweredError("relume view does not answer, or has ended");
  }
}
