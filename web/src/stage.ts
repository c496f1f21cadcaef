import { type BufferGeometry, type Camera, Color, DoubleSide, FrontSide, Mesh, OrthographicCamera, PerspectiveCamera, PlaneGeometry, Scene, Vector2, Vector3, WebGLRenderer } from "three";
import { type FieldData, type Mode, ReflectanceMaterial, ReflectanceTexture, TilePlane } from "relume-three";
import { applyState, cameraFrame, directionOf, inCells, lamp, lampsOf, simplify } from "./applied.js";
import { Making } from "./making.js";
import { DEFAULT_TILING, boundingSphere, geometryOf } from "./objects.js";
import { type Part, flatScale, shownParts } from "./parts.js";
import { TileCache } from "./tiles.js";
import type { ObjectName, ViewState } from "./state.js";

/** Screen pixels of a texel from which on texels are shown as squares. */
const CRISP_PIXELS = 4;
const FIELD_OF_VIEW = 30;
/** Ways that show nothing of textures without normals, such as noise. */
export const NEED_NORMALS: readonly Mode[] = ["diffuse-gain", "specular", "unsharp-normals", "normals", "albedo", "height", "slope", "shading"];

const CLOSED: readonly ObjectName[] = ["sphere", "torus"];

/** Whether a texture can be shown so. */
export function knowsMode(texture: Pick<StagedTexture, "maps"> | null, mode: Mode): boolean {
  return texture?.maps !== null || !NEED_NORMALS.includes(mode);
}

/** A texture on the stage. */
interface Placed {
  texture: ReflectanceTexture;
  material: ReflectanceMaterial;
  /** Of a large texture, of which `texture` is a level. */
  tiles: TileCache | null;
  /** A set of tiles as the plane that it covers, once an object has shown it. */
  plane: Placed | null;
  /** Of such a plane: where its squares begin. */
  start: TilePlane | null;
}

/** What is known of a texture on the stage; its size is that of the whole. */
export interface StagedTexture {
  width: number;
  height: number;
  data: FieldData;
  endless: ReflectanceTexture["endless"];
  maps: ReflectanceTexture["maps"];
}

/** Draws textures by the state. */
export class Stage {
  readonly renderer: WebGLRenderer;
  private readonly placed: (Placed | null)[] = [];
  private readonly flat = new Mesh(new PlaneGeometry(2, 2));
  private readonly solid = new Mesh();
  private readonly scene = new Scene();
  private readonly straight = new OrthographicCamera(-1, 1, 1, -1, -1, 1);
  private readonly eye = new PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
  private shape = "";
  /** The user's own object. */
  mesh: BufferGeometry | null = null;
  /** 1 draws without the interpolation of slanted texels: as the library's renderer, and where there is no graphics card. */
  readonly anisotropy: number;
  /** What the graphics card makes to draw with. */
  readonly making: Making;

  /** `arrived` is called when more of what is in view has come, `told` when there is more to say of what is made. */
  constructor(canvas: HTMLCanvasElement, isotropic: boolean, private readonly arrived: () => void, told: () => void) {
    this.renderer = new WebGLRenderer({ canvas, antialias: !isotropic, preserveDrawingBuffer: true, alpha: false });
    this.renderer.autoClear = false;
    this.making = new Making(this.renderer, arrived, told);
    const plain = isotropic || drawsInSoftware(this.renderer.getContext());
    this.anisotropy = plain ? 1 : Math.min(8, this.renderer.capabilities.getMaxAnisotropy());
    this.flat.frustumCulled = this.solid.frustumCulled = false;
  }

  /** Puts a texture in its place, or a finer level of a large one. */
  add(index: number, data: FieldData, tiles: TileCache | null = null): void {
    const limit = this.renderer.capabilities.maxTextureSize;
    if (Math.max(data.width, data.height) > limit) {
      throw new Error(`the texture has ${data.width} x ${data.height} texels, and this graphics card takes ${limit} across`);
    }
    const before = this.placed[index], texture = new ReflectanceTexture(data, this.anisotropy);
    for (const old of [before, before?.plane]) {
      old?.texture.dispose();
      old?.material.dispose();
    }
    this.placed[index] = { texture, material: new ReflectanceMaterial(texture), tiles, plane: null, start: null };
  }

