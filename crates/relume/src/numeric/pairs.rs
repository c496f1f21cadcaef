//! Products of 16-bit integers added in pairs into 32-bit sums: the one operation in which all exact
//! searches spend their time.
//!
//! Processors have an instruction for it: VPDPWSSD (AVX-512 VNNI) for 32 products at a time,
//! VPMADDWD (AVX2) for 16. A piece of [`Work`] is written once over [`Pairs`] and [`dispatch`]
//! compiles it for each of them and portably; being integers, all give the same sums.

/// Sums kept at a time.
pub const SUMS: usize = 16;

/// Factors taken at a time: two for each sum.
pub const FACTORS: usize = 2 * SUMS;

/// Sums of pairs of products; they wrap around beyond 32 bits.
pub type Sums = [i32; SUMS];

/// A processor's way to multiply and add.
pub trait Pairs: Copy + Sync {
    /// `sums[i] + a[2 i] b[2 i] + a[2 i + 1] b[2 i + 1]`.
    fn multiply_add(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums;

    /// `sums[i]` and the squares of the two differences `a - b` that fall to it, where `mask` is all
    /// ones; where it is zero, nothing. Differences must fit 16 bits.
    fn add_squares(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS], mask: &[i16; FACTORS]) -> Sums;

    /// Bit i tells whether `sums[i]` is at least `floor`.
    fn at_least(self, sums: &Sums, floor: i32) -> u16;
}

/// Something to do with whichever [`Pairs`] the processor has.
pub trait Work {
    /// What it gives.
    type Output;

    /// Does it. Mark implementations `#[inline(always)]`, so that they are compiled for `pairs`.
    fn with<P: Pairs>(self, pairs: P) -> Self::Output;
}

/// Does a piece of work in the best instructions there are.
#[inline]
pub fn dispatch<W: Work>(work: W) -> W::Output {
    #[cfg(target_arch = "x86_64")]
    {
        if let Some(vnni) = x86::Vnni::try_new() {
            return vnni.vectorize(
                #[inline(always)]
                || work.with(vnni),
            );
        }
        if let Some(avx2) = pulp::x86::V3::try_new() {
            return avx2.vectorize(
                #[inline(always)]
                || work.with(avx2),
            );
        }
    }
    work.with(Portable)
}

/// Plain Rust, for any processor; the truth of the others.
#[derive(Debug, Clone, Copy)]
pub struct Portable;

