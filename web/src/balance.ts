// White balance: colours seen under a light of a chromaticity, as they would be under D65 (Bradford; Lam 1985).

/** A chromaticity (CIE 1931 x, y). */
export type White = [number, number];
type Vector = [number, number, number];
type Matrix = [number, number, number, number, number, number, number, number, number];

export const D65: White = [0.3127, 0.329];
/** Colour temperatures that can be chosen, in kelvins. */
export const TEMPERATURES: [number, number] = [2000, 15000];
/** The correlated colour temperature of D65. */
export const NEUTRAL = 6504;

const BRADFORD: Matrix = [0.8951, 0.2664, -0.1614, -0.7502, 1.7135, 0.0367, 0.0389, -0.0685, 1.0296];
/** IEC 61966-2-1. */
const XYZ_FROM_RGB: Matrix = [0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.072175, 0.0193339, 0.119192, 0.9503041];

/** The matrix for linear sRGB that makes light of that chromaticity neutral, and keeps its luminance. */
export function balanceFor(white: White): Matrix {
  if (white[0] === D65[0] && white[1] === D65[1]) return [1, 0, 0, 0, 1, 0, 0, 0, 1];
  const [from, to] = [white, D65].map((xy) => times(BRADFORD, fromChromaticity(xy as White))) as [Vector, Vector];
  const gains: Matrix = [to[0] / from[0], 0, 0, 0, to[1] / from[1], 0, 0, 0, to[2] / from[2]];
  const inXyz = product(inverse(BRADFORD), product(gains, BRADFORD));
  return product(inverse(XYZ_FROM_RGB), product(inXyz, XYZ_FROM_RGB));
}

/** The chromaticity of a linear sRGB colour; null for one that is nearly black. */
export function chromaticityOf(rgb: Vector): White | null {
  const [x, y, z] = times(XYZ_FROM_RGB, rgb), sum = x + y + z;
  return sum < 1e-4 ? null : [x / sum, y / sum];
}

/** The chromaticity of a temperature: on a line beside that of black bodies, through D65. */
export function whiteOf(kelvins: number): White {
  const [u, v] = uv(blackBody(kelvins)), [u0, v0] = uv(blackBody(NEUTRAL)), [un, vn] = uv(D65);
  const [a, b] = [u + un - u0, v + vn - v0], scale = 2 * a - 8 * b + 4;
  return kelvins === NEUTRAL ? [...D65] : [(3 * a) / scale, (2 * b) / scale];
}

/** The temperature on that line nearest to a chromaticity. */
export function temperatureOf(white: White): number {
  const [u, v] = uv(white);
  // Evenly spaced in reciprocal temperature, as differences look.
  const [low, high] = TEMPERATURES.map((kelvins) => 1e6 / kelvins) as [number, number];
  let best = NEUTRAL, least = Infinity;
  for (let mired = high; mired <= low; mired += 0.5) {
    const [a, b] = uv(whiteOf(1e6 / mired)), distance = (a - u) ** 2 + (b - v) ** 2;
    if (distance < least) [best, least] = [1e6 / mired, distance];
  }
  return Math.abs(best - NEUTRAL) < 15 ? NEUTRAL : best;
}

/** Chromaticities of black bodies, 1667 to 25000 K (Kim et al. 2002). */
function blackBody(kelvins: number): White {
  const t = 1000 / kelvins;
  const x = kelvins <= 4000
    ? ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.17991
    : ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.24039;
  if (kelvins <= 2222) return [x, ((-1.1063814 * x - 1.3481102) * x + 2.18555832) * x - 0.20219683];
  if (kelvins <= 4000) return [x, ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867];
  return [x, ((3.081758 * x - 5.8733867) * x + 3.75112997) * x - 0.37001483];
}

/** CIE 1960, in which distances tell temperatures. */
function uv([x, y]: White): [number, number] {
  const scale = -2 * x + 12 * y + 3;
  return [(4 * x) / scale, (6 * y) / scale];
}

function fromChromaticity([x, y]: White): Vector {
  return [x / y, 1, (1 - x - y) / y];
}

function times(m: Matrix, v: Vector): Vector {
  return [0, 3, 6].map((row) => (m[row] ?? 0) * v[0] + (m[row + 1] ?? 0) * v[1] + (m[row + 2] ?? 0) * v[2]) as Vector;
}

function product(a: Matrix, b: Matrix): Matrix {
  return Array.from({ length: 9 }, (_, i) => {
    const row = i - (i % 3), column = i % 3;
    return [0, 1, 2].reduce((sum, k) => sum + (a[row + k] ?? 0) * (b[3 * k + column] ?? 0), 0);
  }) as Matrix;
}

function inverse([a, b, c, d, e, f, g, h, i]: Matrix): Matrix {
  const cofactors = [e * i - f * h, c * h - b * i, b * f - c * e, f * g - d * i, a * i - c * g, c * d - a * f, d * h - e * g, b * g - a * h, a * e - b * d];
  const determinant = a * (cofactors[0] ?? 0) + b * (cofactors[3] ?? 0) + c * (cofactors[6] ?? 0);
  return cofactors.map((value) => value / determinant) as Matrix;
}
