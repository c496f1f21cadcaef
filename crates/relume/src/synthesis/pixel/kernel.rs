//! Sums of weighted squares at neighbouring positions: the kernel of the search and its sieve.
//!
//! Codes come in pairs, so that one instruction multiplies and adds the differences of both.

use super::window::MAX_FACTOR;

/// Neighbouring positions compared at a time.
pub const LANES: usize = 16;

/// The codes of two planes of one texel, or those of one axis of two texels.
pub type CodePair = [i16; 2];

/// The largest weighted square of a pair whose codes are at most `peak`, before its shift.
pub const fn largest_term(peak: i16) -> u64 {
    MAX_FACTOR as u64 * 2 * (peak as u64).pow(2)
}

/// Two planes of one known texel, or one axis of two.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Term {
    /// Their position, relative to the pair of the position searched.
    pub offset: usize,
    /// Their codes in the query.
    pub codes: CodePair,
    /// The factors of the squared differences; 0 where a texel is not compared.
    pub factors: CodePair,
}

/// Whether any sum is at most a limit: no early exit, so it vectorises.
#[inline(always)]
pub fn reaches(sums: &[u32; LANES], limit: u32) -> bool {
    sums.iter().fold(false, |near, &sum| near | (sum <= limit))
}

/// Adds the weighted squares of terms at [`LANES`] positions, `pairs` being those of the first.
#[inline(always)]
pub fn add_all(
    sums: &mut [u32; LANES],
    terms: &[Term],
    pairs: &[CodePair],
    add: impl Fn(&mut [u32; LANES], &Term, &[CodePair; LANES]),
) {
    for term in terms {
        let there = pairs[term.offset..].first_chunk().expect("pairs are followed by more");
        add(sums, term, there);
    }
}

/// Adds the weighted squares of a term at [`LANES`] positions, in AVX2 instructions.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub fn avx2(simd: pulp::x86::V3, sums: &mut [u32; LANES], term: &Term, there: &[CodePair; LANES]) {
    use std::arch::x86_64::__m256i;
    let mut totals: [__m256i; 2] = bytemuck::must_cast(*sums);
    let there: [__m256i; 2] = bytemuck::must_cast(*there);
    let (codes, factors) =
        (bytemuck::must_cast([term.codes; LANES / 2]), bytemuck::must_cast([term.factors; LANES / 2]));
    for (there, total) in there.into_iter().zip(&mut totals) {
        let difference = simd.avx2._mm256_sub_epi16(there, codes);
        let weighted = simd.avx2._mm256_mullo_epi16(difference, factors);
        *total = simd.avx2._mm256_add_epi32(*total, simd.avx2._mm256_madd_epi16(difference, weighted));
    }
    *sums = bytemuck::must_cast(totals);
}

/// The same without special instructions.
pub fn portable(sums: &mut [u32; LANES], term: &Term, there: &[CodePair; LANES]) {
    for (sum, there) in sums.iter_mut().zip(there) {
        for ((a, b), factor) in there.iter().zip(term.codes).zip(term.factors) {
            let difference = i32::from(a - b);
            *sum += (difference * difference * i32::from(factor)).unsigned_abs();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::synthesis::quantise::MAX_CODE;

    /// Terms whose sum must fit 32 bits.
    const TERMS: usize = 8;

    #[test]
    fn processors_without_these_instructions_get_the_same_sums() {
        let mut stream = Stream::new(3, Purpose::Sample, [0]);
        let mut code = || stream.below(4096) as i16;
        let pairs: Vec<CodePair> = (0..200).map(|_| [code(), code()]).collect();
        let terms: Vec<Term> =
            (0..TERMS).map(|i| Term { offset: i * 20, codes: [code(), code()], factors: [8, 3] }).collect();
        let (far, near) =
            ([[MAX_CODE; 2]; LANES], Term { offset: 0, codes: [0; 2], factors: [MAX_FACTOR; 2] });
        let mut slow = [7; LANES];
        add_all(&mut slow, &terms, &pairs, portable);
        let mut largest = [0; LANES];
        add_all(&mut largest, &[near; TERMS], &far, portable);
        assert_eq!(largest, [TERMS as u32 * largest_term(MAX_CODE) as u32; LANES]);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            let (mut fast, mut fast_largest) = ([7; LANES], [0; LANES]);
            let add = |sums: &mut _, term: &_, there: &_| avx2(simd, sums, term, there);
            add_all(&mut fast, &terms, &pairs, add);
            add_all(&mut fast_largest, &[near; TERMS], &far, add);
            assert_eq!((fast, fast_largest), (slow, largest));
        }
    }
}