impl Pairs for Portable {
    #[inline(always)]
    fn multiply_add(self, mut sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums {
        for (i, sum) in sums.iter_mut().enumerate() {
            let product = |j: usize| i32::from(a[j]).wrapping_mul(i32::from(b[j]));
            *sum = sum.wrapping_add(product(2 * i)).wrapping_add(product(2 * i + 1));
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
    use super::{FACTORS, Pairs, SUMS, Sums};
    use pulp::x86::V3;
    use std::arch::x86_64::{__m256i, __m512i};

    pulp::simd_type!({
        /// Tells that the processor has AVX-512 with the VNNI extension.
        #[allow(missing_docs, reason = "each field names the instruction set that it stands for")]
        pub struct Vnni {
            pub avx: f!("avx"),
            pub avx2: f!("avx2"),
            pub bmi1: f!("bmi1"),
            pub bmi2: f!("bmi2"),
            pub fma: f!("fma"),
            pub popcnt: f!("popcnt"),
            pub avx512f: f!("avx512f"),
            pub avx512bw: f!("avx512bw"),
            pub avx512dq: f!("avx512dq"),
            pub avx512vl: f!("avx512vl"),
            pub avx512vnni: f!("avx512vnni"),
        }
    });

    impl Pairs for Vnni {
        /// The compiler joins the two instructions to VPDPWSSD.
        #[inline(always)]
        fn multiply_add(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums {
            let products: __m512i = self.avx512bw._mm512_madd_epi16(pulp::cast(*a), pulp::cast(*b));
            pulp::cast(self.avx512f._mm512_add_epi32(pulp::cast(sums), products))
        }

        #[inline(always)]
        fn add_squares(
            self,
            sums: Sums,
            a: &[i16; FACTORS],
            b: &[i16; FACTORS],
            mask: &[i16; FACTORS],
        ) -> Sums {
            let differences = self.avx512bw._mm512_sub_epi16(pulp::cast(*a), pulp::cast(*b));
            let differences = pulp::cast(self.avx512f._mm512_and_si512(differences, pulp::cast(*mask)));
            self.multiply_add(sums, &differences, &differences)
        }

        #[inline(always)]
        fn at_least(self, sums: &Sums, floor: i32) -> u16 {
            let floor = self.avx512f._mm512_set1_epi32(floor);
            self.avx512f._mm512_cmpge_epi32_mask(pulp::cast(*sums), floor)
        }
    }

    impl Pairs for V3 {
        #[inline(always)]
        fn multiply_add(self, sums: Sums, a: &[i16; FACTORS], b: &[i16; FACTORS]) -> Sums {
            let [a, b]: [[__m256i; 2]; 2] = [pulp::cast(*a), pulp::cast(*b)];
            let sums: [__m256i; 2] = pulp::cast(sums);
            pulp::cast([0, 1].map(
                #[inline(always)]
                |i| self.avx2._mm256_add_epi32(sums[i], self.avx2._mm256_madd_epi16(a[i], b[i])),
            ))
        }

        #[inline(always)]
        fn add_squares(
            self,
            sums: Sums,
            a: &[i16; FACTORS],
            b: &[i16; FACTORS],
            mask: &[i16; FACTORS],
        ) -> Sums {
            let [a, b, mask]: [[__m256i; 2]; 3] = [pulp::cast(*a), pulp::cast(*b), pulp::cast(*mask)];
            let differences: [__m256i; 2] = [0, 1].map(
                #[inline(always)]
                |i| self.avx2._mm256_and_si256(self.avx2._mm256_sub_epi16(a[i], b[i]), mask[i]),
            );
            let differences = pulp::cast(differences);
            self.multiply_add(sums, &differences, &differences)
        }

        #[inline(always)]
        fn at_least(self, sums: &Sums, floor: i32) -> u16 {
            let halves: [__m256i; 2] = pulp::cast(*sums);
            let floor = self.avx._mm256_set1_epi32(floor);
            let below = |half: __m256i| {
                let lanes = self.avx2._mm256_cmpgt_epi32(floor, half);
                self.avx._mm256_movemask_ps(pulp::cast(lanes)) as u16
            };
            !(below(halves[0]) | (below(halves[1]) << (SUMS / 2)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::Stream;

    /// Sums and their comparison for random factors.
    struct Sample(u64);

    impl Work for &Sample {
        type Output = (Sums, u16);

        #[inline(always)]
        fn with<P: Pairs>(self, pairs: P) -> Self::Output {
            let mut stream = Stream::new(self.0, 0);
            let mut sums = [0; SUMS];
            for _ in 0..3 {
                let mut factors = || std::array::from_fn(|_| stream.below(1 << 16) as u16 as i16);
                let (a, b, mask) = (factors(), factors(), factors());
                sums = pairs.multiply_add(sums, &a, &b);
                sums = pairs.add_squares(sums, &a.map(|a| a / 2), &b.map(|b| b / 2), &mask.map(|m| m >> 15));
            }
            sums[3] = 17;
            (sums, pairs.at_least(&sums, 17))
        }
    }

    #[test]
    fn all_instructions_give_the_same_sums() {
        for seed in 0..100 {
            let truth = Sample(seed).with(Portable);
            assert_eq!(dispatch(&Sample(seed)), truth);
            #[cfg(target_arch = "x86_64")]
            if let Some(avx2) = pulp::x86::V3::try_new() {
                assert_eq!(Sample(seed).with(avx2), truth);
            }
            let (sums, bits) = truth;
            (0..SUMS).for_each(|i| assert_eq!(bits >> i & 1 == 1, sums[i] >= 17));
        }
    }
}
