//! The square cells into which neighbourhoods are divided.
//!
//! A strip along the side of a block is covered with squares, so one table of coordinates of squares serves
//! all strips of all neighbourhoods, whichever sides are filled. Distances of disjoint cells add up; texels
//! not covered by whole cells do not contribute to a bound.

use crate::rect::Rect;
use crate::synthesis::neighbourhood::Neighbourhood;

/// The longest side of a cell. Longer cells hold more than a few kernels can represent; on the stones and
/// fabrics of the benchmarks sides of 6 to 8 texels reject most.
const LONGEST_SIDE: usize = 8;

/// The side of the cells for strips that are `narrowest` texels wide or more: the longest that divides the
/// width of the strip.
pub fn side(narrowest: usize) -> usize {
    narrowest / narrowest.div_ceil(LONGEST_SIDE).max(1)
}

/// The positions of the cells of a neighbourhood in its block: upper left texels, strip after strip.
pub fn cells(shape: &Neighbourhood, side: usize) -> Vec<(usize, usize)> {
    shape.rects().flat_map(|strip| paved(strip, side)).collect()
}

/// Squares from the upper left corner on.
fn paved(strip: Rect<usize>, side: usize) -> impl Iterator<Item = (usize, usize)> {
    let (across, down) = (strip.size.width / side, strip.size.height / side);
    (0..across * down).map(move |i| (strip.x + i % across * side, strip.y + i / across * side))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;
    use crate::synthesis::neighbourhood::Margins;

    #[test]
    fn sides_pave_the_strip() {
        let sides: Vec<usize> = [1, 2, 5, 8, 9, 12, 16, 17, 25].into_iter().map(side).collect();
        assert_eq!(sides, [1, 2, 5, 8, 4, 6, 8, 5, 6]);
    }

    #[test]
    fn cells_are_disjoint_and_inside() {
        let margins = Margins { left: 5, top: 6, right: 0, bottom: 5 };
        let shape = Neighbourhood { extent: Size::new(23, 21), margins };
        let mut seen = vec![false; shape.extent.texels()];
        let cells = cells(&shape, 5);
        assert_eq!(cells.len(), 4 + 2 + 4);
        for (x, y) in cells {
            for (x, y) in (y..y + 5).flat_map(|y| (x..x + 5).map(move |x| (x, y))) {
                let texel = shape.extent.index(x, y);
                assert!(shape.contains(x, y) && !seen[texel]);
                seen[texel] = true;
            }
        }
    }
}
