//! The slow truth of every search: texel by texel, plane by plane, in 64 bits.

use super::{BlockQuery, Candidates, Effort, Found, Search};
use crate::synthesis::neighbourhood::Neighbourhood;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::Quantised;
use crate::synthesis::source_map::Texel;

/// Examines every position in turn.
#[derive(Debug, Clone, Copy)]
pub struct Plain<'a> {
    /// The exemplars.
    pub exemplars: &'a Quantised,
    /// The possible positions of blocks.
    pub positions: &'a Positions,
}

impl Search for Plain<'_> {
    fn candidates(&self, queries: &[BlockQuery]) -> Vec<Found> {
        queries.iter().map(|query| self.look(query)).collect()
    }
}

impl Plain<'_> {
    fn look(&self, query: &BlockQuery) -> Found {
        let all: Vec<(Texel, u64)> = (0..self.positions.count())
            .map(|number| self.positions.nth(number))
            .filter(|position| !query.avoided.contains(*position))
            .map(|position| {
                (position, squared_distance(self.exemplars, &query.neighbourhood, &query.codes, position))
            })
            .collect();
        let effort = Effort { examined: all.len() as u64, verified: all.len() as u64 };
        Found { candidates: Candidates::within(all, query.acceptance), effort }
    }
}

/// The squared distance, in codes, between the filled texels of a block and the block at a position.
pub fn squared_distance(exemplars: &Quantised, shape: &Neighbourhood, codes: &[i16], position: Texel) -> u64 {
    let planes = exemplars.planes();
    let exemplar = &exemplars.texels()[position.exemplar as usize];
    let mut sum = 0i64;
    for y in 0..shape.extent.height {
        for x in (0..shape.extent.width).filter(|&x| shape.contains(x, y)) {
            let there = exemplar.run(position.x as usize + x, position.y as usize + y, 1);
            for (k, &code) in there.iter().enumerate() {
                let wanted = codes[shape.extent.index(x, y) * planes + k];
                sum += (i64::from(code) - i64::from(wanted)).pow(2);
            }
        }
    }
    sum.unsigned_abs()
}
