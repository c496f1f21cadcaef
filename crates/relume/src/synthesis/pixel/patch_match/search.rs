//! Matching each patch of the output to one of the exemplars' patches.
//!
//! Propagation: the matches of the four neighbours, moved by as much as those are away, are tried.
//! Random search: patches around the best one so far are tried, within half the distance each time.
//! (Barnes et al. 2009.) Different from the paper, which goes through the patches in order, those of
//! either colour of a chessboard are improved side by side, from the matches before: the result does
//! not depend on the number of threads. The full search is the slow truth.
//!
//! Alone, this ends in repetitions of whatever part of the exemplar matches itself best. As in Kaspar,
//! Neubert, Lischinski, Pauly, Kopf, "Self Tuning Texture Optimization", Computer Graphics Forum 2015,
//! matches therefore cost more where the exemplar is used more than evenly: the mean distance times
//! the uniformity asked for, for each time the even share of a block of 4 x 4 texels.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::super::lattice::Lattice;
use super::super::pyramid::Level;
use super::super::vectors::{Vectors, padded, squared_distance};
use super::super::wei_levoy::full::Full;
use super::SPACING;
use crate::error::Result;
use crate::limits::Limits;
use crate::numeric::random::Stream;
use crate::planes::Size;
use crate::synthesis::positions::Positions;
use crate::synthesis::source_map::Texel;

/// Side of the blocks over which the use of the exemplars is counted.
const BLOCK: u32 = 4;

/// How matches are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PatchSearch {
    /// By propagation and random search.
    Propagation,
    /// Among all patches, however often they are used.
    Full,
}

/// One round of [`Matching::improve`].
#[derive(Debug, Clone, Copy)]
pub struct Improvement {
    /// How matches are found.
    pub search: PatchSearch,
    /// How much more than evenly used parts of the exemplars are avoided.
    pub uniformity: f64,
    /// Seed of the random search.
    pub seed: u64,
}

/// The patches of the exemplars at one level.
#[derive(Debug)]
pub struct Patches {
    window: usize,
    positions: Positions,
    vectors: Vectors,
    /// Their middles.
    places: Vec<Texel>,
    /// The block of the exemplars in which each middle lies, numbered as blocks occur.
    blocks: Vec<u32>,
    block_count: usize,
    reach: usize,
}

impl Patches {
    /// All patches that lie inside the exemplars and hold nothing excluded.
    ///
    /// # Errors
    /// When there is none, or the limits are exceeded.
    pub fn new(level: &Level, window: usize, limits: &Limits) -> Result<Self> {
        let positions = level.positions(window)?;
        let planes = level.exemplars.planes();
        let length = window * window * planes;
        let bytes = positions.count() * (padded(length) * size_of::<i16>() + size_of::<Texel>());
        limits.check_bytes("the patches of the exemplars", bytes as u64)?;
        let mut vectors = Vectors::with_capacity(length, positions.count());
        let mut places = Vec::with_capacity(positions.count());
        let mut vector = Vec::with_capacity(length);
        for corner in positions.iter() {
            let texels = &level.exemplars.texels()[corner.exemplar as usize];
            vector.clear();
            for dy in 0..window {
                vector.extend_from_slice(texels.run(corner.x as usize, corner.y as usize + dy, window));
            }
            vectors.push(&vector);
            places.push(corner.offset(window / 2, window / 2));
        }
        let sides =
            level.exemplars.texels().iter().map(|texels| texels.size().width.max(texels.size().height));
        let reach = sides.max().expect("there is an exemplar");
        let (blocks, block_count) = blocks(&places);
        Ok(Self { window, positions, vectors, places, blocks, block_count, reach })
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.places.len()
    }

    /// The middle of a patch.
    pub fn place(&self, number: u32) -> Texel {
        self.places[number as usize]
    }

    /// The number of the patch around a texel.
    pub fn number(&self, middle: Texel) -> Option<usize> {
        let radius = (self.window / 2).cast_signed();
        self.positions.number(middle.moved(-radius, -radius)?)
    }

    /// Texels from the middle to an edge.
    pub fn radius(&self) -> isize {
        (self.window / 2).cast_signed()
    }

    fn distance(&self, number: usize, patch: &[i16]) -> u64 {
        squared_distance(self.vectors.row(number), patch)
    }

    /// The patch of the output around a place.
    fn of_output(&self, lattice: &Lattice, place: (usize, usize)) -> Vec<i16> {
        let mut patch = Vec::with_capacity(self.vectors.length());
        let radius = self.radius();
        (-radius..=radius).for_each(|dy| lattice.append_row(place, (-radius, dy), self.window, &mut patch));
        patch.resize(self.vectors.length(), 0);
        patch
    }
}

/// The number of the block in which each place lies, and how many blocks there are.
fn blocks(places: &[Texel]) -> (Vec<u32>, usize) {
    let mut known = BTreeMap::new();
    let block = |place: &Texel| {
        let next = known.len() as u32;
        *known.entry((place.exemplar, place.y / BLOCK, place.x / BLOCK)).or_insert(next)
    };
    let numbers = places.iter().map(block).collect();
    (numbers, known.len())
}

/// For each patch of the output, whose middles lie `SPACING` texels apart, the number of its match.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matching {
    cells: Size,
    numbers: Vec<u32>,
    distances: Vec<u64>,
}

impl Matching {
    /// Matches whose distances are not known.
    pub fn new(size: Size, numbers: Vec<u32>) -> Self {
        let cells = Self::cells(size);
        assert_eq!(numbers.len(), cells.texels(), "one match for each patch");
        Self { cells, distances: vec![u64::MAX; numbers.len()], numbers }
    }

