//! Joining a block to the existing texels along a seam where they differ least.
//!
//! - [`inside_cuts`]: minimum error boundary cuts, by [`path`], the path of least error through one
//!   strip;
//! - [`graph`]: the seam of least energy through all strips at once, by [`max_flow`];
//! - [`feather()`]: a ramp of weights across either.
//!
//! In the first, each filled margin has its own cut across the whole side of the block, and a texel is taken
//! from the new block if it lies on the inner side of all of them. If two cuts cross more than once in a
//! corner, only the part connected to the middle of the block counts. The new region is therefore connected
//! and bounded inside every margin, and on the torus, with margins on all four sides, its boundary is one
//! closed curve. The texels of a path itself belong to the new block.

mod feather;
pub mod graph;
pub mod max_flow;
pub mod path;

pub use feather::feather;

use super::neighbourhood::{Margins, Neighbourhood};
use crate::size::Size;
use path::least_path;

/// Whether each texel of a block is taken from the new block. `error(x, y)` is the squared distance between
/// the existing texel and the new block; it is called for filled texels only.
pub fn inside_cuts(shape: &Neighbourhood, error: impl Fn(usize, usize) -> u64) -> Vec<bool> {
    let Size { width, height } = shape.extent;
    let Margins { left, top, right, bottom } = shape.margins;
    let left_cut = cut(height, left, |y, depth| error(depth, y));
    let right_cut = cut(height, right, |y, depth| error(width - 1 - depth, y));
    let top_cut = cut(width, top, &error);
    let bottom_cut = cut(width, bottom, |x, depth| error(x, height - 1 - depth));
    let inside = |x: usize, y: usize| {
        x >= left_cut[y]
            && width - 1 - x >= right_cut[y]
            && y >= top_cut[x]
            && height - 1 - y >= bottom_cut[x]
    };
    connected(shape.extent, middle(shape), inside)
}

/// The first texel that is not filled, or the middle if all are.
fn middle(shape: &Neighbourhood) -> (usize, usize) {
    let Neighbourhood { extent, margins } = shape;
    (margins.left.min(extent.width - 1 - margins.right), margins.top.min(extent.height - 1 - margins.bottom))
}

/// The steps from texel (x, y) out of the block across each filled side.
fn depths(shape: &Neighbourhood, x: usize, y: usize) -> impl Iterator<Item = usize> {
    let Neighbourhood { extent, margins } = shape;
    let sides = [
        (margins.left, x + 1),
        (margins.top, y + 1),
        (margins.right, extent.width - x),
        (margins.bottom, extent.height - y),
    ];
    sides.into_iter().filter(|(margin, _)| *margin > 0).map(|(_, depth)| depth)
}

/// The texels connected to `seed` through texels that are `inside`.
fn connected(size: Size, seed: (usize, usize), inside: impl Fn(usize, usize) -> bool) -> Vec<bool> {
    let mut reached = vec![false; size.texels()];
    let mut waiting = vec![seed];
    while let Some((x, y)) = waiting.pop() {
        if x >= size.width || y >= size.height || reached[size.index(x, y)] || !inside(x, y) {
            continue;
        }
        reached[size.index(x, y)] = true;
        waiting.extend([(x + 1, y), (x, y + 1)]);
        waiting.extend(x.checked_sub(1).map(|x| (x, y)));
        waiting.extend(y.checked_sub(1).map(|y| (x, y)));
    }
    reached
}

/// The depth of a cut below its edge at each position along it: 0 without a margin.
fn cut(length: usize, margin: usize, error: impl Fn(usize, usize) -> u64) -> Vec<usize> {
    if margin == 0 { vec![0; length] } else { least_path(length, margin, error) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPE: Neighbourhood =
        Neighbourhood { extent: Size::new(9, 8), margins: Margins { left: 3, top: 2, right: 2, bottom: 3 } };

    #[test]
    fn cuts_on_four_sides_close_where_the_error_is_nothing() {
        // A ring of zero error one texel inside the edge of the block.
        let on_ring = |x: usize, y: usize| {
            ((x == 1 || x == 7) && (1..=6).contains(&y)) || ((y == 1 || y == 6) && (1..=7).contains(&x))
        };
        let mask = inside_cuts(&SHAPE, |x, y| if on_ring(x, y) { 0 } else { 1000 });
        for (texel, inside) in mask.into_iter().enumerate() {
            let (x, y) = (texel % 9, texel / 9);
            assert_eq!(inside, (1..=7).contains(&x) && (1..=6).contains(&y), "({x}, {y})");
        }
    }

    #[test]
    fn what_is_not_filled_is_always_taken_from_the_new_block() {
        let mask = inside_cuts(&SHAPE, |x, y| ((x * 7 + y * 13) % 5) as u64);
        let unfilled = (0..72).filter(|t| !SHAPE.contains(t % 9, t / 9));
        assert!(unfilled.into_iter().all(|t| mask[t]));
        let first = Neighbourhood { margins: Margins::default(), ..SHAPE };
        assert!(
            inside_cuts(&first, |_, _| unreachable!("nothing is filled")).into_iter().all(|inside| inside)
        );
    }
}
