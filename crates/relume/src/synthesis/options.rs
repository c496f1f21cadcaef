//! Options of block-based synthesis.

use serde::Serialize;

use super::guidance::Guidance;
use super::search::SearchOptions;
use crate::error::{Error, Result};
use crate::names::named;
use crate::size::Size;

/// The tolerance within which blocks of the exemplar are candidates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Tolerance {
    /// Distances up to (1 + this) times the smallest one: squared distances up to its square times the
    /// smallest square. If the smallest is zero, only equal ones.
    Relative(f64),
    /// Root mean square over the texels of the neighbourhood of the distance of two texels in index space.
    /// With the function metric that is the L2 distance of their functions over the domain: a difference of v
    /// in all directions and c channels counts v sqrt(c A), where A is 2 pi for the hemisphere, pi for the
    /// cosine-weighted one and 4 for the square. If no block is as near, the nearest ones.
    Absolute(f64),
}

/// How a block is joined to the existing texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Blend {
    /// Along minimum error boundary cuts, one for each strip: every texel is a copy.
    Cut,
    /// Along the seam of least energy through all strips at once: every texel is a copy.
    GraphCut,
    /// By linear ramps across the overlaps.
    Alpha,
}

named!(Blend { Cut => "cut", GraphCut => "graphcut", Alpha => "alpha" });

/// What lies beyond the edges of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Boundary {
    /// Nothing.
    Open,
    /// The opposite edge: the output tiles without a seam.
    Torus,
}

named!(Boundary { Open => "open", Torus => "torus" });

/// The longest side of a block: that of the largest texture.
const MAX_BLOCK: usize = 1 << 17;

/// The most kernels for each cell: as many as a cell of 16 x 16 texels of 16 planes has numbers.
const MAX_KERNELS: usize = 4096;

/// Options of [`super::synthesize`].
#[derive(Debug, Clone, PartialEq)]
pub struct BlockOptions {
    /// Size of the output in texels.
    pub size: Size,
    /// Side of the square blocks in texels.
    pub block: usize,
    /// Texels by which neighbouring blocks overlap, at most half a block.
    pub overlap: usize,
    /// The tolerance within which candidates are drawn.
    pub tolerance: Tolerance,
    /// How blocks are joined.
    pub blend: Blend,
    /// Texels on either side of a cut within which blocks are blended, at most the overlap; 0 for
    /// none.
    pub feather: usize,
    /// Whether the output tiles.
    pub boundary: Boundary,
    /// The guide that the output follows.
    pub guidance: Option<Guidance>,
    /// Seed of the random choices.
    pub seed: u64,
    /// The search for blocks: a hint, which affects speed only.
    pub search: SearchOptions,
}

impl BlockOptions {
    /// The customary overlap: a sixth of the block (Efros, Freeman 2001), at least one texel.
    pub fn customary_overlap(block: usize) -> usize {
        (block / 6).max(1)
    }

    /// Checks the options in isolation; they are checked against the exemplars later.
    pub fn validate(&self) -> Result<()> {
        let Self { size, block, overlap, .. } = *self;
        if block > MAX_BLOCK {
            return Err(Error::usage(format!(
                "a block of {block} texels is too large: choose at most {MAX_BLOCK}"
            )));
        }
        if block < 2 {
            return Err(Error::usage(format!("a block of {block} texels is too small: it needs at least 2")));
        }
        if overlap == 0 {
            return Err(Error::usage(
                "blocks that do not overlap have no seams to join: choose an overlap of at least 1",
            ));
        }
        if overlap > block / 2 {
            return Err(Error::usage(format!(
                "blocks of {block} texels cannot overlap by {overlap}: choose 1 to {}",
                block / 2
            )));
        }
        if size.width == 0 || size.height == 0 {
            return Err(Error::usage(format!("an output of {size} texels: both sides must be at least 1")));
        }
        if self.boundary == Boundary::Torus && size.width.min(size.height) < block {
            return Err(Error::usage(format!(
                "an output of {size} texels cannot tile with blocks of {block}: a block would overlap \
                 itself; choose a block of at most {} or a larger output",
                size.width.min(size.height)
            )));
        }
        let (Tolerance::Relative(amount) | Tolerance::Absolute(amount)) = self.tolerance;
        if !(0.0..=1e6).contains(&amount) {
            return Err(Error::usage(format!(
                "a tolerance of {amount} has no meaning: expected a number from 0 to 1,000,000"
            )));
        }
        let kernels = self.search.kernels;
        if !(1..=MAX_KERNELS).contains(&kernels) {
            return Err(Error::usage(format!("a search by {kernels} kernels: choose 1 to {MAX_KERNELS}")));
        }
        self.validate_feather()
    }

    fn validate_feather(&self) -> Result<()> {
        let Self { overlap, blend, feather, .. } = *self;
        if feather > 0 && blend == Blend::Alpha {
            return Err(Error::usage(format!(
                "feathering by {feather} blends across cuts, and blocks blended by ramps have none: join them \
                 by cut or graphcut, or leave the feathering out"
            )));
        }
        if feather > overlap {
            return Err(Error::usage(format!(
                "cuts in overlaps of {overlap} texels cannot be feathered by {feather}: choose 0 to {overlap}"
            )));
        }
        Ok(())
    }
}

impl Default for BlockOptions {
    /// 256 x 256 texels, blocks of 32 with the customary overlap, tolerance 0.1, cuts, open edges.
    fn default() -> Self {
        Self {
            size: Size::new(256, 256),
            block: 32,
            overlap: Self::customary_overlap(32),
            tolerance: Tolerance::Relative(0.1),
            blend: Blend::Cut,
            feather: 0,
            boundary: Boundary::Open,
            guidance: None,
            seed: 0,
            search: SearchOptions::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meaningless_options_are_refused() {
        let good = BlockOptions::default();
        assert!(good.validate().is_ok());
        let torus = |side| BlockOptions {
            size: Size::new(side, 64),
            boundary: Boundary::Torus,
            ..BlockOptions::default()
        };
        assert!(torus(32).validate().is_ok());
        assert!(BlockOptions { overlap: 5, feather: 5, ..good.clone() }.validate().is_ok());
        let bad = [
            BlockOptions { block: 1, overlap: 1, ..good.clone() },
            BlockOptions { overlap: 0, ..good.clone() },
            BlockOptions { overlap: 17, ..good.clone() },
            BlockOptions { size: Size::new(0, 5), ..good.clone() },
            BlockOptions { tolerance: Tolerance::Relative(f64::NAN), ..good.clone() },
            BlockOptions { tolerance: Tolerance::Absolute(-1.0), ..good.clone() },
            BlockOptions { overlap: 5, feather: 6, ..good.clone() },
            BlockOptions { blend: Blend::Alpha, feather: 1, ..good.clone() },
            torus(31),
        ];
        for options in bad {
            assert!(options.validate().is_err(), "{options:?}");
        }
    }
}