  /** Takes another object of the user's own. */
  setMesh(geometry: BufferGeometry): void {
    this.mesh?.dispose();
    this.mesh = geometry;
    this.shape = "";
  }

  /** Squares of endless planes that are on their way. */
  get waiting(): number {
    return this.placed.reduce((sum, placed) => sum + ((placed?.plane ?? placed)?.texture.endless?.waiting ?? 0), 0);
  }

  /** Whether there is nothing to draw with for now. */
  get isLost(): boolean {
    return this.renderer.getContext().isContextLost();
  }

  /** What was drawn for endless planes is gone: it is made again where it is seen. */
  forget(): void {
    this.making.forget();
    for (const placed of this.placed) for (const one of [placed, placed?.plane]) one?.texture.endless?.window.forget();
  }

  texture(index: number): StagedTexture | null {
    const placed = this.placed[index];
    return placed ? wholeOf(placed) : null;
  }

  /** Tiles that are still to come. */
  get pending(): number {
    return this.placed.reduce((sum, placed) => sum + (placed?.tiles?.pending ?? 0), 0);
  }

  /** What could not be loaded, a sentence for each texture. */
  get failures(): string[] {
    return this.placed.flatMap((placed) => placed?.tiles?.failure ?? placed?.texture.endless?.failure ?? []);
  }

  /** Asks again for what could not be loaded. */
  retry(): void {
    for (const placed of this.placed) {
      placed?.tiles?.retry();
      placed?.texture.endless?.retry();
    }
  }

  /** Loads the tiles that a state needs. */
  async settle(state: ViewState): Promise<void> {
    do {
      this.draw(state, "#000");
      await Promise.all(this.placed.map((placed) => placed?.tiles?.settled()));
    } while (this.pending > 0);
  }

  /** Whether the card has what draws a state; it makes the rest. */
  isMade(state: ViewState): boolean {
    const { x, y } = this.renderer.getSize(new Vector2());
    const areMade = shownParts(state, (index) => this.texture(index), x, y).map(({ state: part, view }) => {
      const prepared = this.prepare(part, view, y);
      return !prepared || this.making.isReady(prepared.placed.material, this.scene, prepared.camera);
    });
    return areMade.every(Boolean);
  }

  /** The size in CSS pixels and the density of the screen. */
  resize(width: number, height: number, ratio: number): void {
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(width, height, false);
  }

  draw(state: ViewState, background: string): void {
    const size = this.renderer.getSize(new Vector2());
    this.renderer.setClearColor(new Color(background), 1);
    this.renderer.setScissorTest(false);
    this.renderer.setViewport(0, 0, size.x, size.y);
    this.renderer.clear();
    for (const { state: part, view, seen } of shownParts(state, (index) => this.texture(index), size.x, size.y)) this.drawPart(part, view, seen, size.y);
    this.making.watch();
  }

  /** Puts what a part shows into the scene. */
  private prepare(asked: ViewState, view: Part, height: number): { placed: Placed; state: ViewState; camera: Camera } | null {
    const isKnown = knowsMode(this.placed[asked.texture]?.texture ?? null, asked.mode), state = isKnown ? asked : { ...asked, mode: "default" as const };
    const placed = this.formFor(state);
    if (!placed) return null;
    applyState(state, placed.material);
    simplify(placed.texture, placed.material, state.simple);
    this.scene.clear();
    if (state.object === "flat") this.prepareFlat(state, placed, view.width, height);
    else this.prepareSolid(state, placed, view.width, height);
    return { placed, state, camera: state.object === "flat" ? this.straight : this.eye };
  }

  /** Draws into a part of the canvas what a view of another part shows there. */
  private drawPart(asked: ViewState, view: Part, seen: Part, height: number): void {
    const prepared = seen.width > 0 ? this.prepare(asked, view, height) : null;
    if (!prepared) return;
    const { placed, state, camera } = prepared;
    this.renderer.setScissorTest(true);
    this.renderer.setScissor(seen.x, 0, seen.width, height);
    this.renderer.setViewport(view.x, 0, view.width, height);
    this.renderer.render(this.scene, camera);
    if (placed.tiles && state.object === "flat" && state.repeat <= 1) this.drawTiles(state, placed, placed.tiles, { view, seen, height });
  }

