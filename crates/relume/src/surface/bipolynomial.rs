//! A reflectance relative to a matt one, as a polynomial of two cosines, fitted to many values at once.
//!
//! f(x, y) = sum_ij c_ij (2x - 1)^i (2y - 1)^j of x = n . l and y = n . h, of degree 2 and 6: what rough gloss, shadowing
//! between microfacets and light from below the surface do to a matt surface varies slowly with x, highlights faster with
//! y. The bi-polynomial model of B. Shi, P. Tan, Y. Matsushita, K. Ikeuchi, "Bi-polynomial modeling of low-frequency
//! reflectances", IEEE PAMI 36(6), 2014, has n . h and l . h, degree 2, and a function for each texel. On the test data n . l
//! does better than l . h, and degrees from 1 and 1 to
//! 3 and 6 are about alike: lower ones lose gloss, higher ones follow what few values show.

use crate::numeric::small::solve_spd;
use crate::parallel;

/// Powers of n . l, and of n . h.
const ROWS: usize = 3;
const COLUMNS: usize = 7;
const TERMS: usize = ROWS * COLUMNS;
/// Weighted least squares after the first ones, each with the weights of the residuals before.
const REWEIGHTINGS: usize = 5;
/// The scale of the weights in spreads of the residuals.
const REACH: f64 = 2.0;
/// How much the function is held to the matt one, per value: with 1e-5 the normals of a virtual bark without gloss went
/// astray (8.4 degrees; 7.2 with 1e-3), with 1e-2 those of a glossy cat lost two tenths of a degree.
const RIDGE: f64 = 3e-4;
/// The least and the largest value: beyond what the values show, a polynomial may be anything.
const LEAST: f64 = 0.1;
const LARGEST: f64 = 10.0;
/// Values whose sums one task makes.
const TASK: usize = 4096;

/// The polynomial.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bipolynomial {
    coefficients: [[f64; COLUMNS]; ROWS],
}

/// A value of a texel, relative to its albedo, and the cosines of its normal with the light and the half vector.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShadedValue {
    pub to_light: f64,
    pub to_half: f64,
    pub value: f64,
}

/// The upper triangle of the normal equations, and their right-hand side.
type Equations = ([[f64; TERMS]; TERMS], [f64; TERMS]);

impl Bipolynomial {
    /// f = 1.
    pub fn matt() -> Self {
        let mut coefficients = [[0.0; COLUMNS]; ROWS];
        coefficients[0][0] = 1.0;
        Self { coefficients }
    }

    /// The function at two cosines.
    pub fn at(&self, to_light: f64, to_half: f64) -> f64 {
        self.unbounded(to_light, to_half).clamp(LEAST, LARGEST)
    }

    fn unbounded(&self, to_light: f64, to_half: f64) -> f64 {
        let (x, y) = (2.0 * to_light - 1.0, 2.0 * to_half - 1.0);
        let row = |row: &[f64; COLUMNS]| row.iter().rev().fold(0.0, |sum, c| sum * y + c);
        self.coefficients.iter().rev().fold(0.0, |sum, coefficients| sum * x + row(coefficients))
    }

    /// The function that explains values best, f(x, y) x: by least squares, which follow highlights that weights would leave
    /// out, and then with the weights of Geman and McClure.
    pub fn of(values: &[ShadedValue]) -> Self {
        let mut found = Self::matt();
        for pass in 0..=REWEIGHTINGS {
            let spread = if pass == 0 { Some(f64::INFINITY) } else { found.spread(values) };
            let Some(spread) = spread.filter(|_| !values.is_empty()) else { break };
            let parts: Vec<Equations> =
                parallel::map(values.chunks(TASK), |values| found.equations(values, spread));
            let Some(next) = Self::solved(&parts, values.len()) else { break };
            found = next;
        }
        found
    }

    fn residual(&self, at: &ShadedValue) -> f64 {
        at.value - self.unbounded(at.to_light, at.to_half) * at.to_light
    }

