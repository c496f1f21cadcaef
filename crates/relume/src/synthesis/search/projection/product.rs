//! Sums of products for many positions and several sets of factors at a time, as in a product of
//! matrices: words are loaded once for up to [`MOST`] sets, whose sums stay in registers.
//!
//! The projections of the cells of an exemplar on all kernels are such sums, over codes; and so are the
//! bounds of all positions for the queries of a wave, over coordinates.

use crate::numeric::pairs::{Pairs, PairsWork, SUMS, Sums, dispatch};

/// Sets of factors that share the loads of values.
pub const MOST: usize = 16;

/// The number of positions whose sums are kept at a time.
pub const STRETCH: usize = 128;

/// The sums of all sets for a stretch of positions.
pub type Stretch = [[Sums; STRETCH / SUMS]; MOST];

/// Planes of words: first those of two 16-bit numbers, then those of four bytes, and one of 32-bit
/// numbers to which the products are added; in padded rows.
#[derive(Debug)]
pub struct WordPlanes {
    pairs: usize,
    quads: usize,
    stride: usize,
    /// Row by row; in a row plane after plane.
    words: Vec<i32>,
}

impl WordPlanes {
    /// Planes of zeros, with room for a stretch of positions past the end of each row.
    pub fn zeros(pairs: usize, quads: usize, width: usize, height: usize) -> Self {
        let stride = width + STRETCH;
        Self { pairs, quads, stride, words: vec![0; (pairs + quads + 1) * stride * height] }
    }

    /// Their bytes.
    pub fn bytes(pairs: usize, quads: usize, width: usize, height: usize) -> u64 {
        4 * ((pairs + quads + 1) * (width + STRETCH) * height) as u64
    }

    /// The number of multiplied planes.
    pub fn factors(&self) -> usize {
        self.pairs + self.quads
    }

    /// All rows: in each plane after plane, of [`WordPlanes::row_length`] words.
    pub fn rows_mut(&mut self) -> std::slice::ChunksExactMut<'_, i32> {
        let length = (self.factors() + 1) * self.stride;
        self.words.chunks_exact_mut(length)
    }

    /// The words of one plane of a row, padding included.
    pub fn row_length(&self) -> usize {
        self.stride
    }

    /// A word of the position (x, y).
    pub fn word(&self, plane: usize, x: usize, y: usize) -> i32 {
        self.words[(y * (self.factors() + 1) + plane) * self.stride + x]
    }

    /// The words of [`SUMS`] positions from (x, y) to the right.
    #[inline(always)]
    fn at(&self, plane: usize, x: usize, y: usize) -> &Sums {
        let start = (y * (self.factors() + 1) + plane) * self.stride + x;
        self.words[start..].first_chunk().expect("rows are padded")
    }
}

/// A pair of factors in one word.
pub fn pair(factors: [i16; 2]) -> i32 {
    bytemuck::must_cast(factors)
}

/// Four factors in one word.
pub fn quad(factors: [i8; 4]) -> i32 {
    bytemuck::must_cast(factors)
}

/// Sums to be computed.
pub struct Product<'a> {
    /// The words.
    pub planes: &'a WordPlanes,
    /// Their offsets, relative to each position.
    pub offsets: &'a [(usize, usize)],
    /// For each set the factors of each plane, offset after offset.
    pub factors: &'a [[i32; MOST]],
    /// The number of sets, at most [`MOST`].
    pub sets: usize,
    /// The first position.
    pub x: usize,
    /// Its row.
    pub y: usize,
    /// The number of positions, at most [`STRETCH`].
    pub length: usize,
    /// For each set the sum of each position, and meaningless numbers past the last.
    pub sums: &'a mut Stretch,
}

