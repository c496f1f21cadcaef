// The library's hash of four integers, pcg4d of Jarzynski and Olano 2020.
const hashSource = `
void mixHash(inout uvec4 v) { v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z; }
uvec4 hash4(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  mixHash(v);
  v ^= v >> 16u;
  mixHash(v);
  return v;
}
`;

// Uploads a picture whose parts of equal height lie one below the other, a layer each.
async function layers(gl, unit, url, parts) {
  const blob = await (await fetch(url)).blob();
  const whole = await createImageBitmap(blob, asStored);
  const height = whole.height / parts;
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D_ARRAY, gl.createTexture());
  const levels = Math.floor(Math.log2(Math.max(whole.width, height))) + 1;
  gl.texStorage3D(gl.TEXTURE_2D_ARRAY, levels, gl.RGBA8, whole.width, height, parts);
  for (let k = 0; k < parts; k++) {
    const layer = await createImageBitmap(whole, 0, k * height, whole.width, height, asStored);
    gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, k, whole.width, height, 1, gl.RGBA, gl.UNSIGNED_BYTE, layer);
  }
  gl.generateMipmap(gl.TEXTURE_2D_ARRAY);
  gl.texParameteri(gl.TEXTURE_2D_ARRAY, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  return [whole.width, height];
}

// Shows an endless plane in the element of a name: x and y are the texel at the view's upper left, scale is pixels a
// texel, from the least on. prepare makes the shader and gives back what sets its uniforms for each frame.
async function startPlane(name, { scale, least, source, prepare }) {
  const control = (id) => document.getElementById(`${name}-${id}`);
  const stage = document.getElementById(name), view = control("view");
  const gl = view.getContext("webgl2"), made = program(gl, source);
  gl.useProgram(made);
  const at = (uniform) => gl.getUniformLocation(made, uniform);
  const frame = await prepare(gl, at, control);
  const plane = { x: 0, y: 0, scale, light: [-0.5, 0.5, Math.SQRT1_2] };
  const show = () => {
    const ratio = window.devicePixelRatio || 1, box = view.getBoundingClientRect();
    view.width = Math.round(box.width * ratio);
    view.height = Math.round(box.height * ratio);
    gl.viewport(0, 0, view.width, view.height);
    gl.uniform2f(at("size"), view.width, view.height);
    gl.uniform1f(at("scale"), plane.scale * ratio);
    frame(plane);
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
    const scale = Math.min(16, Math.max(least, plane.scale * Math.exp(-e.deltaY / 400)));
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
  document.querySelectorAll(`#${name}-controls input`).forEach((input) => input.addEventListener("input", show));
  window.addEventListener("resize", show);
  show();
  // window.planes.noise.move(x, y, scale, light) moves a view from the console.
  window.planes = { ...window.planes, [name]: { move: (x, y, scale, light) => { Object.assign(plane, { x, y, scale, light }); show(); } } };
}
