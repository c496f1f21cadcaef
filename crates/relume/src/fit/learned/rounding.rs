//! Functions and numbers of a factorised texture rounded to steps, so that its file needs few bits for each.
//!
//! Functions are orthonormal and numbers uncorrelated, so errors add: each function may err alike in the values of the
//! photographs, and one that is less than that is left out (the reverse water-filling of parallel Gaussian sources:
//! T. M. Cover, J. A. Thomas, "Elements of Information Theory", 2nd edition 2006, section 10.3.3). Within a function,
//! the values of the table and the numbers of the texels have errors in the ratio of their counts, where a bit more
//! gains the same in both. Steps of numbers are powers of two: multiples of these are exact in 16-bit floats, and the
//! bytes of a file repeat.

use std::f64::consts::SQRT_2;

use super::packing::{deviations, in_packed};
use crate::error::{Error, Result};
use crate::field::{Learned, PackedFunctions, ReflectanceField};
use crate::job::Job;

/// The coarsest rounding, of values with white at 1.
const COARSEST: f64 = 0.25;

/// The finest: integers of a finer one do not fit, and 16-bit floats without rounding are smaller.
const FINEST: f64 = 1e-6;

/// The bits of the exponent of a 64-bit float: alone they are the power of two below it.
const EXPONENT: u64 = 0x7ff << 52;

/// The most of what a function may err by that its numbers take: the table needs some of it.
const MOST_OF_NUMBERS: f64 = 0.9;

/// Refuses what is no root mean square of errors.
pub(super) fn validate(rmse: f64) -> Result<()> {
    if (FINEST..=COARSEST).contains(&rmse) {
        return Ok(());
    }
    Err(Error::usage(format!(
        "rounding may add a root mean square error of {FINEST} to {COARSEST}, of values with white at 1, not {rmse}: without \
         rounding, numbers are floats"
    )))
}

/// How a texture is rounded.
pub(super) struct FactorRounding {
    /// The mean square by which the numbers of each function may err.
    of_numbers: f64,
    /// The step of the numbers of each function.
    number_steps: Vec<f32>,
    /// The step of the values of each function.
    function_steps: Vec<f32>,
}

impl FactorRounding {
    /// The rounding of a field of learned functions that adds a root mean square error of `rmse` or less.
    pub fn new(field: &ReflectanceField, learned: &Learned, rmse: f64) -> Self {
        let deviations = deviations(field.coefficients(), learned.functions());
        let squares = mean_squares(learned);
        let share = rmse * rmse / deviations.len() as f64;
        let of_table = (learned.pairs().len() * learned.channels()) as f64;
        let of_numbers = share / (1.0 + of_table / field.size().texels() as f64);
        let counts = |(deviation, square): (&f64, &f64)| deviation * deviation * square > share;
        let kept = deviations.iter().zip(&squares).rposition(counts).map_or(0, |last| last + 1);
        let (mut number_steps, mut function_steps) = (Vec::new(), Vec::new());
        for (deviation, square) in deviations.iter().zip(&squares).take(kept) {
            let step = power_of_two(of_numbers, MOST_OF_NUMBERS * share, *square);
            number_steps.push(step as f32);
            let left = share - variance(step) * square;
            function_steps.push(((12.0 * left).sqrt() / deviation) as f32);
        }
        Self { of_numbers, number_steps, function_steps }
    }

    /// The field in rounded functions, its numbers as they come.
    ///
    /// # Errors
    /// Pairs that are not all of some lights with all of some views, and steps that are too coarse or too fine for the
    /// functions; limits exceeded, and a cancelled job.
    pub fn of_functions(
        &self,
        field: &ReflectanceField,
        learned: &Learned,
        job: &Job,
    ) -> Result<ReflectanceField> {
        if self.function_steps.is_empty() {
            return Err(Error::usage("so coarse a rounding leaves nothing of the texture: give a finer one"));
        }
        let packed = PackedFunctions::new(learned, &self.function_steps)?;
        in_packed(field, learned, &packed, job)
    }

