//! A set of tiles as data: where each texel of each comes from.

use crate::numeric::cells::Cells;
use crate::planes::Size;
use crate::synthesis::source_map::{SourceMap, Texel};

/// Tiles of one shape with one border, so that any may lie beside any, each as the sources of its
/// texels in the exemplar. [`crate::synthesis::gather`] applies [`TileSet::map`] to anything
/// registered with it.
#[derive(Debug, Clone, PartialEq)]
pub struct TileSet {
    cells: Cells,
    map: SourceMap,
}

impl TileSet {
    /// Tiles that fill cells, from a map in which the rectangles that hold them lie one below the
    /// other.
    ///
    /// # Panics
    /// When the map is not a whole number of tiles high.
    pub(super) fn new(cells: Cells, map: SourceMap) -> Self {
        let tile = cells.bounds();
        assert!(
            map.size().width == tile.width && map.size().height.is_multiple_of(tile.height),
            "whole tiles"
        );
        Self { cells, map }
    }

    /// The size of a tile, or of the rectangle that holds it where it is oblique. What lies beside the
    /// tile there is the first one's continuation.
    pub fn tile(&self) -> Size {
        self.cells.bounds()
    }

    /// The cells that tiles fill.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }

    /// How many tiles there are.
    pub fn count(&self) -> usize {
        self.map.size().height / self.tile().height
    }

    /// All tiles one below the other, the first on top.
    pub fn map(&self) -> &SourceMap {
        &self.map
    }

    /// The sources of the texels of one tile's rectangle, row after row.
    ///
    /// # Panics
    /// When there is no such tile.
    pub fn sources(&self, number: usize) -> &[Texel] {
        let texels = self.tile().texels();
        &self.map.copies()[number * texels..][..texels]
    }
}
