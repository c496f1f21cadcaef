//! The built-in environment: a sun, a sky that brightens towards the horizon, and brown ground. Chosen for its looks
//! and for tests, not computed from an atmosphere.

use std::f64::consts::PI;

use super::row_cosine;
use crate::error::Result;
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;

/// Texels of the map: 0.7 degrees each.
const SIZE: Size = Size::new(512, 256);
/// Towards the sun, not of unit length: to the upper left, in front of the object.
const SUN: [f64; 3] = [-0.62, 0.62, 0.56];
/// Angles from the centre of the sun at which it begins to fade, and where it ends: much larger than the real one, so
/// that the edges of shadows are soft.
const SUN_DEG: [f64; 2] = [2.5, 3.5];
/// The radiance of the sun: its integral is 0.75 pi, so a white matt surface facing it reflects 0.75.
const SUN_RADIANCE: [f64; 3] = [271.0, 254.0, 220.0];
const ZENITH: [f64; 3] = [0.13, 0.23, 0.46];
const HORIZON: [f64; 3] = [0.62, 0.72, 0.85];
const GROUND: [f64; 3] = [0.13, 0.11, 0.085];
/// The elevation over which ground and sky blend.
const BLEND: f64 = 0.03;

/// The three planes of the map.
pub(super) fn map(job: &Job) -> Result<Planes> {
    let mut planes = Planes::zeros_within(job, "the built-in sky", SIZE, 3)?;
    for y in 0..SIZE.height {
        let up = 0.5 * (row_cosine(y, SIZE.height) + row_cosine(y + 1, SIZE.height));
        let ring = (1.0 - up * up).sqrt();
        for x in 0..SIZE.width {
            let (sin, cos) = (2.0 * PI * ((x as f64 + 0.5) / SIZE.width as f64 - 0.5)).sin_cos();
            let color = radiance([ring * sin, up, -ring * cos]);
            (0..3).for_each(|c| planes.plane_mut(c)[SIZE.index(x, y)] = color[c] as f32);
        }
    }
    Ok(planes)
}

fn radiance(direction: [f64; 3]) -> [f64; 3] {
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let up = direction[1];
    let haze = (1.0 - up.max(0.0)).powi(3);
    let sky = |c: usize| ZENITH[c] + (HORIZON[c] - ZENITH[c]) * haze;
    let above = ((up + BLEND) / (2.0 * BLEND)).clamp(0.0, 1.0);
    let from_sun = (dot(direction, SUN) / dot(SUN, SUN).sqrt()).clamp(-1.0, 1.0).acos().to_degrees();
    let disc = ((SUN_DEG[1] - from_sun) / (SUN_DEG[1] - SUN_DEG[0])).clamp(0.0, 1.0);
    std::array::from_fn(|c| above * sky(c) + (1.0 - above) * GROUND[c] + disc * SUN_RADIANCE[c])
}
