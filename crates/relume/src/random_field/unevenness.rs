//! Detail that is strong in some places and weak in others, by chance.
//!
//! What the neighbours of a texel do not predict is more often weak and more often strong than Gaussian noise of the same
//! variance: smooth parts of a material lie beside rough ones. The noise of a level is therefore Gaussian at every place and
//! multiplied by a strength that varies slowly and at random (M. Wainwright, E. Simoncelli, "Scale Mixtures of Gaussians and
//! the Statistics of Natural Images", NIPS 12, 1999; in time series, stochastic volatility). The logarithm of the strength is a
//! Gaussian field, white noise blurred over a few texels, of standard deviation s; its mean square is 1, so the spectrum of the
//! level stays as it was.
//!
//! The noise of a place is a hash of the place, so any part of an endless plane has the same strengths, to the bit, on every
//! processor.

use super::noise::exp2;
use crate::numeric::hash::of_place;
use crate::numeric::random::{Purpose, key};
use crate::parallel;
use crate::planes::Planes;
use crate::rect::Rect;

/// The deviation s as a number of steps of 1/64.
pub const STEPS: f64 = 64.0;

/// How far the blur reaches, in texels of the level: its weights are the binomial coefficients of twice the reach, their
/// standard deviation 1.7 texels.
const REACH: usize = 6;

/// Deviations below this are not seen.
const LEAST: f64 = 0.15;

/// The deviation of the logarithm of the strength of noise, in steps: 0 where it is the same everywhere.
///
/// For b = g z with normal z and ln g normal of deviation s, the mean square of b is pi / 2 exp(s^2) times the square of its
/// mean magnitude, whatever the scale.
///
/// # Panics
/// When there are no texels.
pub fn of(noise: &Planes) -> u8 {
    let logs: Vec<f64> = noise.iter().filter_map(spread).collect();
    let mean = logs.iter().sum::<f64>() / logs.len().max(1) as f64;
    let deviation = mean.max(0.0).sqrt();
    if deviation < LEAST { 0 } else { (STEPS * deviation).round().min(255.0) as u8 }
}

/// The square of s of one plane; `None` if it is 0 everywhere.
fn spread(plane: &[f32]) -> Option<f64> {
    let n = plane.len() as f64;
    let square = plane.iter().map(|&v| f64::from(v).powi(2)).sum::<f64>() / n;
    let magnitude = plane.iter().map(|&v| f64::from(v).abs()).sum::<f64>() / n;
    (magnitude > 0.0).then(|| (square / magnitude.powi(2)).ln() - std::f64::consts::FRAC_PI_2.ln())
}

/// The strengths of a level of an endless plane.
#[derive(Debug, Clone, Copy)]
pub struct Strengths {
    /// The deviation of their logarithm, in steps.
    pub steps: u8,
    /// The number of the level.
    pub level: usize,
    /// Another seed, another plane.
    pub seed: u64,
    /// Columns and rows of the level after which the plane repeats.
    pub period: Option<[i64; 2]>,
}

impl Strengths {
    /// The strengths over an area.
    pub fn over(&self, area: Rect) -> Planes {
        let (width, kernel, blurred) = (area.size.width, kernel(), self.blurred_across(area));
        let deviation = f64::from(self.steps) / STEPS;
        // exp(s h - s^2) as a power of two.
        let [factor, term] =
            [deviation, -deviation * deviation].map(|v| (v * std::f64::consts::LOG2_E) as f32);
        let mut out = Planes::zeros(area.size, 1);
        parallel::for_each(out.as_mut_slice().chunks_exact_mut(width).enumerate(), |(y, strengths)| {
            for (weight, row) in kernel.iter().zip(blurred[y * width..].chunks_exact(width)) {
                strengths.iter_mut().zip(row).for_each(|(sum, v)| *sum += weight * v);
            }
            strengths.iter_mut().for_each(|h| *h = exp2(factor * *h + term));
        });
        out
    }

