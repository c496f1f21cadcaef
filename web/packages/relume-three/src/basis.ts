// Functions with formulas, as in the library's field/basis; all other bases come with a table (table.ts).

/** Names of bases with formulas. */
const COUNTS: Record<string, number> = { constant: 1, ptm: 6, hsh4: 4, hsh9: 9, hsh16: 16 };

/** Whether the functions of a basis are known by its name. */
export function hasClosedForm(basis: string): boolean {
  return Object.hasOwn(COUNTS, basis);
}

/** The number of functions of a basis with formulas. */
export function functionCount(basis: string): number {
  return COUNTS[basis] ?? 0;
}

/** The values of the functions for a unit light vector (x right, y up, z to the viewer). */
export function weights(basis: string, [x, y, z]: [number, number, number]): number[] {
  switch (basis) {
    case "constant":
      return [1];
    case "ptm":
      return [x * x, y * y, x * y, x, y, 1];
    case "hsh4":
    case "hsh9":
    case "hsh16":
      return harmonics(x, y, Math.max(z, 0)).slice(0, functionCount(basis));
    default:
      throw new Error(`the basis ${basis} has no formulas`);
  }
}

/**
 * Sixteen hemispherical harmonics in the convention of RTI files (Gautron et al. 2004), for the cosine c of the polar angle: without
 * the azimuth, which has no value at the zenith.
 */
function harmonics(u: number, v: number, c: number): number[] {
  const ring = Math.sqrt(c / (1 + c)), x = u * ring, y = v * ring, t = 2 * c - 1, root = (n: number): number => Math.sqrt(n / Math.PI);
  const fifth = 1 + 5 * (c * c - c);
  return [
    root(0.5),
    root(6) * x, root(1.5) * t, root(6) * y,
    -root(30) * (x * x - y * y), root(30) * x * t, root(2.5) * (1 - 6 * c + 6 * c * c), root(30) * y * t, -root(30) * 2 * x * y,
    2 * root(35) * x * (x * x - 3 * y * y), -root(210) * t * (x * x - y * y), 2 * root(21) * x * fifth,
    root(3.5) * (-1 + 12 * c - 30 * c * c + 20 * c * c * c),
    2 * root(21) * y * fifth, -root(210) * t * 2 * x * y, 2 * root(35) * y * (3 * x * x - y * y),
  ];
}

/** Weights of bases with formulas, in GLSL. */
export const CLOSED = `
vec4 closedForm[GROUPS];
vec4 weightGroup(int channel, int group) { return closedForm[group]; }`;

/** The same in GLSL: fills the groups of four values of `closedForm`. */
export const CLOSED_FORM_GLSL: Record<string, string> = {
  constant: `void fillClosedForm(vec3 l) { closedForm[0] = vec4(1.0, 0.0, 0.0, 0.0); }`,
  ptm: `void fillClosedForm(vec3 l) {
  closedForm[0] = vec4(l.x * l.x, l.y * l.y, l.x * l.y, l.x);
  closedForm[1] = vec4(l.y, 1.0, 0.0, 0.0);
}`,
  hsh4: harmonicsGlsl(1),
  hsh9: harmonicsGlsl(3),
  hsh16: harmonicsGlsl(4),
};

/** The first groups of four harmonics. */
function harmonicsGlsl(groups: number): string {
  const root = (n: number, factor = 1): string => `${factor * Math.sqrt(n / Math.PI)}`;
  const lines = [
    `vec4(${root(0.5)}, ${root(6)} * x, ${root(1.5)} * t, ${root(6)} * y)`,
    `vec4(-${root(30)} * (x * x - y * y), ${root(30)} * x * t, ${root(2.5)} * (1.0 - 6.0 * c + 6.0 * c * c), ${root(30)} * y * t)`,
    `vec4(-${root(30, 2)} * x * y, ${root(35, 2)} * x * (x * x - 3.0 * y * y), -${root(210)} * t * (x * x - y * y), ${root(21, 2)} * x * fifth)`,
    `vec4(${root(3.5)} * (-1.0 + 12.0 * c - 30.0 * c * c + 20.0 * c * c * c), ${root(21, 2)} * y * fifth, -${root(210, 2)} * t * x * y, ${root(35, 2)} * y * (3.0 * x * x - y * y))`,
  ];
  return `void fillClosedForm(vec3 l) {
  float c = max(l.z, 0.0), ring = sqrt(c / (1.0 + c)), x = l.x * ring, y = l.y * ring, t = 2.0 * c - 1.0, fifth = 1.0 + 5.0 * (c * c - c);
${lines.slice(0, groups).map((line, k) => `  closedForm[${k}] = ${line};`).join("\n")}
}`;
}
