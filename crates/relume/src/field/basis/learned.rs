//! A basis learned from measurements: the values of the functions for each measured pair of light and view,
//! and for each channel where the channels of a texture have common coefficients.
//!
//! Between measured pairs the functions are interpolated. The layout of the pairs is arbitrary: those of several views
//! by [`crate::numeric::between`], lights seen from one view by radial basis functions
//! ([`super::interpolated`]), which predict photographs left out better.
//!
//! The inner product over the hemisphere is the weighted sum over measured pairs and channels, under which the
//! functions are orthonormal. It is undefined over other domains.

use std::sync::Arc;

use super::interpolated::RadialBasis;
use super::packed::PackedFunctions;
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::numeric::Matrix;
use crate::numeric::between::{Between, PairGrid};

/// The tolerance of orthonormality for sums over measured pairs: values are `f32`.
const ORTHONORMAL_TO: f64 = 1e-4;

/// Functions whose inner products with all others are computed in one pass over the pairs.
const TOGETHER: usize = 16;

/// Functions of light and view known at measured pairs. Copies share the table.
#[derive(Debug, Clone)]
pub struct Learned(Arc<MeasuredValues>);

#[derive(Debug)]
struct MeasuredValues {
    pairs: Vec<Directions>,
    weights: Vec<f64>,
    channels: usize,
    functions: usize,
    values: Vec<f32>,
    places: Places,
    packed: Option<PackedFunctions>,
}

/// What functions are interpolated by.
#[derive(Debug)]
enum Places {
    /// Of lights seen from one view, with a value for each channel and function.
    Radial(RadialBasis),
    Pairs(Between),
}

/// Lights beyond this number are interpolated between their neighbours only: radial basis functions take work that grows
/// with the cube of it.
const MOST_RADIAL: usize = 512;

impl Places {
    fn new(pairs: &[Directions], values: &[f32]) -> Self {
        let is_one_view = pairs.iter().all(|pair| pair.view == pairs[0].view);
        if is_one_view && pairs.len() <= MOST_RADIAL {
            let lights: Vec<_> = pairs.iter().map(|pair| pair.light).collect();
            let columns = values.len() / pairs.len();
            let values = Matrix::from_fn(pairs.len(), columns, |i, k| f64::from(values[i * columns + k]));
            if let Ok(radial) = RadialBasis::new(&lights) {
                return Self::Radial(radial.of_values(&values));
            }
        }
        Self::Pairs(Between::new(pairs))
    }
}

impl Learned {
    /// Functions from their values: `values[i * n + k]` is the value of function `k` of `n` for pair `i`. The
    /// `weights` of pairs are their shares of the measure over lights and views, such as solid angles.
    ///
    /// # Errors
    /// No pair or function; numbers of weights and values that do not match; numbers that are not finite,
    /// weights that are not positive; functions that are not orthonormal to 1e-4 under the weights.
    pub fn new(pairs: Vec<Directions>, weights: Vec<f64>, values: Vec<f32>) -> Result<Self> {
        Self::of_channels(1, pairs, weights, values)
    }

    /// Functions with a value for each of some `channels`: `values[(i * channels + c) * n + k]` is the value of
    /// function `k` of `n` for channel `c` of pair `i`.
    ///
    /// # Errors
    /// As [`Learned::new`], and no channel.
    pub fn of_channels(
        channels: usize,
        pairs: Vec<Directions>,
        weights: Vec<f64>,
        values: Vec<f32>,
    ) -> Result<Self> {
        let rows = pairs.len().saturating_mul(channels);
        let functions = values.len().checked_div(rows).unwrap_or(0);
        if functions == 0 || values.len() != functions * rows || weights.len() != pairs.len() {
            return Err(Error::invalid(format!(
                "a learned basis needs a weight and the values of all functions for each channel of each pair of \
                 directions, found {channels} channels, {} pairs, {} weights and {} values",
                pairs.len(),
                weights.len(),
                values.len()
            )));
        }
        let is_sound = weights.iter().all(|w| w.is_finite() && *w > 0.0);
        if !is_sound || values.iter().any(|v| !v.is_finite()) {
            return Err(Error::invalid("a learned basis has finite values and positive weights only"));
        }
        check_orthonormal(&weights, &values, channels, functions)?;
        let places = Places::new(&pairs, &values);
        Ok(Self(Arc::new(MeasuredValues {
            places,
            pairs,
            weights,
            channels,
            functions,
            values,
            packed: None,
        })))
    }

