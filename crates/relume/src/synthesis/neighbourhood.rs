//! The filled part of a block, as data that any search can sum over.

use crate::rect::Rect;
use crate::size::Size;

/// Widths of the strips along the four sides of a block that earlier blocks have filled; 0 for none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Margins {
    /// Texels from the left edge.
    pub left: usize,
    /// Texels from the top edge.
    pub top: usize,
    /// Texels from the right edge.
    pub right: usize,
    /// Texels from the bottom edge.
    pub bottom: usize,
}

/// The extent of a block (clipped by the edges of the output) and its filled margins. Opposite margins never
/// overlap. Blocks of one shape can share the preparation of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Neighbourhood {
    /// The texels of the block that lie in the output.
    pub extent: Size,
    /// The filled strips.
    pub margins: Margins,
}

impl Neighbourhood {
    /// Whether nothing is filled: the first block.
    pub fn is_empty(&self) -> bool {
        self.margins == Margins::default()
    }

    /// Whether texel (x, y) of the block is filled.
    pub fn contains(&self, x: usize, y: usize) -> bool {
        let Self { extent, margins } = self;
        x < margins.left
            || y < margins.top
            || x >= extent.width - margins.right
            || y >= extent.height - margins.bottom
    }

    /// The number of filled texels.
    pub fn texels(&self) -> usize {
        self.rects().map(|rect| rect.size.texels()).sum()
    }

    /// The filled texels as disjoint rectangles from top to bottom: the whole top strip, left and right
    /// strips between the others, the whole bottom strip. Empty ones are omitted.
    pub fn rects(&self) -> impl Iterator<Item = Rect<usize>> {
        let Size { width, height } = self.extent;
        let Margins { left, top, right, bottom } = self.margins;
        let between = height - top - bottom;
        let rects = [
            Rect::new(0, 0, Size::new(width, top)),
            Rect::new(0, top, Size::new(left, between)),
            Rect::new(width - right, top, Size::new(right, between)),
            Rect::new(0, height - bottom, Size::new(width, bottom)),
        ];
        rects.into_iter().filter(|rect| rect.size.texels() > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_are_disjoint_and_cover_exactly_the_filled_texels() {
        for code in 0..81 {
            let digit = |place: usize| [0, 2, 3][code / 3usize.pow(place as u32) % 3];
            let margins = Margins { left: digit(0), top: digit(1), right: digit(2), bottom: digit(3) };
            let shape = Neighbourhood { extent: Size::new(7, 6), margins };
            let mut covered = [0; 42];
            for r in shape.rects() {
                for (y, x) in
                    (r.y..r.y + r.size.height).flat_map(|y| (r.x..r.x + r.size.width).map(move |x| (y, x)))
                {
                    covered[shape.extent.index(x, y)] += 1;
                }
            }
            for (texel, count) in covered.into_iter().enumerate() {
                assert_eq!(count, i32::from(shape.contains(texel % 7, texel / 7)), "{shape:?}");
            }
            assert_eq!(shape.texels(), covered.iter().sum::<i32>() as usize);
            assert_eq!(shape.is_empty(), shape.texels() == 0);
        }
    }
}
