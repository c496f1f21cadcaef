//! The second look: the coordinates that the first left out, and what they leave of its survivors.

use super::query::Prepared;
use super::table::Grid;
use crate::numeric::pairs::{FACTORS, Pairs, SUMS, Work, dispatch};
use crate::synthesis::source_map::Texel;

/// Survivors of the first look to be looked at again.
pub struct SecondLook<'a> {
    /// The exemplars' coordinates.
    pub grids: &'a [Grid],
    /// What they are compared with.
    pub query: &'a Prepared<'a>,
    /// The survivors with their nearness.
    pub survivors: &'a [(Texel, i32)],
    /// The smallest distance so far.
    pub best: u64,
}

impl SecondLook<'_> {
    /// The positions that may still be accepted.
    pub fn remaining(self) -> Vec<Texel> {
        dispatch(self)
    }

    /// The squared distance of a position's further coordinates to the query's.
    #[inline(always)]
    fn distance<P: Pairs>(&self, pairs: P, position: Texel) -> i32 {
        let grid = &self.grids[position.exemplar as usize];
        let (x, y) = (position.x as usize, position.y as usize);
        let mut sums = [0; SUMS];
        for (&(dx, dy), wanted) in self.query.cells.iter().zip(&self.query.further) {
            let there = grid.further(x + dx, y + dy);
            sums = pairs.add_squares(sums, &there.0, &wanted.0, &[-1; FACTORS]);
        }
        sums.iter().sum()
    }
}

impl Work for SecondLook<'_> {
    type Output = Vec<Texel>;

    #[inline(always)]
    fn with<P: Pairs>(self, pairs: P) -> Vec<Texel> {
        let least = self.query.keeps(self.best);
        let longest = self.query.longest(self.query.query.acceptance.limit(self.best));
        let mut remaining = Vec::new();
        for &(position, nearness) in self.survivors.iter().filter(|(_, nearness)| *nearness >= least) {
            if self.query.square - nearness + self.distance(pairs, position) <= longest {
                remaining.push(position);
            }
        }
        remaining
    }
}
