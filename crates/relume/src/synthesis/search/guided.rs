//! The search for blocks that follow a guide: the whole block is compared with the guide of the output, not
//! only the overlap, after Efros, Freeman 2001 (texture transfer).
//!
//! A guide is compared by its means over square cells of [`CELL`] texels, each with the weight of its texels:
//! guides determine what belongs where, not how texels follow each other. The last cell of a row or column
//! ends with the block and may overlap the one before. All positions are examined; the sum of both distances
//! decides, and the distance of the overlap is that of the other searches.

use super::distance::BlockTarget;
use super::{BlockQuery, Candidates, Effort, Found, Search};
use crate::parallel;
use crate::size::Size;
use crate::synthesis::guidance::GuideCodes;
use crate::synthesis::positions::{PositionRun, Positions};
use crate::synthesis::quantise::{IndexTexels, Quantised};
use crate::synthesis::source_map::Texel;

/// Texels along a side of a cell, at most a block.
pub const CELL: usize = 4;

/// Examines every position, of exemplars and guides together.
#[derive(Debug)]
pub struct GuidedSearch<'a> {
    exemplars: &'a Quantised,
    positions: &'a Positions,
    guide: BlockGuide,
}

impl<'a> GuidedSearch<'a> {
    /// Prepares guides for blocks of a given side; an output that `wraps` continues at the opposite edge.
    pub(in crate::synthesis) fn new(
        exemplars: &'a Quantised,
        positions: &'a Positions,
        guides: &GuideCodes,
        block: usize,
        wraps: bool,
    ) -> Self {
        Self { exemplars, positions, guide: BlockGuide::new(guides, block, wraps) }
    }

    /// The memory of the prepared means: 32 bits for each texel and plane of all guides.
    pub(in crate::synthesis) fn bytes(guides: &GuideCodes) -> u64 {
        let all = guides.sources.iter().chain([&guides.target]);
        all.map(|guide| (size_of::<i32>() * guide.size().texels() * guide.planes()) as u64).sum()
    }

    /// All positions whose blocks fit the filled texels and the guide well enough.
    fn look(&self, query: &BlockQuery) -> Found {
        let acceptance = query.acceptance;
        let targets = BlockTarget::all(query, self.exemplars);
        let near = |run: &PositionRun| -> Vec<(Texel, u64)> {
            let Texel { exemplar, y, x } = run.first;
            let mut distances = targets[exemplar as usize].distances(x as usize, y as usize, run.length);
            self.guide.add(query.place, run, &mut distances);
            query.avoided.strike(run.first, &mut distances, u64::MAX);
            let near = acceptance.near(distances);
            near.map(|(i, distance)| (run.first.offset(i, 0), distance)).collect()
        };
        let near = parallel::map(self.positions.runs().iter(), near).concat();
        let count = self.positions.count() as u64;
        Found {
            candidates: Candidates::within(near, acceptance),
            effort: Effort { examined: count, verified: count },
        }
    }
}

impl Search for GuidedSearch<'_> {
    fn candidates(&self, queries: &[BlockQuery]) -> Vec<Found> {
        parallel::map(queries.iter(), |query| self.look(query))
    }
}

/// The guides of all exemplars and of the output, as means over cells.
#[derive(Debug)]
struct BlockGuide {
    /// Texels along a side of a cell.
    side: usize,
    /// For each exemplar the mean over the cell that begins at each texel, plane after plane.
    sources: Vec<Means>,
    target: Means,
    /// Whether the output continues at the opposite edge.
    wraps: bool,
    /// The starts of the cells of a block along either axis.
    starts: Vec<usize>,
}

/// Means over the cells that begin at each texel.
#[derive(Debug)]
struct Means {
    size: Size,
    planes: Vec<Vec<i32>>,
}

impl Means {
    /// Rounded means of all planes; beyond the right and lower edges the last texels are repeated, or those
    /// from the opposite edge are used.
    fn new(texels: &IndexTexels, side: usize, wraps: bool) -> Self {
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
        Self { size, planes: parallel::map(0..texels.planes(), plane) }
    }
}

impl BlockGuide {
    /// Prepares guides for blocks of a side.
    fn new(guides: &GuideCodes, block: usize, wraps: bool) -> Self {
        let side = CELL.min(block);
        let mut starts: Vec<usize> = (0..=block - side).step_by(side).collect();
        if !block.is_multiple_of(side) {
            starts.push(block - side);
        }
        Self {
            side,
            sources: guides.sources.iter().map(|guide| Means::new(guide, side, false)).collect(),
            target: Means::new(&guides.target, side, wraps),
            wraps,
            starts,
        }
    }

