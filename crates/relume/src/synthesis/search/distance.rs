//! The squared distance of a query to a block, in vector instructions.
//!
//! Each row of the rectangles of a neighbourhood is contiguous in the exemplar. It is divided into groups of
//! [`FACTORS`] codes, the last one of a row masked, so that a distance is one pass over the groups:
//! difference, mask, squares added in pairs in 32 bits. Partial sums are moved to 64 bits before 32 can
//! overflow. All processors give the same integer.

use crate::numeric::pairs::{FACTORS, Pairs, PairsWork, SUMS, dispatch};
use crate::synthesis::neighbourhood::Neighbourhood;
use crate::synthesis::quantise::{IndexTexels, MAX_CODE, PADDING, Quantised};
use crate::synthesis::search::BlockQuery;

/// The number of groups whose squares fit 32 bits: a partial sum takes two squares of each.
const GROUPS: usize = (u32::MAX / (2 * (MAX_CODE as u32).pow(2))) as usize;

/// The number of groups after which a distance that is already too large is abandoned.
const PATIENCE: usize = 8;

const _: () = assert!(PATIENCE <= GROUPS && FACTORS <= PADDING);

/// Consecutive codes of a query.
#[repr(align(64))]
struct CodeGroup {
    codes: [i16; FACTORS],
    /// All ones where there is a code, zero past the end of the row.
    mask: [i16; FACTORS],
    /// Their position, relative to the first code of the block.
    offset: usize,
}

/// A query prepared for one exemplar.
pub struct BlockTarget<'a> {
    exemplar: &'a IndexTexels,
    planes: usize,
    groups: Vec<CodeGroup>,
}

impl<'a> BlockTarget<'a> {
    /// Prepares a query for all exemplars.
    pub fn all(query: &BlockQuery, exemplars: &'a Quantised) -> Vec<Self> {
        let ready = |texels| Self::new(&query.neighbourhood, &query.codes, texels, exemplars.planes());
        exemplars.texels().iter().map(ready).collect()
    }

    /// Prepares the filled texels of a block's codes.
    pub fn new(shape: &Neighbourhood, codes: &[i16], exemplar: &'a IndexTexels, planes: usize) -> Self {
        let rows =
            shape.rects().flat_map(|r| (r.y..r.y + r.size.height).map(move |y| (r.x, y, r.size.width)));
        let mut groups = Vec::new();
        for (x, y, width) in rows {
            let row = &codes[shape.extent.index(x, y) * planes..][..width * planes];
            for (i, part) in row.chunks(FACTORS).enumerate() {
                let offset = exemplar.start(x, y) + i * FACTORS;
                let mut group = CodeGroup { codes: [0; FACTORS], mask: [0; FACTORS], offset };
                group.codes[..part.len()].copy_from_slice(part);
                group.mask[..part.len()].fill(-1);
                groups.push(group);
            }
        }
        Self { exemplar, planes, groups }
    }

    /// The squared distances of `length` blocks from (x, y) to the right.
    pub fn distances(&self, x: usize, y: usize, length: usize) -> Vec<u64> {
        let mut distances = vec![0; length];
        dispatch(RowOfDistances {
            target: self,
            start: self.exemplar.start(x, y),
            distances: &mut distances,
        });
        distances
    }

    /// The squared distance of the block at (x, y), if it is at most `limit`.
    pub fn distance_within(&self, x: usize, y: usize, limit: u64) -> Option<u64> {
        dispatch(DistanceWithin { target: self, start: self.exemplar.start(x, y), limit })
    }
}

/// The distances of neighbouring blocks.
struct RowOfDistances<'a> {
    target: &'a BlockTarget<'a>,
    start: usize,
    distances: &'a mut [u64],
}

impl PairsWork for RowOfDistances<'_> {
    type Output = ();

    #[inline(always)]
    fn with<P: Pairs>(self, pairs: P) {
        let BlockTarget { exemplar, planes, groups } = self.target;
        for (i, distance) in self.distances.iter_mut().enumerate() {
            let block = &exemplar.codes()[self.start + i * planes..];
            *distance = groups.chunks(GROUPS).map(|part| squares(pairs, part, block)).sum();
        }
    }
}

