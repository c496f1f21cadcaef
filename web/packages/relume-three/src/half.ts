import { ClampToEdgeWrapping, DataArrayTexture, DataUtils, HalfFloatType, LinearFilter, RGBAFormat } from "three";

/** Half floats (IEEE 754 binary16) of numbers. */
export function halvesFrom(values: ArrayLike<number>): Uint16Array {
  const halves = new Uint16Array(values.length);
  for (let i = 0; i < values.length; i++) halves[i] = DataUtils.toHalfFloat(clamped(values[i] ?? 0));
  return halves;
}

/** The number of a half float. */
export function fromHalf(half: number): number {
  return DataUtils.fromHalfFloat(half);
}

/** The half floats of 256 codes. */
export function halvesOfCodes(scale: number, offset: number): Uint16Array {
  return halvesFrom(Float32Array.from({ length: 256 }, (_, code) => scale * code + offset));
}

/** A plane of codes as half floats. */
export function halvesOfPlane(codes: Uint8Array, scale: number, offset: number): Uint16Array {
  const values = halvesOfCodes(scale, offset), plane = new Uint16Array(codes.length);
  for (let i = 0; i < codes.length; i++) plane[i] = values[codes[i] ?? 0] ?? 0;
  return plane;
}

/** Layers of four half floats a texel, interpolated within a layer. */
export function halfLayers(texels: ArrayLike<number>, width: number, height: number, layers: number): DataArrayTexture {
  const texture = new DataArrayTexture(new Uint16Array(texels), width, height, layers);
  texture.format = RGBAFormat;
  texture.type = HalfFloatType;
  texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
  texture.magFilter = texture.minFilter = LinearFilter;
  texture.needsUpdate = true;
  return texture;
}

function clamped(value: number): number {
  return Math.min(65504, Math.max(-65504, value));
}
