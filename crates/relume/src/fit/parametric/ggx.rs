//! Facets with derivatives by small steps, of the base colour in closed form. Parameters of a texel are its numbers.
//!
//! Roughness and specular reflectance are hardly decided by a single texel of a surface with relief: shadows, masking and
//! parallax leave residuals that a mirror whose highlight falls between the measured pairs, or a very rough surface, explain as
//! well as the truth, and neighbours fall into different minima. So both are found once for a sample of texels
//! together ([`super::typical`]), and each texel starts there and is held near it by a weak condition: a deviation from
//! the typical value by [`SPREAD`] counts as much as the residuals of all its values together.
//!
//! For maps, where the numbers matter and not the pictures, the pairs that say most of the numbers count most
//! ([`FacetAim::Maps`]): residuals are multiplied by the squared cosine of the view and the cosine of the light, since parallax,
//! masking and shadows grow with the angle, and beyond [`LARGE`] they count by their absolute value (P. J. Huber, "Robust
//! Estimation of a Location Parameter", Annals of Mathematical Statistics 35, 1964), since a shadow is no property of the facet.

use super::FacetAim;
use super::encoded::{MOST_PARAMETERS, TexelReflectance, fit_texel};
use super::texels::brightness;
use super::typical::{TypicalFacet, typical_facet};
use crate::direction::Directions;
use crate::field::parametric::{FacetShares, ggx_radiance};
use crate::microfacet::{DIELECTRIC_F0, LEAST_ROUGHNESS};
use crate::numeric::levenberg_marquardt::{LevenbergMarquardt, NormalEquations};
use crate::numeric::small::solve_spd;
use crate::parallel;

/// Numbers beside the base colour.
const BESIDE: usize = 4;
/// Steps of the fit of a texel of the sample.
const SAMPLE_STEPS: usize = 8;
/// The step of a numerical derivative.
const STEP: f64 = 1e-5;
/// The largest component of a normal: 40 degrees along each axis.
const STEEPEST: f64 = 0.65;
/// Base colours may exceed white: photographs are not calibrated.
const BRIGHTEST: f64 = 4.0;
/// The surfaces of dielectrics and of polished metals.
const SPECULAR: [f64; 2] = [0.0, 0.9];

/// Deviations of roughness and specular reflectance from the typical ones that count as much as all residuals, of fits for
/// pictures and for maps.
const SPREAD: [[f64; 2]; 2] = [[1.25, 0.25], [1.0, 0.2]];
/// Residuals of encoded values, white at 1, from which on they count by their absolute value.
const LARGE: f64 = 0.03;
/// Shares of the brightness of a matte surface in the mean over lights.
const BASE_BY_MEAN: f64 = 1.5;

/// The model at some pairs.
#[derive(Debug, Clone)]
pub(super) struct GgxModel {
    channels: usize,
    pairs: Vec<Directions>,
    bounds: Vec<[f64; 2]>,
    /// For each pair its shares of the normal times the albedo of a matte surface, by least squares.
    to_normal: Vec<[f64; 3]>,
    /// For each pair the factor of its residuals, in fits for maps.
    factors: Option<Vec<f64>>,
    typical: TypicalFacet,
}

impl GgxModel {
    /// The model around the facet that is typical of a sample of texels, each of which has the values under all pairs.
    pub fn new(channels: usize, pairs: &[Directions], aim: FacetAim, sample: &[Vec<f32>]) -> Self {
        let mut model = Self::unweighted(channels, pairs);
        let factor = |pair: &Directions| pair.view.z().powi(2) * pair.light.z();
        model.factors = Some(pairs.iter().map(factor).collect());
        let found = typical_facet(&model, sample);
        if aim == FacetAim::Pictures {
            model.factors = None;
        }
        // What is left where nothing is held near to it: no bias where facets explain all.
        model.typical = found;
        let mean_square = model.squares(sample) / (sample.len().max(1) as f64);
        let weight = |k: usize| mean_square.sqrt() / SPREAD[usize::from(aim == FacetAim::Maps)][k];
        model.typical = TypicalFacet { weights: [0, 1].map(weight), ..found };
        model
    }

    fn unweighted(channels: usize, pairs: &[Directions]) -> Self {
        let mut bounds = vec![[0.0, BRIGHTEST]; channels];
        bounds.extend([[-STEEPEST, STEEPEST], [-STEEPEST, STEEPEST], [LEAST_ROUGHNESS, 1.0], SPECULAR]);
        let typical = TypicalFacet { roughness: 0.5, specular: DIELECTRIC_F0, weights: [0.0; 2] };
        let to_normal = shares_of_normal(pairs);
        Self { channels, pairs: pairs.to_vec(), bounds, to_normal, factors: None, typical }
    }

    /// The same with a roughness and a specular reflectance that no fit changes.
    pub fn fixed_at(&self, facet: TypicalFacet) -> Self {
        let mut fixed = self.clone();
        fixed.typical = facet;
        for (bounds, value) in
            fixed.bounds[self.channels + 2..].iter_mut().zip([facet.roughness, facet.specular])
        {
            *bounds = [value; 2];
        }
        fixed
    }

    /// The sum of squares of all texels of a sample, each fitted by itself.
    pub fn squares(&self, sample: &[Vec<f32>]) -> f64 {
        let of_texel = |observed: &Vec<f32>| {
            let mut parameters = self.start(observed);
            let mut minimiser = LevenbergMarquardt::new(parameters.len());
            fit_texel(self, &mut minimiser, &mut parameters, observed, SAMPLE_STEPS)
        };
        parallel::map(sample.iter(), of_texel).iter().sum()
    }