    /// The step of the numbers of each function.
    pub fn number_steps(&self) -> &[f32] {
        &self.number_steps
    }

    /// The step of the numbers of so many axes of clusters in the space of the functions: together they may err as much as
    /// the numbers of the functions.
    pub fn step_of_axes(&self, axes: usize, learned: &Learned) -> f32 {
        let squares = mean_squares(learned);
        let square = squares.iter().sum::<f64>() / squares.len() as f64;
        let share = self.of_numbers * self.number_steps.len() as f64 / axes as f64;
        power_of_two(share, share, square) as f32
    }
}

/// The mean square of each function over the photographs, which count alike here whatever their solid angles.
fn mean_squares(learned: &Learned) -> Vec<f64> {
    let n = learned.functions();
    let mut sums = vec![0.0; n];
    for row in learned.values().chunks_exact(n) {
        sums.iter_mut().zip(row).for_each(|(sum, value)| *sum += f64::from(*value).powi(2));
    }
    let rows = (learned.values().len() / n) as f64;
    sums.into_iter().map(|sum| sum / rows).collect()
}

/// The power of two nearest to the step whose errors, times `factor`, have the mean square `wanted`; at most `most`.
fn power_of_two(wanted: f64, most: f64, factor: f64) -> f64 {
    let step = (12.0 * wanted / factor).sqrt();
    let below = f64::from_bits(step.to_bits() & EXPONENT);
    let nearest = if step > SQRT_2 * below { 2.0 * below } else { below };
    if variance(nearest) * factor > most { 0.5 * nearest } else { nearest }
}

