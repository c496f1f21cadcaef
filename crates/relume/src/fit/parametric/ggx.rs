//! Facets with derivatives by small steps. Parameters of a texel are its numbers.

use super::encoded::{MOST_PARAMETERS, TexelReflectance};
use crate::direction::Directions;
use crate::field::parametric::ggx_radiance;
use crate::microfacet::{DIELECTRIC_F0, LEAST_ROUGHNESS};
use crate::numeric::levenberg_marquardt::NormalEquations;
use crate::numeric::small::solve_spd;

/// The step of a numerical derivative.
const STEP: f64 = 1e-5;
/// The largest component of a normal: 40 degrees along each axis.
const STEEPEST: f64 = 0.65;
/// Base colours may exceed white: photographs are not calibrated.
const BRIGHTEST: f64 = 4.0;
/// The surfaces of dielectrics and of polished metals.
const SPECULAR: [f64; 2] = [0.0, 0.9];

/// The model at some pairs.
#[derive(Debug, Clone)]
pub(super) struct GgxModel {
    channels: usize,
    pairs: Vec<Directions>,
    bounds: Vec<[f64; 2]>,
    /// For each pair its shares of the normal times the albedo of a matte surface, by least squares.
    to_normal: Vec<[f64; 3]>,
}

impl GgxModel {
    pub fn new(channels: usize, pairs: &[Directions]) -> Self {
        let mut bounds = vec![[0.0, BRIGHTEST]; channels];
        bounds.extend([[-STEEPEST, STEEPEST], [-STEEPEST, STEEPEST], [LEAST_ROUGHNESS, 1.0], SPECULAR]);
        Self { channels, pairs: pairs.to_vec(), bounds, to_normal: shares_of_normal(pairs) }
    }
}

/// (L'L)^-1 L' of the lights L of the pairs, the pseudo-inverse of photometric stereo (R. J. Woodham, "Photometric Method for
/// Determining Surface Orientation from Multiple Images", Optical Engineering 19, 1980); zeros where the lights do not
/// determine a normal.
fn shares_of_normal(pairs: &[Directions]) -> Vec<[f64; 3]> {
    let mut squares = [[0.0; 3]; 3];
    for pair in pairs {
        let light = pair.light.to_array();
        for (row, a) in squares.iter_mut().zip(light) {
            row.iter_mut().zip(light).for_each(|(sum, b)| *sum += a * b);
        }
    }
    let share = |pair: &Directions| solve_spd(&squares, &pair.light.to_array()).unwrap_or([0.0; 3]);
    pairs.iter().map(share).collect()
}

impl TexelReflectance for GgxModel {
    fn channels(&self) -> usize {
        self.channels
    }

    fn bounds(&self) -> &[[f64; 2]] {
        &self.bounds
    }

    fn values(&self, parameters: &[f64], i: usize, out: &mut [f64]) {
        ggx_radiance(parameters, self.pairs[i], out);
    }

    fn derivatives(&self, parameters: &[f64], i: usize, out: &mut [f64], derivatives: &mut [f64]) {
        let n = parameters.len();
        let mut moved = [0.0; MOST_PARAMETERS];
        moved[..n].copy_from_slice(parameters);
        let mut values = [0.0; 3];
        let values = &mut values[..out.len()];
        self.values(parameters, i, out);
        for k in 0..n {
            moved[k] = parameters[k] + STEP;
            self.values(&moved[..n], i, values);
            moved[k] = parameters[k];
            (0..out.len()).for_each(|c| derivatives[c * n + k] = (values[c] - out[c]) / STEP);
        }
    }

    fn condition(&self, _: &[f64], _: Option<&mut NormalEquations>) -> f64 {
        0.0
    }

    fn starts(&self, _: &[f32], brightness: &[f64]) -> Vec<Vec<f64>> {
        let start = |roughness| {
            let base = brightness.iter().map(|b| 1.5 * b);
            base.chain([0.0, 0.0, roughness, DIELECTRIC_F0]).collect()
        };
        [0.25, 0.5, 0.8].map(start).to_vec()
    }

    /// The normal is that of a matte surface.
    fn start_of_texel(&self, mean: &[f64], ratios: &[f64], observed: &[f32]) -> Vec<f64> {
        let mut start = mean.to_vec();
        start.iter_mut().zip(ratios).for_each(|(p, ratio)| *p *= ratio);
        let mut normal = [0.0; 3];
        for (seen, row) in observed.chunks_exact(self.channels).zip(&self.to_normal) {
            let mean = seen.iter().map(|v| f64::from(*v)).sum::<f64>() / self.channels as f64;
            let light = mean.max(0.0).powf(2.2);
            normal.iter_mut().zip(row).for_each(|(n, share)| *n += share * light);
        }
        let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
        if normal[2] > 0.0 && length.is_finite() {
            (0..2).for_each(|axis| start[self.channels + axis] = normal[axis] / length);
        }
        start
    }

    fn numbers(&self, parameters: &[f64]) -> Vec<f32> {
        parameters.iter().map(|p| *p as f32).collect()
    }
}
