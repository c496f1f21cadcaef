// Parts of shaders that are written statement by statement: without a graphics card, loops and indices that vary take several times as
// long.

/** Beyond so many layers, statements are loops: shaders take their time to compile. */
const MOST_UNROLLED = 128;

/** Statements for 0, 1, ... as they stand, or as a loop over many. Without a graphics card, a loop takes twice their time. */
function forAll(count: number, layers: number, statement: (index: string) => string): string {
  if (count * layers > MOST_UNROLLED) return `for (int k = 0; k < ${count}; k++) { ${statement("k")} }`;
  return unrolled(count, (k) => statement(String(k)));
}

/** Statements for 0, 1, ... one after another. */
export function unrolled(count: number, statement: (index: number) => string): string {
  return Array.from({ length: count }, (_, k) => statement(k)).join("\n  ");
}

/** Keeps the layers of a place while its lights are added up. */
export function holdGlsl(layers: number): string {
  const holding = (name: string, lookUp: string): string => forAll(layers, 1, (k) => `${name}[${k}] = ${lookUp}(${k});`);
  return `void holdLayers() {\n  ${holding("held", "lookedUp")}\n#if BLURS\n  ${holding("heldAround", "lookedUpAround")}\n#endif\n}`;
}

/** Adds up the functions, of which each has a layer, or four have one; and in the same steps what lies around the place. */
export function sumGlsl(functions: number, hasLayers: boolean, channels: number): string {
  const groups = Math.ceil(functions / 4);
  if (!hasLayers) {
    const dots = (g: string): string => [0, 1, 2].map((c) => `dot(weightGroup(${c}, ${g}), layer(${g}))`).join(", ");
    return forAll(groups, 1, (g) => `sum += ${channels === 3 ? `vec3(${dots(g)})` : `dot(weightGroup(0, ${g}), layer(${g}))`}; ADD_AROUND(${meanWeights(channels, g)} * layerAround(${g}));`);
  }
  const part = (k: string, j: number): string => `sum += w[${j}] * layer(${k}).rgb; ADD_AROUND(w[${j}] * layerAround(${k}));`;
  const within = (g: string, j: number): string => {
    if (g !== "k") return 4 * Number(g) + j < functions ? part(String(4 * Number(g) + j), j) : "";
    return `if (4 * k + ${j} < ${functions}) { ${part(`4 * k + ${j}`, j)} }`;
  };
  return forAll(groups, 4, (g) => `{ vec4 w = weightGroup(0, ${g}); ${[0, 1, 2, 3].map((j) => within(g, j)).join(" ")} }`);
}

/** The weights of the luminance. */
function meanWeights(channels: number, group: string): string {
  if (channels === 1) return `weightGroup(0, ${group})`;
  return `(${["x", "y", "z"].map((c, i) => `LUMINANCE.${c} * weightGroup(${i}, ${group})`).join(" + ")})`;
}
