//! The positions of a tile left by both looks.

use super::product::STRETCH;
use super::query::PreparedQuery;
use super::second_look::{BoundedPosition, SecondLook};
use super::table::CoordinateGrid;
use crate::numeric::pairs::{Pairs, PairsWork, SUMS, Sums, dispatch};
use crate::synthesis::positions::PositionRun;

/// The positions of a tile that may be accepted for a query.
pub struct Survivors {
    /// The smallest distance so far.
    pub best: u64,
    /// The positions.
    pub positions: Vec<BoundedPosition>,
    /// The number of positions measured on the way.
    pub verified: u64,
    /// The least nearness of positions that may be accepted.
    least: i32,
    /// Their longest difference.
    longest: f64,
}

impl Survivors {
    /// No survivors yet, with `best` as the smallest distance.
    pub fn new(query: &PreparedQuery<'_>, best: u64) -> Self {
        let mut empty = Self { best: 0, positions: Vec::new(), verified: 0, least: 0, longest: 0.0 };
        empty.set_best(query, best);
        empty
    }

    fn set_best(&mut self, query: &PreparedQuery<'_>, best: u64) {
        let limit = query.limit(best);
        self.best = best;
        self.least = query.least_nearness(limit);
        self.longest = query.longest(limit);
    }

    /// Adds the positions of a stretch that may be accepted, and measures the most promising one.
    pub fn take(
        &mut self,
        query: &PreparedQuery<'_>,
        grid: &CoordinateGrid,
        run: &PositionRun,
        nearness: &[Sums; STRETCH / SUMS],
    ) {
        let near = dispatch(NearStretch { nearness, length: run.length, least: self.least });
        if near == 0 {
            return;
        }
        let values = nearness.as_flattened();
        let survivors = ones(near).map(|i| (run.first.offset(i, 0), values[i]));
        let before = self.positions.len();
        SecondLook { grid, query, survivors, longest: self.longest, kept: &mut self.positions }.keep();
        let nearest = self.positions[before..].iter().min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(&(position, length)) = nearest
            && length <= query.longest(self.best)
        {
            self.verified += 1;
            let best = query.nearer(position, self.best);
            if best < self.best {
                self.set_best(query, best);
            }
        }
    }
}

/// The positions of the ones in a number.
fn ones(mut bits: u128) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = bits.trailing_zeros();
        (i < u128::BITS).then(|| {
            bits &= bits - 1;
            i as usize
        })
    })
}

const _: () = assert!(STRETCH == u128::BITS as usize);

/// Which positions of a stretch are near enough, a bit for each.
struct NearStretch<'a> {
    nearness: &'a [Sums; STRETCH / SUMS],
    length: usize,
    least: i32,
}

impl PairsWork for NearStretch<'_> {
    type Output = u128;

    #[inline(always)]
    fn with<P: Pairs>(self, pairs: P) -> u128 {
        let mut bits = 0;
        for (group, sums) in self.nearness.iter().enumerate() {
            bits |= u128::from(pairs.at_least(sums, self.least)) << (group * SUMS);
        }
        // Bits past the last position have no meaning.
        bits & (u128::MAX >> (STRETCH - self.length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ones_are_where_the_positions_are_near() {
        let nearness: [Sums; STRETCH / SUMS] =
            std::array::from_fn(|g| std::array::from_fn(|i| ((g * SUMS + i) * 37 % 101) as i32 - 50));
        for (length, least) in [(1, -50), (17, 0), (128, 10), (128, 51), (100, i32::MIN)] {
            let found: Vec<usize> =
                ones(dispatch(NearStretch { nearness: &nearness, length, least })).collect();
            let truth = (0..length).filter(|&i| nearness.as_flattened()[i] >= least);
            assert_eq!(found, truth.collect::<Vec<_>>());
        }
    }
}
