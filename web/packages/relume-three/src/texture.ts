import {
  ClampToEdgeWrapping, DataArrayTexture, DataTexture, FloatType, HalfFloatType, LinearFilter, LinearMipmapLinearFilter,
  RGBAFormat, RGBAIntegerFormat, RGFormat, RepeatWrapping, type Texture, UnsignedByteType, UnsignedShortType,
} from "three";
import { LoadedBlocks } from "./blocks.js";
import { contrastLayers, distanceTexture } from "./boundaries.js";
import { EndlessTexture } from "./endless.js";
import { lampLightTexture, lampNodeTexture } from "./environment.js";
import { type FieldCodes, type FieldData, planeCount } from "./field.js";
import { fromHalf, halfLayers, halvesFrom } from "./half.js";
import { LampTable } from "./lampTable.js";
import { MeasuredBasis } from "./measured.js";
import { NoiseBlocks } from "./noise.js";
import type { BasisTable } from "./table.js";
import { type TileLayout, tileLayout } from "./tiles.js";

/** Texels from which on the product of luminance and colour is taken in the shader, to save memory. */
const LARGE = 1 << 21;
const ONE = 0x3c00;
/** Functions whose scales and offsets are uniforms. */
const MOST_CODED = 32;

/**
 * How coefficients lie in the layers of the texture: `color`: a function in a layer, its coefficients for red, green and
 * blue; `packed`: four functions in a layer, for all channels; `product`: the same, and then a layer of the colour.
 */
export type Arrangement = "color" | "packed" | "product";

/** A texture of functions on the graphics card. */
export class ReflectanceTexture {
  readonly planes: Texture;
  /** Normal (x, y, z from -1 to 1) and height, then albedo; null without normals. */
  readonly maps: DataArrayTexture | null;
  readonly basisTable: DataArrayTexture | null;
  /** Of measured functions: the triangles around directions, and the directions. */
  readonly cornerMap: DataTexture | null;
  readonly directionPoints: DataTexture | null;
  /** Of light from all around: that of its lamps, and their directions. */
  readonly lampLight: DataArrayTexture | null;
  readonly lampNodes: DataTexture | null;
  /** Measured functions at its lamps. */
  readonly lamps: LampTable | null;
  /** Of boundaries that move: distances to them, and contrasts across them. */
  readonly distances: Texture | null;
  readonly contrasts: Texture | null;
  /** The codes of which the layers are, where they are not half floats. */
  readonly codes: FieldCodes | null;
  readonly arrangement: Arrangement;
  /** Layers of a tile. */
  readonly layers: number;
  readonly tiles: number;
  /** Tiles with what lies around them. */
  readonly layout: TileLayout | null;
  /** The part of an endless plane that is looked at: `cover` it before it is drawn. */
  readonly endless: EndlessTexture | null;
  /** The size of a tile, or of the texture. */
  readonly width: number;
  readonly height: number;
  /** The least and the greatest height, in texels. */
  readonly heightRange: [number, number];

  constructor(readonly data: FieldData, anisotropy = 1) {
    this.tiles = data.cells?.tiles ?? 1;
    this.width = data.width;
    this.height = data.height / this.tiles;
    this.arrangement = arrangementOf(data);
    this.layout = data.cells ? tileLayout(data.cells, this.width, this.height) : null;
    this.endless = endlessOf(data, this.arrangement, anisotropy);
    this.codes = codesOf(data, this.arrangement);
    const layers = this.endless ? [] : this.codes ? codeLayers(this.codes) : layersOf(data, this.arrangement);
    this.layers = this.endless?.maker.layers ?? layers.length;
    this.planes = this.endless?.texture ?? this.upload(layers, anisotropy);
    this.maps = data.normals ? this.upload(mapLayers(data), anisotropy) : null;
    const measured = data.table instanceof MeasuredBasis ? data.table : null;
    this.basisTable = data.table ? tableTexture(data.table) : null;
    this.cornerMap = measured && cornerTexture(measured);
    this.directionPoints = measured && pointTexture(measured);
    this.lampLight = data.environment && lampLightTexture(data.environment);
    this.lampNodes = data.environment && lampNodeTexture(data.environment);
    this.lamps = measured && data.environment && LampTable.of(measured, data.environment);
    this.distances = data.boundaries && distanceTexture(data.boundaries, data.width, data.height, anisotropy);
    this.contrasts = data.boundaries && this.upload(contrastLayers(data.boundaries), anisotropy);
    this.heightRange = data.heights?.range ?? rangeOf(data.heights?.values);
  }

