//! Exact histogram matching, and its inverse.
//!
//! Values are ranked, ties by position, and the value of each rank is replaced by that of the same rank in
//! the other distribution. The ranks allow the inverse: nothing is lost, even where many values become one.

use crate::error::{Error, Result};

/// Samples in ascending order: a distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Distribution(Vec<f32>);

impl Distribution {
    /// The distribution of the given values.
    ///
    /// # Errors
    /// When there are none, or one is not a number.
    pub fn of(values: &[f32]) -> Result<Self> {
        if values.is_empty() || values.iter().any(|v| v.is_nan()) {
            return Err(Error::invalid("a distribution needs at least one value and no NaN"));
        }
        let mut sorted = values.to_vec();
        sorted.sort_unstable_by(f32::total_cmp);
        Ok(Self(sorted))
    }

    /// The value of rank `rank` of `ranks`: with as many samples as ranks the sample of that rank.
    fn at(&self, rank: usize, ranks: usize) -> f32 {
        let twice = (2 * rank as u128 + 1) * self.0.len() as u128;
        self.0[(twice / (2 * ranks as u128)) as usize]
    }
}

/// Which place has which rank: for each rank from the least on, the place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranks(Vec<usize>);

impl Ranks {
    /// The ranks of some values, ties by place.
    pub fn of(values: &[f32]) -> Self {
        let mut places: Vec<usize> = (0..values.len()).collect();
        places.sort_unstable_by(|&a, &b| values[a].total_cmp(&values[b]).then(a.cmp(&b)));
        Self(places)
    }

    /// Values of these ranks and of that distribution. With as many samples as places they are a
    /// rearrangement of the samples; [`Ranks::of`] the original values together with their own
    /// distribution gives the original values.
    pub fn filled(&self, distribution: &Distribution) -> Vec<f32> {
        let mut values = vec![0.0; self.0.len()];
        for (rank, &place) in self.0.iter().enumerate() {
            values[place] = distribution.at(rank, self.0.len());
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn matching_is_exact_monotone_and_taken_back_to_the_bit(
            a in prop::collection::vec(-4i8..4, 1..80), b in prop::collection::vec(-100i8..100, 1..80),
        ) {
            let values: Vec<f32> = a.iter().map(|&v| f32::from(v) / 3.0).collect();
            let other: Vec<f32> = b.iter().map(|&v| f32::from(v) / 7.0).collect();
            let (ranks, target) = (Ranks::of(&values), Distribution::of(&other).unwrap());
            let matched = ranks.filled(&target);
            for (i, j) in (0..values.len()).flat_map(|i| (0..values.len()).map(move |j| (i, j))) {
                prop_assert!(values[i] >= values[j] || matched[i] <= matched[j]);
            }
            if values.len() == other.len() {
                prop_assert_eq!(Distribution::of(&matched).unwrap(), target);
            }
            prop_assert_eq!(ranks.filled(&Distribution::of(&values).unwrap()), values);
        }
    }

    #[test]
    fn a_distribution_of_nothing_is_refused() {
        assert!(Distribution::of(&[]).is_err() && Distribution::of(&[1.0, f32::NAN]).is_err());
    }
}