    /// The same functions, with the integers that they are made of.
    pub(super) fn packed_as(self, packed: PackedFunctions) -> Self {
        let made = Arc::try_unwrap(self.0).expect("functions without a copy");
        Self(Arc::new(MeasuredValues { packed: Some(packed), ..made }))
    }

    /// The integers that the functions are made of, if they are.
    pub fn packed(&self) -> Option<&PackedFunctions> {
        self.0.packed.as_ref()
    }

    /// The number of functions.
    pub fn functions(&self) -> usize {
        self.0.functions
    }

    /// The number of values of a function for a pair: 1, or one for each channel.
    pub fn channels(&self) -> usize {
        self.0.channels
    }

    /// The measured pairs of directions.
    pub fn pairs(&self) -> &[Directions] {
        &self.0.pairs
    }

    /// As [`super::Basis::lowest_light_cosine`].
    pub(super) fn lowest_light_cosine(&self) -> Option<f64> {
        let lowest = || self.pairs().iter().map(|pair| pair.light.z()).reduce(f64::min);
        matches!(self.0.places, Places::Pairs(_)).then(lowest).flatten()
    }

    /// The grid of lights and views that the pairs form, if they do and the functions are interpolated in its triangles.
    pub fn grid(&self) -> Option<&PairGrid> {
        match &self.0.places {
            Places::Pairs(between) => between.grid(),
            Places::Radial(_) => None,
        }
    }

    /// The weight of each pair.
    pub fn weights(&self) -> &[f64] {
        &self.0.weights
    }

    /// The values, all functions of a channel of a pair adjacent, then the next channel.
    pub fn values(&self) -> &[f32] {
        &self.0.values
    }

    /// The values of the functions for pair `i`, channel after channel.
    fn row(&self, i: usize) -> &[f32] {
        let length = self.0.channels * self.0.functions;
        &self.0.values[i * length..][..length]
    }

    /// The radial basis functions by which the functions are interpolated, if they are; a column for each channel and function.
    pub(super) fn radial(&self) -> Option<&RadialBasis> {
        match &self.0.places {
            Places::Radial(radial) => Some(radial),
            Places::Pairs(_) => None,
        }
    }

    /// The functions for any pair of directions, channel after channel.
    pub(super) fn weights_into(&self, directions: Directions, out: &mut [f64]) {
        out.fill(0.0);
        match &self.0.places {
            Places::Radial(radial) => radial.values_into(directions.light, out),
            Places::Pairs(between) => {
                for &(pair, share) in between.shares(directions).as_slice() {
                    out.iter_mut().zip(self.row(pair)).for_each(|(o, &v)| *o += share * f64::from(v));
                }
            }
        }
    }

    /// The weighted sum of f(values) over the measured pairs and channels.
    pub(super) fn integrate(&self, mut f: impl FnMut(&[f64]) -> f64) -> f64 {
        let rows = self.0.values.chunks_exact(self.0.functions);
        let mut value = |row: &[f32]| f(&row.iter().map(|&v| f64::from(v)).collect::<Vec<f64>>());
        rows.enumerate().map(|(i, row)| self.0.weights[i / self.0.channels] * value(row)).sum()
    }
}

/// Shared tables are equal; others are equal if all numbers are.
impl PartialEq for Learned {
    fn eq(&self, other: &Self) -> bool {
        let (a, b) = (&self.0, &other.0);
        let same = |a: &MeasuredValues, b: &MeasuredValues| {
            (a.channels, &a.pairs, &a.weights, &a.values) == (b.channels, &b.pairs, &b.weights, &b.values)
        };
        Arc::ptr_eq(a, b) || same(a, b)
    }
}

/// Refuses functions that are not orthonormal. Of the n x n inner products, those of a few functions with all
/// later ones are in memory at a time.
fn check_orthonormal(weights: &[f64], values: &[f32], channels: usize, n: usize) -> Result<()> {
    let row_weights = || weights.iter().flat_map(|weight| std::iter::repeat_n(weight, channels));
    for first in (0..n).step_by(TOGETHER) {
        let some = first..(first + TOGETHER).min(n);
        let mut products = vec![0.0f64; some.len() * (n - first)];
        for (weight, row) in row_weights().zip(values.chunks_exact(n)) {
            for (j, sums) in some.clone().zip(products.chunks_exact_mut(n - first)) {
                let factor = weight * f64::from(row[j]);
                sums.iter_mut().zip(&row[first..]).for_each(|(sum, &v)| *sum += factor * f64::from(v));
            }
        }
        for (i, product) in products.into_iter().enumerate() {
            check_product(product, first + i / (n - first), first + i % (n - first))?;
        }
    }
    Ok(())
}

