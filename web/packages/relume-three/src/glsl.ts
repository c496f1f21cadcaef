import { HASH_GLSL } from "./hash.js";

// The shaders of ReflectanceMaterial. Row 0 of a texture is its top, and texture coordinates have v up.

export const VERTEX: string = `
in vec4 tangent;
out vec3 worldPosition, worldNormal, worldTangent;
out float handedness;
out vec2 place;
uniform vec2 tiling, shift;
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  worldPosition = world.xyz;
  worldNormal = mat3(modelMatrix) * normal;
  worldTangent = mat3(modelMatrix) * tangent.xyz;
  handedness = tangent.w < 0.0 ? -1.0 : 1.0;
  place = uv * tiling + shift;
  gl_Position = projectionMatrix * viewMatrix * world;
}`;

/** Look-ups of coefficients at the place of a fragment. */
export const LOOKUP: string = `
uniform sampler2DArray planes;
uniform vec2 texels;
uniform float sharpen, radius;
// Decided when the shader is compiled: where no graphics card draws, all branches of others take their time.
const int mode = MODE;
const bool flat_ = FLAT == 1, glossy = GLOSS == 1;
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);
#if CELLS
uniform ivec2 right, down, origin, baseCell;
uniform int oneTile;
uniform float padding;
int tile;
${HASH_GLSL}
int floorDivide(int a, int b) {
  int q = int(floor(float(a) / float(b))), rest = a - q * b;
  return rest < 0 ? q - 1 : rest >= b ? q + 1 : q;
}
uvec4 hashOf(ivec2 cell) { return hash4(uvec4(uvec2(baseCell + cell), 0u, 0u)); }
// The library's numeric/endless.rs and numeric/corner_colors.rs.
int tileOf(ivec2 cell) {
#if CORNERS > 1
  int kind = 0, power = 1;
  for (int corner = 0; corner < 4; corner++) {
    kind += power * int((hashOf(cell + ivec2(corner & 1, corner >> 1)).x >> 16u) % uint(CORNERS));
    power *= CORNERS;
  }
  int alike = (TILES - kind + power - 1) / power;
  return kind + power * int((hashOf(cell).y >> 16u) % uint(alike));
#else
  return int((hashOf(cell).x >> 16u) % uint(TILES));
#endif
}
#endif
#if ENDLESS
uniform vec2 windowShift;
#endif
uniform int showCells;
// The size of the texture on the card, in texels.
uniform vec2 extent;
uniform bool crisp, clipped;
uniform vec4 clip;
vec2 at, dx, dy;
// The pyramid's level, and the logarithm of the width in texels over which look-ups average.
float level, footprint;
void findPlace() {
  vec2 coordinates = vec2(place.x, 1.0 - place.y);
  if (clipped && (any(lessThan(place, clip.xy)) || any(greaterThan(place, clip.zw)))) discard;
  vec2 scale = texels / extent;
  dx = dFdx(coordinates) * scale;
  dy = dFdy(coordinates) * scale;
  float longer = max(length(dx * extent), length(dy * extent));
  level = footprint = log2(max(longer, 1.0));
#if ANISOTROPIC > 1
  footprint = log2(max(max(min(length(dx * extent), length(dy * extent)), longer / float(ANISOTROPIC)), 1.0));
#endif
  at = coordinates;
#if CELLS
  ivec2 p = ivec2(floor(coordinates * texels));
  int area = right.x * down.y - right.y * down.x;
  ivec2 cell = ivec2(floorDivide(p.x * down.y - p.y * down.x, area), floorDivide(right.x * p.y - right.y * p.x, area));
  tile = oneTile == 1 ? 0 : tileOf(cell);
  at = (coordinates * texels - vec2(cell.x * right + cell.y * down + origin) + padding) / extent;
#endif
#if ENDLESS
  at = coordinates * scale + windowShift;
#endif
  if (crisp) at = (floor(at * extent) + 0.5) / extent;
}
float layerIndex(int k) {
#if CELLS
  return float(k * TILES + tile);
#else
  return float(k);
#endif
}
vec4 sampled(sampler2DArray source, int k) {
#if ANISOTROPIC > 1
  return textureGrad(source, vec3(at, layerIndex(k)), dx, dy);
#else
  return textureLod(source, vec3(at, layerIndex(k)), level);
#endif
}
vec4 blurredBy(sampler2DArray source, int k, float levels) { return textureLod(source, vec3(at, layerIndex(k)), level + levels); }
vec4 blurred(sampler2DArray source, int k) { return blurredBy(source, k, radius); }
#if CODED
uniform vec3 codeScale[FUNCTIONS], codeOffset[FUNCTIONS];
vec4 decoded(vec4 codes, int k) { return vec4(codeScale[k] * codes.rgb + codeOffset[k], codes.a); }
#else
vec4 decoded(vec4 values, int k) { return values; }
#endif
vec4 lookedUp(int k) {
  vec4 here = decoded(sampled(planes, k), k);
  if (mode == UNSHARP_COEFFICIENTS) here += sharpen * (here - decoded(blurred(planes, k), k));
  return here;
}
//AROUND
#if IS_HELD
vec4 held[LAYERS];
vec4 layer(int k) { return held[k]; }
//HOLD
#else
void holdLayers() {}
vec4 layer(int k) { return lookedUp(k); }
#endif`;

