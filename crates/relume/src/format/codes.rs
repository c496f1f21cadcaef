//! Integer codes of the values of a picture: sRGB-encoded, rounded to nearest, clamped, with NaN as 0.

use crate::clipping::{Clipper, Clipping};
use crate::error::Result;
use crate::job::Job;
use crate::memory;
use crate::parallel;
use crate::picture::Picture;
use crate::space::Space;

/// Values of sRGB as 8-bit codes.
pub(super) fn code8(encoded: f32) -> u8 {
    code(encoded, 255.0) as u8
}

/// Values of sRGB as 16-bit codes.
pub(super) fn code16(encoded: f32) -> u16 {
    code(encoded, 65535.0) as u16
}

fn code(encoded: f32, most: f64) -> u32 {
    // A cast maps NaN to 0; adding a half before truncation rounds values that are not negative.
    (f64::from(encoded).clamp(0.0, 1.0) * most + 0.5) as u32
}

/// Interleaved 8-bit codes of a picture, rows from the top.
pub(super) fn interleaved8(picture: &Picture, job: &Job) -> Result<Vec<u8>> {
    match picture.space {
        Space::Srgb => interleaved(picture, job, code8),
        Space::Linear => {
            let steps = CodeSteps::new();
            interleaved(picture, job, |value| steps.code(value))
        }
    }
}

/// Interleaved 16-bit codes of a picture, rows from the top.
pub(super) fn interleaved16(picture: &Picture, job: &Job) -> Result<Vec<u16>> {
    let space = picture.space;
    interleaved(picture, job, |value| code16(space.to_srgb(value)))
}

fn interleaved<T: Copy + Default + Send>(
    picture: &Picture,
    job: &Job,
    code: impl Fn(f32) -> T + Sync,
) -> Result<Vec<T>> {
    let (width, channels) = (picture.size().width, picture.planes.count());
    let mut codes = memory::zeros("the codes of the picture", picture.size().texels() * channels)?;
    let of_rows = parallel::try_map(codes.chunks_mut(width * channels).enumerate(), |(y, row)| {
        job.proceed()?;
        let mut clipping = Clipping::default();
        for (c, plane) in picture.planes.iter().enumerate() {
            let values = &plane[y * width..][..width];
            row.iter_mut().skip(c).step_by(channels).zip(values).for_each(|(out, &v)| *out = code(v));
            clipping = clipping.and(Clipping::of(values, Clipper::Codes));
        }
        Ok(clipping)
    })?;
    let clipping = of_rows.into_iter().fold(Clipping::default(), Clipping::and);
    job.count_clipped(Clipper::Codes, clipping);
    Ok(codes)
}

/// The least linear value of each 8-bit code but the first: encoding by look-up instead of a power. Encoding
/// is monotone, so the codes are the same.
struct CodeSteps([f32; 255]);

impl CodeSteps {
    fn new() -> Self {
        Self(std::array::from_fn(|k| least_linear_of(k as u8 + 1)))
    }

    fn code(&self, linear: f32) -> u8 {
        self.0.partition_point(|&step| step <= linear) as u8
    }
}

/// The least value in 0..=1 whose code is at least `target`, by bisection on the bits: floats that are not
/// negative have the order of their bits.
fn least_linear_of(target: u8) -> f32 {
    let (mut below, mut reached) = (0u32, 1f32.to_bits());
    while reached - below > 1 {
        let middle = below + (reached - below) / 2;
        if code8(Space::Linear.to_srgb(f32::from_bits(middle))) >= target {
            reached = middle;
        } else {
            below = middle;
        }
    }
    f32::from_bits(reached)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_round_clamp_and_take_nan_to_black() {
        let cases = [(0.0, 0), (1.0, 255), (7.0, 255), (-3.0, 0), (f32::NAN, 0), (f32::INFINITY, 255)];
        let steps = CodeSteps::new();
        for (value, code) in cases {
            assert_eq!(code8(value), code, "{value}");
            assert_eq!(steps.code(value), code, "{value}");
        }
        assert_eq!((code8(0.499 / 255.0), code8(0.501 / 255.0)), (0, 1));
        assert_eq!((code16(1.0), code16(f32::NAN), code16(0.5)), (65535, 0, 32768));
    }

    #[test]
    fn looking_a_code_up_equals_encoding() {
        let steps = CodeSteps::new();
        let near_steps = steps.0.iter().flat_map(|s| (0..5).map(|d| f32::from_bits(s.to_bits() - 2 + d)));
        let spread = (0..200_000).map(|i| i as f32 / 190_000.0);
        for value in near_steps.chain(spread) {
            assert_eq!(steps.code(value), code8(Space::Linear.to_srgb(value)), "{value:e}");
        }
    }
}
