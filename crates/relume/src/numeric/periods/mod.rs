//! The periods of a texture, axis-aligned or oblique, from its autocorrelation.
//!
//! A texture that repeats is the sum of a periodic part and a residual unrelated to its shifted copies; its
//! correlation at lattice shifts is then the share of the periodic part in the variance, whatever the
//! residual. So a lattice is judged by the mean correlation at its points, minus the mean within its cells:
//! one accidental peak does not make a period. The steps, a file each:
//!
//! - `peaks`: local maxima of the correlation, to a fraction of a texel, best candidates first;
//! - `pairs`: every pair of candidates is a lattice (as H.-C. Lin, L.-L. Wang, S.-N. Yang, Extracting
//!   periodicity of a regular texture based on autocorrelation functions, 1997, test pairs of peaks); among
//!   those nearly as good as the best the densest wins, because multiples of a period are periods too;
//! - `refine`: least squares over all its peaks determines the lattice to a few hundredths of a texel;
//! - `stripes`: where only one direction repeats, the profile across the stripes is judged in the
//!   same way.
//!
//! Limits: a period must fit twice into the texture; slow drifts of brightness should be removed first; a
//! pattern that drifts (perspective, hand-laid bricks) loses share with distance and may be reported as
//! stripes or not at all.

mod pairs;
mod peaks;
mod refine;
mod share;
mod stripes;

use super::autocorrelation::Autocorrelation;
use super::lattice::Lattice;

/// The periods of a texture.
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

/// The periods of a texture, and the share of it that repeats.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Periods {
    /// The periods.
    pub pattern: Pattern,
    /// The share of the variance that repeats, 0 to 1; without a period, the share of the best rejected
    /// guess.
    pub share: f64,
}

/// Periods with at least this fraction of the best share are equivalent: the shortest of them is taken.
const NEARLY_BEST: f64 = 0.9;

/// The least share of `points` correlation values that counts as a period. Unrelated textures of large
/// features reach 0.15 with the best of a thousand lattices of three or four points, and less with more
/// points; real fabrics are at 0.6 and above.
fn least_share(points: usize) -> f64 {
    0.15 + 0.3 / (points as f64).sqrt()
}

/// If stripes explain at least this fraction of what a lattice explains, the texture is only striped: along
/// stripes any vector is as good as a period.
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
