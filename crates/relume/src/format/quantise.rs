//! Scale and bias of a coefficient for the least expected error.
//!
//! Bytes cover a window of 256 steps. A step s has an error of s^2 / 12 on average inside the window
//! (Bennett, "Spectra of Quantized Signals", 1948); a value outside has its distance from the window as the
//! error. A wide window rounds coarsely, a narrow one clips tails: windows of a list of steps, at all integer
//! biases, are compared on a histogram. The squared error of relit values is e' G e with the Gram matrix G,
//! and rounding errors of different coefficients are uncorrelated to first order, so each coefficient is
//! chosen independently.

use super::ptm::WHITE;

/// Bins of the histogram.
const BINS: usize = 4096;

/// The number of steps tried: from a fifth of the step of the whole range to slightly above it.
const STEPS: usize = 96;
const LEAST_STEP: f64 = 0.2;
const MOST_STEP: f64 = 1.02;

/// The largest bias for which single precision can still resolve the byte.
const MOST_BIAS: f64 = 524_288.0;

/// Scale and bias in the units of the file for values with white at 1, each with a weight by which its
/// squared error is multiplied.
pub(in crate::format) fn choose(samples: impl Iterator<Item = (f32, f32)> + Clone) -> (f32, f32) {
    let used = samples.filter(|&(_, weight)| weight > 0.0).map(|(v, w)| (f64::from(v) * WHITE, f64::from(w)));
    let range =
        used.clone().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), (v, _)| (lo.min(v), hi.max(v)));
    let (low, high) = range;
    let magnitude = low.abs().max(high.abs());
    if low > high || magnitude < 1e-15 {
        return (1.0, 0.0);
    }
    if high - low <= 1e-7 * magnitude {
        // A constant is one step away from the byte that represents zero.
        return (magnitude as f32, if low < 0.0 { 1.0 } else { 0.0 });
    }
    best_window(&Histogram::new(used, low, high), magnitude)
}

fn best_window(histogram: &Histogram, magnitude: f64) -> (f32, f32) {
    let whole = (histogram.high - histogram.low) / 254.0;
    let growth = (MOST_STEP / LEAST_STEP).powf(1.0 / (STEPS - 1) as f64);
    let listed = (0..STEPS).map(|i| whole * LEAST_STEP * growth.powi(i as i32));
    let least = magnitude / MOST_BIAS;
    let mut best = (f64::INFINITY, 1.0f32, 0.0f32);
    for step in listed.chain([whole]).map(|step| step.max(least) as f32) {
        let s = f64::from(step);
        let (at_low, at_high) = ((-histogram.low / s).round(), (255.0 - histogram.high / s).round());
        let (first, last) = (at_low.min(at_high) as i64 - 1, at_low.max(at_high) as i64 + 1);
        for bias in first..=last {
            let cost = histogram.cost(s, bias as f64);
            if cost < best.0 {
                best = (cost, step, bias as f32);
            }
        }
    }
    (best.1, best.2)
}

/// Running sums over bins of equal width: the weight below each edge, and its position.
struct Histogram {
    low: f64,
    high: f64,
    /// Weight, weighted distance from `low` and its square, of all bins before each edge.
    below: Vec<[f64; 3]>,
}

impl Histogram {
    fn new(samples: impl Iterator<Item = (f64, f64)>, low: f64, high: f64) -> Self {
        let mut below = vec![[0.0; 3]; BINS + 1];
        let per_unit = BINS as f64 / (high - low);
        for (value, weight) in samples {
            let distance = value - low;
            let bin = ((distance * per_unit) as usize).min(BINS - 1);
            let moments = [weight, weight * distance, weight * distance * distance];
            below[bin + 1].iter_mut().zip(moments).for_each(|(sum, m)| *sum += m);
        }
        for bin in 1..=BINS {
            let before = below[bin - 1];
            below[bin].iter_mut().zip(before).for_each(|(sum, b)| *sum += b);
        }
        Self { low, high, below }
    }

