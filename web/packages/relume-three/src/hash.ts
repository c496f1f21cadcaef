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

/** The same in integers of 32 bits. */
export function hash4(x: number, y: number, z: number, w: number): [number, number, number, number] {
  const mixed = (n: number): number => Math.imul(n, 1664525) + 1013904223;
  let [a, b, c, d] = [mixed(x), mixed(y), mixed(z), mixed(w)];
  for (let round = 0; round < 2; round++) {
    a = (a + Math.imul(b, d)) | 0;
    b = (b + Math.imul(c, a)) | 0;
    c = (c + Math.imul(a, b)) | 0;
    d = (d + Math.imul(b, c)) | 0;
    if (round === 0) [a, b, c, d] = [a ^ (a >>> 16), b ^ (b >>> 16), c ^ (c >>> 16), d ^ (d >>> 16)];
  }
  return [a >>> 0, b >>> 0, c >>> 0, d >>> 0];
}
