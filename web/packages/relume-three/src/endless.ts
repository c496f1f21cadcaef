import { HalfFloatType, LinearFilter, LinearMipmapLinearFilter, RGBAFormat, RepeatWrapping, type Texture, WebGLArrayRenderTarget, type WebGLRenderer } from "three";
import { type PlaneBlock, type PlaneRect, PlaneWindow, modulo } from "./window.js";

/** The most texels and bytes of a window. */
const MOST_TEXELS = 1 << 21;
const MOST_BYTES = 128 << 20;
/** Rows of a window where it may have as many texels as it likes. */
const ROWS = 1024;
/** Texels around a view that filtering may touch. */
const MARGIN = 8;

/** Makes squares of an endless plane. */
export interface BlockMaker {
  /** The side of a square, which divides 1024. */
  readonly side: number;
  /** Layers of the texture. */
  readonly layers: number;
  /** Draws a square into the texture of a window, or promises to; false from the promise if nobody wants it any more. */
  make(renderer: WebGLRenderer, target: WebGLArrayRenderTarget, block: PlaneBlock, window: PlaneWindow): Promise<boolean> | null;
  dispose(): void;
}

/** The part of an endless plane that is looked at, as a texture with all levels of detail. */
export class EndlessTexture {
  readonly window: PlaneWindow;
  private readonly target: WebGLArrayRenderTarget;
  private pending = 0;
  /** Squares that could not be made, and why. */
  private readonly failed: PlaneBlock[] = [];
  private fault: string | null = null;

  constructor(readonly maker: BlockMaker, anisotropy: number) {
    const texels = Math.min(MOST_TEXELS, MOST_BYTES / (8 * maker.layers));
    const rows = Math.max(maker.side, Math.min(ROWS, 2 ** Math.floor(Math.log2(Math.sqrt(texels)))));
    const width = Math.max(maker.side, Math.floor(texels / rows / maker.side) * maker.side);
    this.window = new PlaneWindow(width, rows, maker.side);
    this.target = new WebGLArrayRenderTarget(width, rows, maker.layers, {
      format: RGBAFormat, type: HalfFloatType, depthBuffer: false, wrapS: RepeatWrapping, wrapT: RepeatWrapping,
      magFilter: LinearFilter, minFilter: LinearMipmapLinearFilter, generateMipmaps: true, anisotropy,
    });
    this.target.texture.mipmapsAutoUpdate = false;
  }

  get texture(): Texture {
    return this.target.texture;
  }

  /** The largest part of the plane that can be seen at once, in texels. */
  get reach(): [number, number] {
    const room = this.window.side + 2 * MARGIN;
    return [Math.max(this.window.width - room, this.window.side / 2), Math.max(this.window.height - room, this.window.side / 2)];
  }

  /** Squares that are still on their way. */
  get waiting(): number {
    return this.pending;
  }

  /** Why squares are missing, in a sentence; null once others have come again. */
  get failure(): string | null {
    return this.fault;
  }

  /** Squares that are missing are asked for again when they are next in view. */
  retry(): void {
    for (const block of this.failed.splice(0)) this.window.forget(block);
  }

  /** Where a texel of the plane lies in the texture, in parts of it. */
  shiftOf(x: number, y: number): [number, number] {
    return [modulo(x, this.window.width) / this.window.width, modulo(y, this.window.height) / this.window.height];
  }

  /** Makes what a view of a part of the plane needs; `arrived` is called whenever more of it is there. */
  cover(renderer: WebGLRenderer, rect: PlaneRect, arrived: () => void): void {
    const around = { x: rect.x - MARGIN, y: rect.y - MARGIN, width: rect.width + 2 * MARGIN, height: rect.height + 2 * MARGIN };
    const blocks = this.window.take(around);
    if (blocks.length === 0) return;
    renderer.initRenderTarget(this.target);
    const state = { target: renderer.getRenderTarget(), clear: renderer.autoClear };
    renderer.autoClear = false;
    for (const block of blocks) {
      const promise = this.maker.make(renderer, this.target, block, this.window);
      if (promise) this.wait(promise, renderer, block, arrived);
    }
    renderer.setRenderTarget(state.target);
    renderer.autoClear = state.clear;
    this.refreshLevels(renderer);
  }

  dispose(): void {
    this.maker.dispose();
    this.target.dispose();
  }

  private wait(promise: Promise<boolean>, renderer: WebGLRenderer, block: PlaneBlock, arrived: () => void): void {
    this.pending++;
    const ended = (): void => void this.pending--;
    promise.then(
      (came) => {
        ended();
        if (came) this.fault = null;
        if (came) this.refreshLevels(renderer);
        arrived();
      },
      (fault: unknown) => {
        ended();
        this.failed.push(block);
        this.fault = fault instanceof Error ? fault.message : String(fault);
        arrived();
      },
    );
  }

  private refreshLevels(renderer: WebGLRenderer): void {
    const gl = renderer.getContext() as WebGL2RenderingContext;
    const { __webglTexture: texture } = renderer.properties.get(this.target.texture) as { __webglTexture?: WebGLTexture };
    if (!texture) return;
    renderer.state.bindTexture(gl.TEXTURE_2D_ARRAY, texture);
    gl.generateMipmap(gl.TEXTURE_2D_ARRAY);
    renderer.state.unbindTexture();
  }
}
