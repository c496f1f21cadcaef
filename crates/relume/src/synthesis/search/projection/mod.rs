//! Exact search with projection kernels and rejection.
//!
//! Hel-Or, Malzbender, Gelb, "Synthesis of Reflectance Function Textures from Examples", HPL-2003-16, section
//! 6: a lower bound on the distance from a few projections rejects most positions; only survivors get the
//! full distance. Where we differ:
//!
//! - **Cells instead of shapes.** Every neighbourhood is a union of strips along the sides of a block, and
//!   all strips are covered with square [`mod@cells`], so one [`table`] of cells serves every shape, on the
//!   torus too. The bounds of disjoint cells add up.
//! - **The residual counts.** The part of a cell not captured by the kernels tightens the bound ([`table`]).
//! - **All projections at once, for many blocks at once.** Processors multiply faster than they branch, and
//!   loaded coordinates serve all blocks of a wave (`product`).
//! - **Nothing is lost to rounding.** Coordinates are small integers ([`coordinates`]) with a measured error,
//!   by which the threshold is widened. Survivors are decided by the exact integer distance.
//! - **The threshold tightens during the search**: first come positions expected to be near, then the most
//!   promising one of each stretch of positions is measured in full immediately.

pub mod cells;
pub mod coordinates;
pub mod kernels;
mod product;
mod query;
mod second_look;
mod survivors;
pub mod table;

use std::collections::BTreeMap;

use super::{BlockQuery, Candidates, Effort, Found, KernelBasis, Search};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::pairs::SUMS;
use crate::parallel;
use crate::synthesis::neighbourhood::Neighbourhood;
use crate::synthesis::positions::{PositionRun, Positions};
use crate::synthesis::quantise::Quantised;
use crate::synthesis::source_map::Texel;
use cells::cells;
use kernels::Kernels;
use product::{MOST, Product, STRETCH, Stretch};
use query::PreparedQuery;
use survivors::Survivors;
use table::Table;

/// The most rows of positions in one parallel task.
const TILE_HEIGHT: usize = 64;

/// Positions are examined in rounds: each takes the rows whose numbers are multiples of its step and not in
/// an earlier round. The first rounds are small, and find distances so small that the later ones reject most
/// of their positions.
const ROUNDS: [usize; 3] = [64, 8, 1];

/// Rejects by projections, then compares in full.
#[derive(Debug)]
pub struct Projection<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    table: Table,
    /// The tiles of each round.
    rounds: Vec<Vec<Vec<PositionRun>>>,
}

impl<'a> Projection<'a> {
    /// Projects all cells of the exemplars on at most `most` kernels of a basis, for neighbourhoods of blocks
    /// of `block` texels divided into cells of `side`.
    ///
    /// # Errors
    /// When the job is cancelled.
    pub fn new(
        exemplars: &'a Quantised,
        positions: &'a Positions,
        (block, side): (usize, usize),
        basis: KernelBasis,
        most: usize,
        job: &Job,
    ) -> Result<Self> {
        let kernels = Kernels::new(basis, most, exemplars, side, job)?;
        let table = Table::new(kernels, exemplars, (block / side).pow(2), job)?;
        Ok(Self { exemplars, positions, table, rounds: rounds(positions) })
    }

    /// The bytes of the preparation.
    pub fn bytes(exemplars: &Quantised, most: usize) -> u64 {
        exemplars.texels().iter().map(|texels| Table::bytes(texels.size(), exemplars.planes(), most)).sum()
    }

    fn prepare<'q>(&'q self, query: &'q BlockQuery) -> PreparedQuery<'q> {
        let cells = cells(&query.neighbourhood, self.table.side());
        let mut prepared = PreparedQuery::new(query, cells, &self.table, self.exemplars);
        for &position in query.likely.iter().filter(|position| self.positions.contains(**position)) {
            prepared.near = prepared.nearer(position, prepared.near);
        }
        prepared
    }

