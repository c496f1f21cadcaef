import { type DiskLight, FIRST, onDisk } from "./state.js";
import type { Viewer } from "./viewer.js";

const ORBIT_SECONDS = 8;
const MOST_LIGHTS = 4;
const STEPS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** The lamps of a view, and the one that controls change. */
export class Lamps {
  /** Whether the chosen one goes round; views that are restored end that, since they say where it is. */
  orbiting = false;
  private index = 0;

  constructor(private readonly viewer: Viewer) {}

  /** The number of the light that controls change. */
  get chosen(): number {
    return Math.min(this.index, this.all.length - 1);
  }

  set chosen(index: number) {
    this.index = index;
  }

  get light(): DiskLight {
    return this.all[this.chosen] ?? { ...(FIRST.lights[0] as DiskLight) };
  }

  /** Changes the chosen light: as a step of its own for undo, or within one that has begun. */
  change(patch: Partial<DiskLight>, keep = true): void {
    const { viewer, chosen } = this, lights = this.all.map((light, i) => (i === chosen ? { ...light, ...patch } : light));
    if (keep) return viewer.change({ lights }, "light");
    viewer.state.lights = lights;
    viewer.redraw();
  }

  add(): void {
    if (this.all.length >= MOST_LIGHTS) return;
    const [u, v] = freePlace(this.all, this.light);
    this.chosen = this.all.length;
    this.viewer.change({ lights: [...this.all, { u, v, color: "#ffffff", strength: 0.6, softness: 0 }] });
  }

  remove(): void {
    if (this.all.length < 2) return;
    const { chosen } = this;
    this.viewer.change({ lights: this.all.filter((_, i) => i !== chosen) });
    this.chosen = 0;
  }

  /** Warm and cool light from opposite sides, twenty degrees high: shows relief without regard to colour. */
  rakingPair(): void {
    const u = Math.cos((20 * Math.PI) / 180);
    const one = (u: number, color: string): DiskLight => ({ u, v: 0, color, strength: 1, softness: 0 });
    this.chosen = 0;
    this.viewer.change({ lights: [one(-u, "#ffb37a"), one(u, "#7ab3ff")] });
  }

  /** The light goes around as it is, once in eight seconds. */
  toggleOrbit(): void {
    this.orbiting = !this.orbiting;
    if (this.orbiting) this.viewer.begin();
    this.viewer.redraw();
    if (!this.orbiting) return;
    let before = performance.now();
    const step = (now: number): void => {
      if (!this.orbiting) return;
      const angle = ((now - before) / 1000 / ORBIT_SECONDS) * 2 * Math.PI, { u, v } = this.light;
      before = now;
      const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
      const still = Math.hypot(u, v) < 0.05;
      this.change(still ? { u: 0.6, v: 0 } : { u: u * cos + v * sin, v: v * cos - u * sin }, false);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  /** Moves the light by an arrow key. */
  moveByKey(event: KeyboardEvent): void {
    const step = STEPS[event.key];
    if (!step || event.shiftKey) return;
    event.preventDefault();
    event.stopPropagation();
    const { u, v } = this.light, [du, dv] = step;
    const [x, y] = onDisk(u + 0.05 * du, v + 0.05 * dv);
    this.change({ u: x, v: y });
  }

  private get all(): DiskLight[] {
    return this.viewer.state.lights;
  }
}

/** A place for another light: as high as the one chosen, and as far as can be from all there are. */
function freePlace(lights: DiskLight[], { u, v }: DiskLight): [number, number] {
  const radius = Math.max(0.3, Math.hypot(u, v)), first = Math.atan2(v, u) + Math.PI;
  const places = [0, 4, 2, 6, 1, 7, 3, 5].map((eighth): [number, number] => {
    const angle = first + (eighth * Math.PI) / 4;
    return [radius * Math.cos(angle), radius * Math.sin(angle)];
  });
  const room = ([x, y]: [number, number]): number => Math.min(...lights.map((light) => Math.hypot(light.u - x, light.v - y)));
  // A little more room is no reason for another place: the first ones are spread best.
  return places.reduce((best, place) => (room(place) > room(best) + 1e-6 ? place : best));
}
