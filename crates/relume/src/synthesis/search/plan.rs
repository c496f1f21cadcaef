//! Which search is used: decided before anything is prepared, as data.

use super::brute::Brute;
use super::fft::Fft;
use super::projection::{Projection, cells};
use super::{KernelBasis, Search, SearchMethod, SearchOptions};
use crate::synthesis::layout::Layout;
use crate::synthesis::options::BlockOptions;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::Quantised;

/// A decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recipe {
    /// Every position in full.
    Brute,
    /// Correlation.
    Fft,
    /// Projections.
    Projection {
        /// Texels along a side of a block.
        block: usize,
        /// Texels along a side of the cells that are projected.
        side: usize,
        /// The kernels' basis.
        basis: KernelBasis,
        /// Kernels for each cell at most.
        kernels: usize,
    },
}

/// Decides for a layout of blocks.
pub fn plan(options: &SearchOptions, blocks: &BlockOptions, layout: &Layout) -> Recipe {
    let margins = layout.sequence.iter().map(|block| block.neighbourhood.margins);
    let sides = margins.flat_map(|m| [m.left, m.top, m.right, m.bottom]).filter(|side| *side > 0);
    let side = cells::side(sides.min().unwrap_or(blocks.overlap));
    let SearchOptions { method, basis, kernels, .. } = *options;
    match method {
        SearchMethod::Brute => Recipe::Brute,
        SearchMethod::Fft => Recipe::Fft,
        // Preparing costs about as much as one brute search a kernel.
        SearchMethod::Auto if layout.sequence.len() <= kernels => Recipe::Brute,
        SearchMethod::Auto | SearchMethod::Projection => {
            Recipe::Projection { block: blocks.block, side, basis, kernels }
        }
    }
}

impl Recipe {
    /// Memory that preparing it takes.
    pub fn bytes(self, exemplars: &Quantised) -> u64 {
        let texels: usize = exemplars.texels().iter().map(|texels| texels.size().texels()).sum();
        match self {
            Self::Brute => 0,
            // Half a complex number for each plane, and the sums of squares.
            Self::Fft => texels as u64 * (8 * exemplars.planes() as u64 + 8),
            Self::Projection { kernels, .. } => Projection::bytes(exemplars, kernels),
        }
    }

    /// Prepares the search.
    pub fn prepare<'a>(self, exemplars: &'a Quantised, positions: &'a Positions) -> Box<dyn Search + 'a> {
        match self {
            Self::Brute => Box::new(Brute { exemplars, positions }),
            Self::Fft => Box::new(Fft::new(exemplars, positions)),
            Self::Projection { block, side, basis, kernels } => {
                Box::new(Projection::new(exemplars, positions, (block, side), basis, kernels))
            }
        }
    }
}
