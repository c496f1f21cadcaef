//! The second look: the coordinates omitted by the first, and the survivors they leave.

use super::query::PreparedQuery;
use super::table::CoordinateGrid;
use crate::numeric::pairs::{Pairs, PairsWork, SUMS, dispatch};
use crate::synthesis::source_map::Texel;

/// A position with the squared length, in codes, of the difference of its rounded coordinates.
pub type BoundedPosition = (Texel, f64);

/// Survivors of the first look to be examined again.
pub struct SecondLook<'a, I> {
    /// The coordinates of the exemplar.
    pub grid: &'a CoordinateGrid,
    /// The query they are compared with.
    pub query: &'a PreparedQuery<'a>,
    /// The survivors with their nearness.
    pub survivors: I,
    /// The longest difference of those that may still be accepted.
    pub longest: f64,
    /// The output.
    pub kept: &'a mut Vec<BoundedPosition>,
}

impl<I: Iterator<Item = (Texel, i32)>> SecondLook<'_, I> {
    /// Keeps the positions that may still be accepted.
    pub fn keep(self) {
        dispatch(self);
    }
}

impl<I: Iterator<Item = (Texel, i32)>> PairsWork for SecondLook<'_, I> {
    type Output = ();

    #[inline(always)]
    fn with<P: Pairs>(self, pairs: P) {
        for (position, nearness) in self.survivors {
            let further = further_distance(pairs, self.grid, self.query, position);
            let length = self.query.length(nearness, further);
            if length <= self.longest {
                self.kept.push((position, length));
            }
        }
    }
}

/// The squared distance of the further coordinates of a position from those of the query.
#[inline(always)]
fn further_distance<P: Pairs>(
    pairs: P,
    grid: &CoordinateGrid,
    query: &PreparedQuery<'_>,
    position: Texel,
) -> i32 {
    let (x, y) = (position.x as usize, position.y as usize);
    let (mut sums, mut squares) = ([0; SUMS], query.further_square);
    for (&(dx, dy), wanted) in query.cells.iter().zip(&query.further) {
        let there = grid.further(x + dx, y + dy);
        sums = pairs.multiply_add_bytes(sums, &there.0, &wanted.0);
        squares += there.square();
    }
    squares - 2 * (sums.iter().sum::<i32>() - query.further_bias)
}
