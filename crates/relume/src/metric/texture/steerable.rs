//! STSIM-2: the similarity of the statistics of the steerable pyramids of two textures.
//!
//! J. Zujovic, T. Pappas, D. Neuhoff, Structural texture similarity metrics for image analysis and retrieval,
//! IEEE Transactions on Image Processing 22(7), 2013. For each subband of a complex steerable pyramid of
//! three scales and four directions, and for the low and the high residual, four terms compare the mean, the
//! variance and the correlation with the neighbour along x and along y; their geometric mean is the
//! similarity of the subband. Correlations of the magnitudes of subbands, between directions of a scale and
//! between neighbouring scales of a direction, give one term each. STSIM-2 is the mean of all terms;
//! [`distance`] is 1 minus that, averaged over several planes with their variances as weights.
//!
//! Where we differ: statistics are of the whole texture, not of windows. Subbands are not subsampled, so the
//! neighbour of scale s is 2^s texels away. The mean of a subband, which is zero for any texture, is replaced
//! by that of its magnitudes. The constants that prevent quotients of 0/0 are relative to the variance of the
//! reference plane. The texture is treated as a torus: steps across its borders count as edges, in both
//! alike. It detects contrast, direction, edges, lines and local order; it does not detect positions or
//! repetition.

use std::f64::consts::{FRAC_PI_2, PI};

use realfft::num_complex::Complex64;

use super::variance;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::fourier::{self, Fourier};
use crate::planes::Planes;
use crate::size::Size;

const SCALES: usize = 3;
const DIRECTIONS: usize = 4;
/// Bytes of a texel: the spectrum, the two residual bands, the magnitudes of the oriented bands, the last of which is
/// being transformed, and the gains at half as many bins.
const BYTES: u64 =
    8 * (1 + 2 + (SCALES * DIRECTIONS) as u64) + 4 * (SCALES + DIRECTIONS) as u64 + fourier::BYTES_PER_TEXEL;
/// The threshold, relative to the variance of the reference, below which statistics are negligible.
const NOTHING: f64 = 1e-6;

/// 1 - STSIM-2; see the module.
///
/// # Errors
/// When the limits are exceeded.
///
/// # Panics
/// When the numbers of planes differ.
pub fn distance(reference: &Planes, other: &Planes, job: &Job) -> Result<f64> {
    assert_eq!(reference.count(), other.count(), "as many planes");
    for planes in [reference, other] {
        job.check_bytes("the steerable pyramid", bytes(planes.size()))?;
    }
    let (mut sum, mut weights) = (0.0, 0.0);
    for (a, b) in reference.iter().zip(other.iter()) {
        let weight = variance(a).max(f64::MIN_POSITIVE);
        let nothing = NOTHING * weight;
        let (a, b) = (Statistics::of(a, reference.size(), job)?, Statistics::of(b, other.size(), job)?);
        sum += weight * (1.0 - a.similarity(&b, nothing));
        weights += weight;
    }
    Ok(if weights > 0.0 { sum / weights } else { 0.0 })
}

/// The memory of the pyramid of a texture of `size`.
pub(super) fn bytes(size: Size) -> u64 {
    BYTES.saturating_mul(size.texels() as u64)
}

/// The compared statistics of one plane.
struct Statistics {
    bands: Vec<BandStatistics>,
    crosses: Vec<f64>,
}

/// Mean, variance, and correlation with the neighbours along x and along y.
struct BandStatistics {
    mean: f64,
    variance: f64,
    neighbours: [Complex64; 2],
}

impl Statistics {
    fn of(plane: &[f32], size: Size, job: &Job) -> Result<Self> {
        let plan = Fourier::new(size);
        let spectrum = plan.forward(plane.iter().map(|&v| f64::from(v)).collect());
        let gains = Gains::of(&polar(spectrum.len(), size));
        let image = |gain: &dyn Fn(usize) -> Complex64| {
            plan.inverse(spectrum.iter().enumerate().map(|(i, bin)| bin * gain(i)).collect())
        };
        let low = image(&|i| Complex64::from(gains.low[i]));
        let high = image(&|i| Complex64::from(gains.high[i]));
        let mut bands =
            vec![BandStatistics::of(&low, None, size, 1 << SCALES), BandStatistics::of(&high, None, size, 1)];
        let mut magnitudes = Vec::new();
        for scale in 0..SCALES {
            for direction in 0..DIRECTIONS {
                job.proceed()?;
                let gain = |i: usize| gains.radial[scale][i] * gains.turns[direction][i];
                let even = image(&|i| Complex64::from(gain(i).abs()));
                let odd = image(&|i| Complex64::new(0.0, -gain(i)));
                let magnitude: Vec<f64> = even.iter().zip(&odd).map(|(a, b)| a.hypot(*b)).collect();
                bands.push(BandStatistics::of(&even, Some((&odd, &magnitude)), size, 1 << scale));
                magnitudes.push(magnitude);
            }
        }
        Ok(Self { bands, crosses: crosses(&magnitudes) })
    }

