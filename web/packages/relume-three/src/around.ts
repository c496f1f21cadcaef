// The ways of showing that compare the luminance of a place with that around it: they look up every function blurred as well, with the
// same weights.

/** Look-ups around a place, at one level of blurring or at the three of the still under many lights. */
export const AROUND_GLSL = `
#define BLURS (MODE == UNSHARP_LUMINANCE || MODE == MULTI_LIGHT)
// Of many layers those are kept that are added up again and again.
#define IS_HELD (HELD == 2 || HELD == 1 && (BLURS || AMBIENT == 1 || MODE == DIFFUSE_GAIN))
#if BLURS
const float FINE = 1.5, MIDDLE = 3.0, SOFT = 4.5;
// The luminance of the value around the place, for each level.
vec3 around;
// Of a layer: the luminance of one function, or the values of four, for each level.
#if ARRANGEMENT == 0
#define AROUND vec3
float aroundBy(int k, float levels) { return dot(decoded(blurredBy(planes, k, levels), k).rgb, LUMINANCE); }
const float NONE = 0.0;
#else
#define AROUND mat3x4
vec4 aroundBy(int k, float levels) { return decoded(blurredBy(planes, k, levels), k); }
const vec4 NONE = vec4(0.0);
#endif
#if MODE == MULTI_LIGHT
AROUND lookedUpAround(int k) { return AROUND(aroundBy(k, FINE), aroundBy(k, MIDDLE), aroundBy(k, SOFT)); }
#else
AROUND lookedUpAround(int k) { return AROUND(aroundBy(k, radius), NONE, NONE); }
#endif
#if IS_HELD
AROUND heldAround[LAYERS];
AROUND layerAround(int k) { return heldAround[k]; }
#else
AROUND layerAround(int k) { return lookedUpAround(k); }
#endif
#define ADD_AROUND(part) around += part
#else
#define ADD_AROUND(part)
#endif`;

/** The still under many lights. */
export const MANY_GLSL = `
#if MODE == MULTI_LIGHT
// A still in which every place is lit from where its details show best: of lamps around the upper left, 18 and 45 degrees high, the
// mean of their details, by the power of the local contrast, on the soft light of the higher ones. Lamps of opposite sides
// would cancel each other.
vec3 multiLight(vec3 v) {
  vec3 details = vec3(0.0);
  float total = 0.0, brightness = 0.0;
  for (int i = 0; i < 10; i++) {
    float azimuth = radians(135.0 + 33.75 * float(i % 5 - 2)), height = i < 5 ? 0.309 : 0.707, across = sqrt(1.0 - height * height);
    vec3 value = valueFor(vec3(across * cos(azimuth), across * sin(azimuth), height), v);
    float ground = max(around.z, 0.06);
    float share = pow((abs(around.x - around.y) + abs(around.y - ground)) / ground + 0.02, gain);
    details += share * clamp(value / ground, 0.0, 4.0);
    total += share;
    brightness += i < 5 ? 0.0 : ground / 5.0;
  }
  return toLinear(brightness * details / total);
}
#endif`;