    /// Parameters from which a fit starts: the colour and the normal of a matte surface, and the typical facet.
    fn start(&self, observed: &[f32]) -> Vec<f64> {
        let mut start: Vec<f64> =
            brightness(observed, self.channels).iter().map(|b| BASE_BY_MEAN * b).collect();
        start.extend(self.matte_normal(observed));
        start.extend([self.typical.roughness, self.typical.specular]);
        start
    }

    /// The x and y of the normal by photometric stereo; upright where the values do not determine one.
    fn matte_normal(&self, observed: &[f32]) -> [f64; 2] {
        let mut normal = [0.0; 3];
        for (seen, row) in observed.chunks_exact(self.channels).zip(&self.to_normal) {
            let mean = seen.iter().map(|v| f64::from(*v)).sum::<f64>() / self.channels as f64;
            let light = mean.max(0.0).powf(2.2);
            normal.iter_mut().zip(row).for_each(|(n, share)| *n += share * light);
        }
        let length = normal.iter().map(|v| v * v).sum::<f64>().sqrt();
        if normal[2] > 0.0 && length.is_finite() {
            [normal[0] / length, normal[1] / length]
        } else {
            [0.0; 2]
        }
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
        let (n, channels) = (parameters.len(), self.channels);
        let (base, rest) = parameters.split_at(channels);
        let here = FacetShares::new(rest, self.pairs[i]);
        derivatives.fill(0.0);
        for (c, (out, base)) in out.iter_mut().zip(base).enumerate() {
            *out = here.radiance(*base);
            derivatives[c * n + c] = here.cosine * here.body;
        }
        let mut moved = [0.0; BESIDE];
        moved.copy_from_slice(rest);
        for k in 0..BESIDE {
            moved[k] = rest[k] + STEP;
            let there = FacetShares::new(&moved, self.pairs[i]);
            moved[k] = rest[k];
            for (c, base) in base.iter().enumerate() {
                derivatives[c * n + channels + k] = (there.radiance(*base) - out[c]) / STEP;
            }
        }
    }

    fn counted(&self, i: usize, residual: f64) -> (f64, f64) {
        let Some(factors) = &self.factors else { return (residual, 1.0) };
        let (counted, slope) = huber(residual);
        (factors[i] * counted, factors[i] * slope)
    }

    fn condition(&self, parameters: &[f64], mut equations: Option<&mut NormalEquations>) -> f64 {
        let TypicalFacet { roughness, specular, weights } = self.typical;
        let mut squares = 0.0;
        for (k, (at, weight)) in [roughness, specular].into_iter().zip(weights).enumerate() {
            let place = self.channels + 2 + k;
            let residual = weight * (parameters[place] - at);
            squares += residual * residual;
            if let Some(equations) = &mut equations {
                let mut row = [0.0; MOST_PARAMETERS];
                row[place] = weight;
                equations.add(residual, &row[..parameters.len()]);
            }
        }
        squares.sqrt()
    }

    fn starts(&self, observed: &[f32], _: &[f64]) -> Vec<Vec<f64>> {
        vec![self.start(observed)]
    }

    fn start_of_texel(&self, _: &[f64], _: &[f64], observed: &[f32]) -> Vec<f64> {
        self.start(observed)
    }

    fn numbers(&self, parameters: &[f64], _observed: &[f32]) -> Vec<f32> {
        parameters.iter().map(|p| *p as f32).collect()
    }
}

/// Huber's loss as a square: the square is r^2 up to [`LARGE`] and 2 h |r| - h^2 beyond. With the derivative.
fn huber(residual: f64) -> (f64, f64) {
    if residual.abs() <= LARGE {
        return (residual, 1.0);
    }
    let root = (2.0 * LARGE * residual.abs() - LARGE * LARGE).sqrt();
    (root.copysign(residual), LARGE / root)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_loss_is_smooth_and_linear_far_away() {
        for residual in [-0.7, -0.0301, -0.02, 0.0, 0.029, 0.2, 1.3] {
            let ((value, slope), step) = (huber(residual), 1e-7);
            let numeric = (huber(residual + step).0 - value) / step;
            assert!((numeric - slope).abs() < 1e-5, "{residual}: {slope} {numeric}");
            assert!(value.abs() <= residual.abs() && value * residual >= 0.0);
        }
        let square = |residual: f64| huber(residual).0.powi(2);
        assert!((square(2.0) - square(1.0) - 2.0 * LARGE).abs() < 1e-12);
    }

    #[test]
    fn derivatives_are_those_of_the_values() {
        use crate::direction::Direction;
        let direction = |i: usize| Direction::from_angles(0.1 * i as f64, 2.4 * i as f64);
        let pairs: Vec<Directions> =
            (0..12).map(|i| Directions { light: direction(i), view: direction((5 * i) % 12) }).collect();
        let model = GgxModel::unweighted(3, &pairs);
        let p = [0.4, 0.2, 0.1, 0.1, -0.2, 0.4, 0.05];
        for i in 0..pairs.len() {
            let (mut out, mut derivatives, mut values) = ([0.0; 3], [0.0; 21], [0.0; 3]);
            model.derivatives(&p, i, &mut out, &mut derivatives);
            model.values(&p, i, &mut values);
            assert_eq!(out, values);
            for k in 0..7 {
                let mut moved = p;
                moved[k] += 1e-6;
                model.values(&moved, i, &mut values);
                for c in 0..3 {
                    let numeric = (values[c] - out[c]) / 1e-6;
                    let found = derivatives[c * 7 + k];
                    assert!(
                        (found - numeric).abs() < 1e-3 * (1.0 + numeric.abs()),
                        "{i} {k}: {found} {numeric}"
                    );
                }
            }
        }
    }
}
