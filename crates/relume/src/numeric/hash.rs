//! A hash of four 32-bit integers that a shader computes as well: random access to random numbers.
//!
//! `pcg4d` of Jarzynski, Olano, "Hash Functions for GPU Rendering", Journal of Computer Graphics
//! Techniques 9(3), 2020. All arithmetic is modulo 2^32, so GLSL's `uvec4` gives the same numbers.

/// Four well-mixed integers from four integers.
pub fn hash4(v: [u32; 4]) -> [u32; 4] {
    let mut v = v.map(|n| n.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    mix(&mut v);
    v = v.map(|n| n ^ (n >> 16));
    mix(&mut v);
    v
}

fn mix(v: &mut [u32; 4]) {
    for (to, a, b) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
        v[to] = v[to].wrapping_add(v[a].wrapping_mul(v[b]));
    }
}

/// The hash of a place of a plane under a seed. Places repeat after 2^32 steps along either axis.
pub fn of_place(seed: u64, x: i64, y: i64) -> [u32; 4] {
    hash4([x as u32, y as u32, seed as u32, (seed >> 32) as u32])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computed with the integers of another language from the published text. Stored tile sets and
    /// shaders rely on these values.
    #[test]
    fn values_never_change() {
        assert_eq!(of_place(0, 0, 0), [251_852_841, 760_645_481, 850_445_371, 3_542_436_074]);
        assert_eq!(hash4([1, 2, 3, 4]), [908_250_390, 4_044_648_920, 3_775_961_919, 45_698_095]);
        assert_eq!(of_place(7, -1, 0), [2_395_048_126, 1_075_944_660, 2_968_998_345, 1_749_744_091]);
        assert_ne!(of_place(0, -1, 0), of_place(0, 1, 0));
        assert_ne!(of_place(1, 5, 7), of_place(1 << 32, 5, 7));
    }

    #[test]
    fn every_bit_is_set_half_of_the_time_and_neighbours_differ() {
        let mut counts = [[0u32; 32]; 4];
        let mut flips = 0;
        for place in 0..4096i64 {
            let (here, beside) =
                (of_place(7, place % 64, place / 64), of_place(7, place % 64 + 1, place / 64));
            for (count, n) in counts.iter_mut().zip(here) {
                count.iter_mut().enumerate().for_each(|(bit, c)| *c += n >> bit & 1);
            }
            flips += here.iter().zip(beside).map(|(a, b)| (a ^ b).count_ones()).sum::<u32>();
        }
        // Six standard deviations of a fair coin: 6 * sqrt(4096) / 2.
        assert!(counts.iter().flatten().all(|c| c.abs_diff(2048) < 192), "{counts:?}");
        assert!((f64::from(flips) / 4096.0 - 64.0).abs() < 1.0, "{flips}");
    }
}
