//! The squared distance of a query to a block, in vector instructions.
//!
//! Each row of a neighbourhood's rectangles is contiguous in the exemplar. It is cut into groups of
//! 16 codes, the last one of a row masked, so that a distance is one pass over the groups:
//! difference, mask, squares added in pairs in 32 bits. Partial sums go to 64 bits before 32 can
//! overflow. All processors give the same integer.

use crate::synthesis::quantise::{IndexTexels, MAX_CODE, Quantised};
use crate::synthesis::search::Query;

/// Codes compared at a time.
const LANES: usize = 16;

/// Groups whose squares 32 bits can hold: a partial sum takes two squares of each.
const GROUPS: usize = (u32::MAX / (2 * (MAX_CODE as u32).pow(2))) as usize;

/// Groups after which a distance that is too large already is given up.
const PATIENCE: usize = 24;

const _: () = assert!(PATIENCE <= GROUPS);

/// Up to 16 neighbouring codes of a query.
struct Group {
    /// Where they are compared, counted from the first code of the block.
    offset: usize,
    codes: [i16; LANES],
    /// All ones where there is a code, zero past the end of the row.
    mask: [i16; LANES],
}

/// A query made ready for one exemplar.
pub struct Target<'a> {
    exemplar: &'a IndexTexels,
    planes: usize,
    groups: Vec<Group>,
}

impl<'a> Target<'a> {
    /// Prepares a query for all exemplars.
    pub fn all(query: &Query, exemplars: &'a Quantised) -> Vec<Self> {
        let ready = |texels| Self::new(query, texels, exemplars.planes());
        exemplars.texels().iter().map(ready).collect()
    }

    /// Prepares the filled texels of a query.
    pub fn new(query: &Query, exemplar: &'a IndexTexels, planes: usize) -> Self {
        let shape = query.neighbourhood;
        let rows = shape.rects().flat_map(|r| (r.y..r.y + r.height).map(move |y| (r.x, y, r.width)));
        let mut groups = Vec::new();
        for (x, y, width) in rows {
            let row = &query.codes[shape.extent.index(x, y) * planes..][..width * planes];
            for (i, part) in row.chunks(LANES).enumerate() {
                let offset = exemplar.start(x, y) + i * LANES;
                let mut group = Group { offset, codes: [0; LANES], mask: [0; LANES] };
                group.codes[..part.len()].copy_from_slice(part);
                group.mask[..part.len()].fill(-1);
                groups.push(group);
            }
        }
        Self { exemplar, planes, groups }
    }

    /// The squared distances of `length` blocks from (x, y) to the right.
    pub fn distances(&self, x: usize, y: usize, length: usize) -> Vec<u64> {
        let codes = &self.exemplar.codes()[self.exemplar.start(x, y)..];
        let mut distances = vec![0; length];
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            simd.vectorize(
                #[inline(always)]
                || {
                    for (i, distance) in distances.iter_mut().enumerate() {
                        let block = &codes[i * self.planes..];
                        *distance = self.groups.chunks(GROUPS).map(|part| avx2(simd, part, block)).sum();
                    }
                },
            );
            return distances;
        }
        for (i, distance) in distances.iter_mut().enumerate() {
            let block = &codes[i * self.planes..];
            *distance = self.groups.chunks(GROUPS).map(|part| portable(part, block)).sum();
        }
        distances
    }

    /// The squared distance of the block at (x, y), if it is at most `limit`.
    pub fn distance_within(&self, x: usize, y: usize, limit: u64) -> Option<u64> {
        let block = &self.exemplar.codes()[self.exemplar.start(x, y)..];
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || sum_within(&self.groups, limit, |part| avx2(simd, part, block)),
            );
        }
        sum_within(&self.groups, limit, |part| portable(part, block))
    }
}

/// The sum over parts of the groups, given up when it exceeds `limit`.
#[inline(always)]
fn sum_within(groups: &[Group], limit: u64, sum: impl Fn(&[Group]) -> u64) -> Option<u64> {
    let mut total = 0;
    for part in groups.chunks(PATIENCE) {
        total += sum(part);
        if total > limit {
            return None;
        }
    }
    Some(total)
}

