//! Exact search with projection kernels and rejection.
//!
//! Hel-Or, Malzbender, Gelb, "Synthesis of Reflectance Function Textures from Examples",
//! HPL-2003-16, section 6: a lower bound on the distance from a few projections rejects most
//! positions; only survivors get the full distance. Differences from the document:
//!
//! - **Cells instead of shapes.** Every neighbourhood is a union of strips along a block's sides, and
//!   all strips are paved with square [`mod@cells`], so one [`table`] of cells serves every shape, on the
//!   torus too. The bounds of disjoint cells add up.
//! - **The rest counts.** What the kernels leave of a cell bounds the distance further ([`table`]).
//! - **All projections at once, for many blocks at once.** Processors multiply faster than they
//!   branch, and coordinates that are loaded serve all blocks of a wave (`product`).
//! - **Nothing is lost to rounding.** Coordinates are integers that are off by a stated error, by
//!   which the threshold is widened. Survivors are settled by the exact integer distance.
//! - **The threshold tightens during the search**: first come positions that are expected to be near,
//!   then the most promising one of each stretch of positions is measured in full at once.

pub mod cells;
pub mod kernels;
mod product;
mod query;
mod second_look;
mod survivors;
pub mod table;

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::distance::Target;
use super::{Candidates, Effort, Found, KernelBasis, Query, Search};
use crate::numeric::pairs::{FACTORS, SUMS};
use crate::synthesis::neighbourhood::Neighbourhood;
use crate::synthesis::positions::{Positions, Run};
use crate::synthesis::quantise::Quantised;
use crate::synthesis::source_map::Texel;
use cells::cells;
use kernels::Kernels;
use product::{MOST, Product, STRETCH, Stretch, pair};
use query::{Prepared, rounding_error};
use second_look::SecondLook;
use survivors::Survivors;
use table::{Coordinates, Further, MINUS_SQUARE, Table};

/// Rows of positions that are looked at in one parallel task.
const TILE_HEIGHT: usize = 64;

/// Rejects by projections, then compares in full.
#[derive(Debug)]
pub struct Projection<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    table: Table,
    tiles: Vec<Vec<Run>>,
}

impl<'a> Projection<'a> {
    /// Projects all cells of the exemplars on at most `most` kernels of a basis, for neighbourhoods
    /// of blocks of `block` texels cut into cells of `side`.
    pub fn new(
        exemplars: &'a Quantised,
        positions: &'a Positions,
        (block, side): (usize, usize),
        basis: KernelBasis,
        most: usize,
    ) -> Self {
        let kernels = Kernels::new(basis, most, exemplars, side);
        let table = Table::new(kernels, exemplars, (block / side).pow(2));
        Self { exemplars, positions, table, tiles: tiles(positions) }
    }

    /// Bytes that preparing takes: coordinates, and the codes in pairs and sums of squares while those
    /// are made; rows are padded.
    pub fn bytes(exemplars: &Quantised, most: usize) -> u64 {
        let each = 4 * (most / 2 + 2) + size_of::<Further>() + 4 * exemplars.planes() + 8;
        let padded =
            exemplars.texels().iter().map(|texels| (texels.size().width + STRETCH) * texels.size().height);
        (padded.sum::<usize>() * each) as u64
    }

    fn prepare<'q>(&'q self, query: &'q Query) -> Prepared<'q> {
        let shape = query.neighbourhood;
        let cells = cells(&shape, self.table.side());
        let stride = shape.extent.width * self.exemplars.planes();
        let start = |&(x, y): &(usize, usize)| y * stride + x * self.exemplars.planes();
        let project = |cell| self.table.project(&query.codes, start(cell), stride);
        let coordinates: Vec<Coordinates> = cells.iter().map(project).collect();
        let pairs = self.table.pairs();
        let factors = coordinates.iter().flat_map(|c| {
            let doubled = c.first.as_chunks::<2>().0[..pairs].iter().map(|own| own.map(|c| 2 * c));
            doubled.chain([MINUS_SQUARE]).map(pair)
        });
        let mut prepared = Prepared {
            query,
            factors: factors.collect(),
            further: coordinates.iter().map(|c| c.further).collect(),
            square: coordinates.iter().map(|c| c.square).sum(),
            first_error: rounding_error(2 * cells.len() * self.table.pairs()),
            error: rounding_error(cells.len() * (2 * self.table.pairs() + FACTORS)),
            cells,
            coordinates,
            scale: self.table.scale(),
            targets: Target::all(query, self.exemplars),
            near: u64::MAX,
        };
        for &position in query.likely.iter().filter(|position| self.positions.contains(**position)) {
            prepared.near = prepared.nearer(position, prepared.near);
        }
        prepared
    }

