//! Sums of products for many positions and several sets of factors at a time, as in a product of
//! matrices: values are loaded once for up to [`MOST`] sets, whose sums stay in registers.
//!
//! The projections of an exemplar's cells on all kernels are such sums, over codes; and so are the
//! bounds of all positions for the queries of a wave, over coordinates.

use crate::numeric::pairs::{FACTORS, Pairs, SUMS, Sums, Work, dispatch};

/// Sets of factors that share the loads of values.
pub const MOST: usize = 16;

/// Positions whose sums are kept at a time.
pub const STRETCH: usize = 128;

/// The sums of all sets for a stretch of positions.
pub type Stretch = [[Sums; STRETCH / SUMS]; MOST];

/// Planes of pairs of 16-bit values, in padded rows.
#[derive(Debug)]
pub struct PairPlanes {
    planes: usize,
    stride: usize,
    /// Row after row; in a row plane after plane; in a plane pair after pair.
    values: Vec<i16>,
}

impl PairPlanes {
    /// Planes of zeros, with room for a stretch of positions past the end of each row.
    pub fn zeros(planes: usize, width: usize, height: usize) -> Self {
        let stride = width + STRETCH;
        Self { planes, stride, values: vec![0; 2 * planes * stride * height] }
    }

    /// The number of planes.
    pub fn planes(&self) -> usize {
        self.planes
    }

    /// All rows: in each plane after plane, of [`PairPlanes::row_length`] values.
    pub fn rows_mut(&mut self) -> std::slice::ChunksExactMut<'_, i16> {
        self.values.chunks_exact_mut(2 * self.planes * self.stride)
    }

    /// The values of one plane of a row, padding included.
    pub fn row_length(&self) -> usize {
        2 * self.stride
    }

    /// Value `number` of the position (x, y), counted through its pairs.
    pub fn value(&self, number: usize, x: usize, y: usize) -> i16 {
        self.values[2 * ((y * self.planes + number / 2) * self.stride + x) + number % 2]
    }

    /// The pairs of [`SUMS`] positions from (x, y) to the right.
    #[inline(always)]
    fn at(&self, plane: usize, x: usize, y: usize) -> &[i16; FACTORS] {
        let start = 2 * ((y * self.planes + plane) * self.stride + x);
        self.values[start..].first_chunk().expect("rows are padded")
    }
}

/// A pair of factors in one number.
pub fn pair(factors: [i16; 2]) -> i32 {
    pulp::cast(factors)
}

/// Sums to be computed.
pub struct Product<'a> {
    /// The values.
    pub planes: &'a PairPlanes,
    /// Where they are taken, relative to each position.
    pub offsets: &'a [(usize, usize)],
    /// For each set the pair of factors of each plane, offset after offset.
    pub factors: &'a [[i32; MOST]],
    /// How many sets there are, at most [`MOST`].
    pub sets: usize,
    /// The first position.
    pub x: usize,
    /// Its row.
    pub y: usize,
    /// How many positions, at most [`STRETCH`].
    pub length: usize,
    /// For each set the sum of each position, and meaningless numbers past the last.
    pub sums: &'a mut Stretch,
}

impl Product<'_> {
    /// Computes the sums. Where that costs less than another pass, some of no meaning are computed
    /// beside them.
    pub fn compute(self) {
        dispatch(self);
    }

    /// `Q` sets, `G` groups of positions at a time: at least six sums are under way at once, enough
    /// to hide the delay of a multiplication.
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
        let mut sums = [[[0; SUMS]; G]; Q];
        for (&(dx, dy), factors) in self.offsets.iter().zip(self.factors.chunks_exact(self.planes.planes)) {
            for (plane, factors) in factors.iter().enumerate() {
                for g in 0..G {
                    let there = self.planes.at(plane, x + dx + g * SUMS, self.y + dy);
                    for (sums, &factor) in sums.iter_mut().zip(factors) {
                        sums[g] = pairs.multiply_add(sums[g], there, &pulp::cast([factor; SUMS]));
                    }
                }
            }
        }
        sums
    }
}

impl Work for Product<'_> {
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
    use crate::numeric::random::Stream;

    #[test]
    fn sums_are_those_of_a_plain_loop() {
        for sets in 1..=MOST {
            let mut stream = Stream::new(sets as u64, 0);
            let (planes, width, height) = (1 + stream.below(4), 40 + stream.below(60), 9);
            let mut values = PairPlanes::zeros(planes, width, height);
            values.rows_mut().flatten().for_each(|v| *v = stream.below(2000) as i16 - 1000);
            let offsets: Vec<(usize, usize)> = (0..5).map(|_| (stream.below(9), stream.below(4))).collect();
            let mut factors = vec![[0; MOST]; planes * offsets.len()];
            factors.as_flattened_mut().iter_mut().for_each(|f| *f = pair([stream.below(99) as i16, -7]));
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
                let mut truth = 0;
                for (o, &(dx, dy)) in offsets.iter().enumerate() {
                    for plane in 0..planes {
                        let there = values.at(plane, x + dx + i, y + dy);
                        let [a, b]: [i16; 2] = pulp::cast(factors[o * planes + plane][set]);
                        truth += i32::from(there[0]) * i32::from(a) + i32::from(there[1]) * i32::from(b);
                    }
                }
                assert_eq!(sums[set].as_flattened()[i], truth);
            }
        }
    }
}
