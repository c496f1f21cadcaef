//! Guides of blocks: the whole block is compared with the output's guide, not only what overlaps, after
//! Efros, Freeman 2001 (texture transfer).
//!
//! A guide is compared by its means over square cells of [`CELL`] texels, each counting as many texels
//! as it holds: guides say what belongs where, not how texels follow each other. The last cell of a row
//! or column ends with the block and may overlap the one before. All positions are looked at; the sum of
//! both distances decides, and the distance of the overlap is that of the other searches.

use rayon::prelude::*;

use super::layout::Block;
use super::positions::{Positions, Run};
use super::quantise::{IndexTexels, Quantised};
use super::search::distance::Target;
use super::search::{Candidates, Effort, Found, Query};
use super::source_map::Texel;
use crate::planes::Size;

/// Texels along a side of a cell, at most a block.
pub const CELL: usize = 4;

/// The guides of all exemplars and of the output, as means over cells.
#[derive(Debug)]
pub struct BlockGuide {
    /// Texels along a side of a cell.
    side: usize,
    /// For each exemplar the mean over the cell that begins at each texel, plane after plane.
    sources: Vec<Means>,
    target: Means,
    /// Whether the output goes on at the opposite edge.
    wraps: bool,
    /// Where the cells of a block begin along either axis.
    starts: Vec<usize>,
}

/// Means over the cells that begin at each texel.
#[derive(Debug)]
struct Means {
    size: Size,
    planes: Vec<Vec<i32>>,
}

impl Means {
    /// Rounded means of the last `guides` planes; beyond the right and lower edges texels go on as the
    /// last ones, or from the opposite edge.
    fn new(texels: &IndexTexels, planes: std::ops::Range<usize>, side: usize, wraps: bool) -> Self {
        let size = texels.size();
        let at = |i: usize, length: usize| if wraps { i % length } else { i.min(length - 1) };
        let mean = |k: usize, x: usize, y: usize| {
            let places = (y..y + side).flat_map(|y| (x..x + side).map(move |x| (x, y)));
            let codes = places.map(|(x, y)| texels.run(at(x, size.width), at(y, size.height), 1)[k]);
            let sum: i32 = codes.map(i32::from).sum();
            let count = (side * side) as i32;
            (2 * sum + count) / (2 * count)
        };
        let plane = |k: usize| -> Vec<i32> {
            (0..size.height)
                .flat_map(|y| (0..size.width).map(move |x| (x, y)))
                .map(|(x, y)| mean(k, x, y))
                .collect()
        };
        Self { size, planes: planes.into_par_iter().map(plane).collect() }
    }
}

impl BlockGuide {
    /// Prepares the last `guides` planes of exemplars and of the output for blocks of a side.
    pub fn new(
        exemplars: &Quantised,
        target: &IndexTexels,
        guides: usize,
        block: usize,
        wraps: bool,
    ) -> Self {
        let side = CELL.min(block);
        let planes = exemplars.planes() - guides..exemplars.planes();
        let sources = exemplars.texels().iter().map(|texels| Means::new(texels, planes.clone(), side, false));
        let mut starts: Vec<usize> = (0..=block - side).step_by(side).collect();
        if !block.is_multiple_of(side) {
            starts.push(block - side);
        }
        Self {
            side,
            sources: sources.collect(),
            target: Means::new(target, planes, side, wraps),
            wraps,
            starts,
        }
    }

    /// All positions whose blocks fit what is filled and the guide well enough.
    pub fn candidates(
        &self,
        query: &Query,
        block: &Block,
        exemplars: &Quantised,
        positions: &Positions,
    ) -> Found {
        let acceptance = query.acceptance;
        let targets = Target::all(query, exemplars);
        let near = |run: &Run| -> Vec<(Texel, u64)> {
            let Texel { exemplar, y, x } = run.first;
            let mut distances = targets[exemplar as usize].distances(x as usize, y as usize, run.length);
            self.add(block, run, &mut distances);
            let limit = acceptance.limit(distances.iter().copied().min().unwrap_or(u64::MAX));
            let accepted = distances.into_iter().enumerate().filter(|(_, distance)| *distance <= limit);
            accepted.map(|(i, distance)| (run.first.offset(i, 0), distance)).collect()
        };
        let near = positions.runs().par_iter().flat_map_iter(near).collect();
        let count = positions.count() as u64;
        Found {
            candidates: Candidates::within(near, acceptance),
            effort: Effort { examined: count, verified: count },
        }
    }

    /// The texel of the output's guide `dx` and `dy` into a block; beyond an open edge the last one.
    fn in_target(&self, block: &Block, dx: usize, dy: usize) -> usize {
        let size = self.target.size;
        let at = |i: usize, length: usize| if self.wraps { i % length } else { i.min(length - 1) };
        size.index(at(block.x + dx, size.width), at(block.y + dy, size.height))
    }

    /// Adds the guides' distances of a run of positions.
    fn add(&self, block: &Block, run: &Run, distances: &mut [u64]) {
        let source = &self.sources[run.first.exemplar as usize];
        let count = (self.side * self.side) as u64;
        for (dx, dy) in self.starts.iter().flat_map(|&dy| self.starts.iter().map(move |&dx| (dx, dy))) {
            let wanted = self.in_target(block, dx, dy);
            let first = source.size.index(run.first.x as usize + dx, run.first.y as usize + dy);
            for (plane, target) in source.planes.iter().zip(&self.target.planes) {
                let wanted = target[wanted];
                for (distance, &mean) in distances.iter_mut().zip(&plane[first..][..run.length]) {
                    *distance += count * u64::from((mean - wanted).unsigned_abs().pow(2));
                }
            }
        }
    }

    /// The distance of one block from the guide, cell by cell: the slow truth.
    pub fn plain_distance(&self, block: &Block, position: Texel) -> u64 {
        let source = &self.sources[position.exemplar as usize];
        let mut sum = 0;
        for (k, plane) in source.planes.iter().enumerate() {
            for (dx, dy) in self.starts.iter().flat_map(|&dy| self.starts.iter().map(move |&dx| (dx, dy))) {
                let theirs = plane[(position.y as usize + dy) * source.size.width + position.x as usize + dx];
                let ours = self.target.planes[k][self.in_target(block, dx, dy)];
                sum += (self.side * self.side) as u64 * u64::from(theirs.abs_diff(ours)).pow(2);
            }
        }
        sum
    }
}
