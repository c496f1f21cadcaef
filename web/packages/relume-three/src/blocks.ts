import { Data3DTexture, HalfFloatType, RGBAFormat, Vector3, type WebGLArrayRenderTarget, type WebGLRenderer } from "three";
import type { BlockMaker } from "./endless.js";
import type { FieldBlocks } from "./field.js";
import type { PlaneBlock, PlaneWindow } from "./window.js";

/** Squares asked for at a time. */
const AT_A_TIME = 3;

/** Squares of an endless plane that come from a source, such as the server of `relume view`. */
export class LoadedBlocks implements BlockMaker {
  readonly side: number;
  private readonly nothing: Data3DTexture;
  private readonly queue: (() => void)[] = [];
  private running = 0;

  /** `layersOf` puts the planes of a square into layers of four values. */
  constructor(private readonly source: FieldBlocks, readonly layers: number, private readonly layersOf: (planes: Uint16Array[]) => Uint16Array[]) {
    this.side = source.side;
    this.nothing = this.data(new Uint16Array(4 * this.side ** 2 * layers));
  }

  async make(renderer: WebGLRenderer, target: WebGLArrayRenderTarget, block: PlaneBlock, window: PlaneWindow): Promise<boolean> {
    this.put(renderer, target, this.nothing, window.placeOf(block));
    await this.turn();
    try {
      if (!window.holds(block)) return false;
      const planes = await this.source.load(block.column, block.row);
      if (!window.holds(block)) return false;
      const texels = this.side ** 2, whole = new Uint16Array(4 * texels * this.layers);
      this.layersOf(planes).forEach((layer, k) => whole.set(layer, 4 * texels * k));
      this.put(renderer, target, this.data(whole), window.placeOf(block));
      return true;
    } finally {
      this.running--;
      this.queue.pop()?.();
    }
  }

  dispose(): void {
    this.queue.length = 0;
  }

  /** Waits until few others are loading; whoever came last goes first. */
  private async turn(): Promise<void> {
    if (this.running >= AT_A_TIME) await new Promise<void>((resolve) => this.queue.push(resolve));
    this.running++;
  }

  private put(renderer: WebGLRenderer, target: WebGLArrayRenderTarget, data: Data3DTexture, [x, y]: [number, number]): void {
    const { texture } = target;
    texture.generateMipmaps = false;
    renderer.copyTextureToTexture(data, texture, null, new Vector3(x, y, 0));
    texture.generateMipmaps = true;
  }

  private data(values: Uint16Array): Data3DTexture {
    const texture = new Data3DTexture(values as Uint16Array<ArrayBuffer>, this.side, this.side, this.layers);
    texture.format = RGBAFormat;
    texture.type = HalfFloatType;
    return texture;
  }
}
