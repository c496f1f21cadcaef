// Parts of shaders that are written statement by statement: without a graphics card, loops and indices that vary take several times as
// long.

/** Beyond so many, statements are loops: shaders take their time to compile. */
const MOST_UNROLLED = 32;

/** Statements for 0, 1, ... as they stand, or as a loop over many. Without a graphics card, a loop takes twice their time. */
function forAll(count: number, statement: (index: string) => string): string {
  if (count > MOST_UNROLLED) return `for (int k = 0; k < ${count}; k++) { ${statement("k")} }`;
  return unrolled(count, (k) => statement(String(k)));
}

/** Statements for 0, 1, ... one after another. */
export function unrolled(count: number, statement: (index: number) => string): string {
  return Array.from({ length: count }, (_, k) => statement(k)).join("\n  ");
}

/** Keeps the layers of a place while its lights are added up. */
export function holdGlsl(layers: number): string {
  const blurred = (levels: string): string => forAll(layers, (k) => `${levels}[${k}] = decoded(blurredBy(planes, ${k}, ${levels.toUpperCase()}), ${k});`);
  const still = ["fine", "middle", "soft"].map(blurred).join("\n");
  return `void holdLayers() {\n  ${forAll(layers, (k) => `held[${k}] = lookedUp(${k});`)}\n#if MODE == MULTI_LIGHT\n${still}\n#endif\n}`;
}

/** Adds up the functions, of which each has a layer, or four have one. */
export function sumGlsl(functions: number, hasLayers: boolean, channels: number): string {
  const groups = Math.ceil(functions / 4);
  if (!hasLayers) {
    const dots = (g: string): string => [0, 1, 2].map((c) => `dot(weightGroup(${c}, ${g}), layer(${g}))`).join(", ");
    return forAll(groups, (g) => `sum += ${channels === 3 ? `vec3(${dots(g)})` : `dot(weightGroup(0, ${g}), layer(${g}))`};`);
  }
  const part = (g: string, j: number): string => `sum += w[${j}] * layer(4 * ${g} + ${j}).rgb;`;
  const within = (g: string, j: number): string => (g === "k" ? `if (4 * k + ${j} < ${functions}) ${part(g, j)}` : 4 * Number(g) + j < functions ? part(g, j) : "");
  return forAll(groups, (g) => `{ vec4 w = weightGroup(0, ${g}); ${[0, 1, 2, 3].map((j) => within(g, j)).join(" ")} }`);
}
