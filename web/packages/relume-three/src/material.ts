import { DoubleSide, GLSL3, Matrix3, ShaderMaterial, Vector2, Vector3, Vector4 } from "three";
import { AROUND_GLSL, MANY_GLSL } from "./around.js";
import { CLOSED, CLOSED_FORM_GLSL } from "./basis.js";
import { boundariesGlsl } from "./boundaries.js";
import { ENVIRONMENT_GLSL, momentsGlsl } from "./environment.js";
import { EVALUATE, FRAGMENT, LOOKUP, VERTEX } from "./glsl.js";
import { isTurned } from "./header.js";
import type { FieldData } from "./field.js";
import { MEASURED_GLSL, MeasuredBasis } from "./measured.js";
import { MOST_DIRECTIONS, type ReflectanceLight, directionsOf } from "./softLight.js";
import { BasisTable, TABLE_GLSL } from "./table.js";
import type { ReflectanceTexture } from "./texture.js";
import { holdGlsl, sumGlsl } from "./unrolled.js";

/** What is shown of a texture. */
export const MODES = [
  "default", "diffuse-gain", "specular", "unsharp-luminance", "unsharp-normals", "unsharp-coefficients",
  "multi-light", "normals", "albedo", "height", "slope", "shading", "plain",
] as const;
export type Mode = (typeof MODES)[number];

/** Layers of a place that are kept while its lights are added up: always, and where they are added up many times. */
const FEW_HELD = 32, MOST_HELD = 128;
const ARRANGEMENTS = { color: 0, packed: 1, product: 2 };

/**
 * Shows a texture of functions on any geometry with normals and texture coordinates. Light is looked up in the tangent
 * frame of each fragment: from the attribute `tangent` if there is one, from the slopes on the screen otherwise.
 */
export class ReflectanceMaterial extends ShaderMaterial {
  constructor(private readonly texture: ReflectanceTexture) {
    super({ glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: fragmentFor(texture), side: DoubleSide });
    this.defines = definesFor(texture);
    const cells = texture.data.cells, shapes = texture.data.boundaries?.header;
    const pair = (values: [number, number] | undefined): Vector2 => new Vector2(...(values ?? [0, 0]));
    this.uniforms = {
      planes: { value: texture.planes },
      maps: { value: texture.maps },
      basisTable: { value: texture.basisTable },
      cornerMap: { value: texture.cornerMap },
      directionPoints: { value: texture.directionPoints },
      codeScale: { value: ofChannels(texture.codes?.scale, 255) },
      codeOffset: { value: ofChannels(texture.codes?.offset, 1) },
      distances: { value: texture.distances },
      contrasts: { value: texture.contrasts },
      shapeStrengths: { value: pair(shapes?.strengths) },
      shapeSteps: { value: pair(shapes?.steps) },
      shapeMost: { value: pair(shapes?.most) },
      shapeSoftness: { value: shapes?.softness ?? 1 },
      texels: { value: new Vector2(texture.width, texture.height) },
      extent: { value: new Vector2(...texture.extent) },
      padding: { value: texture.layout?.padding ?? 0 },
      windowShift: { value: new Vector2(0, 0) },
      heightRange: { value: new Vector2(...texture.heightRange) },
      tiling: { value: new Vector2(1, 1) },
      shift: { value: new Vector2(0, 0) },
      lights: { value: 0 },
      lightDirection: { value: Array.from({ length: MOST_DIRECTIONS }, () => new Vector3(0, 0, 1)) },
      lightColor: { value: Array.from({ length: MOST_DIRECTIONS }, () => new Vector3()) },
      lowestLight: { value: texture.data.lowestLight },
      plainLight: { value: new Vector3(0, 0, 1) },
      gain: { value: 1 },
      sharpen: { value: 0 },
      radius: { value: 2.5 },
      exposure: { value: 1 },
      balance: { value: new Matrix3() },
      environment: { value: 0 },
      environmentTurn: { value: new Matrix3() },
      environmentTurned: { value: false },
      environmentLight: { value: texture.lampLight },
      environmentNodes: { value: texture.lampNodes },
      lampTable: { value: null },
      gloss: { value: 0 },
      roughness: { value: 0.6 },
      right: { value: pair(cells?.right) },
      down: { value: pair(cells?.down) },
      origin: { value: pair(cells?.origin) },
      baseCell: { value: new Vector2(0, 0) },
      crisp: { value: false },
      clipped: { value: false },
      clip: { value: new Vector4(0, 0, 1, 1) },
      oneTile: { value: 0 },
      showCells: { value: 0 },
    };
    this.directionalLights = [{ direction: [-0.5, 0.5, 0.7], color: [1, 1, 1] }];
  }

