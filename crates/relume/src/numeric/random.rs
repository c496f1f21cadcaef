//! Random streams that depend on the seed and a place, never on the order of work.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A stream of random numbers that belongs to one place of the work, such as a block.
#[derive(Debug, Clone)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The stream of `place` under `seed`.
    pub fn new(seed: u64, place: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(place);
        Self(generator)
    }

    /// A number below `n`, each equally likely up to 2^-64 n.
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
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_depend_on_seed_and_place_only() {
        let draw = |seed, place| {
            (0..4)
                .map({
                    let mut s = Stream::new(seed, place);
                    move |_| s.below(1000)
                })
                .collect::<Vec<_>>()
        };
        assert_eq!(draw(1, 2), draw(1, 2));
        assert_ne!(draw(1, 2), draw(1, 3));
        assert_ne!(draw(1, 2), draw(2, 2));
        assert!((0..100).all(|place| Stream::new(0, place).below(3) < 3));
        assert!((0..100).all(|place| (0.0..1.0).contains(&Stream::new(0, place).unit())));
    }
}
