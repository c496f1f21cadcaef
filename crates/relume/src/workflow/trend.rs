//! Textures that change from side to side as their exemplar does: its trend, stretched to the output, guides them.
//!
//! Copies of an exemplar that is dark above and bright below, such as a fire, are otherwise laid anywhere, and the
//! output shows patches of light and dark. The trend is the polynomial of second degree closest to each index plane
//! ([`crate::analysis::trend`]).

use crate::analysis::trend::stretched;
use crate::analysis::{Analysis, Warning};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::size::Size;
use crate::synthesis::{Boundary, Exemplar, Guidance};

/// The share of the variance from which on a trend is part of the material rather than a fault of its light.
pub(super) const PLAIN_TREND: f64 = 0.25;

/// Whether a texture had better follow the trend of its exemplars.
pub(super) fn is_plain(analyses: &[Analysis], boundary: Boundary) -> bool {
    let [one] = analyses else { return false };
    boundary == Boundary::Open && one.trend >= PLAIN_TREND && one.warnings.contains(&Warning::UnevenLight)
}

/// The guide that makes an output of the given size follow the trend of the exemplar.
///
/// # Errors
/// Several exemplars, an output that tiles, and exemplars smaller than three texels.
pub(super) fn guidance(
    exemplars: &[Exemplar<'_>],
    size: Size,
    boundary: Boundary,
    job: &Job,
) -> Result<Guidance> {
    let [exemplar] = exemplars else {
        let found = exemplars.len();
        return Err(Error::usage(format!("the trend of one exemplar is followed, and there are {found}")));
    };
    if boundary == Boundary::Torus {
        return Err(Error::usage(
            "a texture that tiles cannot change from side to side as its exemplar does",
        ));
    }
    let own = exemplar.index.size();
    if own.width.min(own.height) < 3 {
        return Err(Error::usage(format!("an exemplar of {own} texels has no trend: 3 x 3 are needed")));
    }
    job.check_bytes("the trends", (4 * exemplar.index.count() * (own.texels() + size.texels())) as u64)?;
    let [source, target] = stretched(exemplar.index, size);
    Ok(Guidance { sources: vec![source], target, weight: 1.0 })
}
