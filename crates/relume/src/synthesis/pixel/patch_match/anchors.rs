//! Texels of the output that stay as they are, at every level: what surrounds a hole that is completed.

use super::super::pyramid::halved_size;
use crate::size::Size;
use crate::synthesis::source_map::Texel;

/// The source of each texel that stays, at one level.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Anchors {
    size: Size,
    sources: Vec<Option<Texel>>,
}

impl Anchors {
    /// One source for each texel of an output; `None` where it is to be found.
    ///
    /// # Panics
    /// When there is not one entry for each texel.
    pub fn new(size: Size, sources: Vec<Option<Texel>>) -> Self {
        assert_eq!(sources.len(), size.texels(), "one entry for each texel");
        Self { size, sources }
    }

    /// The source of a texel that stays.
    pub fn source(&self, texel: usize) -> Option<Texel> {
        self.sources[texel]
    }

    /// The texels to be found.
    pub fn free(&self) -> impl Iterator<Item = usize> {
        (0..self.sources.len()).filter(|&texel| self.sources[texel].is_none())
    }

    /// The column after the last one with an anchor, and the row after the last such row.
    pub fn end(&self) -> (usize, usize) {
        let anchored = (0..self.sources.len()).filter(|&texel| self.sources[texel].is_some());
        let after = |(x, y): (usize, usize), texel: usize| {
            (x.max(texel % self.size.width + 1), y.max(texel / self.size.width + 1))
        };
        anchored.fold((0, 0), after)
    }

    /// The same at half the resolution: a texel stays if all that it covers do, and has the source of the
    /// first of them.
    pub fn halved(&self) -> Self {
        let size = halved_size(self.size);
        let stays = |(x, y): (usize, usize)| {
            let columns = 2 * x..(2 * x + 2).min(self.size.width);
            let mut rows = 2 * y..(2 * y + 2).min(self.size.height);
            let stay = rows.all(|y| columns.clone().all(|x| self.sources[self.size.index(x, y)].is_some()));
            let source = self.sources[self.size.index(2 * x, 2 * y)].filter(|_| stay)?;
            Some(Texel { x: source.x / 2, y: source.y / 2, ..source })
        };
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        Self { size, sources: places.map(stays).collect() }
    }
}
