//! The 8-bit sRGB encoding of many values at once, without tables or branches.
//!
//! Above the linear toe the encoding is 1.055 x^(5/12) - 0.055. With t = x^(1/4), two square roots, x^(5/12)
//! = t^(5/3) is smooth on [0.2365, 1] and is approximated by a polynomial of degree 6. The coefficients come
//! from interpolation at Chebyshev nodes, which a test repeats. The result differs from the exact encoding by
//! less than 0.001 of a code before rounding, so a code is at most 0.501 away from the exact value, and every
//! 8-bit code survives conversion to linear and back. Only additions, multiplications and square roots are
//! used, which are correctly rounded everywhere: the codes do not depend on the instruction set.

use pulp::{Simd, WithSimd};

use crate::space::Space;

/// t^(5/3) on [0.0031308^(1/4), 1] in powers of t, from the constant on.
const POWER_5_3: [f32; 7] =
    [-0.004_491_954, 0.134_557_6, 1.283_955_1, -0.782_255_94, 0.588_627_76, -0.278_907_7, 0.058_515_93];

/// Adding 2^23 to a number in 0..=255 leaves its rounded value in the lowest bits.
const ROUNDER: f32 = 8_388_608.0;

/// Encodes linear values as sRGB codes. Values outside 0..1 and NaN are clamped (NaN to 0).
///
/// # Panics
/// When the slices differ in length.
pub fn srgb8_from_linear(linear: &[f32], codes: &mut [u8]) {
    assert_eq!(linear.len(), codes.len(), "one code a value");
    pulp::Arch::new().dispatch(Encode { linear, codes });
}

struct Encode<'a> {
    linear: &'a [f32],
    codes: &'a mut [u8],
}

impl WithSimd for Encode<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        encode(Space::Linear, self.linear, self.codes);
    }
}

/// The same for values of either space, inlined into the caller's vector code.
#[inline(always)]
pub(super) fn encode(space: Space, values: &[f32], codes: &mut [u8]) {
    match space {
        Space::Linear => {
            codes.iter_mut().zip(values).for_each(|(code, &v)| *code = code_of(encoded(unit(v))))
        }
        Space::Srgb => codes.iter_mut().zip(values).for_each(|(code, &v)| *code = code_of(unit(v))),
    }
}

/// Clamped to 0..1; the comparisons are written so that NaN becomes 0.
#[inline(always)]
fn unit(v: f32) -> f32 {
    let v = if v > 0.0 { v } else { 0.0 };
    if v < 1.0 { v } else { 1.0 }
}

#[inline(always)]
fn code_of(encoded: f32) -> u8 {
    (encoded * 255.0 + ROUNDER).to_bits() as u8
}

#[inline(always)]
fn encoded(v: f32) -> f32 {
    let t = v.sqrt().sqrt();
    let power = POWER_5_3.iter().rev().fold(0.0, |sum, c| sum * t + c);
    if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * power - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::matrix::{Matrix, Qr};
    use crate::space::{linear_from_srgb8, srgb_from_linear};

    fn codes(linear: &[f32]) -> Vec<u8> {
        let mut codes = vec![7; linear.len()];
        srgb8_from_linear(linear, &mut codes);
        codes
    }

    #[test]
    fn codes_are_within_half_a_code_of_the_exact_encoding() {
        let values: Vec<f32> = (0..=0x3f80_0000u32).step_by(97).map(f32::from_bits).collect();
        for (&v, code) in values.iter().zip(codes(&values)) {
            let error = (f64::from(srgb_from_linear(v)) * 255.0 - f64::from(code)).abs();
            assert!(error <= 0.501, "{v} became {code}, off by {error}");
        }
    }

    #[test]
    fn every_code_survives_and_odd_values_are_clamped() {
        assert_eq!(codes(&linear_from_srgb8()), (0..=255).collect::<Vec<u8>>());
        let odd = [f32::NAN, -1.0, -0.0, f32::NEG_INFINITY, f32::INFINITY, 3.0, f32::MIN_POSITIVE / 4.0];
        assert_eq!(codes(&odd), [0, 0, 0, 0, 255, 255, 0]);
    }

    #[test]
    fn the_polynomial_is_the_chebyshev_interpolant() {
        let n = POWER_5_3.len();
        let least = 0.003_130_8f64.powf(0.25);
        let node = |i: usize| {
            let c = (std::f64::consts::PI * (i as f64 + 0.5) / n as f64).cos();
            0.5 * (1.0 + least) + 0.5 * (1.0 - least) * c
        };
        let vandermonde = Matrix::from_fn(n, n, |i, k| node(i).powi(k as i32));
        let inverse = Qr::new(&vandermonde).pseudo_inverse();
        for (k, &coefficient) in POWER_5_3.iter().enumerate() {
            let fresh: f64 = (0..n).map(|i| inverse[(k, i)] * node(i).powf(5.0 / 3.0)).sum();
            assert!((fresh - f64::from(coefficient)).abs() < 1e-6, "{k}: {fresh:.9}");
        }
    }
}
