import { type ViewState, copyOf, toHash } from "./state.js";

/** A change of something else than the view, such as of annotations. */
export interface Change {
  undo(): void;
  redo(): void;
}

type Step = ViewState | Change;

/** Steps that are kept. */
const MOST_STEPS = 200;

/** The views before and after the one shown, and what else was changed between them. */
export class History {
  private past: Step[] = [];
  private future: Step[] = [];

  /** Keeps a view that is about to change. */
  keep(state: ViewState): void {
    const last = this.past[this.past.length - 1];
    if (last && !isChange(last) && toHash(last) === toHash(state)) return;
    this.add(copyOf(state));
  }

  /** Keeps a change that was made. */
  record(change: Change): void {
    this.add(change);
  }

  /** Takes the last change back, or gives the view that was before. */
  back(now: ViewState): ViewState | null {
    return this.step(this.past, this.future, now, (change) => change.undo());
  }

  forth(now: ViewState): ViewState | null {
    return this.step(this.future, this.past, now, (change) => change.redo());
  }

  private add(step: Step): void {
    this.past.push(step);
    if (this.past.length > MOST_STEPS) this.past.shift();
    this.future = [];
  }

  private step(from: Step[], to: Step[], now: ViewState, run: (change: Change) => void): ViewState | null {
    let step = from.pop();
    while (step && !isChange(step) && toHash(step) === toHash(now)) step = from.pop();
    if (!step) return null;
    if (isChange(step)) {
      to.push(step);
      run(step);
      return null;
    }
    to.push(copyOf(now));
    return step;
  }
}

function isChange(step: Step): step is Change {
  return "undo" in step;
}
