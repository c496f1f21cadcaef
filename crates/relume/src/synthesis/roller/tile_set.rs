//! A tile set as data: the source of each texel of each tile.

use crate::numeric::cells::Cells;
use crate::numeric::corner_colors::CornerColors;
use crate::size::Size;
use crate::synthesis::source_map::{SourceMap, Texel};

/// Tiles of one shape that may be neighbours where the colours of their corners agree, each given by the
/// sources of its texels in the exemplar. [`crate::synthesis::gather`] applies [`TileSet::map`] to anything registered with
/// it.
#[derive(Debug, Clone, PartialEq)]
pub struct TileSet {
    cells: Cells,
    corners: CornerColors,
    map: SourceMap,
}

impl TileSet {
    /// Tiles that fill cells, from a map with their bounding rectangles stacked one below the other.
    ///
    /// # Panics
    /// When the map is not a whole number of tiles high.
    pub(super) fn new(cells: Cells, corners: CornerColors, map: SourceMap) -> Self {
        let tile = cells.bounds();
        assert!(
            map.size().width == tile.width && map.size().height.is_multiple_of(tile.height),
            "whole tiles"
        );
        Self { cells, corners, map }
    }

    /// The size of a tile, or of its bounding rectangle if it is oblique. The texels beside the tile there
    /// continue the first one.
    pub fn tile(&self) -> Size {
        self.cells.bounds()
    }

    /// The cells that tiles fill.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// The colours of their corners.
    pub fn corners(&self) -> CornerColors {
        self.corners
    }

    /// The number of tiles.
    pub fn count(&self) -> usize {
        self.map.size().height / self.tile().height
    }

    /// The share of texels that have the same source in all tiles.
    pub fn common(&self) -> f64 {
        let texels = self.tile().texels();
        let same = |&t: &usize| (1..self.count()).all(|number| self.sources(number)[t] == self.sources(0)[t]);
        (0..texels).filter(same).count() as f64 / texels as f64
    }

    /// All tiles one below the other, the first on top.
    pub fn map(&self) -> &SourceMap {
        &self.map
    }

    /// The sources of the texels of the rectangle of one tile, row by row.
    ///
    /// # Panics
    /// When there is no such tile.
    pub fn sources(&self, number: usize) -> &[Texel] {
        let texels = self.tile().texels();
        &self.map.copies()[number * texels..][..texels]
    }
}
