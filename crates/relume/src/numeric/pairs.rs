//! Products of small integers added in groups into 32-bit sums: the operation that dominates the time of all
//! exact searches.
//!
//! Processors have instructions for it: VPDPWSSD and VPDPBUSD (AVX-512 VNNI) for 32 products of words or 64
//! of bytes at a time, VPMADDWD (AVX2) for 16 of words. A piece of [`PairsWork`] is written once over
//! [`Pairs`]; [`dispatch`] compiles it for each of them and portably. Since the arithmetic is on integers,
//! all give the same sums.

#[cfg(target_arch = "x86_64")]
use archmage::{SimdToken, X64V3Token, X64V4xToken};

/// Sums kept at a time.
pub const SUMS: usize = 16;

/// Words taken at a time: two for each sum.
pub const FACTORS: usize = 2 * SUMS;

/// Bytes taken at a time: four for each sum.
pub const BYTES: usize = 4 * SUMS;

/// Sums of products; they wrap around beyond 32 bits.
pub type Sums = [i32; SUMS];

/// The multiply-add operation of a processor.
pub trait Pairs: Copy + Sync {
    /// `sums[i] + a[2 i] b[2 i] + a[2 i + 1] b[2 i + 1]`.
    fn multiply_add(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums;

    /// `sums[i] + a[4 i] b[4 i] + ... + a[4 i + 3] b[4 i + 3]`.
    fn multiply_add_bytes(self, sums: Sums, a: &[u8; BYTES], b: &[i8; BYTES]) -> Sums;

    /// Adds to `sums[i]` the squares of its two differences `a - b` where `mask` is all ones; where it is
    /// zero, adds nothing. Differences must fit 16 bits.
    fn add_squares(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS], mask: &[i16; FACTORS]) -> Sums;

    /// Bit i tells whether `sums[i]` is at least `floor`.
    fn at_least(self, sums: &Sums, floor: i32) -> u16;
}

/// Work to be done with the [`Pairs`] of the processor.
pub trait PairsWork {
    /// The result.
    type Output;

    /// Does the work. Mark implementations `#[inline(always)]`, so that they are compiled for `pairs`.
    fn with<P: Pairs>(self, pairs: P) -> Self::Output;
}

/// Does a piece of work in the best instructions available.
#[inline]
pub fn dispatch<W: PairsWork>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(vnni) = X64V4xToken::summon() {
            return x86::with_vnni(vnni, work);
        }
        if let Some(avx2) = X64V3Token::summon() {
            return x86::with_avx2(avx2, work);
        }
    }
    work.with(PortablePairs)
}

/// Plain Rust, for any processor; the reference for the others.
#[derive(Debug, Clone, Copy)]
pub struct PortablePairs;

impl Pairs for PortablePairs {
    #[inline(always)]
    fn multiply_add(self, mut sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums {
        for (i, sum) in sums.iter_mut().enumerate() {
            let product = |j: usize| i32::from(a[j]).wrapping_mul(i32::from(b[j]));
            *sum = sum.wrapping_add(product(2 * i)).wrapping_add(product(2 * i + 1));
        }
        sums
    }

    #[inline(always)]
    fn multiply_add_bytes(self, mut sums: Sums, a: &[u8; BYTES], b: &[i8; BYTES]) -> Sums {
        for (i, sum) in sums.iter_mut().enumerate() {
            let product = |j: usize| i32::from(a[j]) * i32::from(b[j]);
            *sum = (4 * i..4 * i + 4).fold(*sum, |sum, j| sum.wrapping_add(product(j)));
        }
        sums
    }

    #[inline(always)]
    fn add_squares(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS], mask: &[i16; FACTORS]) -> Sums {
        let differences = std::array::from_fn(|i| a[i].wrapping_sub(b[i]) & mask[i]);
        self.multiply_add(sums, &differences, &differences)
    }

