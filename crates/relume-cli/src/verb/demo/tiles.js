// The endless plane: tiles in the layers of texture arrays, each cell's tile chosen by the library's hash.
// The steps right and down lead from a cell to its neighbours; origin is the corner of a tile's rectangle.
const tilesSource = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArray;
uniform sampler2DArray low, high, tint;
uniform vec2 size, tile, offset;
uniform ivec2 base, right, down, origin;
uniform uvec2 seed;
uniform uint tiles;
uniform vec3 light;
uniform float scale;
uniform int cells;
out vec4 color;
${functionSource}
${hashSource}
uint tileOf(ivec2 cell) { return (hash4(uvec4(uvec2(cell), seed)).x >> 16u) % tiles; }
int floorDivide(int a, int b) {
  int q = int(floor(float(a) / float(b))), rest = a - q * b;
  return rest < 0 ? q - 1 : rest >= b ? q + 1 : q;
}
ivec2 cellOf(ivec2 p) {
  int texels = right.x * down.y - right.y * down.x;
  return ivec2(floorDivide(p.x * down.y - p.y * down.x, texels), floorDivide(right.x * p.y - right.y * p.x, texels));
}
void main() {
  vec2 place = vec2(gl_FragCoord.x, size.y - gl_FragCoord.y) / scale + offset;
  ivec2 cell = cellOf(ivec2(floor(place)));
  uint number = tileOf(base + cell);
  vec3 uv = vec3((place - vec2(cell.x * right + cell.y * down + origin)) / tile, float(number));
  vec2 dx = vec2(1.0 / (scale * tile.x), 0.0), dy = vec2(0.0, 1.0 / (scale * tile.y));
  Texel t = texelOf(textureGrad(low, uv, dx, dy).rgb, textureGrad(high, uv, dx, dy).rgb, textureGrad(tint, uv, dx, dy).rgb);
  vec3 shown = relit(t, light);
  if (cells == 1) shown = mix(shown, fract(vec3(0.61, 0.37, 0.83) * float(number + 1u)), 0.35);
  color = vec4(shown, 1);
}`;

const startTiles = (set) => startPlane("tiles", {
  scale: 2,
  least: 0.25,
  source: tilesSource,
  prepare: async (gl, at, control) => {
    let tile;
    for (const [unit, name] of ["low", "high", "tint"].entries()) {
      tile = await layers(gl, unit, set[name], set.tiles);
      gl.uniform1i(at(name), unit);
    }
    for (const name of ["scaleLow", "biasLow", "scaleHigh", "biasHigh"]) gl.uniform3fv(at(name), set[name]);
    gl.uniform2fv(at("tile"), tile);
    for (const name of ["right", "down", "origin"]) gl.uniform2iv(at(name), set[name]);
    gl.uniform2ui(at("seed"), 0, 0);
    const [w, t] = set.right, [s, h] = set.down, texels = w * h - s * t;
    return (plane) => {
      // Whole cells as integers, the rest as a float: as sharp far away as near.
      const i = Math.floor((plane.x * h - plane.y * s) / texels), j = Math.floor((w * plane.y - t * plane.x) / texels);
      gl.uniform2i(at("base"), i, j);
      gl.uniform2f(at("offset"), plane.x - i * w - j * s, plane.y - i * t - j * h);
      gl.uniform1ui(at("tiles"), control("single").checked ? 1 : set.tiles);
      gl.uniform1i(at("cells"), control("cells").checked ? 1 : 0);
      gl.uniform3fv(at("light"), plane.light);
    };
  },
});
