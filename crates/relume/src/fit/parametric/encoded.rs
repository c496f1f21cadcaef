//! Residuals of encoded values: models are of light, and what is seen of an error is that of the encoded value.

use crate::numeric::levenberg_marquardt::{LevenbergMarquardt, NormalEquations};

/// A reflectance model of a texel at some measured pairs, with its derivatives.
pub(super) trait TexelReflectance: Sync {
    /// The channels of a value.
    fn channels(&self) -> usize;
    /// The least and the largest value of each parameter.
    fn bounds(&self) -> &[[f64; 2]];
    /// The same of a texel of these encoded values.
    fn bounds_of_texel(&self, _observed: &[f32]) -> Vec<[f64; 2]> {
        self.bounds().to_vec()
    }
    /// The linear values at pair `i`.
    fn values(&self, parameters: &[f64], i: usize, out: &mut [f64]);
    /// The same, and for each channel the derivatives by all parameters.
    fn derivatives(&self, parameters: &[f64], i: usize, out: &mut [f64], derivatives: &mut [f64]);
    /// How a residual of an encoded value at pair `i` counts: the number whose square is minimised, and its derivative by the
    /// residual.
    fn counted(&self, _i: usize, residual: f64) -> (f64, f64) {
        (residual, 1.0)
    }
    /// The residual of a weak condition that fixes what the values leave open, with its derivatives.
    fn condition(&self, parameters: &[f64], equations: Option<&mut NormalEquations>) -> f64;
    /// Parameters from which a fit to observed encoded values starts, of which `brightness` is the linear mean.
    fn starts(&self, observed: &[f32], brightness: &[f64]) -> Vec<Vec<f64>>;
    /// Parameters from which the fit of a texel starts: those of the mean, with colours that are `ratios` of its colours, and
    /// what is seen of the texel at once.
    fn start_of_texel(&self, mean: &[f64], ratios: &[f64], observed: &[f32]) -> Vec<f64>;
    /// The numbers of a texel of these encoded values that files keep.
    fn numbers(&self, parameters: &[f64], observed: &[f32]) -> Vec<f32>;
}

/// The most parameters.
pub(super) const MOST_PARAMETERS: usize = 24;

/// Encodes sRGB (IEC 61966-2-1) without an upper end, and gives the derivative; in doubles, for numbers from 0.
fn encoded(value: f64) -> (f64, f64) {
    if value <= 0.003_130_8 {
        return (12.92 * value, 12.92);
    }
    let root = value.powf(1.0 / 2.4);
    (1.055 * root - 0.055, 1.055 / 2.4 * root / value)
}

/// Whether a value is beyond what a photograph that shows white says of it.
fn is_clipped(observed: f32, value: f64) -> bool {
    observed == 1.0 && value > 1.0
}

/// Moves the parameters to those within the bounds of the texel whose encoded values are nearest to the observed ones, which are
/// all channels of a pair, then those of the next. Returns the sum of squares.
pub(super) fn fit_texel(
    model: &impl TexelReflectance,
    minimiser: &mut LevenbergMarquardt,
    parameters: &mut [f64],
    observed: &[f32],
    steps: usize,
) -> f64 {
    let (channels, n) = (model.channels(), parameters.len());
    let bounds = model.bounds_of_texel(observed);
    clamp(parameters, &bounds);
    let add = |p: &[f64], equations: &mut NormalEquations| {
        let (mut values, mut derivatives) = ([0.0; 3], [0.0; 3 * MOST_PARAMETERS]);
        for (i, seen) in observed.chunks_exact(channels).enumerate() {
            model.derivatives(p, i, &mut values[..channels], &mut derivatives[..channels * n]);
            for (c, &y) in seen.iter().enumerate().filter(|(c, y)| !is_clipped(**y, values[*c])) {
                let (value, slope) = encoded(values[c].max(0.0));
                let (residual, by_residual) = model.counted(i, value - f64::from(y));
                let row = &mut derivatives[c * n..][..n];
                row.iter_mut().for_each(|d| *d *= slope * by_residual);
                equations.add(residual, row);
            }
        }
        model.condition(p, Some(equations));
    };
    let squares = |p: &[f64]| {
        let mut values = [0.0; 3];
        let mut sum = model.condition(p, None).powi(2);
        for (i, seen) in observed.chunks_exact(channels).enumerate() {
            model.values(p, i, &mut values[..channels]);
            let shown = seen.iter().zip(values).filter(|(y, value)| !is_clipped(**y, *value));
            let residual = |(y, value): (&f32, f64)| encoded(value.max(0.0)).0 - f64::from(*y);
            sum += shown.map(|seen| model.counted(i, residual(seen)).0.powi(2)).sum::<f64>();
        }
        sum
    };
    minimiser.minimise(parameters, &bounds, steps, add, squares)
}

/// Moves parameters into their bounds.
fn clamp(parameters: &mut [f64], bounds: &[[f64; 2]]) {
    parameters.iter_mut().zip(bounds).for_each(|(p, [least, most])| *p = p.clamp(*least, *most));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::space::Space;

    #[test]
    fn encoded_values_and_slopes_are_those_of_the_space() {
        for value in [0.0, 0.002, 0.004, 0.2, 1.0, 3.0] {
            let (found, slope) = encoded(value);
            assert!((found - f64::from(Space::Linear.to_srgb(value as f32))).abs() < 1e-6);
            let step = 1e-7;
            let numeric = (encoded(value + step).0 - found) / step;
            assert!((numeric / slope - 1.0).abs() < 1e-4, "{value}: {numeric} {slope}");
        }
    }
}