    /// The texel of the guide of the output `dx` and `dy` into a block; beyond an open edge the last one.
    fn in_target(&self, [x, y]: [usize; 2], dx: usize, dy: usize) -> usize {
        let size = self.target.size;
        let at = |i: usize, length: usize| if self.wraps { i % length } else { i.min(length - 1) };
        size.index(at(x + dx, size.width), at(y + dy, size.height))
    }

    /// Adds the guide distances of a run of positions to a block at a place of the output.
    fn add(&self, place: [usize; 2], run: &PositionRun, distances: &mut [u64]) {
        let source = &self.sources[run.first.exemplar as usize];
        let count = (self.side * self.side) as u64;
        for (dx, dy) in self.starts.iter().flat_map(|&dy| self.starts.iter().map(move |&dx| (dx, dy))) {
            let wanted = self.in_target(place, dx, dy);
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
    #[cfg(test)]
    fn plain_distance(&self, place: [usize; 2], position: Texel) -> u64 {
        let source = &self.sources[position.exemplar as usize];
        let mut sum = 0;
        for (k, plane) in source.planes.iter().enumerate() {
            for (dx, dy) in self.starts.iter().flat_map(|&dy| self.starts.iter().map(move |&dx| (dx, dy))) {
                let theirs = plane[(position.y as usize + dy) * source.size.width + position.x as usize + dx];
                let ours = self.target.planes[k][self.in_target(place, dx, dy)];
                sum += (self.side * self.side) as u64 * u64::from(theirs.abs_diff(ours)).pow(2);
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::synthesis::guidance::{Guidance, Guided};
    use crate::synthesis::layout::BlockLayout;
    use crate::synthesis::options::{BlockOptions, Boundary, Tolerance};
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::search::plain::squared_distance;
    use crate::synthesis::search::{Acceptance, Avoided};
    use proptest::prelude::*;

    fn noise(size: Size, planes: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [4]);
        let data = (0..size.texels() * planes).map(|_| stream.below(90) as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(25))]

        #[test]
        fn guided_blocks_are_those_of_the_plain_loops(
            (planes, guides, seed) in (1usize..5, 1usize..4, any::<u64>()),
            (width, height, side, torus, extra) in (4usize..30, 4usize..30, 3usize..10, any::<bool>(), 0usize..9),
        ) {
            let (size, job) = (Size::new(width.max(side), height.max(side)), Job::default());
            let sizes = [Size::new(side + extra, side + extra + 1), Size::new(side + extra + 2, side + extra)];
            let fields = sizes.map(|size| noise(size, planes, seed ^ size.width as u64));
            let exemplars = fields.each_ref().map(|index| Exemplar { index, excluded: None });
            let guidance = Guidance {
                sources: fields.iter().map(|f| noise(f.size(), guides, seed ^ 5)).collect(),
                target: noise(size, guides, seed ^ 7),
                weight: 1.5,
            };
            let guided = Guided::new(&exemplars, Some(&guidance), size, &job).unwrap();
            let (quantised, codes) = guided.apart(&job).unwrap();
            let boundary = if torus { Boundary::Torus } else { Boundary::Open };
            let overlap = (side / 4).max(1);
            let options = BlockOptions { size, block: side, overlap, boundary, ..BlockOptions::default() };
            let positions = Positions::new(&exemplars, side).unwrap();
            let search = GuidedSearch::new(&quantised, &positions, &codes.unwrap(), side, torus);
            for block in &BlockLayout::new(&options, &job).unwrap().sequence {
                let neighbourhood = block.neighbourhood;
                let codes = noise(Size::new(side * planes, side), 1, seed ^ 9);
                let query = BlockQuery {
                    neighbourhood,
                    place: [block.x, block.y],
                    codes: codes.as_slice().iter().map(|v| *v as i16).collect(),
                    acceptance: Acceptance::new(Tolerance::Relative(0.1), 1, 1.0),
                    likely: Vec::new(),
                    avoided: Avoided::default(),
                };
                let distance = |at| {
                    let overlap = squared_distance(&quantised, &neighbourhood, &query.codes, at);
                    (at, overlap + search.guide.plain_distance(query.place, at))
                };
                let truth = Candidates::within(positions.iter().map(distance).collect(), query.acceptance);
                prop_assert_eq!(&search.candidates(std::slice::from_ref(&query))[0].candidates, &truth);
            }
        }
    }
}
