import {
  DataArrayTexture, DataTexture, FloatType, GLSL3, HalfFloatType, Mesh, NearestFilter, OrthographicCamera, PlaneGeometry, RGBAFormat,
  RawShaderMaterial, RedFormat, Scene, Vector2, Vector3, type WebGLArrayRenderTarget, type WebGLRenderer,
} from "three";
import type { BlockMaker } from "./endless.js";
import type { FieldNoise } from "./field.js";
import { HASH_GLSL } from "./hash.js";
import type { PlaneBlock, PlaneWindow } from "./window.js";

const VERTEX = `
in vec3 position;
void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }`;

// By-example noise (Heitz and Neyret 2018) as the library computes it (synthesis/noise): the coefficients of one function.
const FRAGMENT = `
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
uniform sampler2DArray normals;
uniform sampler2D tables;
uniform vec2 slot, offset, fraction;
uniform ivec2 base, exemplar;
uniform uvec2 key;
uniform vec3 functions[PLANES + 1];
uniform float side, reach;
uniform int averages;
out vec4 coefficients;
${HASH_GLSL}
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
// The value of a plane for a normal value.
float restored(int plane, float normal) {
  float place = clamp((normal / reach * 0.5 + 0.5) * float(ENTRIES - 1), 0.0, float(ENTRIES - 1));
  int below = int(place);
  float low = texelFetch(tables, ivec2(below, plane), 0).r;
  return mix(low, texelFetch(tables, ivec2(min(below + 1, ENTRIES - 1), plane), 0).r, place - float(below));
}
void main() {
  ivec2 p = ivec2(floor(gl_FragCoord.xy - slot + offset));
  vec2 from = vec2(p) - fraction;
  float down = from.y / (side * HEIGHT), across = from.x / side - 0.5 * down;
  ivec2 cell = ivec2(floor(vec2(across, down)));
  vec2 st = vec2(across, down) - vec2(cell);
  bool upper = st.x + st.y < 1.0;
  ivec2 first = sourceOf(cell + (upper ? ivec2(0) : ivec2(1)), p);
  ivec2 second = sourceOf(cell + (upper ? ivec2(1, 0) : ivec2(0, 1)), p);
  ivec2 third = sourceOf(cell + (upper ? ivec2(0, 1) : ivec2(1, 0)), p);
  vec3 w = upper ? vec3(1.0 - st.x - st.y, st) : vec3(st.x + st.y - 1.0, 1.0 - st);
  // The sides of triangles are marked by an opacity of 0.
  float mark = min(w.x, min(w.y, w.z)) < 0.5 / side ? 0.0 : 1.0;
  // Weights over the root of their squares' sum keep the variance.
  if (averages == 0) w /= length(w);
  vec3 sum = functions[0];
  for (int group = 0; group < (PLANES + 3) / 4; group++) {
    vec4 normal = w.x * texelFetch(normals, ivec3(first, group), 0);
    normal += w.y * texelFetch(normals, ivec3(second, group), 0);
    normal += w.z * texelFetch(normals, ivec3(third, group), 0);
    for (int c = 0; c < 4; c++) {
      int plane = 4 * group + c;
      if (plane < PLANES) sum += functions[plane + 1] * restored(plane, normal[c]);
    }
  }
  coefficients = vec4(sum, mark);
}`;

/** Noise drawn by the graphics card: a layer for each function, its coefficients for red, green and blue. */
export class NoiseBlocks implements BlockMaker {
  readonly side = 128;
  private averaging = false;
  private readonly scene = new Scene();
  private readonly camera = new OrthographicCamera();
  private readonly material: RawShaderMaterial;
  private readonly square = new PlaneGeometry(2, 2);
  private readonly normals: DataArrayTexture;
  private readonly tables: DataTexture;

