//! The choice of the search, made before anything is prepared, as data.

use super::brute::Brute;
use super::coarse::{self, CoarseToFine};
use super::fft::Fft;
use super::guided::GuidedSearch;
use super::projection::{Projection, cells};
use super::{KernelBasis, Search, SearchMethod, SearchOptions};
use crate::error::Result;
use crate::job::Job;
use crate::synthesis::guidance::GuideCodes;
use crate::synthesis::layout::BlockLayout;
use crate::synthesis::options::{BlockOptions, Boundary};
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::{IndexTexels, Quantised};

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
        /// Texels along a side of the projected cells.
        side: usize,
        /// The basis of the kernels.
        basis: KernelBasis,
        /// The most kernels for each cell.
        kernels: usize,
    },
    /// From coarse to fine.
    Coarse {
        /// The reduction of the coarsest level.
        factor: usize,
    },
    /// Every position in full, and its guide.
    Guided {
        /// Texels along a side of a block.
        block: usize,
        /// Whether the output continues at the opposite edge.
        wraps: bool,
    },
}

/// The number of cells per transform above which correlation is faster, with one transform per plane and one
/// back. On 256 x 256 RGB, projections of 11 cells take eight tenths of its time, those of 28 cells the same,
/// and those of 32 to 51 cells 1.3 to 2 times its time (`docs/performance.md`).
const CELLS_A_TRANSFORM: usize = 7;

/// Nanoseconds of a texel and plane of a position that is compared plainly, and of a texel, plane and halving of a transform
/// (leather of 512 x 512, 25 blocks: 16.5 s plainly, 0.5 s by correlation).
const PLAIN_NS: f64 = 0.18;
const TRANSFORM_NS: f64 = 1.1;
/// Plain searches that take less in all need no preparation.
const AT_ONCE_NS: f64 = 2e7;

/// Whether few blocks are found sooner by plain searches than by correlation.
fn is_plain_faster(layout: &BlockLayout, exemplars: &Quantised) -> bool {
    let (blocks, planes) = (layout.sequence.len() as f64, exemplars.planes() as f64);
    let texels: usize = exemplars.texels().iter().map(|texels| texels.size().texels()).sum();
    let texels = texels as f64;
    let compared: usize = layout.sequence.iter().map(|block| block.neighbourhood.texels()).sum();
    let plain = PLAIN_NS * texels * compared as f64 * planes;
    let transforms = (planes + 1.0) * blocks + planes;
    plain <= (TRANSFORM_NS * transforms * texels * texels.max(2.0).log2()).max(AT_ONCE_NS)
}

/// Decides for a layout of blocks and exemplars. With a guide there is no
/// choice: guided distances have no bounds or transforms yet, so all positions are examined whatever method
/// is requested.
pub fn plan(blocks: &BlockOptions, layout: &BlockLayout, exemplars: &Quantised) -> Recipe {
    let planes = exemplars.planes();
    if blocks.guidance.is_some() {
        return Recipe::Guided { block: blocks.block, wraps: blocks.boundary == Boundary::Torus };
    }
    let sizes = exemplars.texels().iter().map(IndexTexels::size);
    let factor = if blocks.search.coarse { coarse::reduction(sizes, blocks.overlap) } else { 1 };
    if factor > 1 {
        return Recipe::Coarse { factor };
    }
    let shapes = layout.sequence.iter().map(|block| block.neighbourhood);
    let margins = shapes.clone().map(|shape| shape.margins);
    let sides = margins.flat_map(|m| [m.left, m.top, m.right, m.bottom]).filter(|side| *side > 0);
    let side = cells::side(sides.min().unwrap_or(blocks.overlap));
    let cells = shapes.map(|shape| shape.texels() / side.pow(2)).max().unwrap_or(0);
    let SearchOptions { method, basis, kernels, .. } = blocks.search;
    match method {
        SearchMethod::Brute => Recipe::Brute,
        SearchMethod::Fft => Recipe::Fft,
        // Preparation costs about as much as one brute-force search per kernel.
        SearchMethod::Auto if layout.sequence.len() <= kernels => {
            if is_plain_faster(layout, exemplars) {
                Recipe::Brute
            } else {
                Recipe::Fft
            }
        }
        SearchMethod::Auto if cells > CELLS_A_TRANSFORM * (planes + 1) => Recipe::Fft,
        SearchMethod::Auto | SearchMethod::Projection => {
            Recipe::Projection { block: blocks.block, side, basis, kernels }
        }
    }
}

