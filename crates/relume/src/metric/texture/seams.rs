//! Seam visibility: steps across cuts compared with steps inside copied pieces.
//!
//! A cut runs between two neighbours that are not neighbours in the exemplar. The root mean square step
//! across cuts divided by that inside pieces is 1 where cuts are as smooth as the texture itself. Cuts that
//! follow edges of the texture may exceed 1 and still be invisible, so compare methods on one exemplar. It
//! detects jumps at cuts, but not features that end there.

use serde::Serialize;

use super::sources::Sources;
use super::steps::{NeighbourSteps, ratio};
use crate::error::{Error, Result};
use crate::planes::Planes;

/// The visibility of cuts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Seams {
    /// Pairs of neighbours with a cut in between.
    pub cuts: usize,
    /// Their share of all pairs.
    pub share: f64,
    /// Root mean square step across cuts.
    pub across: f64,
    /// Root mean square step inside pieces.
    pub inside: f64,
    /// `across` divided by `inside`; 1 without cuts.
    pub ratio: f64,
}

/// Measures the cuts of a texture.
///
/// # Errors
/// When the sources belong to a texture of another size.
pub fn seams(planes: &Planes, sources: &Sources<'_>) -> Result<Seams> {
    if planes.size() != sources.size() {
        return Err(Error::usage(format!(
            "a source map of {} texels does not belong to a texture of {}: both must have the same size",
            sources.size(),
            planes.size()
        )));
    }
    let (mut cut, mut kept) = (NeighbourSteps::default(), NeighbourSteps::default());
    for (here, there, step) in sources.neighbours() {
        let steps = if sources.continues(here, there, step) { &mut kept } else { &mut cut };
        steps.add(planes, here, there);
    }
    let (across, inside) = (cut.rms(), kept.rms());
    Ok(Seams {
        cuts: cut.count(),
        share: cut.count() as f64 / (cut.count() + kept.count()).max(1) as f64,
        across,
        inside,
        ratio: if cut.count() == 0 || kept.count() == 0 { 1.0 } else { ratio(across, inside) },
    })
}
