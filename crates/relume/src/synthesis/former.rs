//! What blocks copy that were placed before, and what the next one should not copy for it.
//!
//! - The block that continues its neighbour fits without any difference. So the best block always continues the first one
//!   up to the border of the exemplar, and the texture begins with a copy of much of it. Therefore a piece that has grown
//!   to a part of the exemplar is not continued.
//! - What fits once fits again: the same part of the exemplar recurs a block further, which shows. Therefore a block does
//!   not begin near where one in its surroundings begins in the exemplar.
//!
//! The next block is the best of the others. Where a pattern repeats a few times only, these may not fit at all: where a
//! block would fit much worse than usual, it may recur or continue after all, if it fits much better then.

use std::collections::BTreeMap;

use super::layout::{BlockLayout, PlacedBlock};
use super::options::{BlockOptions, Boundary};
use super::quantise::Quantised;
use super::search::Avoided;
use super::source_map::Texel;
use crate::size::Size;

/// The part of the smallest exemplar to which a piece may grow, as one over this number.
const PIECE: usize = 4;
/// The surroundings in which nothing should recur: this part of the shorter side of the smallest exemplar.
const REACH: usize = 5;
/// At most so many blocks along x and y, since small blocks have many around them.
const MOST_REACH: usize = 4;
/// At most one of so many positions is left out.
const LEFT_OUT: usize = 2;
/// From so many times the usual distance on, a block fits much worse.
const MUCH: f64 = 2.0;

/// An exemplar, and how far its texels are from those of the output along x and y, around a torus of its size.
type Shift = (u32, usize, usize);

/// The blocks placed so far.
#[derive(Debug)]
pub struct FormerBlocks {
    /// The position each was copied from, by its number.
    sources: Vec<Option<Texel>>,
    columns: usize,
    rows: usize,
    /// The number of blocks copied with each shift.
    pieces: BTreeMap<Shift, usize>,
    /// The number of them from which on a piece is not continued.
    largest: usize,
    /// The surroundings of a block: columns and rows from it, the nearest first.
    surroundings: Vec<[isize; 2]>,
    block: usize,
    overlap: usize,
    boundary: Boundary,
    /// The size of the output.
    size: Size,
    /// Whether the blocks follow a guide, which decides alone what recurs.
    guided: bool,
    /// The sum and the number of the distances of blocks that continue nothing.
    distances: (f64, usize),
}

impl FormerBlocks {
    /// Before any block.
    pub fn new(options: &BlockOptions, exemplars: &Quantised, layout: &BlockLayout) -> Self {
        let BlockOptions { block, overlap, boundary, .. } = *options;
        let sizes = || exemplars.texels().iter().map(|texels| texels.size());
        let texels = sizes().map(|size| size.texels()).min().unwrap_or(0);
        let side = sizes().map(|size| size.width.min(size.height)).min().unwrap_or(0);
        let step = block - overlap;
        Self {
            sources: vec![None; layout.sequence.len()],
            columns: layout.columns,
            rows: layout.rows,
            pieces: BTreeMap::new(),
            largest: (texels / PIECE / step.pow(2)).max(1),
            surroundings: surroundings(((side / REACH + step / 2) / step).min(MOST_REACH) as isize),
            block,
            overlap,
            boundary,
            size: layout.size,
            guided: options.guidance.is_some(),
            distances: (0.0, 0),
        }
    }

    /// Adds a block copied from a position, whose best candidate has a root mean square distance.
    pub fn add(&mut self, block: &PlacedBlock, from: Texel, best: f64) {
        if best > 0.0 {
            self.distances = (self.distances.0 + best, self.distances.1 + 1);
        }
        *self.pieces.entry(self.shift(block, from)).or_default() += 1;
        self.sources[block.number] = Some(from);
    }

    /// Whether a block with a best candidate of a root mean square distance fits much worse than usual.
    pub fn is_poor(&self, best: f64) -> bool {
        let (sum, count) = self.distances;
        best > 0.0 && (count == 0 || best * count as f64 > MUCH * sum)
    }

    /// Whether a root mean square distance is much smaller than another one.
    pub fn is_much_nearer(best: f64, other: f64) -> bool {
        MUCH * best < other
    }

