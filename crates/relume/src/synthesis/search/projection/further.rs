//! The second look at a position: the squared distance of the coordinates that the first left out.

use super::table::{Further, Grid};
use crate::numeric::pairs::{FACTORS, Pairs, SUMS, Work, dispatch};

/// A distance to be computed.
pub struct FurtherDistance<'a> {
    /// The exemplar's coordinates.
    pub grid: &'a Grid,
    /// Where the cells lie in the block.
    pub cells: &'a [(usize, usize)],
    /// The query's further coordinates, cell after cell.
    pub wanted: &'a [Further],
    /// The position.
    pub x: usize,
    /// Its row.
    pub y: usize,
}

impl FurtherDistance<'_> {
    /// Computes it.
    #[inline]
    pub fn compute(self) -> i32 {
        dispatch(self)
    }
}

impl Work for FurtherDistance<'_> {
    type Output = i32;

    #[inline(always)]
    fn with<P: Pairs>(self, pairs: P) -> i32 {
        let mut sums = [0; SUMS];
        for (&(dx, dy), wanted) in self.cells.iter().zip(self.wanted) {
            let there = self.grid.further(self.x + dx, self.y + dy);
            sums = pairs.add_squares(sums, &there.0, &wanted.0, &[-1; FACTORS]);
        }
        sums.iter().sum()
    }
}