    /// The survivors of a tile for each query, all of one shape and at most [`MOST`]; `best` are the smallest
    /// distances so far.
    fn look(&self, tile: &[PositionRun], queries: &[&PreparedQuery<'_>], best: &[u64]) -> Vec<Survivors> {
        let mut found: Vec<Survivors> =
            queries.iter().zip(best).map(|(query, &best)| Survivors::new(query, best)).collect();
        let factors = side_by_side(queries);
        let mut nearness: Box<Stretch> = Box::new([[[0; SUMS]; STRETCH / SUMS]; MOST]);
        for run in tile {
            self.nearness(run, queries, &factors, &mut nearness);
            let grid = &self.table.grids()[run.first.exemplar as usize];
            for ((query, found), nearness) in queries.iter().zip(&mut found).zip(&*nearness) {
                found.take(query, grid, run, nearness);
            }
        }
        found
    }

    /// The first look at a run of at most [`STRETCH`] positions.
    fn nearness(
        &self,
        run: &PositionRun,
        queries: &[&PreparedQuery<'_>],
        factors: &[[i32; MOST]],
        nearness: &mut Stretch,
    ) {
        let product = Product {
            planes: self.table.grids()[run.first.exemplar as usize].first(),
            offsets: &queries[0].cells,
            factors,
            sets: queries.len(),
            x: run.first.x as usize,
            y: run.first.y as usize,
            length: run.length,
            sums: nearness,
        };
        product.compute();
    }

    /// The survivors of a tile that may be accepted, with their exact distances; `best` is the smallest
    /// distance in any tile so far.
    fn settle(&self, query: &PreparedQuery<'_>, survivors: &Survivors, mut best: u64) -> Settled {
        let mut settled = Settled { near: Vec::new(), verified: 0 };
        let longest = query.longest(query.limit(best));
        for &(position, _) in survivors.positions.iter().filter(|(_, length)| *length <= longest) {
            settled.verified += 1;
            if let Some(exact) = query.distance(position, query.limit(best)) {
                best = best.min(exact);
                settled.near.push((position, exact));
            }
        }
        settled
    }

    /// The number of positions that each further kernel of every cell leaves for a query whose nearest
    /// position is at the squared distance `best`, without the residual: the rejection curve.
    fn remaining(&self, query: &BlockQuery, best: u64) -> Vec<u64> {
        let query = self.prepare(query);
        let longest = query.longest(query.limit(best));
        let kernels = self.table.kernels();
        let left = |run: &PositionRun| -> Vec<u64> {
            let mut left = vec![0; kernels];
            for position in (0..run.length).map(|i| run.first.offset(i, 0)) {
                let mut length = 0.0;
                for (kernel, left) in left.iter_mut().enumerate() {
                    length +=
                        self.table.squared_difference(kernel, &query.cells, &query.coordinates, position);
                    *left += u64::from(length <= longest);
                }
            }
            left
        };
        let mut sums = vec![0; kernels];
        for left in parallel::map(self.positions.runs().iter(), left) {
            sums.iter_mut().zip(left).for_each(|(sum, more)| *sum += more);
        }
        sums
    }

    /// The candidates of queries in groups of one shape. All groups process a tile in turn, while it is in
    /// the caches of the processor.
    fn search(&self, groups: &[Vec<&PreparedQuery<'_>>]) -> Vec<Found> {
        let queries = groups.concat();
        let mut best: Vec<u64> = queries.iter().map(|query| query.near).collect();
        let mut survivors: Vec<Vec<Survivors>> = Vec::new();
        for tiles in &self.rounds {
            let look = |tile: &Vec<PositionRun>| -> Vec<Survivors> {
                let mut begun = best.as_slice();
                let each = groups.iter().flat_map(|group| {
                    let own = begun.split_off(..group.len()).expect("one for each query");
                    self.look(tile, group, own)
                });
                each.collect()
            };
            let round: Vec<Vec<Survivors>> = parallel::map(tiles.iter(), look);
            for tile in &round {
                best.iter_mut().zip(tile).for_each(|(best, own)| *best = own.best.min(*best));
            }
            survivors.extend(round);
        }
        let settle = |tile: &Vec<Survivors>| -> Vec<Settled> {
            (0..queries.len()).map(|q| self.settle(queries[q], &tile[q], best[q])).collect()
        };
        let mut settled: Vec<Vec<Settled>> = parallel::map(survivors.iter(), settle);
        let found = |q: usize| {
            let measured: u64 = survivors.iter().map(|tile| tile[q].verified).sum();
            let verified = measured + settled.iter().map(|tile| tile[q].verified).sum::<u64>();
            let mut near: Vec<(Texel, u64)> =
                settled.iter_mut().flat_map(|tile| std::mem::take(&mut tile[q].near)).collect();
            near.sort_unstable();
            let effort = Effort { examined: self.positions.count() as u64, verified };
            Found { candidates: Candidates::within(near, queries[q].query.acceptance), effort }
        };
        (0..queries.len()).map(found).collect()
    }
}

/// The final result for the positions of a tile.
struct Settled {
    /// Those that may be accepted, with their distances.
    near: Vec<(Texel, u64)>,
    verified: u64,
}

impl Search for Projection<'_> {
    fn candidates(&self, queries: &[BlockQuery]) -> Vec<Found> {
        let prepared: Vec<PreparedQuery<'_>> = parallel::map(queries.iter(), |query| self.prepare(query));
        let groups = by_shape(queries);
        let members = |group: &Vec<usize>| group.iter().map(|&i| &prepared[i]).collect();
        let found = self.search(&groups.iter().map(members).collect::<Vec<_>>());
        let mut numbered: Vec<(usize, Found)> = groups.concat().into_iter().zip(found).collect();
        numbered.sort_unstable_by_key(|(number, _)| *number);
        numbered.into_iter().map(|(_, found)| found).collect()
    }

    fn rejection_curve(&self, query: &BlockQuery, best: u64) -> Option<Vec<u64>> {
        Some(self.remaining(query, best))
    }
}

/// The factors of queries of one shape, those of each word adjacent.
fn side_by_side(queries: &[&PreparedQuery<'_>]) -> Vec<[i32; MOST]> {
    let mut factors = vec![[0; MOST]; queries[0].factors.len()];
    for (q, query) in queries.iter().enumerate() {
        factors.iter_mut().zip(&query.factors).for_each(|(all, own)| all[q] = *own);
    }
    factors
}

/// Numbers of the queries in groups of one shape, each of at most [`MOST`].
fn by_shape(queries: &[BlockQuery]) -> Vec<Vec<usize>> {
    let mut shapes: Vec<(Neighbourhood, Vec<usize>)> = Vec::new();
    for (number, query) in queries.iter().enumerate() {
        let shape = query.neighbourhood;
        let open = shapes.iter_mut().find(|(other, members)| *other == shape && members.len() < MOST);
        match open {
            Some((_, members)) => members.push(number),
            None => shapes.push((shape, vec![number])),
        }
    }
    shapes.into_iter().map(|(_, members)| members).collect()
}

/// The runs of all positions in rounds, divided into tiles of [`STRETCH`] columns and [`TILE_HEIGHT`] rows,
/// whose coordinates stay in the second-level cache.
fn rounds(positions: &Positions) -> Vec<Vec<Vec<PositionRun>>> {
    let mut rounds: [BTreeMap<(u32, usize, usize), Vec<PositionRun>>; ROUNDS.len()] = Default::default();
    for &PositionRun { first: Texel { exemplar, y, x }, length } in positions.runs() {
        let round = ROUNDS.iter().position(|&step| (y as usize).is_multiple_of(step));
        let tiles = &mut rounds[round.expect("one divides all numbers")];
        let (mut start, end) = (x as usize, x as usize + length);
        while start < end {
            let column = start / STRETCH;
            let next = end.min((column + 1) * STRETCH);
            let first = Texel { exemplar, y, x: start as u32 };
            let tile = tiles.entry((exemplar, y as usize / TILE_HEIGHT, column)).or_default();
            tile.push(PositionRun { first, length: next - start });
            start = next;
        }
    }
    rounds.into_iter().map(|tiles| tiles.into_values().collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::second_look::SecondLook;
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::synthesis::neighbourhood::Margins;
    use crate::synthesis::options::Tolerance;
    use crate::synthesis::quantise::{Exemplar, MAX_CODE};
    use crate::synthesis::search::Acceptance;

    /// A field whose texels resemble their left neighbours.
    fn streaked(size: Size, planes: usize, stream: &mut Stream) -> Planes {
        let mut value = 0.0;
        let mut next = |_| {
            value = 0.7 * value + stream.unit() as f32;
            value
        };
        Planes::from_vec(size, planes, (0..size.texels() * planes).map(&mut next).collect()).unwrap()
    }

    #[test]
    fn no_bound_is_larger_than_the_distance() {
        for (planes, block, side) in [(1, 9, 4), (3, 16, 8), (18, 10, 5)] {
            let mut stream = Stream::new(planes as u64, Purpose::Sample, [0]);
            let field = streaked(Size::new(150, 21), planes, &mut stream);
            let exemplars = [Exemplar { index: &field, excluded: None }];
            let quantised = Quantised::new(&exemplars, &Job::default()).unwrap();
            let positions = Positions::new(&exemplars, block).unwrap();
            let margins = Margins { left: side, top: side, ..Margins::default() };
            let neighbourhood = Neighbourhood { extent: Size::new(block, block), margins };
            let acceptance = Acceptance::new(Tolerance::Relative(0.1), 1, 1.0);
            let search =
                Projection::new(&quantised, &positions, (block, side), KernelBasis::Svd, 12, &Job::default())
                    .unwrap();
            for spread in [1, 40, 4096] {
                // A block of the exemplar with little noise, with some, or only noise.
                let rows = (3..3 + block).flat_map(|y| quantised.texels()[0].run(90, y, block));
                let noisy = |code: &i16| {
                    (if spread < 4096 { *code } else { 0 } + stream.below(spread) as i16).min(MAX_CODE)
                };
                let codes = rows.map(noisy).collect();
                let query = BlockQuery::alone(neighbourhood, codes, acceptance);
                let query = search.prepare(&query);
                let mut nearness: Box<Stretch> = Box::new([[[0; SUMS]; STRETCH / SUMS]; MOST]);
                for run in search.rounds.iter().flatten().flatten() {
                    search.nearness(run, &[&query], &side_by_side(&[&query]), &mut nearness);
                    let grid = &search.table.grids()[0];
                    for (i, &nearness) in nearness[0].as_flattened()[..run.length].iter().enumerate() {
                        let (position, mut kept) = (run.first.offset(i, 0), Vec::new());
                        let survivors = std::iter::once((position, nearness));
                        let longest = f64::INFINITY;
                        SecondLook { grid, query: &query, survivors, longest, kept: &mut kept }.keep();
                        let exact = query.distance(position, u64::MAX).unwrap();
                        assert!(nearness >= query.least_nearness(exact), "{position:?} of {planes} planes");
                        assert!(kept[0].1 <= query.longest(exact), "{position:?} of {planes} planes");
                    }
                }
            }
        }
    }

    #[test]
    fn the_rejection_curve_falls_to_no_less_than_the_candidates() {
        let (block, planes) = (8, 3);
        let mut stream = Stream::new(3, Purpose::Sample, [0]);
        let size = Size::new(150, 40);
        let field = streaked(size, planes, &mut stream);
        let exemplars = [Exemplar { index: &field, excluded: None }];
        let quantised = Quantised::new(&exemplars, &Job::default()).unwrap();
        let positions = Positions::new(&exemplars, block).unwrap();
        for basis in [KernelBasis::Svd, KernelBasis::Dct, KernelBasis::WalshHadamard] {
            let search =
                Projection::new(&quantised, &positions, (block, 4), basis, 6, &Job::default()).unwrap();
            let neighbourhood = Neighbourhood {
                extent: Size::new(block, block),
                margins: Margins { left: 4, top: 4, ..Margins::default() },
            };
            let acceptance =
                Acceptance::new(Tolerance::Relative(0.1), neighbourhood.texels(), quantised.step());
            // A block of the exemplar with some noise.
            let rows = (9..9 + block).flat_map(|y| quantised.texels()[0].run(17, y, block));
            let codes = rows.map(|code| code + stream.below(100) as i16).collect();
            let query = BlockQuery::alone(neighbourhood, codes, acceptance);
            let found = &search.candidates(std::slice::from_ref(&query))[0].candidates;
            let curve = search.remaining(&query, found.best);
            assert!(curve.len() > 6 && curve[0] <= positions.count() as u64);
            assert!(curve.windows(2).all(|pair| pair[1] <= pair[0]), "{curve:?}");
            assert!(*curve.last().unwrap() >= found.positions.len() as u64);
            assert!(curve[curve.len() - 1] < curve[0], "{basis:?} rejects nothing: {curve:?}");
        }
    }
}
