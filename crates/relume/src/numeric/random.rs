//! Random numbers from a seed, a purpose and a place: the only derivation.
//!
//! A stream is ChaCha with 8 rounds (D. J. Bernstein, "ChaCha, a variant of Salsa20", 2008). Its 256-bit key
//! is the seed followed by the integers of the place; its 64-bit nonce is the [`Purpose`] and the number of
//! integers of the place. So different (seed, purpose, place) are different inputs of the cipher by
//! construction, whatever their values: level 1 under seed 0 has nothing in common with level 0 under seed 1.
//! Nothing depends on the order of work.
//! 1. Nothing depends on the order of work.
//!
//! Where numbers are needed at arbitrary positions of a plane, or in a shader, [`key`] gives the seed of an
//! integer hash ([`crate::numeric::hash`]) for one purpose.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The purposes of random numbers. Each has its own numbers under the same seed.
///
/// The discriminants are part of the meaning of a seed: append new ones, never renumber.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Purpose {
    /// Data of tests, benchmarks and examples. Place: any.
    Sample = 0,
    /// The choice of a candidate for a block of image quilting. Place: the number of the block.
    Block = 1,
    /// The first texels of growth. Place: none.
    FirstTexels = 2,
    /// Ties in the order of growth. Place: the texel.
    GrowthOrder = 3,
    /// The choice of a fitting window for a growing texel. Place: the texel.
    GrownTexel = 4,
    /// The random initialisation of PatchMatch. Place: level, patch; or level, texel, 0 for a patch to replace one with
    /// excluded texels.
    FirstPatch = 5,
    /// The random search of PatchMatch, by [`key`]. Place: level, round.
    PatchSearch = 6,
    /// The initial noise of scanlines. Place: level, row.
    ScanlineNoise = 7,
    /// Candidates of a scanline texel that continues nothing. Place: level, texel.
    ScanlineCandidates = 8,
    /// Cells from which projection kernels are learned. Place: the side of a cell.
    KernelSamples = 9,
    /// The initial vectors of the iteration for singular vectors. Place: their length.
    KernelStart = 10,
    /// The part of the exemplar at each vertex of blended noise, by [`key`]. Place: none.
    NoiseVertices = 11,
    /// The Gaussian noise of a random field, by [`key`]. Place: level, group of components.
    FieldNoise = 12,
    /// The positions of the patches of the sliced Wasserstein distance. Place: level.
    MeasuredPatches = 13,
    /// The directions of the sliced Wasserstein distance. Place: level, direction.
    MeasuredDirections = 14,
    /// The seeds of further rounds of tries, by [`key`]. Place: the round.
    Tries = 15,
    /// The seed for another attempt at a texture that was a copy, by [`key`]. Place: none.
    CopiedAgain = 16,
    /// The places of the windows of the repetition measure. Place: none.
    MeasuredWindows = 17,
    /// The order of the shuffled texels to which a model is compared. Place: none.
    ShuffledTexels = 18,
    /// The element of a cell of laid elements. Place: the cell.
    Elements = 19,
    /// The random matrix that begins the factorisation of photographs. Place: the photograph.
    FactorSketch = 20,
    /// The directions of a virtual gonioreflectometer that keep apart. Place: their number.
    SpreadDirections = 21,
    /// Independent pairs of directions. Place: the number of the pair.
    RandomDirections = 22,
    /// The directions drawn from an environment at a point of a picture. Place: column, line of the sample.
    EnvironmentSamples = 23,
    /// The texels from which clusters of texels begin. Place: none.
    ClusterSeeds = 24,
    /// The photographs from which clusters of photographs begin. Place: none.
    PhotographClusters = 25,
    /// The vectors from which the factorisation of a texel begins. Place: the vector.
    TexelFactors = 26,
    /// The strength of the detail of a random field, by [`key`]. Place: level.
    FieldStrength = 27,
}

/// The most integers of a place.
const PARTS: usize = 3;

/// A stream of random numbers that belongs to one place of the work, such as a block.
#[derive(Debug, Clone)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of a purpose at a place, of at most three integers, under a seed.
    pub fn new<const N: usize>(seed: u64, purpose: Purpose, place: [u64; N]) -> Self {
        const { assert!(N <= PARTS, "a place has at most three integers") };
        let mut bytes = [0; 8 * (1 + PARTS)];
        for (bytes, part) in bytes.chunks_exact_mut(8).zip(std::iter::once(seed).chain(place)) {
            bytes.copy_from_slice(&part.to_le_bytes());
        }
        let mut generator = ChaCha8Rng::from_seed(bytes);
        generator.set_stream((N as u64) << 32 | u64::from(purpose as u32));
        Self(generator)
    }

    /// A number below `n`, all equally likely up to 2^-64 n.
    ///
    /// # Panics
    /// When `n` is zero.
    pub fn below(&mut self, n: usize) -> usize {
        assert!(n > 0, "a choice needs at least one candidate");
        ((u128::from(self.0.next_u64()) * n as u128) >> 64) as usize
    }

    /// A number in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A normal number of mean 0 and variance 1 (G. Box, M. Muller, A note on the generation of random normal deviates, 1958).
    pub fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.unit()).ln()).sqrt() * (std::f64::consts::TAU * self.unit()).cos()
    }
}

