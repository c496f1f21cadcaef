//! The distribution of the values of a plane, and its transform to and from the normal distribution.
//!
//! A Gaussian field has normal values; textures do not. Each plane is therefore modelled after a monotone
//! curve has made its values normal, and the inverse restores them: the distribution of the output is that of
//! the input, whatever the field does. A curve consists of the values at a few quantiles, linear in between:
//! [`KNOTS`] of them, evenly from -4 to 4 standard deviations.

/// The number of quantiles of a curve.
pub const KNOTS: usize = 33;

/// The standard deviations covered by the curve on either side; beyond it is constant.
const SPAN: f64 = 4.0;

/// The number of steps in which values are stored between the least and the greatest of a plane.
pub const STEPS: u16 = 4095;

/// The values of a plane as a function of standard normal scores.
#[derive(Debug, Clone, PartialEq)]
pub enum Marginal {
    /// value = mean + deviation score.
    Normal {
        /// Mean.
        mean: f32,
        /// Standard deviation.
        deviation: f32,
    },
    /// Linear between values at evenly spaced scores.
    Curve {
        /// Value of code 0.
        low: f32,
        /// Value of code [`STEPS`].
        high: f32,
        /// The value at each knot, never decreasing.
        codes: Box<[u16; KNOTS]>,
    },
}

impl Marginal {
    /// The normal distribution with the mean and deviation of the values.
    pub fn normal(values: &[f32]) -> Self {
        let n = values.len() as f64;
        let mean = values.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
        let variance = values.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n;
        let constant = values.iter().all(|&v| v == values[0]);
        Self::Normal { mean: mean as f32, deviation: if constant { 0.0 } else { variance.sqrt() as f32 } }
    }

    /// The curve through the quantiles of the values.
    ///
    /// # Panics
    /// When there are no values.
    pub fn curve(values: &[f32]) -> Self {
        Self::through(values, normal_cdf)
    }

    /// The curve that maps scores with a non-normal distribution, given by a sample, to the distribution of
    /// the values.
    ///
    /// # Panics
    /// When there are no values or no scores.
    pub fn matched(values: &[f32], scores: &[f32]) -> Self {
        let mut sorted = scores.to_vec();
        sorted.sort_unstable_by(f32::total_cmp);
        let below = |score: f64| sorted.partition_point(|&v| f64::from(v) <= score);
        Self::through(values, |score| below(score) as f64 / sorted.len() as f64)
    }

    /// The curve whose value at each score is the quantile at the share of scores below it.
    fn through(values: &[f32], share_below: impl Fn(f64) -> f64) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f32::total_cmp);
        let (low, high) = (sorted[0], sorted[sorted.len() - 1]);
        let quantile = |p: f64| {
            let place = (p * sorted.len() as f64 - 0.5).clamp(0.0, (sorted.len() - 1) as f64);
            let (below, part) = (place as usize, place.fract() as f32);
            let above = sorted[(below + 1).min(sorted.len() - 1)];
            sorted[below] + part * (above - sorted[below])
        };
        let code = |i: usize| match i {
            0 => 0,
            _ if i == KNOTS - 1 => STEPS,
            _ if high <= low => 0,
            _ => {
                let part = (quantile(share_below(knot(i))) - low) / (high - low);
                (part * f32::from(STEPS)).round() as u16
            }
        };
        Self::Curve { low, high, codes: Box::new(std::array::from_fn(code)) }
    }

    /// Whether all values are the same.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Normal { deviation, .. } => *deviation <= 0.0,
            Self::Curve { low, high, .. } => high <= low,
        }
    }

    /// A function from scores to values.
    pub fn values(&self) -> impl Fn(f32) -> f32 + use<> {
        let (knots, line) = self.parts();
        move |score| match &knots {
            None => line.0 + line.1 * score,
            Some(knots) => {
                let place = (score * PER_KNOT as f32 + (KNOTS / 2) as f32).clamp(0.0, (KNOTS - 1) as f32);
                let below = (place as usize).min(KNOTS - 2);
                knots[below] + (place - below as f32) * (knots[below + 1] - knots[below])
            }
        }
    }

    /// A function from values to scores: the inverse of the curve, and the middle where it is level.
    pub fn scores(&self) -> impl Fn(f32) -> f32 + use<> {
        let (knots, line) = self.parts();
        move |value| match &knots {
            None if line.1 > 0.0 => (value - line.0) / line.1,
            None => 0.0,
            Some(knots) => inverse(knots, value, -SPAN, 1.0 / PER_KNOT),
        }
    }

    fn parts(&self) -> (Option<[f32; KNOTS]>, (f32, f32)) {
        match self {
            Self::Normal { mean, deviation } => (None, (*mean, *deviation)),
            Self::Curve { low, high, codes } => {
                let scale = (high - low) / f32::from(STEPS);
                (Some(std::array::from_fn(|i| low + scale * f32::from(codes[i]))), (0.0, 0.0))
            }
        }
    }
}

