//! Finding the blocks of the exemplars that fit what is there already.
//!
//! - [`brute`]: every position, many at a time;
//! - [`plain`]: every position, one texel after another: the slow truth;
//! - [`distance`]: the vectorised distance.
//!
//! All members give identical candidates: distances are exact integers, thresholds are integers,
//! and candidates come in the order of exemplar, row, column.

pub mod brute;
pub mod distance;
pub mod plain;

use super::neighbourhood::Neighbourhood;
use super::options::Tolerance;
use super::source_map::Texel;

/// What a block has to fit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Query {
    /// Which of its texels are filled.
    pub neighbourhood: Neighbourhood,
    /// The codes of the whole extent, the planes of a texel together, row after row; those of
    /// texels that are not filled have no meaning.
    pub codes: Vec<i16>,
}

/// Positions whose blocks fit well enough.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidates {
    /// The smallest squared distance over all positions.
    pub best: u64,
    /// All positions within the acceptance of it, in order.
    pub positions: Vec<Texel>,
}

/// Which squared distances are good enough once the smallest one is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Acceptance {
    factor: f64,
    always: u64,
}

impl Acceptance {
    /// The acceptance of a tolerance for neighbourhoods of `texels` texels in codes of `step`.
    pub fn new(tolerance: Tolerance, texels: usize, step: f64) -> Self {
        match tolerance {
            Tolerance::Relative(amount) => Self { factor: (1.0 + amount).powi(2), always: 0 },
            Tolerance::Absolute(delta) => {
                Self { factor: 1.0, always: ((delta / step).powi(2) * texels as f64) as u64 }
            }
        }
    }

    /// The largest squared distance that is accepted when `best` is the smallest. It rises with
    /// `best`, so the limit of a part of the positions never rejects a candidate of the whole.
    pub fn limit(self, best: u64) -> u64 {
        best.max(self.always).max((best as f64 * self.factor) as u64)
    }
}

/// A way to find candidates.
pub trait Search: Sync {
    /// All positions whose squared distance to the query is accepted, and the smallest distance.
    fn candidates(&self, query: &Query, acceptance: Acceptance) -> Candidates;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn acceptance_is_the_tolerance_squared() {
        let relative = Acceptance::new(Tolerance::Relative(0.1), 100, 0.5);
        assert_eq!((relative.limit(0), relative.limit(100), relative.limit(1000)), (0, 121, 1210));
        assert_eq!(Acceptance::new(Tolerance::Relative(0.0), 1, 1.0).limit(7), 7);
        let absolute = Acceptance::new(Tolerance::Absolute(2.0), 10, 0.5);
        assert_eq!((absolute.limit(3), absolute.limit(500)), (160, 500));
    }
}
