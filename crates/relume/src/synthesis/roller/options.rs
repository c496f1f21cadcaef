//! Options of the Roller.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::numeric::periods::Pattern;
use crate::size::Size;

/// Options of [`super::roll`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RollerOptions {
    /// The number of tiles k; each takes about a k-th of the texels of the exemplar.
    pub tiles: usize,
    /// Texels by which a tile overlaps its continuation, and the width of the common border; `None` for
    /// [`RollerOptions::customary_overlap`].
    pub overlap: Option<usize>,
    /// The periods of the texture, if known: sides of tiles are whole numbers of them, to the rounding to texels,
    /// or there is an error. Otherwise they are measured, and sides are whole periods where there are any.
    pub pattern: Option<Pattern>,
    /// The least side of a tile as a fraction of the longest possible one.
    pub least_side: f64,
    /// The largest tile is taken whose overlaps differ by at most (1 + this) times the least: squared errors
    /// up to this fraction above the least squared error.
    pub slack: f64,
    /// The least distance between the parts of the exemplar for two tiles, as a fraction of the side of the
    /// tile along x or y.
    pub least_offset: f64,
    /// Whether tiles may be oblique, if that follows oblique periods better than rectangles do.
    pub oblique: bool,
    /// Whether 16 tiles or more of a texture that does not repeat have borders that vary: those that meet at
    /// corners of one colour fit together, instead of all.
    pub vary: bool,
}

impl RollerOptions {
    /// A sixteenth of the smaller side of the exemplar, at least 2 texels: for 256 texels, 16, the customary
    /// overlap of image quilting (a sixth of a block of about 96).
    pub fn customary_overlap(exemplar: Size) -> usize {
        (exemplar.width.min(exemplar.height) / 16).max(2)
    }

    /// Checks the options in isolation; they are checked against the exemplar later.
    pub fn validate(&self) -> Result<()> {
        let share = |v: f64| v.is_finite() && (0.0..=1.0).contains(&v);
        if !(1..=Self::MOST_TILES).contains(&self.tiles) {
            return Err(Error::usage(format!(
                "{} tiles cannot be made: choose 1 to {}",
                self.tiles,
                Self::MOST_TILES
            )));
        }
        let periods = match self.pattern {
            None | Some(Pattern::None) => Vec::new(),
            Some(Pattern::Stripes(period)) => vec![period],
            Some(Pattern::Lattice(lattice)) => lattice.basis().to_vec(),
        };
        if let Some([x, y]) = periods.into_iter().find(|p| !p.iter().all(|c| c.abs() <= Self::LONGEST_PERIOD))
        {
            return Err(Error::usage(format!(
                "a period of ({x}, {y}) texels: expected numbers from -{most} to {most}",
                most = Self::LONGEST_PERIOD
            )));
        }
        if let Some(overlap) = self.overlap.filter(|overlap| *overlap > Self::MOST_OVERLAP) {
            return Err(Error::usage(format!(
                "an overlap of {overlap} texels: choose 1 to {}",
                Self::MOST_OVERLAP
            )));
        }
        if self.overlap == Some(0) {
            return Err(Error::usage("an overlap of 0 texels leaves no room for a cut: choose at least 1"));
        }
        if !share(self.least_side) || !share(self.slack) || !share(self.least_offset) {
            return Err(Error::usage("least side, slack and least offset must be numbers from 0 to 1"));
        }
        Ok(())
    }

    /// The largest overlap: half the longest side of a texture.
    pub const MOST_OVERLAP: usize = 1 << 16;

    /// The longest period along x or y: the longest side of a texture.
    pub const LONGEST_PERIOD: f64 = 131_072.0;

    /// The most tiles of a set: 16 bits of a hash choose among them evenly to one in 256.
    pub const MOST_TILES: usize = 256;
}

impl Default for RollerOptions {
    /// One tile, the customary overlap, periods as measured, sides of at least 0.6 of the longest,
    /// a slack of 0.1 (the tolerance of image quilting), parts a quarter of a tile apart, rectangles
    /// with one border.
    fn default() -> Self {
        Self {
            tiles: 1,
            overlap: None,
            pattern: None,
            least_side: 0.6,
            slack: 0.1,
            least_offset: 0.25,
            oblique: false,
            vary: false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::lattice::Lattice;

    #[test]
    fn meaningless_options_are_refused() {
        let good = RollerOptions::default();
        assert!(good.validate().is_ok());
        let bad = [
            RollerOptions { tiles: 0, ..good.clone() },
            RollerOptions { tiles: 257, ..good.clone() },
            RollerOptions { overlap: Some(0), ..good.clone() },
            RollerOptions { overlap: Some(usize::MAX), ..good.clone() },
            RollerOptions { pattern: Some(Pattern::Stripes([0.0, f64::NAN])), ..good.clone() },
            RollerOptions {
                pattern: Lattice::new([2f64.powi(64), 0.0], [0.0, 4.0]).map(Pattern::Lattice),
                ..good.clone()
            },
            RollerOptions { least_side: f64::NAN, ..good.clone() },
            RollerOptions { slack: -0.1, ..good.clone() },
            RollerOptions { least_offset: 1.5, ..good },
        ];
        for options in bad {
            assert!(options.validate().is_err(), "{options:?}");
        }
    }
}