    fn spread(&self, values: &[ShadedValue]) -> Option<f64> {
        let mut sizes: Vec<f64> = values.iter().map(|value| self.residual(value).abs()).collect();
        let middle = sizes.len() / 2;
        let median = (!sizes.is_empty()).then(|| *sizes.select_nth_unstable_by(middle, f64::total_cmp).1)?;
        Some(REACH * (1.4826 * median).max(1e-9))
    }

    /// The sums of some values, for the difference to the matt function.
    fn equations(&self, values: &[ShadedValue], spread: f64) -> Equations {
        let (mut matrix, mut right) = ([[0.0; TERMS]; TERMS], [0.0; TERMS]);
        for at in values {
            let weight = (1.0 + (self.residual(at) / spread).powi(2)).powi(-2);
            let (x, y) = (2.0 * at.to_light - 1.0, 2.0 * at.to_half - 1.0);
            let mut terms = [0.0; TERMS];
            let mut row = at.to_light;
            for terms in terms.as_chunks_mut::<COLUMNS>().0 {
                let mut term = row;
                for out in terms {
                    *out = term;
                    term *= y;
                }
                row *= x;
            }
            let lacking = weight * (at.value - at.to_light);
            for (i, (matrix, right)) in matrix.iter_mut().zip(&mut right).enumerate() {
                *right += terms[i] * lacking;
                let scaled = weight * terms[i];
                matrix[i..].iter_mut().zip(&terms[i..]).for_each(|(sum, term)| *sum += scaled * term);
            }
        }
        (matrix, right)
    }

    fn solved(parts: &[Equations], count: usize) -> Option<Self> {
        let (mut matrix, mut right) = ([[0.0; TERMS]; TERMS], [0.0; TERMS]);
        for part in parts {
            for i in 0..TERMS {
                right[i] += part.1[i];
                (i..TERMS).for_each(|j| matrix[j][i] += part.0[i][j]);
            }
        }
        (0..TERMS).for_each(|i| matrix[i][i] += RIDGE * count as f64);
        let found = solve_spd(&matrix, &right)?;
        let mut coefficients = [[0.0; COLUMNS]; ROWS];
        coefficients.as_flattened_mut().copy_from_slice(&found);
        coefficients[0][0] += 1.0;
        Some(Self { coefficients })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn truth(x: f64, y: f64) -> f64 {
        0.7 + 0.2 * x - 0.3 * x * y + 0.6 * y.powi(5)
    }

    fn values(count: usize) -> Vec<ShadedValue> {
        let mut stream = Stream::new(3, Purpose::Sample, [1]);
        let value = |_| {
            let (to_light, to_half) = (0.05 + 0.95 * stream.unit(), 0.05 + 0.95 * stream.unit());
            ShadedValue { to_light, to_half, value: truth(to_light, to_half) * to_light }
        };
        (0..count).map(value).collect()
    }

    #[test]
    fn a_polynomial_is_found_again_though_a_fifth_of_the_values_is_in_shadow() {
        let mut values = values(9001);
        values.iter_mut().step_by(5).for_each(|value| value.value *= 0.1);
        let found = Bipolynomial::of(&values);
        for (x, y) in [(0.1, 0.9), (0.5, 0.5), (0.9, 0.2), (1.0, 1.0)] {
            let (found, truth) = (found.at(x, y), truth(x, y));
            // The ridge holds it back by up to two hundredths.
            assert!((found - truth).abs() < 0.03, "{found} instead of {truth} at {x}, {y}");
        }
    }

    #[test]
    fn matt_values_and_none_leave_the_matt_function() {
        let mut matt = values(500);
        matt.iter_mut().for_each(|value| value.value = value.to_light);
        let found = Bipolynomial::of(&matt);
        assert!([0.1, 0.5, 1.0].into_iter().all(|x| (found.at(x, 0.7) - 1.0).abs() < 1e-9));
        assert_eq!(Bipolynomial::of(&[]), Bipolynomial::matt());
    }

    #[test]
    fn thread_counts_do_not_change_a_bit() {
        let values = values(20_000);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Bipolynomial::of(&values))
        };
        assert_eq!(run(1), run(3));
    }
}
