import type { Camera, Scene, WebGLRenderer } from "three";
import type { ReflectanceMaterial } from "relume-three";

/** What takes longer is said, in milliseconds. */
const LONG = 1000;
/** The first picture is asked after so often, in milliseconds. */
const POLL = 50;

/** The programs that the graphics card draws with: it makes each once, and some browsers only with its first picture. */
export class Making {
  /** Whether something has been made for long. */
  isLong = false;
  private readonly made = new Set<string>();
  private readonly running = new Set<string>();
  private timer = 0;
  private isUndrawn = false;

  /** `arrived` is called when a program is there, `told` when `isLong` changes. */
  constructor(private readonly renderer: WebGLRenderer, private readonly arrived: () => void, private readonly told: () => void) {}

  /** Whether what the scene shows can be drawn; it is made otherwise. */
  isReady(material: ReflectanceMaterial, scene: Scene, camera: Camera): boolean {
    const key = `${material.id} ${material.variant}`;
    if (this.made.has(key)) return true;
    if (this.running.has(key)) return false;
    const isMade = (): void => {
      this.made.add(key);
      this.isUndrawn = true;
    };
    // Otherwise the card is waited for when it draws.
    if (!this.renderer.extensions.has("KHR_parallel_shader_compile")) {
      isMade();
      return true;
    }
    this.begin(key);
    void this.renderer.compileAsync(scene, camera).then(() => {
      isMade();
      this.end(key);
      this.arrived();
    });
    return false;
  }

  /** After everything was drawn: waits for the first picture of what was made, without waiting for the card. */
  watch(): void {
    const gl = this.renderer.getContext();
    if (!this.isUndrawn || !(gl instanceof WebGL2RenderingContext)) return;
    this.isUndrawn = false;
    const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), key = "picture";
    if (!sync) return;
    gl.flush();
    this.begin(key);
    const ask = (): void => {
      if (!gl.isContextLost() && gl.getSyncParameter(sync, gl.SYNC_STATUS) === gl.UNSIGNALED) return void setTimeout(ask, POLL);
      gl.deleteSync(sync);
      this.end(key);
    };
    setTimeout(ask, POLL);
  }

  /** The card has lost everything. */
  forget(): void {
    this.made.clear();
  }

  private begin(key: string): void {
    this.running.add(key);
    if (this.timer !== 0) return;
    this.timer = window.setTimeout(() => this.say(true), LONG);
  }

  private end(key: string): void {
    this.running.delete(key);
    if (this.running.size > 0) return;
    clearTimeout(this.timer);
    this.timer = 0;
    if (this.isLong) this.say(false);
  }

  private say(isLong: boolean): void {
    this.isLong = isLong;
    this.told();
  }
}