  /** The size of the texture on the card, in texels. */
  get extent(): [number, number] {
    const { width, height } = this.endless?.window ?? this.layout ?? this;
    return [width, height];
  }

  private lampTableTaken: DataArrayTexture | null = null;

  /** What `lamps` is on the card; made when it is asked for, since not all who share light from all around look at it. */
  get lampTable(): DataArrayTexture | null {
    return (this.lampTableTaken ??= this.lamps?.taken() ?? null);
  }

  dispose(): void {
    this.endless?.dispose();
    if (this.lampTableTaken) this.lamps?.letGo();
    this.lampTableTaken = null;
    for (const texture of [this.planes, this.maps, this.basisTable, this.cornerMap, this.directionPoints, this.lampLight, this.lampNodes, this.distances, this.contrasts]) texture?.dispose();
  }

  /** Each layer once for each tile: layer k of tile i is k * tiles + i. */
  private upload(layers: (Uint16Array | Uint8Array)[], anisotropy: number): DataArrayTexture {
    const [width, height] = this.extent, length = 4 * width * height * this.tiles * layers.length, isHalf = layers[0] instanceof Uint16Array;
    const whole = isHalf ? new Uint16Array(length) : new Uint8Array(length);
    layers.forEach((layer, k) => {
      const part = whole.subarray((k * whole.length) / layers.length, ((k + 1) * whole.length) / layers.length);
      if (this.layout) this.layout.sources.forEach((source, i) => part.set(layer.subarray(4 * source, 4 * source + 4), 4 * i));
      else part.set(layer);
    });
    const texture = new DataArrayTexture(whole, width, height, layers.length * this.tiles);
    texture.format = RGBAFormat;
    texture.type = isHalf ? HalfFloatType : UnsignedByteType;
    texture.wrapS = texture.wrapT = this.layout ? ClampToEdgeWrapping : RepeatWrapping;
    texture.magFilter = LinearFilter;
    texture.minFilter = LinearMipmapLinearFilter;
    texture.generateMipmaps = true;
    texture.anisotropy = anisotropy;
    texture.needsUpdate = true;
    return texture;
  }
}

function arrangementOf({ layout, width, height, noise, blocks }: FieldData): Arrangement {
  if (layout === "rgb" || noise) return "color";
  if (layout === "lrgb" && blocks) return "color";
  // Luminance and colour apart are not linear: averages of products need the products.
  if (layout === "lrgb") return width * height <= LARGE ? "color" : "product";
  return "packed";
}

/** Functions of red, green and blue stay as they are stored. */
function codesOf({ codes, layout, noise, blocks, functions }: FieldData, arrangement: Arrangement): FieldCodes | null {
  return arrangement === "color" && layout === "rgb" && !noise && !blocks && functions <= MOST_CODED ? codes : null;
}

function codeLayers({ planes }: FieldCodes): Uint8Array[] {
  const functions = planes.length / 3;
  return Array.from({ length: functions }, (_, k) => {
    const texels = planes[k]?.length ?? 0, out = new Uint8Array(4 * texels).fill(255);
    for (let c = 0; c < 3; c++) {
      const plane = planes[c * functions + k];
      for (let i = 0; i < texels; i++) out[4 * i + c] = plane?.[i] ?? 0;
    }
    return out;
  });
}

function layersOf(data: FieldData, arrangement: Arrangement): Uint16Array[] {
  return arrangement === "color" ? colorLayers(data) : packedLayers(data);
}

