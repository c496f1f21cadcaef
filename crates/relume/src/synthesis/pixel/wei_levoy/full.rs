//! The search among all neighbourhoods, on several threads, each abandoned once it is too far.

use std::ops::Range;

use super::super::vectors::{self, Vectors};
use crate::parallel;

/// The number of vectors examined by one thread in turn.
const SHARE: usize = 4096;

/// Codes between two checks of the limit.
const PATIENCE: usize = 32;

/// All neighbourhoods of a level.
#[derive(Debug, Clone, Copy)]
pub struct Full<'a> {
    /// Their vectors.
    pub vectors: &'a Vectors,
}

impl Full<'_> {
    /// The number of the nearest vector, the first among equals, and its squared distance.
    ///
    /// # Panics
    /// When there is no vector.
    pub fn nearest(&self, query: &[i16]) -> (usize, u64) {
        let count = self.vectors.count();
        let near = parallel::map(0..count.div_ceil(SHARE), |share| {
            let range = share * SHARE..((share + 1) * SHARE).min(count);
            #[cfg(target_arch = "x86_64")]
            if let Some(simd) = pulp::x86::V3::try_new() {
                return simd.vectorize(
                    #[inline(always)]
                    || self.nearest_of(range, query, |a, b| vectors::avx2(simd, a, b)),
                );
            }
            self.nearest_of(range, query, vectors::portable)
        });
        let (distance, number) = near.into_iter().min().expect("there is a vector");
        (number, distance)
    }

    #[inline(always)]
    fn nearest_of(
        &self,
        range: Range<usize>,
        query: &[i16],
        squared_distance: impl Fn(&[i16], &[i16]) -> u64,
    ) -> (u64, usize) {
        let mut near = (u64::MAX, usize::MAX);
        for number in range {
            let parts = self.vectors.row(number).chunks(PATIENCE).zip(query.chunks(PATIENCE));
            let mut distance = 0;
            for (a, b) in parts {
                distance += squared_distance(a, b);
                if distance >= near.0 {
                    break;
                }
            }
            if distance < near.0 {
                near = (distance, number);
            }
        }
        near
    }
}
