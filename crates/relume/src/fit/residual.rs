//! The difference between a relit field and a photograph.

use crate::field::{Basis, PlaneLayout};
use crate::lamps::LampPositions;
use crate::planes::Planes;
use crate::raster::Raster;

use super::levels::SampleLevels;
use super::sample::Grid;

/// Texels relit at a time.
const BAND: usize = 4096;

/// The sum of squared differences between a photograph and the field relit with `weights`, over all texels
/// and channels, both clamped to 0..1 as on a display.
pub(super) fn squared_error(
    coefficients: &Planes,
    layout: &PlaneLayout,
    weights: &[f64],
    photograph: &Raster,
    levels: &SampleLevels,
) -> f64 {
    let weights: Vec<f32> = weights.iter().map(|&w| w as f32).collect();
    let texels = coefficients.size().texels();
    let (mut relit, mut truth) = ([0.0f32; BAND], [0.0f32; BAND]);
    let mut sum = 0.0;
    for channel in 0..photograph.channels() {
        for first in (0..texels).step_by(BAND) {
            let relit = &mut relit[..BAND.min(texels - first)];
            let truth = &mut truth[..relit.len()];
            relight_channel(coefficients, layout, &weights, channel, first, relit);
            levels.channel(photograph, channel, first, truth);
            let pairs = relit.iter().zip(&*truth);
            sum += pairs.map(|(a, b)| f64::from(a.clamp(0.0, 1.0) - b.clamp(0.0, 1.0)).powi(2)).sum::<f64>();
        }
    }
    sum
}

/// A near lamp over the texels of a grid.
pub(super) struct Lamp<'a> {
    pub lamps: &'a LampPositions,
    pub number: usize,
    pub grid: &'a Grid,
    pub basis: &'a Basis,
}

/// As [`squared_error`], for light that comes from another direction at each texel.
pub(super) fn squared_error_near(
    coefficients: &Planes,
    layout: &PlaneLayout,
    lamp: &Lamp<'_>,
    photograph: &Raster,
    levels: &SampleLevels,
) -> f64 {
    let mut functions = vec![0.0; lamp.basis.len()];
    let mut weights = vec![0.0f32; lamp.basis.len()];
    let mut sum = 0.0;
    for (texel, (x, y)) in lamp.grid.places().enumerate() {
        lamp.basis.weights_into(lamp.lamps.direction_at(lamp.number, x, y).into(), &mut functions);
        weights.iter_mut().zip(&functions).for_each(|(weight, value)| *weight = *value as f32);
        for channel in 0..photograph.channels() {
            let (mut relit, mut truth) = ([0.0f32], [0.0f32]);
            relight_channel(coefficients, layout, &weights, channel, texel, &mut relit);
            levels.channel(photograph, channel, texel, &mut truth);
            sum += f64::from(relit[0].clamp(0.0, 1.0) - truth[0].clamp(0.0, 1.0)).powi(2);
        }
    }
    sum
}

/// One channel of consecutive texels, starting with `first`, not clamped.
pub(super) fn relight_channel(
    coefficients: &Planes,
    layout: &PlaneLayout,
    weights: &[f32],
    channel: usize,
    first: usize,
    out: &mut [f32],
) {
    let (n, texels) = (weights.len(), out.len());
    let function = layout.function_plane(channel, n);
    out.fill(0.0);
    // Of interpolated photographs all but one are without a part in what their lights show.
    for (k, weight) in weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
        let plane = &coefficients.plane(function + k)[first..][..texels];
        out.iter_mut().zip(plane).for_each(|(o, c)| *o += weight * c);
    }
    if let Some(color) = layout.color_plane(channel, n) {
        let plane = &coefficients.plane(color)[first..][..texels];
        out.iter_mut().zip(plane).for_each(|(o, c)| *o *= c);
    }
}