    fn similarity(&self, other: &Self, nothing: f64) -> f64 {
        let bands = self.bands.iter().zip(&other.bands).map(|(a, b)| a.similarity(b, nothing));
        let crosses = self.crosses.iter().zip(&other.crosses).map(|(a, b)| 1.0 - 0.5 * (a - b).abs());
        (bands.sum::<f64>() + crosses.sum::<f64>()) / (self.bands.len() + self.crosses.len()) as f64
    }
}

impl BandStatistics {
    /// The statistics of a real band, or of a complex one with its imaginary part and its magnitude.
    fn of(even: &[f64], odd: Option<(&[f64], &[f64])>, size: Size, step: usize) -> Self {
        let count = even.len() as f64;
        let value = |i: usize| Complex64::new(even[i], odd.map_or(0.0, |(odd, _)| odd[i]));
        let centre = even.iter().sum::<f64>() / count;
        let energy = (0..even.len()).map(|i| (value(i) - centre).norm_sqr()).sum::<f64>() / count;
        let lagged = |dx: usize, dy: usize| {
            let rows = (0..size.height).map(|y| (y * size.width, (y + dy) % size.height * size.width));
            let pairs = rows.flat_map(|(here, there)| {
                (0..size.width).map(move |x| {
                    (here + x, there + if x + dx < size.width { x + dx } else { x + dx - size.width })
                })
            });
            let sum: Complex64 = pairs.map(|(i, j)| (value(i) - centre) * (value(j) - centre).conj()).sum();
            if energy > 0.0 { sum / (count * energy) } else { Complex64::ZERO }
        };
        let step = |side: usize| step % side;
        let neighbours = [lagged(step(size.width), 0), lagged(0, step(size.height))];
        match odd {
            None => Self { mean: centre, variance: energy, neighbours },
            Some((_, magnitude)) => {
                let mean = magnitude.iter().sum::<f64>() / count;
                Self { mean, variance: (energy - mean * mean).max(0.0), neighbours }
            }
        }
    }

    fn similarity(&self, other: &Self, nothing: f64) -> f64 {
        let like = |a: f64, b: f64| (2.0 * a * b + nothing) / (a * a + b * b + nothing);
        // Quotients of means are not below 0 for magnitudes; the mean of a residual may change its sign.
        let mean = like(self.mean, other.mean).max(0.0);
        let spread = like(self.variance.sqrt(), other.variance.sqrt());
        let [x, y] = [0, 1].map(|k| 1.0 - 0.5 * (self.neighbours[k] - other.neighbours[k]).norm());
        (mean * spread * x * y).powf(0.25)
    }
}

/// The gains of all filters at each bin of a spectrum; those of a band are the product of a radial and a turning
/// one.
struct Gains {
    low: Vec<f64>,
    high: Vec<f64>,
    radial: Vec<Vec<f64>>,
    turns: Vec<Vec<f64>>,
}

impl Gains {
    fn of(polar: &[(f64, f64)]) -> Self {
        let all = |gain: &dyn Fn(f64, f64) -> f64| {
            polar.iter().map(|&(radius, angle)| gain(radius, angle)).collect()
        };
        Self {
            low: all(&|radius, _| low_pass(radius, SCALES)),
            high: all(&|radius, _| high_pass(radius, 0)),
            radial: (0..SCALES)
                .map(|s| all(&|radius, _| low_pass(radius, s) * high_pass(radius, s + 1)))
                .collect(),
            turns: (0..DIRECTIONS).map(|d| all(&|_, angle| turn_gain(angle, d))).collect(),
        }
    }
}

/// The radius in half cycles per texel, and the angle, of each bin of a spectrum.
fn polar(bins: usize, size: Size) -> Vec<(f64, f64)> {
    let place = |i: usize| {
        let (k, l) = (i / size.height, i % size.height);
        let down = if 2 * l > size.height { l as f64 - size.height as f64 } else { l as f64 };
        let (u, v) = (2.0 * k as f64 / size.width as f64, 2.0 * down / size.height as f64);
        (u.hypot(v), v.atan2(u))
    };
    (0..bins).map(place).collect()
}

