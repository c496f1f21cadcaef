//! Every position in full, with the vector instructions of the processor and all threads.

use super::distance::BlockTarget;
use super::{BlockQuery, Candidates, Effort, Found, Search};
use crate::parallel;
use crate::synthesis::positions::{PositionRun, Positions};
use crate::synthesis::quantise::Quantised;
use crate::synthesis::source_map::Texel;

/// Examines every position.
#[derive(Debug, Clone, Copy)]
pub struct Brute<'a> {
    /// The exemplars.
    pub exemplars: &'a Quantised,
    /// The possible positions of blocks.
    pub positions: &'a Positions,
}

impl Search for Brute<'_> {
    fn candidates(&self, queries: &[BlockQuery]) -> Vec<Found> {
        parallel::map(queries.iter(), |query| self.look(query))
    }
}

impl Brute<'_> {
    fn look(&self, query: &BlockQuery) -> Found {
        let acceptance = query.acceptance;
        let targets = BlockTarget::all(query, self.exemplars);
        let near = |run: &PositionRun| -> Vec<(Texel, u64)> {
            let Texel { exemplar, y, x } = run.first;
            let mut distances = targets[exemplar as usize].distances(x as usize, y as usize, run.length);
            query.avoided.strike(run.first, &mut distances, u64::MAX);
            let near = acceptance.near(distances);
            near.map(|(i, distance)| (run.first.offset(i, 0), distance)).collect()
        };
        let near = parallel::map(self.positions.runs().iter(), near).concat();
        let count = self.positions.count() as u64;
        let effort = Effort { examined: count, verified: count };
        Found { candidates: Candidates::within(near, acceptance), effort }
    }
}