    /// Columns and rows of patches of an output.
    pub fn cells(size: Size) -> Size {
        Size::new(size.width.div_ceil(SPACING), size.height.div_ceil(SPACING))
    }

    /// The middles of an output's patches in order.
    pub fn middles(size: Size) -> impl Iterator<Item = (usize, usize)> {
        let rows = (0..size.height).step_by(SPACING);
        rows.flat_map(move |y| (0..size.width).step_by(SPACING).map(move |x| (x, y)))
    }

    /// How many patches there are.
    pub fn count(&self) -> usize {
        self.numbers.len()
    }

    /// The match of the patch around a middle.
    pub fn at(&self, (x, y): (usize, usize)) -> u32 {
        self.numbers[self.cells.index(x / SPACING, y / SPACING)]
    }

    /// The squared distances of the matches, as they were when these were last improved.
    pub fn distances(&self) -> impl Iterator<Item = u64> {
        self.distances.iter().copied()
    }

    /// Improves all matches for the texels of a lattice.
    pub fn improve(&mut self, lattice: &Lattice, patches: &Patches, how: Improvement) {
        let measure = |cell: usize| {
            let patch = patches.of_output(lattice, self.middle(cell));
            patches.distance(self.numbers[cell] as usize, &patch)
        };
        self.distances = (0..self.count()).into_par_iter().with_min_len(64).map(measure).collect();
        let costs = self.costs(patches, how.uniformity);
        for color in 0..2 {
            let cells: Vec<usize> = (0..self.count()).filter(|&cell| self.color(cell) == color).collect();
            let better = |&cell: &usize| self.better(cell, lattice, patches, &costs, how);
            let found: Vec<(usize, u64)> = cells.par_iter().with_min_len(64).map(better).collect();
            for (cell, (number, distance)) in cells.into_iter().zip(found) {
                self.numbers[cell] = number as u32;
                self.distances[cell] = distance;
            }
        }
    }

    /// What a match in each block of the exemplars costs besides its distance.
    fn costs(&self, patches: &Patches, uniformity: f64) -> Vec<u64> {
        let mut used = vec![0u64; patches.block_count];
        self.numbers.iter().for_each(|&number| used[patches.blocks[number as usize] as usize] += 1);
        let even = self.count() as f64 / patches.block_count as f64;
        let mean = self.distances().map(|distance| distance as f64).sum::<f64>() / self.count() as f64;
        used.into_iter().map(|used| (uniformity * mean * (used as f64 / even)) as u64).collect()
    }

    fn color(&self, cell: usize) -> usize {
        (cell % self.cells.width + cell / self.cells.width) % 2
    }

    fn middle(&self, cell: usize) -> (usize, usize) {
        (cell % self.cells.width * SPACING, cell / self.cells.width * SPACING)
    }

    /// The match of least cost that is found for one patch, at most that of the present one, and its
    /// distance.
    fn better(
        &self,
        cell: usize,
        lattice: &Lattice,
        patches: &Patches,
        costs: &[u64],
        how: Improvement,
    ) -> (usize, u64) {
        let middle = self.middle(cell);
        let patch = patches.of_output(lattice, middle);
        if how.search == PatchSearch::Full {
            return Full { vectors: &patches.vectors }.nearest(&patch);
        }
        let cost_of = |number: usize| costs[patches.blocks[number] as usize];
        let present = self.numbers[cell] as usize;
        let mut best = (present, self.distances[cell], self.distances[cell] + cost_of(present));
        let mut attempt = |number: usize| {
            let distance = patches.distance(number, &patch);
            let cost = distance + cost_of(number);
            if cost < best.2 {
                best = (number, distance, cost);
            }
            best.0
        };
        let mut middle_of_best = present;
        for number in self.of_neighbours(middle, lattice.size(), patches) {
            middle_of_best = attempt(number);
        }
        let mut stream = Stream::new(how.seed, cell as u64);
        let mut reach = patches.reach.cast_signed();
        while reach > 0 {
            let mut step = || stream.below((2 * reach + 1).cast_unsigned()).cast_signed() - reach;
            let place = patches.places[middle_of_best].moved(step(), step());
            if let Some(number) = place.and_then(|place| patches.number(place)) {
                middle_of_best = attempt(number);
            }
            reach /= 2;
        }
        (best.0, best.1)
    }

    /// The matches that continue those of the four neighbours.
    fn of_neighbours(&self, (x, y): (usize, usize), size: Size, patches: &Patches) -> Vec<usize> {
        let away = |at: usize, length: usize, back: bool| match back {
            true if at >= SPACING => (at - SPACING, SPACING.cast_signed()),
            true => (
                (length - 1) / SPACING * SPACING,
                (at + length - (length - 1) / SPACING * SPACING).cast_signed(),
            ),
            false if at + SPACING < length => (at + SPACING, -SPACING.cast_signed()),
            false => (0, at.cast_signed() - length.cast_signed()),
        };
        let moved = |back, along_x: bool| {
            let (middle, dx, dy) = if along_x {
                let (there, dx) = away(x, size.width, back);
                ((there, y), dx, 0)
            } else {
                let (there, dy) = away(y, size.height, back);
                ((x, there), 0, dy)
            };
            patches.place(self.at(middle)).moved(dx, dy).and_then(|place| patches.number(place))
        };
        [(true, true), (false, true), (true, false), (false, false)]
            .into_iter()
            .filter_map(|(back, along_x)| moved(back, along_x))
            .collect()
    }
}