    /// What should not be copied, given the continuations of what a block overlaps and the number of positions.
    pub fn avoided(&self, block: &PlacedBlock, continuations: &[Texel], positions: usize) -> Avoided {
        let mut avoided = Avoided::default();
        if self.guided {
            return avoided;
        }
        let most = positions / LEFT_OUT;
        let is_full =
            |from: &&Texel| self.pieces.get(&self.shift(block, **from)).is_some_and(|n| *n >= self.largest);
        for from in continuations.iter().filter(is_full) {
            avoided.add(*from, (self.overlap / 2) as u32, most);
        }
        for from in self.around(block) {
            avoided.add(from, (self.block / 2) as u32, most);
        }
        avoided
    }

    /// The positions of the blocks in the surroundings of one, the nearest first.
    fn around(&self, block: &PlacedBlock) -> Vec<Texel> {
        let (column, row) = ((block.number % self.columns) as isize, (block.number / self.columns) as isize);
        let source = |&[x, y]: &[isize; 2]| {
            let (x, y) = (self.along(column + x, self.columns)?, self.along(row + y, self.rows)?);
            self.sources[y * self.columns + x]
        };
        self.surroundings.iter().filter_map(source).collect()
    }

    /// The number of a column or row, if there is one.
    fn along(&self, at: isize, count: usize) -> Option<usize> {
        match self.boundary {
            Boundary::Torus => Some(at.rem_euclid(count as isize) as usize),
            Boundary::Open => usize::try_from(at).ok().filter(|at| *at < count),
        }
    }

    fn shift(&self, block: &PlacedBlock, from: Texel) -> Shift {
        let Size { width, height } = self.size;
        let along = |from: u32, at: usize, side: usize| (from as usize + side - at) % side;
        (from.exemplar, along(from.x, block.x, width), along(from.y, block.y, height))
    }
}

/// All places within `reach` along x and y, the nearest first.
fn surroundings(reach: isize) -> Vec<[isize; 2]> {
    let mut places: Vec<[isize; 2]> =
        (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y])).collect();
    places.sort_by_key(|[x, y]| x * x + y * y);
    places
}

#[cfg(test)]
mod tests {
    use super::super::blocks::synthesize;
    use super::super::quantise::Exemplar;
    use super::super::source_map::SourceMap;
    use super::*;
    use crate::job::Job;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;

    fn made(index: &Planes, options: &BlockOptions) -> SourceMap {
        synthesize(&[Exemplar { index, excluded: None }], options, &Job::default()).unwrap().map
    }

    fn options(side: usize, block: usize, overlap: usize, seed: u64) -> BlockOptions {
        BlockOptions { size: Size::new(side, side), block, overlap, seed, ..BlockOptions::default() }
    }

    /// Stripes along y with a grain.
    fn stripes() -> Planes {
        let (size, mut random) = (Size::new(128, 128), Stream::new(2, Purpose::Sample, [0]));
        let value = |i: usize| (i as f32 / 128.0 * 11.0 * std::f32::consts::TAU).sin();
        let data = (0..size.texels()).map(|i| value(i % 128) + 0.2 * random.unit() as f32).collect();
        Planes::from_vec(size, 1, data).unwrap()
    }

    /// A former fault: the first block was continued up to the border of the exemplar.
    #[test]
    fn no_piece_grows_to_half_of_the_exemplar() {
        let exemplar = stripes();
        for seed in 0..4 {
            let map = made(&exemplar, &options(256, 32, 5, seed));
            let mut shifts: BTreeMap<(i64, i64), usize> = BTreeMap::new();
            for (i, from) in map.copies().iter().enumerate() {
                let shift = (i64::from(from.x) - i as i64 % 256, i64::from(from.y) - i as i64 / 256);
                *shifts.entry(shift).or_default() += 1;
            }
            let largest = shifts.values().max().unwrap();
            assert!(2 * largest < exemplar.size().texels(), "seed {seed}: {largest}");
        }
    }

    /// Where a pattern repeats twice, nothing fits but what recurs.
    #[test]
    fn two_repeats_are_continued_without_a_fault() {
        let mut random = Stream::new(4, Purpose::Sample, [0]);
        let period = Size::new(24, 24);
        let data = (0..period.texels()).map(|_| random.unit() as f32).collect();
        let exemplar = Planes::from_vec(period, 1, data).unwrap().repeated(2, 2);
        for block in [12, 16, 20, 24] {
            let map = made(&exemplar, &options(120, block, block / 4, 3));
            let first = map.copies()[0];
            for (i, from) in map.copies().iter().enumerate() {
                let expected = ((first.x as usize + i % 120) % 24, (first.y as usize + i / 120) % 24);
                assert_eq!((from.x as usize % 24, from.y as usize % 24), expected, "{block} {i}");
            }
        }
    }
}