  /** `layers` are the planes of normal values, four together; the exemplar has `width` x `height` texels. */
  constructor(private readonly noise: FieldNoise, readonly layers: number, normals: Uint16Array[], width: number, height: number) {
    this.normals = normalTexture(normals, width, height);
    this.tables = new DataTexture(noise.tables as Float32Array<ArrayBuffer>, noise.entries, noise.planes, RedFormat, FloatType);
    this.tables.minFilter = this.tables.magFilter = NearestFilter;
    this.tables.needsUpdate = true;
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3, vertexShader: VERTEX, fragmentShader: FRAGMENT, depthTest: false, depthWrite: false,
      defines: { PLANES: noise.planes, ENTRIES: noise.entries },
      uniforms: {
        normals: { value: this.normals }, tables: { value: this.tables }, slot: { value: new Vector2() }, offset: { value: new Vector2() },
        fraction: { value: new Vector2() }, base: { value: new Vector2() }, exemplar: { value: new Vector2(width, height) },
        key: { value: new Vector2(...noise.key) }, functions: { value: [] }, side: { value: noise.side }, reach: { value: noise.reach },
        averages: { value: 0 },
      },
    });
    const mesh = new Mesh(this.square, this.material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
  }

  /** Whether parts are averaged, which loses contrast, instead of blended. */
  get averages(): boolean {
    return this.averaging;
  }

  set averages(value: boolean) {
    this.averaging = value;
    this.set("averages", value ? 1 : 0);
  }

  make(renderer: WebGLRenderer, target: WebGLArrayRenderTarget, block: PlaneBlock, window: PlaneWindow): null {
    const { side } = this.noise, [slotX, slotY] = window.placeOf(block), x = block.column * this.side, y = block.row * this.side;
    // A vertex near the square as integers, the rest as floats: as sharp far away as near.
    const height = side * Math.sqrt(0.75), j = Math.floor(y / height), i = Math.floor(x / side - 0.5 * j);
    const vertex = [side * (i + 0.5 * j), height * j] as const, whole = vertex.map(Math.floor) as [number, number];
    this.vector("slot").set(slotX, slotY);
    this.vector("offset").set(x - whole[0], y - whole[1]);
    this.vector("fraction").set(vertex[0] - whole[0], vertex[1] - whole[1]);
    this.vector("base").set(i, j);
    target.viewport.set(slotX, slotY, this.side, this.side);
    for (let layer = 0; layer < this.layers; layer++) {
      this.set("functions", this.functionsOf(layer));
      this.material.uniformsNeedUpdate = true;
      renderer.setRenderTarget(target, layer);
      renderer.render(this.scene, this.camera);
    }
    target.viewport.set(0, 0, target.width, target.height);
    return null;
  }

  dispose(): void {
    for (const part of [this.material, this.square, this.normals, this.tables]) part.dispose();
  }

  /** The coefficients of a function for red, green and blue: of the mean and of each plane. */
  private functionsOf(layer: number): Vector3[] {
    const { functions, planes } = this.noise, each = functions.length / (planes + 1), channels = each / this.layers;
    const at = (k: number, c: number): number => functions[k * each + (channels === 1 ? 0 : c) * this.layers + layer] ?? 0;
    return Array.from({ length: planes + 1 }, (_, k) => new Vector3(at(k, 0), at(k, 1), at(k, 2)));
  }

  private vector(name: string): Vector2 {
    return this.material.uniforms[name]?.value as Vector2;
  }

  private set(name: string, value: unknown): void {
    const uniform = this.material.uniforms[name];
    if (uniform) uniform.value = value;
  }
}

function normalTexture(layers: Uint16Array[], width: number, height: number): DataArrayTexture {
  const whole = new Uint16Array(4 * width * height * layers.length);
  layers.forEach((layer, k) => whole.set(layer, 4 * width * height * k));
  const texture = new DataArrayTexture(whole, width, height, layers.length);
  texture.format = RGBAFormat;
  texture.type = HalfFloatType;
  texture.minFilter = texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  return texture;
}
