//! Distance of the power spectra by frequency and direction.
//!
//! The power of all planes under a Hann window (P. Welch, The use of fast Fourier transform for the
//! estimation of power spectra, 1967) is averaged over half octaves of frequency and eight directions; the
//! distance is the root mean square of the ratio in dB over the bins that both textures resolve. It detects
//! blur (missing high frequencies), noise, scrambling, other scales and directions, and contrast. It does not
//! detect phase, and so neither edges nor shapes; nor repetition, whose lines fall into the same wide bins.

use std::f64::consts::PI;

use crate::error::Result;
use crate::job::Job;
use crate::numeric::fourier::{self, Fourier};
use crate::planes::Planes;
use crate::size::Size;

/// Directions over half a turn.
const DIRECTIONS: usize = 8;
/// Half octaves below the highest frequency, half a cycle per texel (corners exceed it and count as the
/// first).
const BANDS: usize = 16;
/// The least number of frequencies for a meaningful mean of a bin.
const LEAST_FREQUENCIES: u32 = 4;
/// Powers below this share of the strongest bin of the reference are raised to it: 60 dB, the limit of 8-bit
/// codes.
const FLOOR: f64 = 1e-6;

/// The distance in dB; see the module. 0 where no bin is resolved.
///
/// # Errors
/// When the limits are exceeded.
pub fn distance_db(reference: &Planes, other: &Planes, job: &Job) -> Result<f64> {
    let (a, b) = (bins(reference, job)?, bins(other, job)?);
    let strongest = a.iter().flatten().copied().fold(0.0, f64::max);
    let floor = (FLOOR * strongest).max(f64::MIN_POSITIVE);
    let both = a.iter().zip(&b).filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?)));
    let ratios: Vec<f64> = both.map(|(a, b)| 10.0 * (a.max(floor) / b.max(floor)).log10()).collect();
    Ok((ratios.iter().map(|db| db * db).sum::<f64>() / ratios.len().max(1) as f64).sqrt())
}

/// The mean power per texel in each bin, `None` where there are too few frequencies.
fn bins(planes: &Planes, job: &Job) -> Result<Vec<Option<f64>>> {
    job.check_bytes("the power spectrum", bytes(planes.size()))?;
    let plan = Fourier::new(planes.size());
    let mut sums = vec![(0.0, 0u32); BANDS * DIRECTIONS];
    for plane in planes.iter() {
        job.proceed()?;
        let spectrum = plan.forward(windowed(plane, planes.size()));
        for (i, bin) in spectrum.iter().enumerate() {
            if let Some(place) = bin_of(i / planes.size().height, i % planes.size().height, planes.size()) {
                sums[place].0 += bin.norm_sqr();
                sums[place].1 += 1;
            }
        }
    }
    let least = LEAST_FREQUENCIES * planes.count() as u32;
    let mean = |(sum, count): (f64, u32)| (count >= least).then(|| sum / f64::from(count));
    Ok(sums.into_iter().map(mean).collect())
}

/// The memory of the spectrum of a texture of `size`.
pub(super) fn bytes(size: Size) -> u64 {
    fourier::BYTES_PER_TEXEL.saturating_mul(size.texels() as u64)
}

/// The bin of frequency (k / width, l / height); the mean has none.
fn bin_of(k: usize, l: usize, size: Size) -> Option<usize> {
    let down = if 2 * l > size.height { l as f64 - size.height as f64 } else { l as f64 };
    let (u, v) = (k as f64 / size.width as f64, down / size.height as f64);
    let band = -2.0 * (2.0 * u.hypot(v)).log2();
    let band = if band.is_finite() { band.max(0.0) as usize } else { return None };
    let turn = (v.atan2(u) / PI + 1.0 + 0.5 / DIRECTIONS as f64).fract();
    let direction = ((turn * DIRECTIONS as f64) as usize).min(DIRECTIONS - 1);
    (band < BANDS).then_some(band * DIRECTIONS + direction)
}

/// A plane minus its mean under a window with a mean square of 1, so that power does not depend on size.
fn windowed(plane: &[f32], size: Size) -> Vec<f64> {
    let hann = |i: usize, n: usize| (1.0 - (2.0 * PI * (i as f64 + 0.5) / n as f64).cos()) / 1.5f64.sqrt();
    let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
    let scale = 1.0 / (size.texels() as f64).sqrt();
    let weight = |i: usize| scale * hann(i % size.width, size.width) * hann(i / size.width, size.height);
    plane.iter().enumerate().map(|(i, &v)| weight(i) * (f64::from(v) - mean)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn noise(size: Size, gain: f32, seed: u64) -> Planes {
        let mut random = Stream::new(seed, Purpose::Sample, [0]);
        Planes::from_vec(size, 1, (0..size.texels()).map(|_| gain * random.unit() as f32).collect()).unwrap()
    }

    #[test]
    fn white_noise_has_its_variance_in_every_bin_at_any_size() {
        for (width, height) in [(128, 128), (97, 160)] {
            let found = bins(&noise(Size::new(width, height), 1.0, 3), &Job::default()).unwrap();
            // The four highest bands; the window and the removed mean affect only the lowest.
            let known: Vec<f64> = found.into_iter().take(4 * DIRECTIONS).flatten().collect();
            assert_eq!(known.len(), 4 * DIRECTIONS);
            let mean = known.iter().sum::<f64>() / known.len() as f64;
            assert!((mean * 12.0 - 1.0).abs() < 0.1, "{mean} is not 1 / 12");
        }
    }

    #[test]
    fn a_gain_is_its_decibels() {
        let job = Job::default();
        let (quiet, loud) = (noise(Size::new(64, 64), 0.25, 1), noise(Size::new(64, 64), 0.5, 1));
        let found = distance_db(&loud, &quiet, &job).unwrap();
        assert!((found - 20.0 * 2f64.log10()).abs() < 1e-3, "{found}");
        assert_eq!(distance_db(&loud, &loud, &job).unwrap(), 0.0);
    }

    #[test]
    fn directions_are_kept_apart() {
        let wave = |u: f64, v: f64| {
            let value = |i: usize| (2.0 * PI * (u * (i % 64) as f64 + v * (i / 64) as f64)).cos() as f32;
            Planes::from_vec(Size::new(64, 64), 1, (0..4096).map(value).collect()).unwrap()
        };
        let job = Job::default();
        assert!(distance_db(&wave(0.25, 0.0), &wave(0.0, 0.25), &job).unwrap() > 5.0);
        assert!(distance_db(&wave(0.25, 0.0), &wave(-0.25, 0.0), &job).unwrap() < 1e-6);
    }
}