    #[inline(always)]
    fn at_least(self, sums: &Sums, floor: i32) -> u16 {
        sums.iter().enumerate().fold(0, |bits, (i, sum)| bits | (u16::from(*sum >= floor) << i))
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use archmage::{X64V3Token, X64V4xToken, arcane};
    use bytemuck::must_cast as cast;

    use super::{BYTES, FACTORS, Pairs, PairsWork, SUMS, Sums};

    /// Does a piece of work in AVX-512 with VNNI.
    #[arcane]
    pub fn with_vnni<W: PairsWork>(vnni: X64V4xToken, work: W) -> W::Output {
        work.with(vnni)
    }

    /// Does a piece of work in AVX2.
    #[arcane]
    pub fn with_avx2<W: PairsWork>(avx2: X64V3Token, work: W) -> W::Output {
        work.with(avx2)
    }

    impl Pairs for X64V4xToken {
        #[arcane(import_intrinsics, _self = X64V4xToken)]
        fn multiply_add(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums {
            cast(_mm512_dpwssd_epi32(cast(sums), cast(*a), cast(*b)))
        }

        #[arcane(import_intrinsics, _self = X64V4xToken)]
        fn multiply_add_bytes(self, sums: Sums, a: &[u8; BYTES], b: &[i8; BYTES]) -> Sums {
            cast(_mm512_dpbusd_epi32(cast(sums), cast(*a), cast(*b)))
        }

        #[arcane(import_intrinsics, _self = X64V4xToken)]
        fn add_squares(
            self,
            sums: Sums,
            a: &[i16; FACTORS],
            b: &[i16; FACTORS],
            mask: &[i16; FACTORS],
        ) -> Sums {
            let differences = _mm512_and_si512(_mm512_sub_epi16(cast(*a), cast(*b)), cast(*mask));
            cast(_mm512_dpwssd_epi32(cast(sums), differences, differences))
        }

        #[arcane(import_intrinsics, _self = X64V4xToken)]
        fn at_least(self, sums: &Sums, floor: i32) -> u16 {
            _mm512_cmpge_epi32_mask(cast(*sums), _mm512_set1_epi32(floor))
        }
    }

    impl Pairs for X64V3Token {
        #[arcane(import_intrinsics, _self = X64V3Token)]
        fn multiply_add(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums {
            let [a, b]: [[__m256i; 2]; 2] = [cast(*a), cast(*b)];
            let [first, second]: [__m256i; 2] = cast(sums);
            cast([
                _mm256_add_epi32(first, _mm256_madd_epi16(a[0], b[0])),
                _mm256_add_epi32(second, _mm256_madd_epi16(a[1], b[1])),
            ])
        }

        /// Converted to words, those of even and odd positions separately.
        #[arcane(import_intrinsics, _self = X64V3Token)]
        fn multiply_add_bytes(self, sums: Sums, a: &[u8; BYTES], b: &[i8; BYTES]) -> Sums {
            let [a, b]: [[__m256i; 2]; 2] = [cast(*a), cast(*b)];
            let mut sums: [__m256i; 2] = cast(sums);
            for i in 0..2 {
                let even = _mm256_madd_epi16(
                    _mm256_and_si256(a[i], _mm256_set1_epi16(0xff)),
                    _mm256_srai_epi16::<8>(_mm256_slli_epi16::<8>(b[i])),
                );
                let odd = _mm256_madd_epi16(_mm256_srli_epi16::<8>(a[i]), _mm256_srai_epi16::<8>(b[i]));
                sums[i] = _mm256_add_epi32(sums[i], _mm256_add_epi32(even, odd));
            }
            cast(sums)
        }

        #[arcane(import_intrinsics, _self = X64V3Token)]
        fn add_squares(
            self,
            sums: Sums,
            a: &[i16; FACTORS],
            b: &[i16; FACTORS],
            mask: &[i16; FACTORS],
        ) -> Sums {
            let [a, b, mask]: [[__m256i; 2]; 3] = [cast(*a), cast(*b), cast(*mask)];
            let mut sums: [__m256i; 2] = cast(sums);
            for i in 0..2 {
                let differences = _mm256_and_si256(_mm256_sub_epi16(a[i], b[i]), mask[i]);
                sums[i] = _mm256_add_epi32(sums[i], _mm256_madd_epi16(differences, differences));
            }
            cast(sums)
        }

        #[arcane(import_intrinsics, _self = X64V3Token)]
        fn at_least(self, sums: &Sums, floor: i32) -> u16 {
            let [first, second]: [__m256i; 2] = cast(*sums);
            let floor = _mm256_set1_epi32(floor);
            let below = [_mm256_cmpgt_epi32(floor, first), _mm256_cmpgt_epi32(floor, second)];
            let [first, second] = [below[0], below[1]].map(|lanes| _mm256_movemask_ps(cast(lanes)) as u16);
            !(first | (second << (SUMS / 2)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    #[cfg(target_arch = "x86_64")]
    use archmage::SimdToken;

    /// Sums and their comparison for random factors.
    struct Sample(u64);

    impl PairsWork for &Sample {
        type Output = (Sums, u16);

        #[inline(always)]
        fn with<P: Pairs>(self, pairs: P) -> Self::Output {
            let mut stream = Stream::new(self.0, Purpose::Sample, [0]);
            let mut sums = [0; SUMS];
            for _ in 0..3 {
                let mut factors = || std::array::from_fn(|_| stream.below(1 << 16) as u16 as i16);
                let (a, b, mask) = (factors(), factors(), factors());
                sums = pairs.multiply_add(sums, &a, &b);
                sums = pairs.multiply_add_bytes(sums, &bytemuck::must_cast(a), &bytemuck::must_cast(b));
                sums = pairs.add_squares(sums, &a.map(|a| a / 2), &b.map(|b| b / 2), &mask.map(|m| m >> 15));
            }
            sums[3] = 17;
            (sums, pairs.at_least(&sums, 17))
        }
    }

    #[test]
    fn all_instructions_give_the_same_sums() {
        for seed in 0..100 {
            let truth = Sample(seed).with(PortablePairs);
            assert_eq!(dispatch(&Sample(seed)), truth);
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = archmage::X64V3Token::summon() {
                assert_eq!(Sample(seed).with(avx2), truth);
            }
            let (sums, bits) = truth;
            (0..SUMS).for_each(|i| assert_eq!(bits >> i & 1 == 1, sums[i] >= 17));
        }
    }
}