    /// The expected squared error of the window whose byte 0 represents -bias * step.
    fn cost(&self, step: f64, bias: f64) -> f64 {
        let (first, last) = (-bias * step - self.low, (255.0 - bias) * step - self.low);
        let total = self.below[BINS];
        let under = self.before(first);
        let not_over = self.before(last);
        let over: [f64; 3] = std::array::from_fn(|i| total[i] - not_over[i]);
        let clipped = |[w, wd, wdd]: [f64; 3], edge: f64| (wdd - 2.0 * edge * wd + edge * edge * w).max(0.0);
        let inside = total[0] - under[0] - over[0];
        inside * step * step / 12.0 + clipped(under, first) + clipped(over, last)
    }

    /// The sums below a distance from `low`, to the nearest bin.
    fn before(&self, distance: f64) -> [f64; 3] {
        let edge = distance / (self.high - self.low) * BINS as f64;
        self.below[edge.round().clamp(0.0, BINS as f64) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::ptm::{PtmEncoding, nearest_byte};
    use crate::numeric::random::{Purpose, Stream};

    fn squared_error(values: &[f32], (scale, bias): (f32, f32)) -> f64 {
        let encoding = PtmEncoding { scale: [scale; 6], bias: [bias; 6] };
        let error =
            |&v: &f32| f64::from(v - encoding.value(0, nearest_byte(encoding.position(0, v)))).powi(2);
        values.iter().map(error).sum()
    }

    fn chosen(values: &[f32]) -> (f32, f32) {
        choose(values.iter().map(|&v| (v, 1.0)))
    }

    /// The window from the least to the largest value.
    fn whole_range(values: &[f32]) -> (f32, f32) {
        let (lo, hi) = values.iter().fold((f32::MAX, f32::MIN), |(a, b), &v| (a.min(v), b.max(v)));
        let scale = (hi - lo) * 255.0 / 254.0;
        (scale, (-lo * 255.0 / scale).round())
    }

    #[test]
    fn tails_are_clipped_where_that_errs_less() {
        let mut random = Stream::new(3, Purpose::Sample, [0]);
        let mut bell = || (0..12).map(|_| random.unit() as f32).sum::<f32>() - 6.0;
        let mut values: Vec<f32> = (0..400_000).map(|_| 0.05 * bell()).collect();
        values[17] = 0.8;
        let (ours, plain) = (chosen(&values), whole_range(&values));
        assert!(squared_error(&values, ours) < 0.7 * squared_error(&values, plain), "{ours:?} {plain:?}");
        for factor in [0.9, 0.95, 1.05, 1.1] {
            let other = (ours.0 * factor, ours.1);
            assert!(squared_error(&values, ours) <= 1.001 * squared_error(&values, other), "{factor}");
        }
    }

    #[test]
    fn no_whole_range_is_better_than_the_choice() {
        let mut random = Stream::new(4, Purpose::Sample, [0]);
        for (offset, width) in [(0.0, 1.0), (-0.7, 0.3), (5.0, 0.01), (-80.0, 0.2)] {
            let values: Vec<f32> = (0..5000).map(|_| (offset + width * random.unit()) as f32).collect();
            let (ours, plain) = (chosen(&values), whole_range(&values));
            let (a, b) = (squared_error(&values, ours), squared_error(&values, plain));
            assert!(a <= 1.02 * b, "{offset} {width}: {a:e} against {b:e}");
            assert_eq!(ours.1, ours.1.round());
        }
    }

    #[test]
    fn constants_are_exact_and_nothing_at_all_is_accepted() {
        for constant in [0.0, 1.0, -0.3, 1e-9, 250.0, -1e-30] {
            let error = squared_error(&[constant; 5], chosen(&[constant; 5]));
            assert!(error < 1e-13 * f64::from(constant).powi(2) + 1e-36, "{constant}: {error:e}");
        }
        assert_eq!(chosen(&[]), (1.0, 0.0));
        assert_eq!(choose([(4.0, 0.0), (0.0, 0.0)].into_iter()), (1.0, 0.0));
    }

    #[test]
    fn weights_decide_whose_error_counts() {
        let values = [0.0f32, 0.1, 0.2, 40.0];
        let weighted = choose(values.iter().map(|&v| (v, if v > 1.0 { 1e-9 } else { 1.0 })));
        assert!(squared_error(&values[..3], weighted) < squared_error(&values[..3], chosen(&values)));
    }
}
