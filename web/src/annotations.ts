/** Left upper corner, width and height, in texels. */
export type Box = [number, number, number, number];

/** A point or a box of the texture with a text, and the view in which it was written; without a box, a bookmark: the name of that view. */
export interface Annotation {
  text: string;
  box?: Box;
  view: string;
}

/** An annotation of a place. */
export type PlacedNote = Annotation & { box: Box };

/** Annotations that are taken away, and others put in their place. */
export interface NoteChange {
  taken: Annotation[];
  put: Annotation[];
  /** Where they are put in the list; at its end where it is shorter. */
  at: number;
}

/** The largest file. The rules are those of the program (`viewer/annotations.rs`). */
export const MOST_BYTES = 1 << 20;
const MOST_ANNOTATIONS = 1000;
const MOST_LETTERS = 8000;
const FARTHEST = 1e15;

/** The annotations of a file; what is none is an error in a sentence. */
export function parseAnnotations(value: unknown): Annotation[] {
  const file = value as { relume?: unknown; version?: unknown; annotations?: unknown } | null;
  const known = ["relume", "version", "annotations"];
  if (file?.relume !== "annotations" || file.version !== 1 || !Array.isArray(file.annotations) || !hasOnly(file, known)) throw new Error("the file holds no annotations");
  return checkedNotes(file.annotations);
}

/** A list of annotations that the program takes as well. */
export function checkedNotes(notes: unknown[]): Annotation[] {
  if (notes.length > MOST_ANNOTATIONS) throw new Error(`there may be ${MOST_ANNOTATIONS} annotations of a texture: found ${notes.length}`);
  return notes.map((one, i) => {
    const wrong = faultOf(one);
    if (wrong !== null) throw new Error(`annotation ${i + 1}: ${wrong}`);
    return one as Annotation;
  });
}

function faultOf(one: unknown): string | null {
  const { text, box, view } = (one ?? {}) as Partial<Annotation>;
  const isNote = typeof text === "string" && typeof view === "string" && (box === undefined || Array.isArray(box));
  if (!isNote || !hasOnly(one as object, ["text", "box", "view"])) return "expected a text, a view, and a box unless it is a bookmark, and nothing else";
  if (Math.max(lettersOf(text), lettersOf(view)) > MOST_LETTERS) return `a text and a view may have ${MOST_LETTERS} letters`;
  const isFar = (n: unknown): boolean => typeof n !== "number" || !(Math.abs(n) <= FARTHEST);
  const isBox = box === undefined || (box.length === 4 && !box.some(isFar) && box[2] >= 0 && box[3] >= 0);
  return isBox ? null : "expected a box of four numbers, left, top, width and height, none beyond 1e15 and no negative size";
}

export function isPlaced(note: Annotation): note is PlacedNote {
  return note.box !== undefined;
}

function hasOnly(object: object, names: string[]): boolean {
  return Object.keys(object).every((name) => names.includes(name));
}

function lettersOf(text: string): number {
  return text.length > MOST_LETTERS ? [...text].length : text.length;
}

export function annotationFile(annotations: Annotation[]): string {
  return JSON.stringify({ relume: "annotations", version: 1, annotations }, null, 2);
}

/** What was changed here and what was changed elsewhere since both were `before`: nothing that either side wrote is lost. */
export function mergedNotes(before: Annotation[], mine: Annotation[], theirs: Annotation[]): Annotation[] {
  const here = without(mine, before);
  return [...without(mine, without(before, theirs)), ...without(without(theirs, before), here)];
}

/** A list after a change. */
export function changedNotes(notes: Annotation[], { taken, put, at }: NoteChange): Annotation[] {
  const left = without(notes, taken);
  return [...left.slice(0, at), ...put, ...left.slice(at)];
}

/** The change that takes another one back. */
export function inverseOf({ taken, put, at }: NoteChange): NoteChange {
  return { taken: put, put: taken, at };
}

export function areSame(a: Annotation[], b: Annotation[]): boolean {
  return a === b || (a.length === b.length && a.every((one, i) => keyOf(one) === keyOf(b[i] as Annotation)));
}

/** Those of a list that are not in another, each as often as it is there more often. */
function without(notes: Annotation[], others: Annotation[]): Annotation[] {
  const counts = new Map<string, number>();
  for (const one of others) counts.set(keyOf(one), (counts.get(keyOf(one)) ?? 0) + 1);
  return notes.filter((one) => {
    const count = counts.get(keyOf(one)) ?? 0;
    counts.set(keyOf(one), count - 1);
    return count <= 0;
  });
}

/** Annotations with the same content are the same. */
function keyOf({ text, box, view }: Annotation): string {
  return JSON.stringify([text, box, view]);
}