/// The low pass of scale `s`, whose octave ends at 2^-s: a raised cosine in octaves (J. Portilla, E.
/// Simoncelli, A parametric texture model based on joint statistics of complex wavelet coefficients, 2000,
/// appendix).
fn low_pass(radius: f64, s: usize) -> f64 {
    let octave = (radius.max(1e-12).log2() + s as f64 + 1.0).clamp(0.0, 1.0);
    (FRAC_PI_2 * octave).cos()
}

/// The complement of [`low_pass`]: their squares sum to 1.
fn high_pass(radius: f64, s: usize) -> f64 {
    let octave = (radius.max(1e-12).log2() + s as f64 + 1.0).clamp(0.0, 1.0);
    (FRAC_PI_2 * octave).sin()
}

/// cos^3 of the angle to a direction, with the sign of the half plane; the squares over the four directions
/// sum to 1.
fn turn_gain(angle: f64, direction: usize) -> f64 {
    // sum_k cos^6(x - k pi / 4) = 4 * 5 / 16.
    let scale = (5.0f64 / 4.0).sqrt().recip();
    scale * (angle - direction as f64 * PI / DIRECTIONS as f64).cos().powi(3)
}

/// Correlations of magnitudes: pairs of directions of each scale, then neighbouring scales of each
/// direction.
fn crosses(magnitudes: &[Vec<f64>]) -> Vec<f64> {
    let at = |scale: usize, direction: usize| &magnitudes[scale * DIRECTIONS + direction];
    let pairs = (0..DIRECTIONS).flat_map(|j| (0..j).map(move |i| (i, j)));
    let within = (0..SCALES).flat_map(|s| pairs.clone().map(move |(i, j)| (at(s, i), at(s, j))));
    let across = (1..SCALES).flat_map(|s| (0..DIRECTIONS).map(move |d| (at(s - 1, d), at(s, d))));
    within.chain(across).map(|(a, b)| correlation(a, b)).collect()
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let count = a.len() as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / count, b.iter().sum::<f64>() / count);
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - mean_a, y - mean_b);
        ab += x * y;
        aa += x * x;
        bb += y * y;
    }
    if aa * bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn noise(size: Size, seed: u64) -> Planes {
        let mut random = Stream::new(seed, Purpose::Sample, [0]);
        Planes::from_vec(size, 1, (0..size.texels()).map(|_| random.unit() as f32).collect()).unwrap()
    }

    #[test]
    fn the_bands_share_all_energy() {
        for radius in [0.01, 0.1, 0.2, 0.37, 0.5, 0.8, 1.3] {
            for angle in [-1.5, -0.3, 0.0, 0.4, 1.2] {
                let residuals = low_pass(radius, SCALES).powi(2) + high_pass(radius, 0).powi(2);
                let band = |s: usize| {
                    let radial = (low_pass(radius, s) * high_pass(radius, s + 1)).powi(2);
                    (0..DIRECTIONS).map(|d| radial * turn_gain(angle, d).powi(2)).sum::<f64>()
                };
                let whole = residuals + (0..SCALES).map(band).sum::<f64>();
                assert!((whole - 1.0).abs() < 1e-12, "{radius} {angle}: {whole}");
            }
        }
    }

    #[test]
    fn a_texture_is_like_itself_moved_on_the_torus_and_unlike_its_transpose() {
        let size = Size::new(48, 40);
        let wave = |x: usize, y: usize| {
            ((x as f32 * 0.9).sin() * (y as f32 * 0.2).cos()) + 0.02 * (x * y % 7) as f32
        };
        let planes = |f: &dyn Fn(usize, usize) -> f32| {
            Planes::from_vec(size, 1, (0..size.texels()).map(|i| f(i % 48, i / 48)).collect()).unwrap()
        };
        let job = Job::default();
        let a = planes(&wave);
        assert!(distance(&a, &a, &job).unwrap().abs() < 1e-12);
        let moved = planes(&|x, y| wave((x + 11) % 48, (y + 29) % 40));
        assert!(distance(&a, &moved, &job).unwrap() < 1e-9);
        let turned = planes(&|x, y| wave(y, x));
        assert!(distance(&a, &turned, &job).unwrap() > 0.05);
    }

    #[test]
    fn noise_is_like_other_noise_of_any_size() {
        let job = Job::default();
        let near = distance(&noise(Size::new(128, 128), 1), &noise(Size::new(150, 100), 2), &job).unwrap();
        assert!(near < 0.03, "{near}");
        let flat = Planes::from_vec(Size::new(32, 32), 1, vec![0.5; 1024]).unwrap();
        assert!(distance(&flat, &flat, &job).unwrap() < 1e-9);
        assert!(distance(&noise(Size::new(32, 32), 1), &flat, &job).unwrap() > 0.2);
    }
}