impl Recipe {
    /// The memory of its preparation, for exemplars and the guides of a guided one.
    pub(in crate::synthesis) fn bytes(self, exemplars: &Quantised, guides: Option<&GuideCodes>) -> u64 {
        let texels: usize = exemplars.texels().iter().map(|texels| texels.size().texels()).sum();
        match self {
            Self::Brute => 0,
            // Half a complex number for each plane, the sums of squares, and the spectra of a query a thread.
            Self::Fft => {
                let threads = rayon::current_num_threads() as u64;
                texels as u64 * (8 * exemplars.planes() as u64 + 8 + 32 * threads)
            }
            Self::Projection { kernels, .. } => Projection::bytes(exemplars, kernels),
            Self::Coarse { factor } => coarse::bytes(exemplars, factor),
            Self::Guided { .. } => guides.map_or(0, GuidedSearch::bytes),
        }
    }

    /// Prepares the search.
    ///
    /// # Errors
    /// When the job is cancelled.
    ///
    /// # Panics
    /// When a guided one gets no guides.
    pub(in crate::synthesis) fn prepare<'a>(
        self,
        exemplars: &'a Quantised,
        positions: &'a Positions,
        guides: Option<&GuideCodes>,
        job: &Job,
    ) -> Result<Box<dyn Search + 'a>> {
        Ok(match self {
            Self::Brute => Box::new(Brute { exemplars, positions }),
            Self::Fft => Box::new(Fft::new(exemplars, positions)),
            Self::Projection { block, side, basis, kernels } => {
                Box::new(Projection::new(exemplars, positions, (block, side), basis, kernels, job)?)
            }
            Self::Coarse { factor } => match CoarseToFine::new(exemplars, positions, factor) {
                Some(search) => Box::new(search),
                None => Box::new(Fft::new(exemplars, positions)),
            },
            Self::Guided { block, wraps } => {
                let guides = guides.expect("a guided search has guides");
                Box::new(GuidedSearch::new(exemplars, positions, guides, block, wraps))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::synthesis::guidance::{Guidance, Guided};
    use crate::synthesis::quantise::Exemplar;

    #[test]
    fn few_blocks_are_searched_plainly_and_wide_overlaps_by_correlation() {
        let chosen = |side: usize, block: usize, overlap: usize, planes: usize| {
            let blocks =
                BlockOptions { size: Size::new(side, side), block, overlap, ..BlockOptions::default() };
            let layout = BlockLayout::new(&blocks, &Job::default()).unwrap();
            let index = Planes::zeros(Size::new(8, 8), planes);
            let exemplar = [Exemplar { index: &index, excluded: None }];
            plan(&blocks, &layout, &Quantised::new(&exemplar, &Job::default()).unwrap())
        };
        assert_eq!(chosen(100, 32, 8, 3), Recipe::Brute);
        assert!(matches!(chosen(512, 32, 8, 3), Recipe::Projection { side: 8, .. }));
        assert!(matches!(chosen(512, 48, 12, 18), Recipe::Projection { side: 6, .. }));
        assert_eq!(chosen(512, 96, 32, 3), Recipe::Fft);
        assert!(matches!(chosen(512, 96, 32, 18), Recipe::Projection { side: 8, .. }));
    }

    /// A former fault: guided searches were planned and charged as projections, then replaced.
    #[test]
    fn guided_searches_are_planned_and_charged_as_such() {
        let job = Job::default();
        let (exemplar, size) = (Planes::zeros(Size::new(64, 64), 3), Size::new(512, 512));
        let guidance = Guidance {
            sources: vec![Planes::zeros(exemplar.size(), 2)],
            target: Planes::zeros(size, 2),
            weight: 1.0,
        };
        for method in [SearchMethod::Auto, SearchMethod::Projection, SearchMethod::Fft, SearchMethod::Brute] {
            let search = SearchOptions { method, ..SearchOptions::default() };
            let guidance = Some(guidance.clone());
            let blocks = BlockOptions { size, search, guidance, ..BlockOptions::default() };
            let layout = BlockLayout::new(&blocks, &job).unwrap();
            let exemplars = [Exemplar { index: &exemplar, excluded: None }];
            let guided = Guided::new(&exemplars, blocks.guidance.as_ref(), size, &job).unwrap();
            let (quantised, guides) = guided.apart(&job).unwrap();
            let recipe = plan(&blocks, &layout, &quantised);
            assert_eq!(recipe, Recipe::Guided { block: blocks.block, wraps: false });
            // Two planes of 32-bit means over the exemplar and over the output.
            let bytes = recipe.bytes(&quantised, guides.as_ref());
            assert_eq!(bytes, 2 * 4 * (64 * 64 + 512 * 512));
        }
    }
}