/** The value of the functions at the place, in the space of the texture. */
export const EVALUATE: string = `
// Whether a light is a lamp, which makes highlights; the light from all around may be less than none at one of its places.
bool ofLamp = true;
#if SHAPES
vec3 lightOfShapes;
#endif
vec3 evaluate() {
  vec3 sum = vec3(0.0);
#if BLURS
  around = vec3(0.0);
#endif
//SUM
#if ARRANGEMENT == 2
  sum *= layer(GROUPS).rgb;
#if BLURS
  around *= vec4(LUMINANCE, 0.0) * layerAround(GROUPS);
#endif
#endif
#if SHAPES
  // Under the light from all around, whose lamps stand for smooth light, boundaries fade as in the linear form.
  if (ofLamp) addMovedBoundaries(lightOfShapes, sum);
#endif
  return sum;
}
vec3 valueFor(vec3 light, vec3 view) {
  fillWeights(light, view);
#if SHAPES
  lightOfShapes = light;
#endif
  return evaluate();
}
// The value for the light that is added: of a lamp whose weights are known, without looking for them.
vec3 valueUnder(vec3 light, vec3 view) {
#if AMBIENT && LAMP_SIDE > 0
  if (!ofLamp) {
    isForLamp = true;
    return evaluate();
  }
#endif
  return valueFor(light, view);
}
vec3 toLinear(vec3 v) {
#if SRGB
  v = mix(v / 12.92, pow(max(v + 0.055, 0.0) / 1.055, vec3(2.4)), step(vec3(0.04045), v));
  return max(v, 0.0);
#else
  return ofLamp ? max(v, 0.0) : v;
#endif
}`;