/// Knots per standard deviation.
const PER_KNOT: f64 = (KNOTS - 1) as f64 / (2.0 * SPAN);

/// The score of a knot.
fn knot(i: usize) -> f64 {
    i as f64 / PER_KNOT - SPAN
}

/// The score at which the line through knots has a value; the first knot has the score `first`, and each
/// further one is a `step` on.
pub(super) fn inverse(knots: &[f32], value: f32, first: f64, step: f64) -> f32 {
    let score = |i: usize| first + i as f64 * step;
    let equal = knots.partition_point(|&k| k < value);
    let beyond = knots.partition_point(|&k| k <= value);
    if beyond > equal {
        // Several knots have this value: the middle of the level stretch.
        return ((score(equal) + score(beyond - 1)) / 2.0) as f32;
    }
    if equal == 0 || equal == knots.len() {
        return score(equal.min(knots.len() - 1)) as f32;
    }
    let (below, above) = (knots[equal - 1], knots[equal]);
    (score(equal - 1) + f64::from((value - below) / (above - below)) * step) as f32
}

/// The normal distribution function, to 1e-7: Abramowitz and Stegun 26.2.17.
pub fn normal_cdf(x: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * x.abs());
    let series = [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_53];
    let sum = series.iter().fold(0.0, |sum, c| t * (c + sum));
    let upper = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt() * sum;
    if x > 0.0 { 1.0 - upper } else { upper }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    /// Values whose distribution is far from normal.
    fn skewed(n: usize, levels: f32, seed: u64) -> Vec<f32> {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        (0..n).map(|_| (stream.unit().powi(3) as f32 * levels).round() / levels * 0.8 + 0.1).collect()
    }

    #[test]
    fn the_distribution_function_is_known() {
        for (x, p) in [(0.0, 0.5), (1.0, 0.841_344_746), (-1.96, 0.024_997_895), (3.0, 0.998_650_102)] {
            assert!((normal_cdf(x) - p).abs() < 1e-7, "{x}");
        }
    }

    #[test]
    fn scores_are_standard_normal_and_lead_back() {
        let values = skewed(40_000, 1e6, 3);
        let curve = Marginal::curve(&values);
        let scores: Vec<f64> = values.iter().map(|&v| f64::from(curve.scores()(v))).collect();
        let n = scores.len() as f64;
        let moment = |p: i32| scores.iter().map(|s| s.powi(p)).sum::<f64>() / n;
        assert!(moment(1).abs() < 0.03 && (moment(2) - 1.0).abs() < 0.03, "{} {}", moment(1), moment(2));
        assert!(moment(3).abs() < 0.1 && (moment(4) - 3.0).abs() < 0.2, "{} {}", moment(3), moment(4));
        for (value, score) in values.iter().zip(scores) {
            assert!((curve.values()(score as f32) - value).abs() < 1e-5);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]
        #[test]
        fn curves_are_monotone_both_ways_and_stay_in_the_values_range(
            n in 1usize..400, levels in 1.0f32..300.0, curved: bool, seed: u64,
        ) {
            let values = skewed(n, levels.round(), seed);
            let marginal = if curved { Marginal::curve(&values) } else { Marginal::normal(&values) };
            let (forth, back) = (marginal.scores(), marginal.values());
            let mut sorted = values.clone();
            sorted.sort_unstable_by(f32::total_cmp);
            prop_assert!(sorted.windows(2).all(|w| forth(w[0]) <= forth(w[1])));
            let line: Vec<f32> = (-60..=60).map(|i| back(i as f32 * 0.1)).collect();
            prop_assert!(line.windows(2).all(|w| w[0] <= w[1]));
            if curved {
                prop_assert!(line[0] >= sorted[0] - 1e-6 && line[120] <= sorted[n - 1] + 1e-6);
            }
            prop_assert_eq!(marginal.is_constant(), sorted[0] == sorted[n - 1]);
        }
    }
}
