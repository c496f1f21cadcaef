//! From the texels of one level to the first texels of the next finer one, on the torus.
//!
//! Each coarser texel becomes 2 x 2. Where the finer side is odd, twice the coarser one is a texel too long:
//! dropping its last column would leave a jump at the border that every level repeats. Instead one texel of
//! each row is dropped along a closed seam of least error, and of each column likewise: Avidan, Shamir, "Seam
//! Carving for Content-Aware Image Resizing", SIGGRAPH 2007, with the step that the removal creates as the
//! error (Rubinstein, Shamir, Avidan, "Improved Seam Carving for Video Retargeting", SIGGRAPH 2008), and
//! closed on the torus ([`Strip`]).
//!
//! Seams lie within the last [`REACH`] columns and rows, and behind all anchors, which keep their places.

use std::ops::Range;

use super::super::canvas::PixelCanvas;
use super::super::pyramid::ExemplarLevel;
use super::anchors::Anchors;
use crate::size::Size;
use crate::synthesis::roller::profile::squared_distance;
use crate::synthesis::roller::toroidal::Strip;
use crate::synthesis::source_map::Texel;

/// Columns or rows among which a seam is sought.
const REACH: usize = 48;

/// The sources of the texels of a finer level of the given size.
pub fn finer(
    coarser: &PixelCanvas,
    level: &ExemplarLevel,
    size: Size,
    anchors: Option<&Anchors>,
) -> Vec<Texel> {
    let coarse = coarser.size();
    let doubled = Size::new(2 * coarse.width, 2 * coarse.height);
    let source = |(x, y): (usize, usize)| {
        let from = coarser.source(coarse.index(x / 2, y / 2));
        let limit = level.exemplars.texels()[from.exemplar as usize].size();
        let at = |coarse: u32, by: usize, side: usize| (2 * coarse + by as u32).min(side as u32 - 1);
        Texel { x: at(from.x, x % 2, limit.width), y: at(from.y, y % 2, limit.height), ..from }
    };
    let places = (0..doubled.height).flat_map(|y| (0..doubled.width).map(move |x| (x, y)));
    let (after_x, after_y) = anchors.map_or((0, 0), Anchors::end);
    let doubled = SourceGrid { size: doubled, sources: places.map(source).collect() };
    let narrow = if size.width < doubled.size.width { doubled.narrower(level, after_x) } else { doubled };
    if size.height == narrow.size.height {
        return narrow.sources;
    }
    narrow.transposed().narrower(level, after_y).transposed().sources
}

/// Sources of a torus.
struct SourceGrid {
    size: Size,
    sources: Vec<Texel>,
}

impl SourceGrid {
    fn transposed(&self) -> Self {
        let size = Size::new(self.size.height, self.size.width);
        let places = (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
        let sources = places.map(|(x, y)| self.sources[self.size.index(y, x)]).collect();
        Self { size, sources }
    }

    /// Without one texel of each row, at or behind column `from`.
    fn narrower(&self, level: &ExemplarLevel, from: usize) -> Self {
        let Size { width, height } = self.size;
        let dropped = self.seam(level, from.max(width.saturating_sub(REACH)).min(width - 1)..width);
        let row = |(row, dropped): (&[Texel], usize)| [&row[..dropped], &row[dropped + 1..]].concat();
        let rows = self.sources.chunks_exact(width).zip(dropped);
        Self { size: Size::new(width - 1, height), sources: rows.flat_map(row).collect() }
    }

    /// For each row a column in the range: the closed seam whose removal makes the least steps.
    fn seam(&self, level: &ExemplarLevel, columns: Range<usize>) -> Vec<usize> {
        let Size { width, height } = self.size;
        let codes = |x: usize, y: usize| {
            let from = self.sources[self.size.index(x % width, y)];
            level.exemplars.texels()[from.exemplar as usize].run(from.x as usize, from.y as usize, 1)
        };
        let strip = Strip::new(height, columns.len(), |along, across| {
            let (x, y) = (columns.start + across, along % height);
            squared_distance(codes(x + width - 1, y), codes(x + 1, y))
        });
        let start = (0..columns.len()).min_by_key(|&across| strip.least_sum(0, across));
        let path = strip.least_path(0, start.expect("the range is not empty"));
        path.into_iter().take(height).map(|across| columns.start + across).collect()
    }
}
