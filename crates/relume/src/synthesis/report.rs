//! The result of a synthesis by blocks, and its report.

use serde::Serialize;

use super::search::Effort;
use super::source_map::{SourceMap, Texel};

/// The result of a synthesis.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthesis {
    /// Where each texel comes from.
    pub map: SourceMap,
    /// The report.
    pub report: SynthesisReport,
    /// The times of the stages.
    pub times: StageTimes,
}

/// Wall-clock seconds of each stage; the only part of a result that differs between runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StageTimes {
    /// Quantising the exemplars and preparing the search.
    pub prepare_s: f64,
    /// Searching for all blocks.
    pub search_s: f64,
    /// Drawing and joining all blocks, and the rejection curve if requested.
    pub join_s: f64,
}

/// The report of a synthesis.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct SynthesisReport {
    /// Blocks in each row.
    pub columns: usize,
    /// Rows of blocks.
    pub rows: usize,
    /// The number of positions in the exemplars from which a block can be taken.
    pub positions: usize,
    /// The difference in index space of one code.
    pub step: f64,
    /// The number of candidates over all blocks but the first.
    pub candidates: u64,
    /// The total effort of the searches.
    pub effort: Effort,
    /// The rejection curve, if requested and supported by the search.
    pub curve: Option<RejectionCurve>,
    /// The blocks in the order in which they were placed.
    pub placements: Vec<Placement>,
}

/// The rejection by projections, summed over a sample of the blocks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct RejectionCurve {
    /// The number of blocks in the sample.
    pub blocks: usize,
    /// The number of positions examined for them.
    pub positions: u64,
    /// The number of positions that remain after each kernel of every cell.
    pub remaining: Vec<u64>,
}

impl RejectionCurve {
    /// Adds another block of the sample.
    pub(super) fn add(&mut self, positions: usize, remaining: &[u64]) {
        self.blocks += 1;
        self.positions += positions as u64;
        self.remaining.iter_mut().zip(remaining).for_each(|(sum, more)| *sum += more);
    }
}

/// The choice for one block.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Placement {
    /// Left column in the output.
    pub x: usize,
    /// Top row in the output.
    pub y: usize,
    /// The exemplar texel at its top left.
    pub source: Texel,
    /// The number of candidates.
    pub candidates: usize,
    /// The root mean square distance of the best one, over the texels of the neighbourhood in index space.
    pub best: f64,
}
