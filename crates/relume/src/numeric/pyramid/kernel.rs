//! The generating kernel, for any reduction factor.

use crate::error::{Error, Result};

/// The weight of either outer tap of the three-tap smoothing: with a factor of 2 the centre weight becomes
/// Burt and Adelson's a = 0.4, the member of their family closest to a Gaussian.
const SIDE: f64 = 0.2;

/// The valid factors: beyond them a level has almost nothing in common with the one above.
const FACTORS: std::ops::RangeInclusive<usize> = 2..=16;

/// A kernel w and the factor n by which it reduces: the triangle of half-width n, smoothed.
///
/// A box of n samples convolved with anything gives every sample the same total weight (equal contribution).
/// Here the box is convolved with itself and with (0.2, 0.6, 0.2).
#[derive(Debug, Clone, PartialEq)]
pub struct Kernel {
    factor: usize,
    weights: Vec<f32>,
}

impl Kernel {
    /// The kernel of reduction factor `factor`.
    ///
    /// # Errors
    /// When the factor is not between 2 and 16.
    pub fn new(factor: usize) -> Result<Self> {
        if !FACTORS.contains(&factor) {
            return Err(Error::usage(format!(
                "a pyramid's reduction factor is {factor}: expected a whole number from {} to {}",
                FACTORS.start(),
                FACTORS.end()
            )));
        }
        let n = factor as f64;
        let triangle = |i: i64| (n - i.abs() as f64).max(0.0) / (n * n);
        let smooth = |i| SIDE * triangle(i - 1) + (1.0 - 2.0 * SIDE) * triangle(i) + SIDE * triangle(i + 1);
        let reach = factor as i64;
        Ok(Self { factor, weights: (-reach..=reach).map(|i| smooth(i) as f32).collect() })
    }

    /// The reduction factor n.
    pub fn factor(&self) -> usize {
        self.factor
    }

    /// Samples to either side of the centre.
    pub fn reach(&self) -> usize {
        self.weights.len() / 2
    }

    /// The weight of the sample `offset` from the centre; zero beyond the reach.
    pub fn weight(&self, offset: i64) -> f32 {
        let place = usize::try_from(offset + self.reach() as i64).ok();
        place.and_then(|i| self.weights.get(i)).copied().unwrap_or(0.0)
    }

    /// The weights from left to right.
    pub fn weights(&self) -> &[f32] {
        &self.weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_are_normalised_symmetric_and_of_equal_contribution() {
        for factor in FACTORS {
            let kernel = Kernel::new(factor).unwrap();
            let reach = kernel.reach() as i64;
            let sum: f32 = kernel.weights().iter().sum();
            assert!((sum - 1.0).abs() < 1e-6, "factor {factor}: sum {sum}");
            for i in 0..=reach {
                assert_eq!(kernel.weight(i), kernel.weight(-i));
                assert!(kernel.weight(i) >= 0.0 && (i == 0 || kernel.weight(i) <= kernel.weight(i - 1)));
            }
            for phase in 0..factor as i64 {
                let share: f32 = (-3..=3).map(|k| kernel.weight(phase - k * factor as i64)).sum();
                assert!(
                    (share - 1.0 / factor as f32).abs() < 1e-6,
                    "factor {factor}, phase {phase}: {share}"
                );
            }
        }
    }

    #[test]
    fn a_factor_of_two_gives_burt_and_adelsons_kernel() {
        let kernel = Kernel::new(2).unwrap();
        for (weight, truth) in kernel.weights().iter().zip([0.05, 0.25, 0.4, 0.25, 0.05]) {
            assert!((weight - truth).abs() < 1e-7);
        }
        assert!(Kernel::new(1).is_err() && Kernel::new(17).is_err());
    }
}