fn check_product(product: f64, j: usize, k: usize) -> Result<()> {
    let expected = f64::from(u8::from(j == k));
    if product.is_nan() || (product - expected).abs() > ORTHONORMAL_TO {
        return Err(Error::invalid(format!(
            "functions {j} and {k} of the learned basis have the inner product {product:.6} and orthonormal ones \
             {expected}: make them orthonormal under the weights of the pairs"
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;
    use crate::field::basis::examples;

    #[test]
    fn measured_pairs_keep_their_values() {
        for learned in [examples::learned(7, 5, 4), examples::scattered(7, 5, 4)] {
            let mut out = [0.0; 4];
            for (pair, row) in learned.pairs().iter().zip(learned.values().chunks_exact(4)) {
                learned.weights_into(*pair, &mut out);
                out.iter().zip(row).for_each(|(o, v)| assert!((o - f64::from(*v)).abs() < 1e-6));
            }
        }
    }

    #[test]
    fn values_between_pairs_are_between_theirs_and_continuous() {
        [examples::learned(9, 6, 3), examples::scattered(9, 6, 3)].iter().for_each(check_between);
    }

    fn check_between(learned: &Learned) {
        let range = |k: usize| {
            let values = learned.values().iter().skip(k).step_by(3).map(|&v| f64::from(v));
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)))
        };
        let place = |t: f64| Directions {
            light: Direction::from_angles(0.2 + t, 3.0 * t),
            view: Direction::from_angles(1.1 - t, 0.5 - 2.0 * t),
        };
        let (mut before, mut out) = ([0.0; 3], [0.0; 3]);
        learned.weights_into(place(0.0), &mut before);
        let steps = 20_000;
        for i in 1..=steps {
            learned.weights_into(place(f64::from(i) / f64::from(steps)), &mut out);
            for k in 0..3 {
                let (low, high) = range(k);
                assert!(out[k] >= low - 1e-9 && out[k] <= high + 1e-9, "outside the measured values");
                let step = (out[k] - before[k]).abs();
                assert!(step < 0.002 * (high - low), "a jump of {step} at step {i}");
            }
            before = out;
        }
    }

    /// A fault: the check allocated n x n products, 4 GiB for as many functions as measured pairs.
    #[test]
    fn as_many_functions_as_pairs_are_checked_in_bounded_memory() {
        // Each function is 1 at one pair: orthonormal, and with 40 not a multiple of those in one pass.
        let n = 40;
        let light = |i: usize| Direction::from_angles(0.03 * i as f64, 2.4 * i as f64);
        let pairs: Vec<Directions> = (0..n).map(|i| Directions::from(light(i))).collect();
        let mut values: Vec<f32> = (0..n * n).map(|i| if i / n == i % n { 1.0 } else { 0.0 }).collect();
        assert!(Learned::new(pairs.clone(), vec![1.0; n], values.clone()).is_ok());
        (values[3 * n + 3], values[37 * n + 3]) = (0.937_5f32.sqrt(), 0.25);
        let error = Learned::new(pairs, vec![1.0; n], values).unwrap_err().to_string();
        assert!(error.contains("functions 3 and 37") && error.contains("0.250000"), "{error}");
    }

    #[test]
    fn tables_that_are_no_basis_are_refused() {
        let good = examples::learned(4, 3, 2);
        let (pairs, weights, values) =
            (good.pairs().to_vec(), good.weights().to_vec(), good.values().to_vec());
        let refused = |p: &[Directions], w: &[f64], v: &[f32]| {
            Learned::new(p.to_vec(), w.to_vec(), v.to_vec()).unwrap_err().to_string()
        };
        assert!(refused(&[], &[], &[]).contains("0 pairs"));
        let none = Learned::of_channels(0, pairs.clone(), weights.clone(), values.clone()).unwrap_err();
        assert!(none.to_string().contains("0 channels"), "{none}");
        assert!(refused(&pairs, &weights[1..], &values).contains("11 weights"));
        assert!(refused(&pairs, &weights, &values[1..]).contains("23 values"));
        let doubled: Vec<f32> = values.iter().map(|v| 2.0 * v).collect();
        assert!(refused(&pairs, &weights, &doubled).contains("orthonormal"));
        let mut broken = values.clone();
        broken[3] = f32::NAN;
        assert!(refused(&pairs, &weights, &broken).contains("finite"));
        assert_eq!(Learned::new(pairs, weights, values).unwrap(), good);
    }
}
