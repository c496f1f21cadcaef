//! The attached shadow: light near the horizon of a surface fades out over the last few degrees.

/// The cosine between light and object below which the attached shadow begins: six degrees.
pub(super) const FADE_COSINE: f64 = 0.1;

/// The share of a light that a surface gets, by the cosine between the light and its normal: 0 below the horizon, 1
/// above the fade, smooth in between.
pub(super) fn attached_share(cosine: f64) -> f64 {
    let t = (cosine / FADE_COSINE).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
