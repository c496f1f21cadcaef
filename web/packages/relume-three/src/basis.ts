// Functions with formulas, as in the library's field/basis; all other bases come with a table (table.ts).

/** Names of bases with formulas. */
const COUNTS: Record<string, number> = { constant: 1, ptm: 6, hsh9: 9 };

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
    case "hsh9":
      return harmonics(x, y, Math.max(z, 0));
    default:
      throw new Error(`the basis ${basis} has no formulas`);
  }
}

/** Nine hemispherical harmonics in the convention of RTI files (Gautron et al. 2004). */
function harmonics(x: number, y: number, c: number): number[] {
  const ratio = c / (1 + c), ring = Math.sqrt(ratio), t = 2 * c - 1;
  const first = Math.sqrt(6 / Math.PI), second = Math.sqrt(30 / Math.PI);
  return [
    Math.sqrt(0.5 / Math.PI),
    first * x * ring,
    Math.sqrt(1.5 / Math.PI) * t,
    first * y * ring,
    -second * (x * x - y * y) * ratio,
    second * x * t * ring,
    Math.sqrt(2.5 / Math.PI) * (1 - 6 * c + 6 * c * c),
    second * y * t * ring,
    -second * 2 * x * y * ratio,
  ];
}

/** The same in GLSL: fills the groups of four values of `closedForm`. */
export const CLOSED_FORM_GLSL: Record<string, string> = {
  constant: `void fillClosedForm(vec3 l) { closedForm[0] = vec4(1.0, 0.0, 0.0, 0.0); }`,
  ptm: `void fillClosedForm(vec3 l) {
  closedForm[0] = vec4(l.x * l.x, l.y * l.y, l.x * l.y, l.x);
  closedForm[1] = vec4(l.y, 1.0, 0.0, 0.0);
}`,
  hsh9: `void fillClosedForm(vec3 l) {
  float c = max(l.z, 0.0), ratio = c / (1.0 + c), ring = sqrt(ratio), t = 2.0 * c - 1.0;
  const float first = ${Math.sqrt(6 / Math.PI)}, second = ${Math.sqrt(30 / Math.PI)};
  closedForm[0] = vec4(${Math.sqrt(0.5 / Math.PI)}, first * l.x * ring, ${Math.sqrt(1.5 / Math.PI)} * t, first * l.y * ring);
  closedForm[1] = vec4(-second * (l.x * l.x - l.y * l.y) * ratio, second * l.x * t * ring,
    ${Math.sqrt(2.5 / Math.PI)} * (1.0 - 6.0 * c + 6.0 * c * c), second * l.y * t * ring);
  closedForm[2] = vec4(-second * 2.0 * l.x * l.y * ratio, 0.0, 0.0, 0.0);
}`,
};
