//! Gaussian noise as a function of position: the same numbers however a plane is cut or divided.
//!
//! A position and a key, that of a seed, a level and a group of components, are hashed to four numbers
//! ([`crate::numeric::hash`]), and each pair of them is made normal by the transform of Box and Muller
//! (1958). Logarithm, sine and cosine are polynomials in single precision with fused multiply-adds and square
//! roots, all of which IEEE 754 rounds exactly: every processor gives the same bits.

use crate::numeric::hash::hash4;

/// Positions processed at a time: enough for compilers to vectorise the loops over them.
pub const BATCH: usize = 256;

/// One number for each position of a block.
pub type Batch<T> = [T; BATCH];

/// Independent standard normal numbers per position.
pub const NUMBERS: usize = 4;

/// Four standard normal numbers for each position under a key.
#[inline(always)]
pub fn normals(xs: &Batch<u32>, ys: &Batch<u32>, key: u64) -> [Batch<f32>; NUMBERS] {
    let [mut a, mut b, mut c, mut d] = [[0u32; BATCH]; 4];
    let (low, high) = (key as u32, (key >> 32) as u32);
    for i in 0..BATCH {
        [a[i], b[i], c[i], d[i]] = hash4([xs[i], ys[i], low, high]);
    }
    let (mut first, mut second) = ([0.0; BATCH], [0.0; BATCH]);
    let (mut third, mut fourth) = ([0.0; BATCH], [0.0; BATCH]);
    for i in 0..BATCH {
        (first[i], second[i]) = box_muller(a[i], b[i]);
    }
    for i in 0..BATCH {
        (third[i], fourth[i]) = box_muller(c[i], d[i]);
    }
    [first, second, third, fourth]
}

/// Two normal numbers from two hashes.
#[inline(always)]
fn box_muller(a: u32, b: u32) -> (f32, f32) {
    // 24 bits in (0, 1): the largest radius is 5.9.
    let unit = ((a >> 8) as i32 as f32 + 0.5) * (1.0 / 16_777_216.0);
    let radius = (-2.0 * ln(unit)).sqrt();
    // Two bits choose the quarter of the circle, 24 the angle within it.
    let turn = (((b >> 6) & 0x00ff_ffff) as i32 as f32 + 0.5) * (1.0 / 16_777_216.0) - 0.5;
    let (sine, cosine) = sin_cos_quarter(turn);
    let swapped = b >> 31 == 1;
    let signed = radius * f32::from_bits(0x3f80_0000 | ((b & 0x4000_0000) << 1));
    (signed * if swapped { sine } else { cosine }, signed * if swapped { cosine } else { sine })
}

/// The natural logarithm of a normal positive number, to about 1e-7 relative to max(1, |ln x|).
#[inline(always)]
fn ln(x: f32) -> f32 {
    // x = m 2^e with m in [sqrt(1/2), sqrt(2)).
    let bits = x.to_bits().wrapping_sub(0x3f35_04f3);
    let exponent = (bits as i32 >> 23) as f32;
    let m = f32::from_bits((bits & 0x007f_ffff) + 0x3f35_04f3);
    // ln m = 2 artanh s, s = (m - 1) / (m + 1), |s| < 0.172: the odd series to the ninth power.
    let s = (m - 1.0) / (m + 1.0);
    let t = s * s;
    let series = t.mul_add(2.0 / 9.0, 2.0 / 7.0).mul_add(t, 2.0 / 5.0).mul_add(t, 2.0 / 3.0).mul_add(t, 2.0);
    exponent.mul_add(std::f32::consts::LN_2, series * s)
}

/// 2 to the power x, to about 2e-7 of its value, for |x| < 126.
#[inline(always)]
pub fn exp2(x: f32) -> f32 {
    // x = n + f with |f| <= 1/2: the Taylor series of exp(f ln 2) to the seventh power.
    let x = x.clamp(-126.0, 126.0);
    let whole = x.round_ties_even();
    let t = (x - whole) * std::f32::consts::LN_2;
    let series = t
        .mul_add(1.0 / 5_040.0, 1.0 / 720.0)
        .mul_add(t, 1.0 / 120.0)
        .mul_add(t, 1.0 / 24.0)
        .mul_add(t, 1.0 / 6.0)
        .mul_add(t, 0.5)
        .mul_add(t, 1.0)
        .mul_add(t, 1.0);
    series * f32::from_bits(((whole as i32 + 127) << 23) as u32)
}

