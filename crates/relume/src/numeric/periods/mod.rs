//! The periods of a texture, axis-aligned or oblique, from its autocorrelation.
//!
//! A texture that repeats is the sum of a periodic part and a rest that does not resemble its own
//! copies; its correlation at lattice shifts is then the periodic part's share of the variance,
//! whatever the rest is. So a lattice is judged by the mean correlation at its points, less the mean
//! within its cells: one lucky peak does not make a period. The steps, a file each:
//!
//! - `peaks`: local maxima of the correlation, to a fraction of a texel, best candidates first;
//! - `pairs`: every pair of candidates is a lattice (as H.-C. Lin, L.-L. Wang, S.-N. Yang, Extracting
//!   periodicity of a regular texture based on autocorrelation functions, 1997, test pairs of
//!   peaks); among those nearly as good as the best the densest wins, for multiples of a period
//!   are periods too;
//! - `refine`: least squares over all its peaks give the lattice to a few hundredths of a texel;
//! - `stripes`: where only one direction repeats, the profile across the stripes is judged in the
//!   same way.
//!
//! Limits: a period must fit twice into the texture; slow drifts of brightness should be taken out
//! first; a pattern that drifts (perspective, hand-laid bricks) loses share with distance and may be
//! called stripes or nothing.

mod pairs;
mod peaks;
mod refine;
mod share;
mod stripes;

use super::autocorrelation::Autocorrelation;
use super::lattice::Lattice;

/// How a texture repeats.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Pattern {
    /// No period was found.
    None,
    /// In one direction only: the period across the stripes, in texels, x to the right, y down.
    Stripes([f64; 2]),
    /// In two directions.
    Lattice(Lattice),
}

/// How a texture repeats, and how much of it does.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Periods {
    /// How it repeats.
    pub pattern: Pattern,
    /// The share of the variance that repeats, 0 to 1; where there is no period, the share of the
    /// best guess that was refused.
    pub share: f64,
}

/// Periods of at least this part of the best share are as good: the shortest of them is taken.
const NEARLY_BEST: f64 = 0.9;

/// The least share of `points` correlation values that is called a period. Unrelated textures of
/// large features reach 0.15 with the best of a thousand lattices of three or four points, and less
/// with more points; real fabrics are at 0.6 and above.
fn least_share(points: usize) -> f64 {
    0.15 + 0.3 / (points as f64).sqrt()
}

/// Stripes that explain at least this part of what a lattice does are only stripes: along them any
/// vector is as good as a period.
const AS_GOOD: f64 = 0.95;

/// Finds the periods in an autocorrelation.
pub fn find(correlation: &Autocorrelation) -> Periods {
    let lattice = pairs::best(correlation, &peaks::candidates(correlation));
    let stripes = stripes::best(correlation);
    let guess = stripes.map_or(0.0, |found| found.share.clamp(0.0, 1.0));
    let stripes = stripes.filter(|found| found.share >= least_share(found.points));
    let (pattern, share) = match (lattice, stripes) {
        (Some(two), Some(one)) if one.share >= AS_GOOD * two.share => {
            (Pattern::Stripes(one.period), one.share)
        }
        (Some(two), _) => (Pattern::Lattice(refine::lattice(correlation, two.lattice)), two.share),
        (None, Some(one)) => (Pattern::Stripes(one.period), one.share),
        (None, None) => (Pattern::None, guess),
    };
    Periods { pattern, share: share.min(1.0) }
}

#[cfg(test)]
mod tests;
