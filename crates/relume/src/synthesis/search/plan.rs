//! Which search is used: decided before anything is prepared, as data.

use super::brute::Brute;
use super::fft::Fft;
use super::projection::{Projection, Strips};
use super::{KernelBasis, Search, SearchMethod, SearchOptions};
use crate::synthesis::layout::Layout;
use crate::synthesis::options::{BlockOptions, Boundary};
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::Quantised;

/// Codes of a strip above which integer projections have too few bits to be of use, and in the end
/// to be exact.
const WIDEST_STRIP: usize = 1 << 16;

/// A decision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Recipe {
    /// Every position in full.
    Brute,
    /// Correlation.
    Fft,
    /// Projections of these strips on so many kernels.
    Projection {
        /// The strips.
        strips: Strips,
        /// The kernels' basis.
        basis: KernelBasis,
        /// Kernels for each strip.
        kernels: usize,
    },
}

/// Decides for a layout of blocks and exemplars of so many planes.
pub fn plan(options: &SearchOptions, blocks: &BlockOptions, layout: &Layout, planes: usize) -> Recipe {
    let strips = strips(blocks, layout);
    let strip_codes = strips.block * strips.overlap * planes;
    let projection = Recipe::Projection { strips, basis: options.basis, kernels: options.kernels };
    match options.method {
        SearchMethod::Brute => Recipe::Brute,
        SearchMethod::Fft => Recipe::Fft,
        // Preparing costs about as much as one brute search a kernel.
        SearchMethod::Auto if layout.sequence.len() <= options.kernels => Recipe::Brute,
        // Asked for or not: projections of such strips would no longer be exact in 32 bits.
        SearchMethod::Auto | SearchMethod::Projection if strip_codes > WIDEST_STRIP => Recipe::Fft,
        SearchMethod::Auto | SearchMethod::Projection => projection,
    }
}

/// The strips that all neighbourhoods of the layout contain.
fn strips(blocks: &BlockOptions, layout: &Layout) -> Strips {
    let margins = layout.sequence.iter().map(|block| block.neighbourhood.margins);
    let sides = || margins.clone().flat_map(|m| [m.left, m.top, m.right, m.bottom]).filter(|side| *side > 0);
    let overlap = sides().min().unwrap_or(blocks.overlap);
    let closing = if blocks.boundary == Boundary::Torus { sides().max().unwrap_or(overlap) } else { 0 };
    let upright = blocks.block.saturating_sub(overlap + closing).max(1);
    Strips { block: blocks.block, overlap, upright }
}

impl Recipe {
    /// Memory that preparing it takes.
    pub fn bytes(self, exemplars: &Quantised) -> u64 {
        let texels: usize = exemplars.texels().iter().map(|texels| texels.size().texels()).sum();
        let each = match self {
            Self::Brute => 0,
            // Half a complex number for each plane, and the sums of squares.
            Self::Fft => 8 * exemplars.planes() as u64 + 8,
            Self::Projection { kernels, .. } => Projection::bytes_per_texel(kernels, exemplars.planes()),
        };
        texels as u64 * each
    }

    /// Prepares the search.
    pub fn prepare<'a>(self, exemplars: &'a Quantised, positions: &'a Positions) -> Box<dyn Search + 'a> {
        match self {
            Self::Brute => Box::new(Brute { exemplars, positions }),
            Self::Fft => Box::new(Fft::new(exemplars, positions)),
            Self::Projection { strips, basis, kernels } => {
                Box::new(Projection::new(exemplars, positions, strips, basis, kernels))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::planes::Size;

    #[test]
    fn strips_too_wide_for_exact_projections_are_correlated() {
        let blocks =
            BlockOptions { size: Size::new(2400, 2400), block: 600, overlap: 300, ..BlockOptions::default() };
        let layout = Layout::new(&blocks, &Limits::default()).unwrap();
        let search = SearchOptions { method: SearchMethod::Projection, ..SearchOptions::default() };
        assert_eq!(plan(&search, &blocks, &layout, 18), Recipe::Fft);
        let narrow = BlockOptions { block: 32, overlap: 8, ..blocks };
        let layout = Layout::new(&narrow, &Limits::default()).unwrap();
        assert!(matches!(plan(&search, &narrow, &layout, 18), Recipe::Projection { .. }));
    }
}