/// Sine and cosine of `turn` quarter circles, |turn| <= 1/2: Taylor series, with an error below 4e-8.
#[inline(always)]
fn sin_cos_quarter(turn: f32) -> (f32, f32) {
    let x = turn * std::f32::consts::FRAC_PI_2;
    let t = x * x;
    let sine = t
        .mul_add(1.0 / 362_880.0, -1.0 / 5_040.0)
        .mul_add(t, 1.0 / 120.0)
        .mul_add(t, -1.0 / 6.0)
        .mul_add(t, 1.0);
    let cosine =
        t.mul_add(1.0 / 40_320.0, -1.0 / 720.0).mul_add(t, 1.0 / 24.0).mul_add(t, -0.5).mul_add(t, 1.0);
    (sine * x, cosine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, key};

    #[test]
    fn elementary_functions_are_near_the_exact_ones() {
        for i in 1..100_000u32 {
            let x = i as f32 / 100_001.0;
            let exact = f64::from(x).ln();
            assert!((f64::from(ln(x)) - exact).abs() < 2e-7 * exact.abs().max(1.0), "ln {x}");
            let power = 60.0 * (x - 0.5);
            let exact = f64::from(power).exp2();
            assert!((f64::from(exp2(power)) - exact).abs() < 3e-7 * exact, "2^{power}");
            let turn = x - 0.5;
            let (sine, cosine) = sin_cos_quarter(turn);
            let angle = f64::from(turn) * std::f64::consts::FRAC_PI_2;
            assert!((f64::from(sine) - angle.sin()).abs() < 2e-7, "sin {turn}");
            assert!((f64::from(cosine) - angle.cos()).abs() < 2e-7, "cos {turn}");
        }
    }

    /// A square of noise: four numbers per position.
    fn square(side: u32, seed: u64, group: u64) -> Vec<[f64; 4]> {
        let key = key(seed, Purpose::FieldNoise, [0, group]);
        let mut numbers = Vec::new();
        for y in 0..side {
            for x in (0..side).step_by(BATCH) {
                let xs = std::array::from_fn(|i| x + i as u32);
                let four = normals(&xs, &[y; BATCH], key);
                numbers.extend((0..BATCH).map(|i| four.map(|block| f64::from(block[i]))));
            }
        }
        numbers
    }

    #[test]
    fn numbers_are_standard_normal_and_independent_of_each_other_and_their_neighbours() {
        const SIDE: usize = 256;
        let (here, there) = (square(SIDE as u32, 0, 0), square(SIDE as u32, 0, 1));
        let n = here.len() as f64;
        let correlation = |f: &dyn Fn(usize) -> f64| (0..here.len()).map(f).sum::<f64>() / n;
        // Five standard errors of a mean of n products.
        let bound = 5.0 / n.sqrt();
        for a in 0..4 {
            let moment = |power: i32| correlation(&|i| here[i][a].powi(power));
            assert!(moment(1).abs() < bound, "mean {}", moment(1));
            assert!((moment(2) - 1.0).abs() < 1.5 * bound, "variance {}", moment(2));
            assert!(moment(3).abs() < 4.0 * bound, "skewness {}", moment(3));
            assert!((moment(4) - 3.0).abs() < 10.0 * bound, "kurtosis {}", moment(4));
            for b in 0..4 {
                if a != b {
                    assert!(correlation(&|i| here[i][a] * here[i][b]).abs() < bound, "numbers {a}, {b}");
                }
                for shift in [1, 2, SIDE, SIDE + 1, 16 * SIDE] {
                    let lag = correlation(&|i| here[i][a] * here[(i + shift) % (SIDE * SIDE)][b]);
                    assert!(lag.abs() < bound, "numbers {a}, {b} at {shift}: {lag}");
                }
                assert!(correlation(&|i| here[i][a] * there[i][b]).abs() < bound, "streams, {a}, {b}");
            }
        }
    }

    #[test]
    fn the_distribution_is_normal_between_every_sixteenth_quantile() {
        // Abramowitz and Stegun's table: the quantiles of the normal distribution at k / 16.
        let quantiles =
            [1.534_120_5, 1.150_349_4, 0.887_146_6, 0.674_489_8, 0.488_776_4, 0.318_639_4, 0.157_310_7];
        let mut edges: Vec<f64> = quantiles.iter().map(|q| -q).chain([0.0]).collect();
        edges.extend(quantiles.iter().rev());
        let mut counts = [0.0f64; 16];
        let numbers = square(256, 9, 3);
        numbers.iter().flatten().for_each(|v| counts[edges.partition_point(|e| e < v)] += 1.0);
        let expected = 4.0 * numbers.len() as f64 / 16.0;
        let chi_square: f64 = counts.iter().map(|c| (c - expected).powi(2) / expected).sum();
        // 15 degrees of freedom: one in a thousand exceeds 37.7.
        assert!(chi_square < 37.7, "{chi_square}");
    }
}
