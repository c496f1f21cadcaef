// By-example noise (Heitz and Neyret 2018) as the library computes it: the normal values of the principal planes in the
// layers of a texture array, three planes a layer, and a row of a table for each plane that puts its values back.
const noiseSource = (planes, entries) => `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
uniform sampler2DArray normals;
uniform sampler2D tables;
uniform vec2 size, offset, fraction;
uniform ivec2 base, exemplar;
uniform uvec2 key;
uniform vec3 mean, weights[${planes}];
uniform float side, scale, reach;
uniform int plain, grid;
out vec4 color;
${hashSource}
const float HEIGHT = 0.8660254037844386;
// The upper half of the product of a hash and a number below 2^16.
int among(uint hash, int room) {
  uint n = uint(room);
  return int(((hash >> 16u) * n + (((hash & 65535u) * n) >> 16u)) >> 16u);
}
// The texel of the exemplar that a vertex shows at p.
ivec2 sourceOf(ivec2 vertex, ivec2 p) {
  vec2 place = side * vec2(float(vertex.x) + 0.5 * float(vertex.y), HEIGHT * float(vertex.y));
  ivec2 middle = ivec2(floor(place + fraction + 0.5));
  uvec4 hash = hash4(uvec4(uvec2(base + vertex), key));
  int margin = int(side) + 1;
  ivec2 room = exemplar - 2 * margin;
  return margin + ivec2(among(hash.x, room.x), among(hash.y, room.y)) + p - middle;
}
float put(int plane, float normal) {
  float place = clamp((normal / reach * 0.5 + 0.5) * ${entries - 1}.0, 0.0, ${entries - 1}.0);
  int below = int(place);
  float low = texelFetch(tables, ivec2(below, plane), 0).r;
  return mix(low, texelFetch(tables, ivec2(min(below + 1, ${entries - 1}), plane), 0).r, place - float(below));
}
void main() {
  ivec2 p = ivec2(floor(vec2(gl_FragCoord.x, size.y - gl_FragCoord.y) / scale + offset));
  vec2 from = vec2(p) - fraction;
  float down = from.y / (side * HEIGHT), across = from.x / side - 0.5 * down;
  ivec2 cell = ivec2(floor(vec2(across, down)));
  vec2 st = vec2(across, down) - vec2(cell);
  bool upper = st.x + st.y < 1.0;
  ivec2 first = sourceOf(cell + (upper ? ivec2(0) : ivec2(1)), p);
  ivec2 second = sourceOf(cell + (upper ? ivec2(1, 0) : ivec2(0, 1)), p);
  ivec2 third = sourceOf(cell + (upper ? ivec2(0, 1) : ivec2(1, 0)), p);
  vec3 w = upper ? vec3(1.0 - st.x - st.y, st) : vec3(st.x + st.y - 1.0, 1.0 - st);
  if (grid == 1 && min(w.x, min(w.y, w.z)) < 0.5 / side) { color = vec4(1.0, 0.8, 0.45, 1.0); return; }
  // Weights over the root of their squares' sum keep the variance.
  if (plain == 0) w /= length(w);
  vec3 sum = mean;
  for (int layer = 0; layer < ${Math.ceil(planes / 3)}; layer++) {
    mat3 parts = mat3(
      texelFetch(normals, ivec3(first, layer), 0).rgb,
      texelFetch(normals, ivec3(second, layer), 0).rgb,
      texelFetch(normals, ivec3(third, layer), 0).rgb);
    vec3 normal = ((parts * 2.0 - mat3(1, 1, 1, 1, 1, 1, 1, 1, 1)) * w) * reach;
    for (int c = 0; c < 3 && 3 * layer + c < ${planes}; c++) {
      sum += weights[3 * layer + c] * put(3 * layer + c, normal[c]);
    }
  }
  color = vec4(sum, 1);
}`;

const startNoise = (noise) => startPlane("noise", {
  scale: 1,
  least: 1,
  source: noiseSource(noise.planes, noise.entries),
  prepare: async (gl, at, control) => {
    await layers(gl, 0, noise.normals, Math.ceil(noise.planes / 3));
    gl.uniform1i(at("normals"), 0);
    const bytes = Uint8Array.from(atob(noise.tables), (letter) => letter.charCodeAt(0));
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, noise.entries, noise.planes, 0, gl.RED, gl.FLOAT, new Float32Array(bytes.buffer));
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    gl.uniform1i(at("tables"), 1);
    gl.uniform1f(at("side"), noise.side);
    gl.uniform1f(at("reach"), noise.reach);
    gl.uniform2iv(at("exemplar"), noise.size);
    gl.uniform2ui(at("key"), noise.key[0], noise.key[1]);
    // The values under a light of functions R, G and B, six coefficients each.
    const value = (functions, [u, v]) => {
      const basis = [u * u, v * v, u * v, u, v, 1];
      return [0, 6, 12].map((first) => basis.reduce((sum, b, k) => sum + b * functions[first + k], 0));
    };
    return (plane) => {
      // A vertex near the view as integers, the rest as floats: as sharp far away as near.
      const height = noise.side * Math.sqrt(0.75), j = Math.floor(plane.y / height);
      const i = Math.floor(plane.x / noise.side - 0.5 * j);
      const vertex = [noise.side * (i + 0.5 * j), height * j], whole = vertex.map(Math.floor);
      gl.uniform2i(at("base"), i, j);
      gl.uniform2f(at("fraction"), vertex[0] - whole[0], vertex[1] - whole[1]);
      gl.uniform2f(at("offset"), plane.x - whole[0], plane.y - whole[1]);
      gl.uniform3fv(at("mean"), value(noise.mean, plane.light));
      gl.uniform3fv(at("weights"), noise.axes.flatMap((axis) => value(axis, plane.light)));
      gl.uniform1i(at("plain"), control("plain").checked ? 1 : 0);
      gl.uniform1i(at("grid"), control("grid").checked ? 1 : 0);
    };
  },
});