/// One distance, abandoned when it exceeds the limit.
struct DistanceWithin<'a> {
    target: &'a BlockTarget<'a>,
    start: usize,
    limit: u64,
}

impl PairsWork for DistanceWithin<'_> {
    type Output = Option<u64>;

    #[inline(always)]
    fn with<P: Pairs>(self, pairs: P) -> Option<u64> {
        let block = &self.target.exemplar.codes()[self.start..];
        let mut total = 0;
        for part in self.target.groups.chunks(PATIENCE) {
            total += squares(pairs, part, block);
            if total > self.limit {
                return None;
            }
        }
        Some(total)
    }
}

/// The squares of at most [`GROUPS`] groups.
#[inline(always)]
fn squares<P: Pairs>(pairs: P, groups: &[CodeGroup], block: &[i16]) -> u64 {
    let mut sums = [0; SUMS];
    for CodeGroup { codes, mask, offset } in groups {
        let there = block[*offset..].first_chunk().expect("exemplars are padded");
        sums = pairs.add_squares(sums, there, codes, mask);
    }
    sums.iter().map(|sum| u64::from(sum.cast_unsigned())).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::Job;
    use crate::numeric::pairs::PortablePairs;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::size::Size;
    use crate::synthesis::neighbourhood::Margins;
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::search::plain::squared_distance;
    use crate::synthesis::source_map::Texel;

    /// Distances of all blocks in all rows, by the kernel of the processor and by the portable one, compared
    /// with the plain loop.
    fn compare(exemplars: &Quantised, shape: &Neighbourhood, codes: &[i16]) {
        let exemplar = &exemplars.texels()[0];
        let target = BlockTarget::new(shape, codes, exemplar, exemplars.planes());
        let (size, extent) = (exemplar.size(), shape.extent);
        for y in 0..=size.height - extent.height {
            let length = size.width - extent.width + 1;
            let found = target.distances(0, y, length);
            for (x, found) in found.into_iter().enumerate() {
                let place = Texel { exemplar: 0, y: y as u32, x: x as u32 };
                let truth = squared_distance(exemplars, shape, codes, place);
                assert_eq!(found, truth);
                let block = &exemplar.codes()[exemplar.start(x, y)..];
                let parts = target.groups.chunks(GROUPS).map(|part| squares(PortablePairs, part, block));
                assert_eq!(parts.sum::<u64>(), truth);
            }
        }
    }

    #[test]
    fn kernels_equal_the_plain_loop() {
        for planes in 1..20 {
            let mut stream = Stream::new(planes as u64, Purpose::Sample, [0]);
            let size = Size::new(17 + planes, 19);
            let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
            let index = Planes::from_vec(size, planes, data).unwrap();
            let exemplars =
                Quantised::new(&[Exemplar { index: &index, excluded: None }], &Job::default()).unwrap();
            let margins = Margins { left: 1 + planes % 5, top: 4, right: planes % 3, bottom: 2 };
            let neighbourhood = Neighbourhood { extent: Size::new(13, 11), margins };
            let codes: Vec<i16> = (0..13 * 11 * planes).map(|_| stream.below(4096) as i16).collect();
            compare(&exemplars, &neighbourhood, &codes);
        }
    }

    #[test]
    fn the_largest_differences_do_not_overflow() {
        let planes = 18;
        let index = Planes::zeros(Size::new(62, 61), planes);
        let mut exemplars =
            Quantised::new(&[Exemplar { index: &index, excluded: None }], &Job::default()).unwrap();
        exemplars.fill_for_tests(MAX_CODE);
        let margins = Margins { left: 30, top: 30, right: 30, bottom: 30 };
        let neighbourhood = Neighbourhood { extent: Size::new(60, 60), margins };
        compare(&exemplars, &neighbourhood, &vec![0; 3600 * planes]);
    }
}
