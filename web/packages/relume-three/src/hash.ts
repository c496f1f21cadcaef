/** The library's hash of four integers in GLSL: pcg4d of Jarzynski and Olano 2020. */
export const HASH_GLSL = `
uvec4 hash4(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  for (int round = 0; round < 2; round++) {
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    if (round == 0) v ^= v >> 16u;
  }
  return v;
}`;