/** The endless plane of noise, or of squares that are loaded. */
function endlessOf(data: FieldData, arrangement: Arrangement, anisotropy: number): EndlessTexture | null {
  const { noise, blocks, functions, planes, width, height } = data;
  if (noise) {
    const groups = Array.from({ length: Math.ceil(noise.planes / 4) }, (_, g) => interleaved(planes.slice(4 * g, 4 * g + 4)));
    return new EndlessTexture(new NoiseBlocks(noise, functions, groups, width, height), anisotropy);
  }
  if (!blocks) return null;
  const layers = arrangement === "color" ? functions : Math.ceil(planeCount(data.layout, functions) / 4);
  return new EndlessTexture(new LoadedBlocks(blocks, layers, (planes) => layersOf({ ...data, planes }, arrangement)), anisotropy);
}

function colorLayers(data: FieldData): Uint16Array[] {
  return Array.from({ length: data.functions }, (_, k) => interleaved(channelPlanes(data, k)));
}

/** The coefficients of function k for red, green and blue. */
function channelPlanes({ layout, planes, functions }: FieldData, k: number): Uint16Array[] {
  const plane = (index: number): Uint16Array => planes[index] ?? new Uint16Array();
  if (layout === "rgb") return [0, 1, 2].map((c) => plane(c * functions + k));
  const luminance = Float32Array.from(plane(k), fromHalf);
  return [0, 1, 2].map((c) => {
    const color = plane(functions + c);
    return halvesFrom(luminance.map((value, i) => value * fromHalf(color[i] ?? 0)));
  });
}

function packedLayers({ layout, planes, functions }: FieldData): Uint16Array[] {
  const groups = Array.from({ length: Math.ceil(functions / 4) }, (_, g) => planes.slice(4 * g, Math.min(4 * g + 4, functions)));
  if (layout === "lrgb") groups.push(planes.slice(functions));
  return groups.map(interleaved);
}

function mapLayers({ normals, heights, albedo, width, height }: FieldData): Uint16Array[] {
  const texels = width * height;
  const part = (values: Float32Array | undefined, c: number): Uint16Array =>
    values ? halvesFrom(values.subarray(c * texels, (c + 1) * texels)) : new Uint16Array(texels);
  const first = [0, 1, 2].map((c) => part(normals?.values, c));
  first.push(part(heights?.values, 0));
  const color = [0, 1, 2].map((c) => part(albedo?.values, albedo?.channels === 1 ? 0 : c));
  return [interleaved(first), interleaved(color)];
}

/** Up to four planes as texels of four values; the fourth of three is 1. */
function interleaved(planes: Uint16Array[]): Uint16Array {
  const texels = planes[0]?.length ?? 0;
  const out = new Uint16Array(4 * texels);
  planes.forEach((plane, c) => {
    for (let i = 0; i < texels; i++) out[4 * i + c] = plane[i] ?? 0;
  });
  if (planes.length === 3) for (let i = 0; i < texels; i++) out[4 * i + 3] = ONE;
  return out;
}

function tableTexture(table: BasisTable | MeasuredBasis): DataArrayTexture {
  const [width, height] = table instanceof MeasuredBasis ? [table.lights.length, table.views.length] : [table.side, table.side];
  return halfLayers(table.texels, width, height, table.layers);
}

/** The map of triangles around lights, and below it that around views. */
function cornerTexture({ corners, mapNodes }: MeasuredBasis): DataTexture {
  const texture = new DataTexture(new Uint16Array(corners), mapNodes, 2 * mapNodes, RGBAIntegerFormat, UnsignedShortType);
  texture.internalFormat = "RGBA16UI";
  texture.needsUpdate = true;
  return texture;
}

/** A row of lights, and a row of views. */
function pointTexture({ lights, views }: MeasuredBasis): DataTexture {
  const width = Math.max(lights.length, views.length), points = new Float32Array(4 * width);
  [lights, views].forEach((row, y) => row.forEach((point, x) => points.set(point, 2 * (y * width + x))));
  const texture = new DataTexture(points, width, 2, RGFormat, FloatType);
  texture.needsUpdate = true;
  return texture;
}

function rangeOf(values: Float32Array | undefined): [number, number] {
  let low = Infinity, high = -Infinity;
  for (const value of values ?? []) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  return low < high ? [low, high] : [0, 1];
}