  /** The lights, at most four; directions of any length, in world space. */
  set directionalLights(lights: ReflectanceLight[]) {
    const all = directionsOf(lights, this.texture.data.dependsOnView);
    this.set("lights", all.length);
    all.forEach(({ direction, color }, i) => {
      (this.uniforms["lightDirection"]?.value as Vector3[])[i]?.copy(direction);
      (this.uniforms["lightColor"]?.value as Vector3[])[i]?.copy(color);
    });
  }

  /** Whether the texture came with light from all around. */
  get knowsEnvironment(): boolean {
    return this.uniforms["environmentLight"]?.value != null;
  }

  /** Light from all around, where the texture was shared with some: its strength, and by which angle it is turned to the right. */
  setEnvironment(strength: number, turnRad = 0): void {
    const cos = Math.cos(turnRad), sin = Math.sin(turnRad);
    this.set("environment", strength);
    const isLit = strength > 0 && this.knowsEnvironment, table = this.uniforms["lampTable"];
    this.vary("AMBIENT", isLit ? 1 : 0);
    if (isLit && table) table.value ??= this.texture.lampTable;
    this.set("environmentTurned", turnRad !== 0);
    (this.uniforms["environmentTurn"]?.value as Matrix3).set(cos, 0, sin, 0, 1, 0, -sin, 0, cos);
  }

  /** A matrix for linear colours, row after row. */
  setBalance(rows: readonly [number, number, number, number, number, number, number, number, number]): void {
    (this.uniforms["balance"]?.value as Matrix3).set(...rows);
  }

  /** What is shown, and how strongly its effect. */
  setMode(mode: Mode, gain: number): void {
    this.vary("MODE", MODES.indexOf(mode));
    this.set("gain", gain);
    this.set("sharpen", mode === "unsharp-coefficients" ? gain : 0);
  }

  /** The part of texture coordinates that is shown where `clipped` is set. */
  setClip(left: number, bottom: number, right: number, top: number): void {
    (this.uniforms["clip"]?.value as Vector4).set(left, bottom, right, top);
  }

  /** How often the texture repeats over texture coordinates 0..1, and where it begins. */
  setTiling(across: number, down: number, shiftX = 0, shiftY = 0): void {
    (this.uniforms["tiling"]?.value as Vector2).set(across, down);
    (this.uniforms["shift"]?.value as Vector2).set(shiftX, shiftY);
  }

  /** The texel of an endless plane at which texture coordinates begin. */
  setOrigin(texture: ReflectanceTexture, x: number, y: number): void {
    if (texture.endless) (this.uniforms["windowShift"]?.value as Vector2).set(...texture.endless.shiftOf(x, y));
  }

  /** Whether the texture is drawn as it is, facing the viewer. */
  setFlat(flat: boolean): void {
    this.vary("FLAT", flat ? 1 : 0);
  }

  /** What the shader is compiled for now. */
  get variant(): string {
    return `${["MODE", "FLAT", "GLOSS", "AMBIENT"].map((name) => String(this.defines[name])).join(" ")} ${this.side}`;
  }

  /** What the shader is compiled for; programs are kept for each. */
  private vary(name: string, value: number): void {
    if (this.defines[name] === value) return;
    this.defines[name] = value;
    this.needsUpdate = true;
  }

