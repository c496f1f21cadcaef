//! A set of tiles as data: where each texel of each comes from.

use crate::planes::Size;
use crate::synthesis::source_map::{SourceMap, Texel};

/// Tiles of one size with one border, so that any may lie beside any, each as the sources of its
/// texels in the exemplar. [`crate::synthesis::gather`] applies [`TileSet::map`] to anything
/// registered with it.
#[derive(Debug, Clone, PartialEq)]
pub struct TileSet {
    tile: Size,
    map: SourceMap,
}

impl TileSet {
    /// Tiles from a map in which they lie one below the other.
    ///
    /// # Panics
    /// When the map is not a whole number of tiles high.
    pub(super) fn new(tile: Size, map: SourceMap) -> Self {
        assert!(
            map.size().width == tile.width && map.size().height.is_multiple_of(tile.height),
            "whole tiles"
        );
        Self { tile, map }
    }

    /// The size of a tile.
    pub fn tile(&self) -> Size {
        self.tile
    }

    /// How many tiles there are.
    pub fn count(&self) -> usize {
        self.map.size().height / self.tile.height
    }

    /// All tiles one below the other, the first on top.
    pub fn map(&self) -> &SourceMap {
        &self.map
    }

    /// The sources of one tile's texels, row after row.
    ///
    /// # Panics
    /// When there is no such tile.
    pub fn sources(&self, number: usize) -> &[Texel] {
        let texels = self.tile.texels();
        &self.map.copies()[number * texels..][..texels]
    }
}