/** What is shown, by mode; and the lights. */
export const FRAGMENT: string = `
in vec3 worldPosition, worldNormal, worldTangent;
in float handedness;
in vec2 place;
out vec4 shown;
uniform int lights;
uniform vec3 lightDirection[MOST_DIRECTIONS], lightColor[MOST_DIRECTIONS];
uniform float gain, exposure, gloss, roughness;
uniform mat3 balance;
uniform vec3 plainLight;
uniform float lowestLight;
uniform vec2 heightRange;
#if MAPS
uniform sampler2DArray maps;
#endif
//LOOKUP
//WEIGHTS
//EVALUATE
vec3 tangentX, tangentY, tangentZ, eye;
void findFrame() {
  if (flat_) {
    tangentX = vec3(1.0, 0.0, 0.0);
    tangentY = vec3(0.0, 1.0, 0.0);
    tangentZ = eye = vec3(0.0, 0.0, 1.0);
    return;
  }
  eye = normalize(isOrthographic ? vec3(viewMatrix[0].z, viewMatrix[1].z, viewMatrix[2].z) : cameraPosition - worldPosition);
  vec3 along = dFdx(worldPosition), across = dFdy(worldPosition);
  vec3 n = normalize(worldNormal), t = worldTangent;
  if (dot(t, t) < 1e-12) {
    // Without tangents: dP/ds from the slopes on the screen.
    vec2 a = dFdx(place), b = dFdy(place);
    t = (along * b.y - across * a.y) * sign(a.x * b.y - a.y * b.x);
  }
  vec3 face = cross(along, across);
  if (dot(face, n) < 0.0) face = -face;
  vec3 flatTangent = t - n * dot(n, t);
  // Where the texture has no direction, any will do: the same as in the library's vector.rs.
  if (!(dot(flatTangent, flatTangent) > 1e-30)) {
    vec3 axis = abs(n.x) < 0.7 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
    flatTangent = axis - n * dot(n, axis);
  }
  tangentX = normalize(flatTangent);
  tangentY = cross(n, tangentX) * handedness;
  tangentZ = dot(face, eye) < 0.0 ? -n : n;
}
vec3 inFrame(vec3 d) { return vec3(dot(d, tangentX), dot(d, tangentY), dot(d, tangentZ)); }
vec3 fromDisk(vec2 d) {
  d /= max(length(d), 1.0);
  return vec3(d, sqrt(max(0.0, 1.0 - dot(d, d))));
}
float attachedShare(float cosine) {
  if (flat_) return cosine > 0.0 ? 1.0 : 0.0;
  // Below the lowest measured lights as a matt surface, else over the last six degrees.
  bool proportional = lowestLight > 0.1;
  float t = clamp(cosine / (proportional ? lowestLight : 0.1), 0.0, 1.0);
  return proportional ? t : t * t * (3.0 - 2.0 * t);
}
vec4 normalAndHeight() {
#if MAPS
  vec4 here = sampled(maps, 0);
  return vec4(normalize(here.xyz), here.w);
#else
  return vec4(0.0, 0.0, 1.0, 0.0);
#endif
}
vec3 albedo() {
#if MAPS
  return sampled(maps, 1).rgb;
#else
  return vec3(1.0);
#endif
}
// GGX with height-correlated Smith shadowing and Schlick's Fresnel term, times pi (the library's microfacet.rs).
float lobe(vec3 n, vec3 l, vec3 v) {
  float nl = dot(n, l), nv = dot(n, v);
  vec3 sum = l + v;
  if (nl <= 0.0 || nv <= 0.0 || dot(sum, sum) < 1e-12) return 0.0;
  vec3 h = normalize(sum);
  float alpha = max(roughness, 0.05) * max(roughness, 0.05), a2 = alpha * alpha, nh = dot(n, h);
  float t = nh * nh * (a2 - 1.0) + 1.0, distribution = a2 / t / t;
  float visibility = 0.5 / max(nl * sqrt(a2 + (1.0 - a2) * nv * nv) + nv * sqrt(a2 + (1.0 - a2) * nl * nl), 1e-9);
  float fresnel = gloss + (1.0 - gloss) * pow(1.0 - clamp(dot(l, h), 0.0, 1.0), 5.0);
  return distribution * visibility * fresnel * nl;
}
// The function about its value at the normal, with its differences multiplied: f(n) + f'(n)(l - n) + g (f(l) - f(n) - f'(n)(l - n)).
vec3 diffuseGain(vec3 l, vec3 v, vec3 n) {
  vec3 peak = valueFor(n, v), value = valueUnder(l, v);
  const float STEP = 1.0 / 64.0;
  vec2 from = n.xy / max(1.0, length(n.xy) / 0.98), d = l.xy - n.xy;
  vec3 slopeX = (valueFor(fromDisk(from + vec2(STEP, 0.0)), v) - valueFor(fromDisk(from - vec2(STEP, 0.0)), v)) / (2.0 * STEP);
  vec3 slopeY = (valueFor(fromDisk(from + vec2(0.0, STEP)), v) - valueFor(fromDisk(from - vec2(0.0, STEP)), v)) / (2.0 * STEP);
  vec3 tangentPlane = peak + slopeX * d.x + slopeY * d.y;
  return tangentPlane + gain * (value - tangentPlane);
}
//MANY
// Blue to red over 0..1 through green and yellow.
vec3 heat(float t) {
  t = clamp(t, 0.0, 1.0);
  return clamp(vec3(1.5 - abs(4.0 * t - 3.0), 1.5 - abs(4.0 * t - 2.0), 1.5 - abs(4.0 * t - 1.0)), 0.0, 1.0);
}
vec3 underLight(vec3 l, vec3 v, vec3 n) {
  if (mode == DIFFUSE_GAIN) return toLinear(diffuseGain(l, v, n));
  if (mode == PLAIN) return toLinear(valueFor(plainLight, vec3(0.0, 0.0, 1.0))) * l.z;
  if (mode == UNSHARP_NORMALS) {
#if MAPS
    vec3 sharp = normalize(n + gain * (n - blurred(maps, 0).xyz));
    return toLinear(albedo() * max(dot(sharp, l), 0.0));
#endif
  }
  vec3 value = valueUnder(l, v);
  if (mode == SPECULAR) {
    float luminance = max(dot(value, LUMINANCE), 0.0);
    return toLinear(0.4 * value + 0.7 * gain * pow(max(dot(n, normalize(l + v)), 0.0), 75.0) * luminance);
  }
#if MODE == UNSHARP_LUMINANCE
  float sharp = dot(value, LUMINANCE);
  value *= max(sharp + gain * (sharp - around.x), 0.0) / max(sharp, 1e-4);
#endif
  if (mode == SHADING) {
    vec3 body = albedo();
    float share = dot(value, LUMINANCE) / max(dot(body, LUMINANCE), 1e-3);
    return toLinear(vec3(share));
  }
  vec3 color = toLinear(value);
  if (glossy && ofLamp) color += lobe(n, l, v);
  return color;
}
//ENVIRONMENT
void main() {
  findPlace();
  findFrame();
  const bool needsNormals = glossy || (mode != DEFAULT && mode != PLAIN && mode != ALBEDO && mode != SHADING);
  vec4 relief = vec4(0.0, 0.0, 1.0, 0.0);
  if (needsNormals) relief = normalAndHeight();
  vec3 n = relief.xyz;
  if (mode == NORMALS) { shown = vec4(n * 0.5 + 0.5, 1.0); return; }
  if (mode == ALBEDO) { shown = vec4(albedo(), 1.0); return; }
  if (mode == HEIGHT) { shown = vec4(vec3((relief.w - heightRange.x) / (heightRange.y - heightRange.x)), 1.0); return; }
  if (mode == SLOPE) { shown = vec4(heat(acos(clamp(n.z, -1.0, 1.0)) / 1.0471976), 1.0); return; }
  vec3 v = inFrame(eye), sum = vec3(0.0);
  v = fromDisk(v.xy);
  holdLayers();
#if SHAPES
  holdBoundaries();
#endif
#if MODE == MULTI_LIGHT
  sum = multiLight(v);
#else
  for (int i = 0; i < MOST_DIRECTIONS; i++) {
    if (i >= lights) break;
    vec3 l = inFrame(lightDirection[i]);
    float lit = attachedShare(l.z);
    if (lit > 0.0) sum += lit * lightColor[i] * underLight(fromDisk(l.xy), v, n);
  }
#if AMBIENT
  ofLamp = false;
  sum += underEnvironment(v, n);
#endif
#endif
#if ENDLESS
  if (showCells == 1) sum = mix(vec3(1.0, 0.6, 0.17), sum, sampled(planes, 0).a);
#endif
#if CELLS
  if (showCells == 1) sum = mix(sum, fract(vec3(0.61, 0.37, 0.83) * float(tile + 1)), 0.35);
#endif
  shown = vec4(max(balance * sum, 0.0) * exposure, 1.0);
  shown = linearToOutputTexel(shown);
}`;