    /// White noise over the rows of an area and those the blur reaches, blurred along the rows.
    fn blurred_across(&self, area: Rect) -> Vec<f32> {
        let (width, height) = (area.size.width, area.size.height + 2 * REACH);
        let (key, kernel) = (key(self.seed, Purpose::FieldStrength, [self.level as u64]), kernel());
        let [left, top] = area.origin().map(|v| v - REACH as i64);
        let wrap = |v: i64, axis: usize| self.period.map_or(v, |period| v.rem_euclid(period[axis]));
        let mut blurred = vec![0.0f32; width * height];
        parallel::for_each(blurred.chunks_exact_mut(width).enumerate(), |(j, row)| {
            let y = wrap(top + j as i64, 1);
            let noise: Vec<f32> =
                (0..width + 2 * REACH).map(|i| noise(of_place(key, wrap(left + i as i64, 0), y))).collect();
            for (shift, weight) in kernel.iter().enumerate() {
                row.iter_mut().zip(&noise[shift..]).for_each(|(sum, v)| *sum += weight * v);
            }
        });
        blurred
    }
}

/// A number of mean 0 and variance 1 from four hashes: a sum of uniform ones, which the blur makes normal.
fn noise(hashes: [u32; 4]) -> f32 {
    let sum: f32 = hashes.iter().map(|hash| (hash >> 8) as i32 as f32 * (1.0 / 16_777_216.0)).sum();
    (sum - 2.0) * 1.732_050_8
}

/// Binomial weights whose squares sum to 1, so that blurred white noise has the variance of the noise.
fn kernel() -> [f32; 2 * REACH + 1] {
    let mut weights = [1.0f64; 2 * REACH + 1];
    for i in 1..weights.len() {
        weights[i] = weights[i - 1] * (2 * REACH + 1 - i) as f64 / i as f64;
    }
    let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.map(|w| (w / norm) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Stream;
    use crate::size::Size;

    fn gaussian(size: Size) -> Planes {
        let mut random = Stream::new(6, Purpose::Sample, [0]);
        let data = (0..2 * size.texels()).map(|_| random.normal() as f32).collect();
        Planes::from_vec(size, 2, data).unwrap()
    }

    fn strengths(steps: u8) -> Strengths {
        Strengths { steps, level: 1, seed: 3, period: None }
    }

    #[test]
    fn the_deviation_that_was_given_is_found_and_the_variance_stays() {
        let size = Size::new(256, 256);
        let plain = gaussian(size);
        assert_eq!(of(&plain), 0);
        for steps in [32, 48, 64] {
            let (mut noise, over) = (plain.clone(), strengths(steps).over(Rect::new(-40, 7, size)));
            for plane in noise.iter_mut() {
                plane.iter_mut().zip(over.plane(0)).for_each(|(v, g)| *v *= g);
            }
            let found = of(&noise);
            assert!(found.abs_diff(steps) <= 4, "{found} for {steps}");
            let square = |planes: &Planes| planes.as_slice().iter().map(|v| f64::from(v * v)).sum::<f64>();
            let ratio = square(&noise) / square(&plain);
            assert!((0.8..1.2).contains(&ratio), "{ratio} at {steps}");
        }
        assert_eq!(of(&Planes::zeros(size, 1)), 0);
    }

    #[test]
    fn parts_have_the_strengths_of_the_whole_and_a_period_repeats() {
        let (whole, part) = (Rect::new(-5, 90, Size::new(60, 40)), Size::new(21, 13));
        let cut = strengths(80).over(Rect::new(25, 110, part));
        assert_eq!(cut, strengths(80).over(whole).crop(30, 20, part).unwrap());
        let periodic = Strengths { period: Some([30, 20]), ..strengths(80) }.over(whole);
        let quarter = |x, y| periodic.crop(x, y, Size::new(30, 20)).unwrap();
        assert_eq!(quarter(0, 0), quarter(30, 20));
    }
}