/// The squares of at most [`GROUPS`] groups in AVX2 instructions.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn avx2(simd: pulp::x86::V3, groups: &[Group], block: &[i16]) -> u64 {
    use std::arch::x86_64::__m256i;
    let mut sums: __m256i = pulp::cast([0u32; LANES / 2]);
    for group in groups {
        let mut there = [0; LANES];
        there.copy_from_slice(&block[group.offset..][..LANES]);
        let difference = simd.avx2._mm256_sub_epi16(pulp::cast(there), pulp::cast(group.codes));
        let difference = simd.avx2._mm256_and_si256(difference, pulp::cast(group.mask));
        let squares = simd.avx2._mm256_madd_epi16(difference, difference);
        sums = simd.avx2._mm256_add_epi32(sums, squares);
    }
    sum(pulp::cast(sums))
}

/// The squares of at most [`GROUPS`] groups without particular instructions.
fn portable(groups: &[Group], block: &[i16]) -> u64 {
    let mut sums = [0u32; LANES / 2];
    for group in groups {
        let there = &block[group.offset..][..LANES];
        for i in 0..LANES {
            let difference = i32::from((there[i] - group.codes[i]) & group.mask[i]);
            sums[i / 2] += (difference * difference).unsigned_abs();
        }
    }
    sum(sums)
}

#[inline(always)]
fn sum(parts: [u32; LANES / 2]) -> u64 {
    parts.iter().map(|&part| u64::from(part)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::Stream;
    use crate::planes::{Planes, Size};
    use crate::synthesis::neighbourhood::{Margins, Neighbourhood};
    use crate::synthesis::quantise::Exemplar;
    use crate::synthesis::search::plain::squared_distance;
    use crate::synthesis::source_map::Texel;

    /// Distances of all blocks in all rows, by the processor's kernel and by the portable one,
    /// against the plain loop.
    fn compare(exemplars: &Quantised, query: &Query) {
        let exemplar = &exemplars.texels()[0];
        let target = Target::new(query, exemplar, exemplars.planes());
        let (size, extent) = (exemplar.size(), query.neighbourhood.extent);
        for y in 0..=size.height - extent.height {
            let length = size.width - extent.width + 1;
            let found = target.distances(0, y, length);
            for (x, found) in found.into_iter().enumerate() {
                let truth =
                    squared_distance(exemplars, query, Texel { exemplar: 0, y: y as u32, x: x as u32 });
                assert_eq!(found, truth);
                let block = &exemplar.codes()[exemplar.start(x, y)..];
                let parts = target.groups.chunks(GROUPS).map(|part| portable(part, block));
                assert_eq!(parts.sum::<u64>(), truth);
            }
        }
    }

    #[test]
    fn kernels_equal_the_plain_loop() {
        for planes in 1..20 {
            let mut stream = Stream::new(planes as u64, 0);
            let size = Size::new(17 + planes, 19);
            let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
            let index = Planes::from_vec(size, planes, data).unwrap();
            let exemplars =
                Quantised::new(&[Exemplar { index: &index, excluded: None }], &Limits::default()).unwrap();
            let margins = Margins { left: 1 + planes % 5, top: 4, right: planes % 3, bottom: 2 };
            let neighbourhood = Neighbourhood { extent: Size::new(13, 11), margins };
            let codes = (0..13 * 11 * planes).map(|_| stream.below(4096) as i16).collect();
            compare(&exemplars, &Query { neighbourhood, codes });
        }
    }

    #[test]
    fn the_largest_differences_do_not_overflow() {
        let planes = 18;
        let index = Planes::zeros(Size::new(62, 61), planes);
        let mut exemplars =
            Quantised::new(&[Exemplar { index: &index, excluded: None }], &Limits::default()).unwrap();
        exemplars.fill_for_tests(MAX_CODE);
        let margins = Margins { left: 30, top: 30, right: 30, bottom: 30 };
        let neighbourhood = Neighbourhood { extent: Size::new(60, 60), margins };
        compare(&exemplars, &Query { neighbourhood, codes: vec![0; 3600 * planes] });
    }
}
