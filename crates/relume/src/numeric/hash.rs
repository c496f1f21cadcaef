//! A hash of four 32-bit integers that a shader can compute as well: random access to random numbers.
//!
//! `pcg4d` of Jarzynski, Olano, "Hash Functions for GPU Rendering", Journal of Computer Graphics
//! Techniques 9(3), 2020. All arithmetic is modulo 2^32, so GLSL's `uvec4` gives the same numbers.

/// Four well-mixed integers from four integers: a linear congruential step, then two rounds of mixing
/// products. Written out so that loops over many positions vectorise.
#[inline(always)]
pub fn hash4(v: [u32; 4]) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = v.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w] = [x ^ (x >> 16), y ^ (y >> 16), z ^ (z >> 16), w ^ (w >> 16)];
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    [x, y, z, w]
}

/// The hash of a position of a plane under a key. Positions repeat after 2^32 steps along either axis.
///
/// A key belongs to one purpose ([`crate::numeric::random::key`]). The exception is the tiles of an endless
/// plane, whose key is the seed itself, as `docs/formats.md` promises to readers of tile sets and models.
pub fn of_place(key: u64, x: i64, y: i64) -> [u32; 4] {
    hash4([x as u32, y as u32, key as u32, (key >> 32) as u32])
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