  /** On objects a set of tiles is the plane that it covers, where this has room, and nothing about single tiles or normals is shown. */
  private formFor(state: ViewState): Placed | null {
    const placed = this.placed[state.texture] ?? null;
    const cells = placed?.texture.data.cells;
    if (!placed || !cells || state.object === "flat" || state.cells || state.simple || state.gloss > 0 || NEED_NORMALS.includes(state.mode)) return placed;
    if (!placed.plane) {
      const start = new TilePlane(placed.texture.data, cells), texture = new ReflectanceTexture(start.data, this.anisotropy);
      placed.plane = { texture, material: new ReflectanceMaterial(texture), tiles: null, plane: null, start };
    }
    const { texture } = placed.plane, [across, down] = DEFAULT_TILING[state.object], reach = texture.endless?.reach ?? [0, 0];
    const hasRoom = across * state.repeat * texture.width <= reach[0] && down * state.repeat * texture.height <= reach[1];
    return hasRoom ? placed.plane : placed;
  }

  /** Draws the tiles of a large texture over the level that is there as a whole. */
  private drawTiles(state: ViewState, placed: Placed, tiles: TileCache, { view, seen, height }: { view: Part; seen: Part; height: number }): void {
    const whole = wholeOf(placed), scale = flatScale(state, whole, view.width, height);
    const across = view.width / scale / whole.width, down = height / scale / whole.height;
    const left = state.x - across / 2, top = state.y - down / 2;
    for (const tile of tiles.shown(1 / scale / this.renderer.getPixelRatio(), [left, top, left + across, top + down])) {
      const { texture, material } = tile, [x0, y0, x1, y1] = tiles.windowOf(tile.place), { border } = tiles.share;
      // From parts of the whole to those of the tile with its border.
      const kx = (1 - (2 * border) / texture.width) / (x1 - x0), ky = (1 - (2 * border) / texture.height) / (y1 - y0);
      const bx = border / texture.width, by = border / texture.height;
      applyState(state, material);
      material.setTiling(across * kx, down * ky, (left - x0) * kx + bx, 1 - (top + down - y0) * ky - by);
      material.setClip(bx, by, 1 - bx, 1 - by);
      this.prepareFlatMaterial(state, material, scale);
      material.set("clipped", true);
      const from = Math.floor(view.x + ((x0 - left) / across) * view.width), to = Math.ceil(view.x + ((x1 - left) / across) * view.width);
      const low = Math.floor((1 - (y1 - top) / down) * height), high = Math.ceil((1 - (y0 - top) / down) * height);
      const cut = { x: Math.max(from, seen.x), to: Math.min(to, seen.x + seen.width), low: Math.max(low, 0), high: Math.min(high, height) };
      if (cut.x >= cut.to || cut.low >= cut.high) continue;
      this.renderer.setScissor(cut.x, cut.low, cut.to - cut.x, cut.high - cut.low);
      this.renderer.render(this.scene, this.straight);
    }
  }

  /** What all materials of the flat view have in common. */
  private prepareFlatMaterial(state: ViewState, material: ReflectanceMaterial, scale: number): void {
    material.setFlat(true);
    material.set("crisp", scale * this.renderer.getPixelRatio() >= CRISP_PIXELS * Math.max(1, this.renderer.getPixelRatio()));
    material.directionalLights = lampsOf(state, material).map((light) => lamp(light, directionOf(light)));
    this.flat.material = material;
  }

  private prepareFlat(state: ViewState, placed: Placed, width: number, height: number): void {
    const { texture, material } = placed, whole = wholeOf(placed), scale = flatScale(state, whole, width, height);
    const across = width / scale / whole.width, down = height / scale / whole.height;
    const cells = texture.data.cells, isPlane = cells !== null || texture.endless !== null;
    if (texture.endless) this.cover(texture, state.x - across / 2, state.y - down / 2, across, down);
    // Whole repetitions as integers, the rest as a float: as sharp far away as near.
    const [x, y] = cells ? inCells(state, texture, material) : [state.x - Math.floor(state.x), state.y - Math.floor(state.y)];
    material.setOrigin(texture, Math.floor(state.x) * texture.width, Math.floor(state.y) * texture.height);
    const repeats = isPlane || state.repeat > 1;
    const [left, top] = repeats ? [x, y] : [state.x, state.y];
    material.setTiling(across, down, left - across / 2, 1 - top - down / 2);
    material.set("clipped", !repeats);
    this.prepareFlatMaterial(state, material, scale);
    this.scene.add(this.flat);
  }