  set(name: string, value: number | boolean): void {
    if (name === "gloss") this.vary("GLOSS", Number(value) > 0 ? 1 : 0);
    const uniform = this.uniforms[name];
    if (uniform) uniform.value = value;
  }
}

/** Numbers of the planes of functions of red, green and blue as vectors for each function, times a factor. */
function ofChannels(numbers: number[] | undefined, factor: number): Vector3[] {
  const functions = (numbers?.length ?? 3) / 3, of = (i: number): number => factor * (numbers?.[i] ?? 0);
  return Array.from({ length: functions }, (_, k) => new Vector3(of(k), of(functions + k), of(2 * functions + k)));
}

function definesFor(texture: ReflectanceTexture): Record<string, number> {
  const { data } = texture, light = data.environment?.header;
  const modes = Object.fromEntries(MODES.map((mode, i) => [mode.toUpperCase().replaceAll("-", "_"), i]));
  return {
    ...modes,
    MODE: 0,
    FLAT: 0,
    GLOSS: 0,
    AMBIENT: 0,
    MOST_DIRECTIONS,
    FUNCTIONS: data.functions,
    GROUPS: Math.ceil(data.functions / 4),
    CHANNELS: data.layout === "shared" ? 3 : 1,
    ARRANGEMENT: ARRANGEMENTS[texture.arrangement],
    SRGB: data.space === "srgb" ? 1 : 0,
    MAPS: texture.maps ? 1 : 0,
    ANISOTROPIC: texture.planes.anisotropy,
    CELLS: data.cells ? 1 : 0,
    CORNERS: data.cells?.corners ?? 1,
    ENDLESS: texture.endless ? 1 : 0,
    CODED: texture.codes ? 1 : 0,
    SHAPES: data.boundaries?.channels ?? 0,
    TILES: texture.tiles,
    LAYERS: texture.layers,
    HELD: texture.layers <= FEW_HELD ? 2 : texture.layers <= MOST_HELD ? 1 : 0,
    NODES: light?.nodes ?? 0,
    MOMENTS: light && isTurned(light) ? light.functions : 0,
    LAMP_SIDE: texture.lamps?.side ?? 0,
    LAMPS_ACROSS: texture.lamps?.across ?? 1,
    LIGHT_NODES: data.table instanceof BasisTable ? data.table.lightNodes : 2,
    VIEW_NODES: data.table instanceof BasisTable ? data.table.viewNodes : 1,
    MAP_NODES: data.table instanceof MeasuredBasis ? data.table.mapNodes : 1,
  };
}

function fragmentFor({ data, arrangement, layers }: ReflectanceTexture): string {
  const parts: Record<string, string> = {
    LOOKUP, WEIGHTS: `${weightsFor(data)}${data.boundaries ? boundariesGlsl(data.boundaries) : ""}`, EVALUATE, ENVIRONMENT: ENVIRONMENT_GLSL, AROUND: AROUND_GLSL, MANY: MANY_GLSL, HOLD: holdGlsl(layers),
    MOMENTS: momentsGlsl(data.environment?.header),
    SUM: sumGlsl(data.functions, arrangement === "color", data.layout === "shared" ? 3 : 1),
  };
  const precisions = "precision highp float;\nprecision highp int;\nprecision highp sampler2DArray;\n";
  return precisions + Object.entries(parts).reduce((text, [name, part]) => text.replace(`//${name}\n`, () => `${part}\n`), FRAGMENT);
}

/** The functions in GLSL: measured, tabulated, or by formulas. */
function weightsFor({ table, basis }: FieldData): string {
  if (table instanceof MeasuredBasis) return MEASURED_GLSL;
  if (table) return TABLE_GLSL;
  const formulas = CLOSED_FORM_GLSL[basis] ?? "";
  return `${CLOSED}\n${formulas}\nvoid fillWeights(vec3 light, vec3 view) { fillClosedForm(light); }`;
}