/// The first 64 bits of a stream: the seed of a hash for one purpose.
pub fn key<const N: usize>(seed: u64, purpose: Purpose, place: [u64; N]) -> u64 {
    Stream::new(seed, purpose, place).0.next_u64()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::HashSet;

    #[test]
    fn streams_depend_on_seed_purpose_and_place_only() {
        let draw = |seed, purpose, place| {
            let mut stream = Stream::new(seed, purpose, [place]);
            (0..4).map(|_| stream.below(1000)).collect::<Vec<_>>()
        };
        assert_eq!(draw(1, Purpose::Block, 2), draw(1, Purpose::Block, 2));
        assert_ne!(draw(1, Purpose::Block, 2), draw(1, Purpose::Block, 3));
        assert_ne!(draw(1, Purpose::Block, 2), draw(2, Purpose::Block, 2));
        assert_ne!(draw(1, Purpose::Block, 2), draw(1, Purpose::GrownTexel, 2));
        assert!((0..100).all(|place| Stream::new(0, Purpose::Block, [place]).below(3) < 3));
        assert!((0..100).all(|place| (0.0..1.0).contains(&Stream::new(0, Purpose::Block, [place]).unit())));
    }

    /// A former fault: seeds and levels were added, so both gave the same numbers.
    #[test]
    fn level_1_of_seed_0_is_not_level_0_of_seed_1() {
        assert_ne!(key(0, Purpose::ScanlineNoise, [1, 7]), key(1, Purpose::ScanlineNoise, [0, 7]));
        assert_ne!(key(0, Purpose::PatchSearch, [1, 0]), key(0, Purpose::PatchSearch, [0, 1]));
        assert_ne!(key(0, Purpose::Tries, [1]), key(1, Purpose::Tries, [0]));
    }

    /// A former fault: the noise of scanline 7 and the candidates of texel 7 were the same numbers.
    #[test]
    fn places_of_different_lengths_and_purposes_are_different() {
        let seeds = [0, 1, 2, u64::MAX];
        let purposes = [Purpose::Sample, Purpose::Block, Purpose::ScanlineNoise, Purpose::ScanlineCandidates];
        let mut all = HashSet::new();
        let mut count = 0;
        for (seed, purpose) in seeds.iter().flat_map(|s| purposes.map(|p| (*s, p))) {
            count += 1;
            all.insert(key(seed, purpose, []));
            for a in 0..8 {
                count += 1;
                all.insert(key(seed, purpose, [a]));
                for b in 0..8 {
                    count += 2;
                    all.insert(key(seed, purpose, [a, b]));
                    all.insert(key(seed, purpose, [a, b, 0]));
                }
            }
        }
        assert_eq!(all.len(), count);
    }

    proptest! {
        #[test]
        fn different_derivations_have_different_keys(
            (a, b) in (any::<(u64, [u64; 3])>(), any::<(u64, [u64; 3])>()),
            part in 0usize..4,
            bit in 0u32..64,
        ) {
            let of = |(seed, place): (u64, [u64; 3])| key(seed, Purpose::Sample, place);
            prop_assert_eq!(a == b, of(a) == of(b));
            // One bit apart.
            let mut near = a;
            match part {
                0 => near.0 ^= 1 << bit,
                k => near.1[k - 1] ^= 1 << bit,
            }
            let flipped = (of(a) ^ of(near)).count_ones();
            // Seven standard deviations of 64 fair coins.
            prop_assert!((4..=60).contains(&flipped), "{flipped} bits differ");
        }
    }

    #[test]
    fn neighbouring_seeds_purposes_and_places_are_uncorrelated() {
        const N: u64 = 4096;
        let unit = |seed, purpose, place: [u64; 2]| Stream::new(seed, purpose, place).unit() - 0.5;
        let here: Vec<f64> = (0..N).map(|i| unit(0, Purpose::Block, [i, 0])).collect();
        let beside: [&dyn Fn(u64) -> f64; 4] = [
            &|i| unit(0, Purpose::Block, [i + 1, 0]),
            &|i| unit(0, Purpose::Block, [i, 1]),
            &|i| unit(1, Purpose::Block, [i, 0]),
            &|i| unit(0, Purpose::GrowthOrder, [i, 0]),
        ];
        for there in beside {
            let products = here.iter().zip(0..).map(|(here, i)| 12.0 * here * there(i));
            let correlation = products.sum::<f64>() / N as f64;
            // Five standard errors.
            assert!(correlation.abs() < 5.0 / (N as f64).sqrt(), "{correlation}");
        }
    }
}