  private prepareSolid(state: ViewState, { texture, material, start }: Placed, width: number, height: number): void {
    const tiling = tilingOf(state, texture);
    // The upper edge of the object is the upper edge of its last repetition, and those below follow.
    const first = start ? Math.round((1 - tiling[1]) * texture.height) : 0;
    if (start && start.firstRow !== first) {
      start.firstRow = first;
      texture.endless?.window.forget();
    }
    if (texture.endless) this.cover(texture, 0, 1 - tiling[1] - first / texture.height, ...tiling);
    material.setOrigin(texture, 0, -first);
    const aspect = (tiling[0] * texture.width) / (tiling[1] * texture.height);
    this.reshape(state.object, aspect);
    const { center, radius } = boundingSphere(this.solid.geometry);
    const toward = cameraFrame(state);
    const smaller = Math.min(width / height, 1), tangent = Math.tan((FIELD_OF_VIEW * Math.PI) / 360);
    const distance = radius / Math.sin(Math.atan(0.94 * smaller * tangent)) / state.near;
    this.eye.aspect = width / height;
    this.eye.near = 0.001 * Math.min(distance, radius);
    this.eye.far = distance + 4 * radius;
    this.eye.position.set(...center).addScaledVector(toward.back, distance);
    this.eye.up.copy(toward.up);
    this.eye.lookAt(new Vector3(...center));
    this.eye.updateProjectionMatrix();
    material.setTiling(...tiling);
    material.setFlat(false);
    for (const name of ["clipped", "crisp"]) material.set(name, false);
    material.directionalLights = lampsOf(state, material).map((light) => {
      const [x, y, z] = directionOf(light);
      const d = toward.right.clone().multiplyScalar(x).addScaledVector(toward.up, y).addScaledVector(toward.back, z);
      return lamp(light, [d.x, d.y, d.z]);
    });
    // Of closed objects the inside is never seen.
    material.side = CLOSED.includes(state.object) ? FrontSide : DoubleSide;
    this.solid.material = material;
    this.scene.add(this.solid);
  }

  /** Makes the part of an endless plane that is in view, in parts of the texture. */
  private cover(texture: ReflectanceTexture, x: number, y: number, across: number, down: number): void {
    const { width, height } = texture;
    texture.endless?.cover(this.renderer, { x: x * width, y: y * height, width: across * width, height: down * height }, this.arrived);
  }

  private reshape(object: ObjectName, aspect: number): void {
    const shape = object === "plane" || (object === "mesh" && !this.mesh) ? `plane ${aspect}` : object;
    if (shape === this.shape) return;
    if (this.solid.geometry !== this.mesh) this.solid.geometry.dispose();
    this.solid.geometry = object === "mesh" && this.mesh ? this.mesh : geometryOf(object, aspect);
    this.shape = shape;
  }
}

/** The size and the data of a texture, of which a level may be on the stage. */
function wholeOf({ texture, tiles }: Placed): StagedTexture {
  const [width, height] = tiles?.share.size ?? [texture.width, texture.height];
  return { width, height, data: texture.data, endless: texture.endless, maps: texture.maps };
}

/** Repetitions of a texture on an object: of an endless plane no more than there is room for. */
function tilingOf(state: ViewState, { endless, width, height }: ReflectanceTexture): [number, number] {
  const [across, down] = DEFAULT_TILING[state.object], reach = endless?.reach ?? [Infinity, Infinity];
  const repeat = Math.min(state.repeat, reach[0] / (across * width), reach[1] / (down * height));
  return [across * repeat, down * repeat];
}

function drawsInSoftware(gl: WebGLRenderingContext | WebGL2RenderingContext): boolean {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return info !== null && /swiftshader|llvmpipe|software/i.test(String(gl.getParameter(info.UNMASKED_RENDERER_WEBGL)));
}