impl Product<'_> {
    /// Computes the sums. Where it is cheaper than another pass, some meaningless ones are computed as well.
    pub fn compute(self) {
        dispatch(self);
    }

    /// `Q` sets, `G` groups of positions at a time: at least six sums are in flight, enough to hide the
    /// latency of a multiplication.
    #[inline(always)]
    fn sets<const Q: usize, const G: usize, P: Pairs>(self, pairs: P) {
        for group in (0..self.length.div_ceil(SUMS)).step_by(G) {
            let sums = self.groups::<Q, G, P>(pairs, group);
            for (to, sums) in self.sums.iter_mut().zip(sums) {
                to[group..].iter_mut().zip(sums).for_each(|(to, sum)| *to = sum);
            }
        }
    }

    #[inline(always)]
    fn groups<const Q: usize, const G: usize, P: Pairs>(&self, pairs: P, group: usize) -> [[Sums; G]; Q] {
        let x = self.x + group * SUMS;
        let mut sums = [self.bases(x); Q];
        let in_pairs = self.planes.pairs;
        for (&(dx, dy), factors) in self.offsets.iter().zip(self.factors.chunks_exact(self.planes.factors()))
        {
            let there = |plane: usize, g: usize| *self.planes.at(plane, x + dx + g * SUMS, self.y + dy);
            let (of_pairs, of_quads) = factors.split_at(in_pairs);
            for (plane, factors) in of_pairs.iter().enumerate() {
                for g in 0..G {
                    let there = bytemuck::must_cast(there(plane, g));
                    for (sums, &factor) in sums.iter_mut().zip(factors) {
                        sums[g] = pairs.multiply_add(sums[g], &there, &bytemuck::must_cast([factor; SUMS]));
                    }
                }
            }
            for (plane, factors) in of_quads.iter().enumerate() {
                for g in 0..G {
                    let there = bytemuck::must_cast(there(in_pairs + plane, g));
                    for (sums, &factor) in sums.iter_mut().zip(factors) {
                        sums[g] =
                            pairs.multiply_add_bytes(sums[g], &there, &bytemuck::must_cast([factor; SUMS]));
                    }
                }
            }
        }
        sums
    }

    /// The initial values of the sums.
    #[inline(always)]
    fn bases<const G: usize>(&self, x: usize) -> [Sums; G] {
        let mut bases: [Sums; G] = [[0; SUMS]; G];
        for &(dx, dy) in self.offsets {
            for (g, base) in bases.iter_mut().enumerate() {
                let there = self.planes.at(self.planes.factors(), x + dx + g * SUMS, self.y + dy);
                base.iter_mut().zip(there).for_each(|(sum, more)| *sum = sum.wrapping_add(*more));
            }
        }
        bases
    }
}

impl PairsWork for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn with<P: Pairs>(self, pairs: P) {
        match self.sets {
            13.. => self.sets::<16, 1, P>(pairs),
            9.. => self.sets::<12, 1, P>(pairs),
            7.. => self.sets::<8, 1, P>(pairs),
            5.. => self.sets::<6, 1, P>(pairs),
            4 => self.sets::<4, 2, P>(pairs),
            3 => self.sets::<3, 2, P>(pairs),
            2 => self.sets::<2, 4, P>(pairs),
            _ => self.sets::<1, 8, P>(pairs),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn sums_are_those_of_a_plain_loop() {
        for sets in 1..=MOST {
            let mut stream = Stream::new(sets as u64, Purpose::Sample, [0]);
            let (pairs, quads) = (1 + stream.below(2), stream.below(3));
            let (width, height) = (40 + stream.below(60), 9);
            let mut values = WordPlanes::zeros(pairs, quads, width, height);
            values.rows_mut().flatten().for_each(|v| *v = stream.below(1 << 32) as u32 as i32 >> 4);
            let planes = values.factors();
            let offsets: Vec<(usize, usize)> = (0..5).map(|_| (stream.below(9), stream.below(4))).collect();
            let mut factors = vec![[0; MOST]; planes * offsets.len()];
            factors.as_flattened_mut().iter_mut().for_each(|f| *f = stream.below(1 << 32) as u32 as i32);
            let length = 1 + stream.below(width - 9);
            let mut sums = [[[0; SUMS]; STRETCH / SUMS]; MOST];
            let (x, y) = (stream.below(width - 8 - length + 1), 5);
            let product = Product {
                planes: &values,
                offsets: &offsets,
                factors: &factors,
                sets,
                x,
                y,
                length,
                sums: &mut sums,
            };
            product.compute();
            for (set, i) in (0..sets).flat_map(|set| (0..length).map(move |i| (set, i))) {
                let mut truth = 0i32;
                for (o, &(dx, dy)) in offsets.iter().enumerate() {
                    truth = truth.wrapping_add(values.word(planes, x + dx + i, y + dy));
                    for plane in 0..planes {
                        let there = values.word(plane, x + dx + i, y + dy);
                        let factor = factors[o * planes + plane][set];
                        truth = truth.wrapping_add(if plane < pairs {
                            let ([a, b], [c, d]): ([i16; 2], [i16; 2]) =
                                (bytemuck::must_cast(there), bytemuck::must_cast(factor));
                            (i32::from(a) * i32::from(c)).wrapping_add(i32::from(b) * i32::from(d))
                        } else {
                            let (a, b): ([u8; 4], [i8; 4]) =
                                (bytemuck::must_cast(there), bytemuck::must_cast(factor));
                            a.iter().zip(b).map(|(a, b)| i32::from(*a) * i32::from(b)).sum()
                        });
                    }
                }
                assert_eq!(sums[set].as_flattened()[i], truth);
            }
        }
    }
}