    /// What a tile leaves of each query, all of one shape and at most [`MOST`].
    fn look(&self, tile: &[Run], queries: &[&Prepared<'_>]) -> Vec<Survivors> {
        let mut found: Vec<Survivors> = queries.iter().map(|query| Survivors::new(query)).collect();
        let mut factors = vec![[0; MOST]; queries[0].factors.len()];
        for (q, query) in queries.iter().enumerate() {
            factors.iter_mut().zip(&query.factors).for_each(|(all, own)| all[q] = *own);
        }
        let mut nearness: Box<Stretch> = Box::new([[[0; SUMS]; STRETCH / SUMS]; MOST]);
        for run in tile {
            let grid = &self.table.grids()[run.first.exemplar as usize];
            let (x, y) = (run.first.x as usize, run.first.y as usize);
            let product = Product {
                planes: grid.first(),
                offsets: &queries[0].cells,
                factors: &factors,
                sets: queries.len(),
                x,
                y,
                length: run.length,
                sums: &mut nearness,
            };
            product.compute();
            for ((query, found), nearness) in queries.iter().zip(&mut found).zip(&*nearness) {
                found.take(query, run, nearness);
            }
        }
        found
    }

    /// Of the survivors of a tile those that may be accepted, with their exact distances; `best` is
    /// the smallest distance in any tile so far.
    fn settle(&self, query: &Prepared<'_>, survivors: &Survivors, mut best: u64) -> Settled {
        let grids = self.table.grids();
        let remaining = SecondLook { grids, query, survivors: &survivors.positions, best }.remaining();
        let mut settled = Settled { near: Vec::new(), verified: remaining.len() as u64 };
        for position in remaining {
            if let Some(exact) = query.distance(position, query.query.acceptance.limit(best)) {
                best = best.min(exact);
                settled.near.push((position, exact));
            }
        }
        settled
    }

    /// How many positions each further kernel of every cell leaves for a query whose nearest position
    /// is at the squared distance `best`, without the help of the rest: the rejection curve.
    fn remaining(&self, query: &Query, best: u64) -> Vec<u64> {
        let query = self.prepare(query);
        let longest = f64::from(query.longest(query.query.acceptance.limit(best)));
        let kernels = self.table.kernels();
        let left = |run: &Run| -> Vec<u64> {
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
        let add = |sums: Vec<u64>, more: Vec<u64>| sums.into_iter().zip(more).map(|(a, b)| a + b).collect();
        self.positions.runs().par_iter().map(left).reduce(|| vec![0; kernels], add)
    }

    /// The candidates of queries of one shape.
    fn search(&self, queries: &[&Prepared<'_>]) -> Vec<Found> {
        let survivors: Vec<Vec<Survivors>> =
            self.tiles.par_iter().map(|tile| self.look(tile, queries)).collect();
        let best = |q: usize| survivors.iter().map(|tile| tile[q].best).fold(queries[q].near, u64::min);
        let best: Vec<u64> = (0..queries.len()).map(best).collect();
        let settle = |tile: &Vec<Survivors>| -> Vec<Settled> {
            (0..queries.len()).map(|q| self.settle(queries[q], &tile[q], best[q])).collect()
        };
        let mut settled: Vec<Vec<Settled>> = survivors.par_iter().map(settle).collect();
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

/// What is known in the end of the positions of a tile.
struct Settled {
    /// Those that may be accepted, with their distances.
    near: Vec<(Texel, u64)>,
    verified: u64,
}

impl Search for Projection<'_> {
    fn candidates(&self, queries: &[Query]) -> Vec<Found> {
        let prepared: Vec<Prepared<'_>> = queries.par_iter().map(|query| self.prepare(query)).collect();
        let mut found: Vec<Option<Found>> = vec![None; queries.len()];
        for group in by_shape(queries) {
            let members: Vec<&Prepared<'_>> = group.iter().map(|&i| &prepared[i]).collect();
            let settled = self.search(&members);
            group.iter().zip(settled).for_each(|(&i, own)| found[i] = Some(own));
        }
        found.into_iter().flatten().collect()
    }

    fn rejection_curve(&self, query: &Query, best: u64) -> Option<Vec<u64>> {
        Some(self.remaining(query, best))
    }
}

/// Numbers of the queries in groups of one shape, each of at most [`MOST`].
fn by_shape(queries: &[Query]) -> Vec<Vec<usize>> {
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

/// The runs of all positions cut into tiles of [`STRETCH`] columns and [`TILE_HEIGHT`] rows, whose
/// coordinates stay in the processor's second cache.
fn tiles(positions: &Positions) -> Vec<Vec<Run>> {
    let mut tiles: BTreeMap<(u32, usize, usize), Vec<Run>> = BTreeMap::new();
    for &Run { first: Texel { exemplar, y, x }, length } in positions.runs() {
        let (mut start, end) = (x as usize, x as usize + length);
        while start < end {
            let column = start / STRETCH;
            let next = end.min((column + 1) * STRETCH);
            let first = Texel { exemplar, y, x: start as u32 };
            let tile = tiles.entry((exemplar, y as usize / TILE_HEIGHT, column)).or_default();
            tile.push(Run { first, length: next - start });
            start = next;
        }
    }
    tiles.into_values().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::Stream;
    use crate::planes::{Planes, Size};
    use crate::synthesis::neighbourhood::Margins;
    use crate::synthesis::options::Tolerance;
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::search::Acceptance;

    #[test]
    fn the_rejection_curve_falls_to_no_less_than_the_candidates() {
        let (block, planes) = (8, 3);
        let mut stream = Stream::new(3, 0);
        let size = Size::new(150, 40);
        let mut value = 0.0;
        let mut next = || {
            value = 0.7 * value + stream.unit() as f32;
            value
        };
        let field =
            Planes::from_vec(size, planes, (0..size.texels() * planes).map(|_| next()).collect()).unwrap();
        let exemplars = [Exemplar { index: &field, excluded: None }];
        let quantised = Quantised::new(&exemplars, &Limits::default()).unwrap();
        let positions = Positions::new(&exemplars, block).unwrap();
        for basis in [KernelBasis::Svd, KernelBasis::Dct, KernelBasis::WalshHadamard] {
            let search = Projection::new(&quantised, &positions, (block, 4), basis, 6);
            let neighbourhood = Neighbourhood {
                extent: Size::new(block, block),
                margins: Margins { left: 4, top: 4, ..Margins::default() },
            };
            let acceptance =
                Acceptance::new(Tolerance::Relative(0.1), neighbourhood.texels(), quantised.step());
            // A block of the exemplar with some noise.
            let rows = (9..9 + block).flat_map(|y| quantised.texels()[0].run(17, y, block));
            let codes = rows.map(|code| code + stream.below(100) as i16).collect();
            let query = Query { neighbourhood, codes, acceptance, likely: Vec::new() };
            let found = &search.candidates(std::slice::from_ref(&query))[0].candidates;
            let curve = search.remaining(&query, found.best);
            assert!(curve.len() > 6 && curve[0] <= positions.count() as u64);
            assert!(curve.windows(2).all(|pair| pair[1] <= pair[0]), "{curve:?}");
            assert!(*curve.last().unwrap() >= found.positions.len() as u64);
            assert!(curve[curve.len() - 1] < curve[0], "{basis:?} rejects nothing: {curve:?}");
        }
    }
}
