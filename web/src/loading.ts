import { UnansweredError, loadMesh } from "relume-three";
import type { Notice } from "./notice.js";
import type { Notes } from "./notes.js";
import { type PageMesh, type PageTexture, meshBytes } from "./page.js";
import type { Viewer } from "./viewer.js";

/** Something that the page consists of. */
interface Piece {
  title: string;
  load(): Promise<void>;
  /** Why it could not be loaded; the page tries again. */
  failure: string | null;
}

/** Loads everything that the page consists of, and again what no server gave. */
export class Loading {
  private readonly pieces: Piece[] = [];
  private faults = 0;
  private isLoading = false;

  constructor(private readonly viewer: Viewer, private readonly textures: PageTexture[], notes: Notes, mesh: PageMesh | null, private readonly notice: Notice) {
    const order = textures.map((_, i) => i).sort((a, b) => Number(b === viewer.state.texture) - Number(a === viewer.state.texture));
    const add = (title: string, load: () => Promise<void>): void => void this.pieces.push({ title, load, failure: null });
    for (const i of order) add(textures[i]?.title ?? "", () => this.loadTexture(i));
    add("annotations", () => notes.load());
    if (mesh) add(mesh.title, async () => viewer.setObject(mesh.title, await loadMesh(await meshBytes(mesh))));
  }

  /** What is missing and asked for again, in sentences. */
  get failures(): string[] {
    return this.pieces.flatMap(({ title, failure }) => (failure === null ? [] : `${title}: ${failure}`));
  }

  /** Loads what is missing. */
  async run(): Promise<void> {
    if (this.isLoading) return;
    this.isLoading = true;
    for (const piece of [...this.pieces]) await this.loadPiece(piece);
    this.isLoading = false;
    document.documentElement.dataset["ready"] = String(this.faults);
    this.viewer.redraw();
  }

  private async loadPiece(piece: Piece): Promise<void> {
    const isLast = (): void => void this.pieces.splice(this.pieces.indexOf(piece), 1);
    try {
      await piece.load();
      isLast();
    } catch (error) {
      piece.failure = error instanceof Error ? error.message : String(error);
      if (error instanceof UnansweredError) return;
      isLast();
      const isNamed = this.textures.some((texture) => texture.error === piece.failure);
      this.faults++;
      this.notice.fail({ title: isNamed ? null : piece.title, sentence: piece.failure });
    }
  }

  private async loadTexture(index: number): Promise<void> {
    const texture = this.textures[index];
    if (!texture) return;
    // What still comes in after a file failed says nothing.
    let isLoading = true;
    const progress = (share: number): void => {
      if (isLoading) this.notice.say([`${texture.title}: ${Math.round(100 * share)} %`]);
    };
    try {
      await this.viewer.load(index, texture, progress);
    } finally {
      isLoading = false;
    }
    document.documentElement.dataset["loaded"] = String(Number(document.documentElement.dataset["loaded"] ?? 0) + 1);
  }
}
