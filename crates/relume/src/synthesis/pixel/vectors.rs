//! Vectors of codes in rows, such as neighbourhoods, and their exact squared distances.

use pulp::Arch;

use crate::synthesis::quantise::MAX_CODE;

/// Rows are padded with zeros to a multiple of this many codes.
pub const LANES: usize = 16;

/// The number of codes whose squared differences fit 32-bit sums of pairs.
const BLOCK: usize = LANES * (u32::MAX / (2 * (MAX_CODE as u32).pow(2))) as usize;

/// The number of rows whose squares fit 32 bits.
const FEW: usize = (u32::MAX / (MAX_CODE as u32).pow(2)) as usize;

/// Vectors of equal length, row by row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vectors {
    length: usize,
    codes: Vec<i16>,
}

impl Vectors {
    /// No vectors of `length` codes yet, with capacity for `count`.
    pub fn with_capacity(length: usize, count: usize) -> Self {
        let length = padded(length);
        Self { length, codes: Vec::with_capacity(length * count) }
    }

    /// Appends a vector, padded with zeros.
    pub fn push(&mut self, vector: &[i16]) {
        self.codes.extend_from_slice(vector);
        self.codes.resize(self.codes.len().next_multiple_of(self.length), 0);
    }

    /// The memory that they take.
    pub fn bytes(&self) -> u64 {
        size_of_val(&*self.codes) as u64
    }

    /// Codes in a row.
    pub fn length(&self) -> usize {
        self.length
    }

    /// The number of vectors.
    pub fn count(&self) -> usize {
        self.codes.len() / self.length
    }

    /// One vector.
    pub fn row(&self, number: usize) -> &[i16] {
        &self.codes[number * self.length..][..self.length]
    }
}

/// The length of a row that holds `length` codes.
pub fn padded(length: usize) -> usize {
    length.max(1).next_multiple_of(LANES)
}

/// The squared distance of two rows.
#[inline(always)]
pub fn squared_distance(a: &[i16], b: &[i16]) -> u64 {
    #[cfg(target_arch = "x86_64")]
    if let Some(simd) = pulp::x86::V3::try_new() {
        return simd.vectorize(
            #[inline(always)]
            || avx2(simd, a, b),
        );
    }
    portable(a, b)
}

/// The squared distance of two rows in AVX2 instructions.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub fn avx2(simd: pulp::x86::V3, a: &[i16], b: &[i16]) -> u64 {
    use std::arch::x86_64::__m256i;
    let mut total = 0;
    for (a, b) in a.chunks(BLOCK).zip(b.chunks(BLOCK)) {
        let mut sums: __m256i = bytemuck::must_cast([0u32; LANES / 2]);
        for (a, b) in pulp::as_arrays::<LANES, i16>(a).0.iter().zip(pulp::as_arrays::<LANES, i16>(b).0) {
            let difference = simd.avx2._mm256_sub_epi16(bytemuck::must_cast(*a), bytemuck::must_cast(*b));
            sums = simd.avx2._mm256_add_epi32(sums, simd.avx2._mm256_madd_epi16(difference, difference));
        }
        let sums: [u32; LANES / 2] = bytemuck::must_cast(sums);
        for sum in sums {
            total += u64::from(sum);
        }
    }
    total
}

/// The squared distance of two rows without special instructions.
#[inline(always)]
pub fn portable(a: &[i16], b: &[i16]) -> u64 {
    a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum()
}

/// Sums and sums of squares of each coordinate over given rows.
pub fn moments(vectors: &Vectors, rows: &[u32]) -> (Vec<i64>, Vec<i64>) {
    let length = vectors.length();
    let (mut sums, mut squares) = (vec![0i64; length], vec![0i64; length]);
    let (mut few_sums, mut few_squares) = (vec![0u32; length], vec![0u32; length]);
    for few in rows.chunks(FEW) {
        few_sums.fill(0);
        few_squares.fill(0);
        Arch::new().dispatch(
            #[inline(always)]
            || add_moments(vectors, few, &mut few_sums, &mut few_squares),
        );
        sums.iter_mut().zip(&few_sums).for_each(|(sum, &few)| *sum += i64::from(few));
        squares.iter_mut().zip(&few_squares).for_each(|(sum, &few)| *sum += i64::from(few));
    }
    (sums, squares)
}

#[inline(always)]
fn add_moments(vectors: &Vectors, rows: &[u32], sums: &mut [u32], squares: &mut [u32]) {
    for &row in rows {
        for ((sum, square), &code) in sums.iter_mut().zip(squares.iter_mut()).zip(vectors.row(row as usize)) {
            let code = i32::from(code);
            *sum = sum.wrapping_add(code.unsigned_abs());
            *square = square.wrapping_add((code * code).unsigned_abs());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn distances_are_exact_at_any_length() {
        let mut stream = Stream::new(1, Purpose::Sample, [0]);
        for length in [1, 15, 16, 17, 63, 500, BLOCK, 2 * BLOCK + 5] {
            let mut vectors = Vectors::with_capacity(length, 2);
            let rows: [Vec<i16>; 2] =
                std::array::from_fn(|_| (0..length).map(|_| stream.below(4096) as i16).collect());
            rows.iter().for_each(|row| vectors.push(row));
            let truth =
                rows[0].iter().zip(&rows[1]).map(|(a, b)| u64::from(a.abs_diff(*b)).pow(2)).sum::<u64>();
            assert_eq!((vectors.count(), vectors.length() % LANES), (2, 0));
            assert_eq!(squared_distance(vectors.row(0), vectors.row(1)), truth);
            assert_eq!(portable(vectors.row(0), vectors.row(1)), truth);
        }
        let mut vectors = Vectors::with_capacity(3, 700);
        (0..700).for_each(|n| vectors.push(&[MAX_CODE, n, 0]));
        let (sums, squares) = moments(&vectors, &(0..700).collect::<Vec<u32>>());
        assert_eq!(sums[..3], [700 * 4095, 699 * 350, 0]);
        assert_eq!(squares[..3], [700 * 4095 * 4095, (0..700).map(|n| n * n).sum(), 0]);
        let (low, high) = ([0; 2 * BLOCK], [MAX_CODE; 2 * BLOCK]);
        assert_eq!(squared_distance(&low, &high), (2 * BLOCK) as u64 * 4095 * 4095);
    }
}
