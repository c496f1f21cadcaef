// The endless plane: tiles in the layers of texture arrays, each cell's tile chosen by the library's hash.
const endlessSource = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArray;
uniform sampler2DArray low, high, tint;
uniform vec2 size, tile, offset;
uniform ivec2 base;
uniform uvec2 seed;
uniform uint tiles;
uniform vec3 light;
uniform float scale;
uniform int cells;
out vec4 color;
${functionSource}
void mixHash(inout uvec4 v) { v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z; }
uvec4 hash4(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  mixHash(v);
  v ^= v >> 16u;
  mixHash(v);
  return v;
}
uint tileOf(ivec2 cell) { return (hash4(uvec4(uvec2(cell), seed)).x >> 16u) % tiles; }
void main() {
  vec2 place = vec2(gl_FragCoord.x, size.y - gl_FragCoord.y) / scale + offset;
  vec2 cell = floor(place / tile);
  uint number = tileOf(base + ivec2(cell));
  vec3 uv = vec3(place / tile - cell, float(number));
  vec2 dx = vec2(1.0 / (scale * tile.x), 0.0), dy = vec2(0.0, 1.0 / (scale * tile.y));
  Texel t = texelOf(textureGrad(low, uv, dx, dy).rgb, textureGrad(high, uv, dx, dy).rgb, textureGrad(tint, uv, dx, dy).rgb);
  vec3 shown = relit(t, light);
  if (cells == 1) shown = mix(shown, fract(vec3(0.61, 0.37, 0.83) * float(number + 1u)), 0.35);
  color = vec4(shown, 1);
}`;

// Uploads a picture whose tiles lie one below the other, a layer each.
async function layers(gl, unit, url, tiles) {
  const blob = await (await fetch(url)).blob();
  const whole = await createImageBitmap(blob, asStored);
  const height = whole.height / tiles;
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, gl.createTexture());
  const levels = Math.floor(Math.log2(Math.max(whole.width, height))) + 1;
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, levels, gl.RGBA8, whole.width, height, tiles);
  for (let k = 0; k < tiles; k++) {
    const layer = await createImageBitmap(whole, 0, k * height, whole.width, height, asStored);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, k, whole.width, height, 1, gl.RGBA, gl.UNSIGNED_BYTE, layer);
  }
  gl.generateMipmap(gl.TEXTURE_2D_ARRAY);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return [whole.width, height];
}

// x and y are the texel at the view's upper left; scale is pixels a texel.
const plane = { x: 0, y: 0, scale: 2, light: [-0.5, 0.5, Math.SQRT1_2] };

async function startEndless(set) {
  const stage = document.getElementById("plane"), view = document.getElementById("endless");
  const control = (id) => document.getElementById(id);
  const gl = view.getContext("webgl2"), made = program(gl, endlessSource);
  gl.useProgram(made);
  const at = (name) => gl.getUniformLocation(made, name);
  let tile;
  for (const [unit, name] of ["low", "high", "tint"].entries()) {
    tile = await layers(gl, unit, set[name], set.tiles);
    gl.uniform1i(at(name), unit);
  }
  for (const name of ["scaleLow", "biasLow", "scaleHigh", "biasHigh"]) gl.uniform3fv(at(name), set[name]);
  gl.uniform2fv(at("tile"), tile);
  gl.uniform2ui(at("seed"), 0, 0);
  const show = () => {
    const ratio = window.devicePixelRatio || 1, box = view.getBoundingClientRect();
    view.width = Math.round(box.width * ratio);
    view.height = Math.round(box.height * ratio);
    gl.viewport(0, 0, view.width, view.height);
    // Whole cells as integers, the rest as a float: as sharp far away as near.
    const base = [plane.x, plane.y].map((v, i) => Math.floor(v / tile[i]));
    gl.uniform2i(at("base"), ...base);
    gl.uniform2f(at("offset"), plane.x - base[0] * tile[0], plane.y - base[1] * tile[1]);
    gl.uniform2f(at("size"), view.width, view.height);
    gl.uniform1f(at("scale"), plane.scale * ratio);
    gl.uniform1ui(at("tiles"), control("single").checked ? 1 : set.tiles);
    gl.uniform1i(at("cells"), control("cells").checked ? 1 : 0);
    gl.uniform3fv(at("light"), plane.light);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    control("place").value = Math.round(plane.x) + ", " + Math.round(plane.y);
  };
  stage.addEventListener("pointerdown", (e) => stage.setPointerCapture(e.pointerId));
  stage.addEventListener("pointermove", (e) => {
    if (e.buttons) {
      plane.x -= e.movementX / plane.scale;
      plane.y -= e.movementY / plane.scale;
    } else {
      const box = stage.getBoundingClientRect(), half = box.height / 2;
      const u = (e.clientX - box.left - box.width / 2) / half, v = -(e.clientY - box.top - half) / half;
      const s = Math.min(1, 0.98 / Math.hypot(u, v));
      plane.light = [u * s, v * s, Math.sqrt(1 - s * s * (u * u + v * v))];
    }
    show();
  });
  stage.addEventListener("wheel", (e) => {
    e.preventDefault();
    const box = view.getBoundingClientRect(), x = e.clientX - box.left, y = e.clientY - box.top;
    const scale = Math.min(16, Math.max(0.25, plane.scale * Math.exp(-e.deltaY / 400)));
    plane.x += x / plane.scale - x / scale;
    plane.y += y / plane.scale - y / scale;
    plane.scale = scale;
    show();
  }, { passive: false });
  stage.addEventListener("keydown", (e) => {
    const step = { ArrowLeft: [-40, 0], ArrowRight: [40, 0], ArrowUp: [0, -40], ArrowDown: [0, 40] }[e.key];
    if (!step) return;
    e.preventDefault();
    plane.x += step[0] / plane.scale;
    plane.y += step[1] / plane.scale;
    show();
  });
  control("far").addEventListener("click", () => {
    for (const axis of ["x", "y"]) plane[axis] = Math.round((Math.random() - 0.5) * 2e9);
    show();
  });
  for (const id of ["cells", "single"]) control(id).addEventListener("input", show);
  window.addEventListener("resize", show);
  show();
}