/// The mean square error of rounding to multiples of a step.
fn variance(step: f64) -> f64 {
    step * step / 12.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::{Direction, Directions};
    use crate::field::Basis;
    use crate::fit::learned::tests::{Photographed, material};
    use crate::fit::learned::{ClusterOptions, LearnedFit, LearnedOptions, Rank, fit};
    use crate::planes::Planes;

    /// The bits a value, if a file knew how often each occurs in its plane.
    fn entropy_bits(planes: &Planes) -> f64 {
        let of_plane = |plane: &[f32]| {
            let mut counts = std::collections::BTreeMap::new();
            plane.iter().for_each(|value| *counts.entry(value.to_bits()).or_insert(0.0) += 1.0);
            let shares = counts.into_values().map(|count: f64| count / plane.len() as f64);
            -shares.map(|share| share * share.log2()).sum::<f64>()
        };
        planes.iter().map(of_plane).sum::<f64>() / planes.count() as f64
    }

    fn fitted(of: &Photographed, rounding: impl Into<Option<f64>>) -> LearnedFit {
        let rounding = rounding.into();
        of.fit(&LearnedOptions { rank: Rank::Functions(8), rounding, ..LearnedOptions::default() }).unwrap()
    }

    #[test]
    fn rounding_adds_the_error_asked_for_or_less_and_numbers_need_fewer_bits() {
        let material = material(9, 8, 3, 0.05);
        let exact = fitted(&material, None).report.error.rmse;
        let mut before = f64::MAX;
        for asked in [0.001, 0.004, 0.016, 0.04] {
            let fit = fitted(&material, asked);
            let added = (fit.report.error.rmse.powi(2) - exact * exact).sqrt();
            assert!(added > 0.4 * asked && added < 1.02 * asked, "{added} for {asked}");
            // All texels are measured; the errors of rounding and of the factorisation are nearly independent.
            assert!(
                (fit.report.fitted.error.rmse / fit.report.error.rmse - 1.0).abs() < 0.03,
                "{:?}",
                fit.report
            );
            let bits = entropy_bits(fit.field.coefficients());
            assert!(bits < before, "{bits} bits at {asked}");
            before = bits;
        }
    }

    #[test]
    fn rounded_numbers_are_exact_in_halves() {
        let fit = fitted(&material(6, 5, 3, 0.05), 0.004);
        let values = fit.field.coefficients().as_slice();
        assert!(values.iter().all(|value| half::f16::from_f32(*value).to_f32() == *value));
    }

    #[test]
    fn functions_of_less_than_the_rounding_are_left_out() {
        let fit = fitted(&material(6, 5, 3, 0.0), 0.05);
        assert!(fit.field.basis().len() < 8, "{}", fit.field.basis().len());
        assert!(fit.report.error.rmse < 0.05, "{}", fit.report.error.rmse);
    }

    #[test]
    fn an_error_asked_for_holds_with_rounding() {
        let (asked, rounding) = (0.02, Some(0.008));
        let options = LearnedOptions { rank: Rank::Error(asked), rounding, ..LearnedOptions::default() };
        let found = material(9, 8, 3, 0.05).fit(&options).unwrap().report.error.rmse;
        assert!(found < asked, "{found}");
    }

    #[test]
    fn clusters_are_rounded_as_well() {
        let material = material(9, 8, 3, 0.05);
        let clusters = Some(ClusterOptions { clusters: 4, axes: 3 });
        let run = |rounding| {
            let rank = Rank::Functions(8);
            material.fit(&LearnedOptions { rank, clusters, rounding, ..LearnedOptions::default() }).unwrap()
        };
        let (plain, rounded) = (run(None), run(Some(0.01)));
        let bits = |fit: &LearnedFit| entropy_bits(fit.clustered.as_ref().unwrap().planes());
        assert!(bits(&rounded) < bits(&plain) - 0.5, "{} and {} bits", bits(&rounded), bits(&plain));
        let (exact, found) = (plain.report.error.rmse, rounded.report.error.rmse);
        assert!(found > exact && found < (exact * exact + 1.2e-4).sqrt(), "{found} and {exact}");
    }

    #[test]
    fn steps_are_the_nearest_powers_of_two() {
        for (wanted, step) in [(1.0, 1.0), (1.4, 1.0), (1.42, 2.0), (0.3, 0.25), (6e-4, 1.0 / 2048.0)] {
            assert_eq!(power_of_two(variance(wanted), 1.0, 1.0), step);
        }
        assert_eq!(power_of_two(variance(1.5), variance(1.9), 1.0), 1.0);
    }

    #[test]
    fn roundings_without_meaning_are_refused_in_a_sentence() {
        let mut material = material(4, 3, 3, 0.1);
        let message = |of: &Photographed, rank, rounding| {
            let options = LearnedOptions { rank, rounding: Some(rounding), ..LearnedOptions::default() };
            of.fit(&options).unwrap_err().to_string()
        };
        for wrong in [0.0, -1.0, 0.3, f64::NAN, 1e-12] {
            assert!(message(&material, Rank::Functions(2), wrong).contains("to 0.25, of values"));
        }
        assert!(message(&material, Rank::Error(0.01), 0.01).contains("holds that of rounding, 0.01"));
        let fine = message(&material, Rank::Functions(2), 1e-9);
        assert!(fine.contains("0.000001 to 0.25"), "{fine}");
        // Found before the second photograph is read.
        material.pairs[5].1 =
            Directions { light: Direction::from_angles(0.3, 0.1), view: Direction::from_angles(0.2, 5.0) };
        let load = |i: usize| match i {
            0 => Ok(material.images[0].clone()),
            _ => Err(Error::invalid("the second photograph")),
        };
        let options = LearnedOptions { rounding: Some(0.01), ..LearnedOptions::default() };
        let error = fit(&material.pairs, &load, &options, &Job::default()).unwrap_err().to_string();
        assert!(error.contains("each light is needed with each view"), "{error}");
    }

    #[test]
    fn a_capture_of_lights_is_rounded_too() {
        let fit = fitted(&material(20, 1, 3, 0.05), 0.01);
        let Basis::Learned(learned) = fit.field.basis() else { panic!("learned functions") };
        assert!(learned.packed().is_some());
    }
}
