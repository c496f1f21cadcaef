//! Projection kernels: a few directions in the space of square cells of codes that hold most of the
//! differences between cells.
//!
//! Hel-Or, Hel-Or, "Real Time Pattern Matching using Projection Kernels", ICCV 2003; Hel-Or, Malzbender,
//! Gelb, HPL-2003-16, section 6. Each basis is orthonormalised and rounded to integers, so that projections
//! of codes are exact in 32 bits whatever the order of their sums. Rounding leaves the kernels nearly
//! orthonormal: A = U / sqrt(lambda), with lambda no less than the largest eigenvalue of U U', never
//! lengthens a vector, which is all that a lower bound needs.

use pulp::Arch;

use super::coordinates::WIDE;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};
use crate::synthesis::quantise::{MAX_CODE, Quantised};
use crate::synthesis::search::KernelBasis;

/// Cells of the exemplars from which a basis is chosen.
const SAMPLES: usize = 768;

/// Rounds of subspace iteration; the energy of the leading directions has converged to one per cent.
const ROUNDS: usize = 4;

/// Frequencies along each side from which trigonometric and Walsh kernels are chosen.
const FREQUENCIES: usize = 8;

/// The share of the energy of the samples that is enough for a first look: further kernels would cost more
/// than they reject.
const ENOUGH: f64 = 0.8;

/// The most kernels of the first look.
pub const MOST_FIRST: usize = 32;

/// Kernels beyond those of the first look, which with the residual of a cell and their squared length
/// fill one vector register.
pub const FURTHER: usize = 59;

/// The share of the samples within the range of a unit of 8 bits; others are clipped. A larger range makes
/// rounding coarser, a smaller one clips too much.
const UNCLIPPED: f64 = 0.95;

/// Integer kernels for cells of one size.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernels {
    /// Texels along x and along y.
    pub side: usize,
    /// Kernel after kernel, row by row, the planes of a texel adjacent.
    pub weights: Vec<Vec<i16>>,
    /// The number of kernels of the first look.
    pub first: usize,
    /// An upper bound of the largest eigenvalue of the matrix of inner products of the kernels.
    pub lambda: f64,
    /// The length along the first kernel with an 8-bit coordinate that few cells exceed, in codes.
    pub usual_narrow: f64,
    /// The same along the first kernel omitted by the first look.
    pub usual_further: f64,
    /// The root mean square length of the residual of a cell.
    pub usual_residual: f64,
}

impl Kernels {
    /// Kernels of a basis, the most significant first: as many as are enough for the first look, but at most
    /// `most` of those, and at most [`FURTHER`] others.
    ///
    /// # Errors
    /// When their choice does not fit into the memory, or the job is cancelled.
    pub fn new(
        basis: KernelBasis,
        most: usize,
        exemplars: &Quantised,
        side: usize,
        job: &Job,
    ) -> Result<Self> {
        let planes = exemplars.planes();
        let length = side * side * planes;
        job.check_bytes("the choice of kernels", 4 * (length * (length + SAMPLES)) as u64)?;
        let samples = centred_samples(exemplars, side);
        let covariance = Covariance::new(&samples, job)?;
        let most = most.min(MOST_FIRST);
        let count = (most + FURTHER).min(length);
        let mut vectors = match basis {
            KernelBasis::Svd => covariance.leading_directions(count, job)?,
            KernelBasis::Dct => most_energetic(&covariance, count, products(planes, side, cosine), job)?,
            KernelBasis::WalshHadamard => {
                most_energetic(&covariance, count, products(planes, side, walsh), job)?
            }
        };
        let energies = vectors.iter().map(|vector| job.proceed().map(|()| covariance.energy(vector)));
        let energies: Vec<f64> = energies.collect::<Result<_>>()?;
        let first = enough(&energies, covariance.total()).min(most).min(vectors.len());
        vectors.truncate(first + FURTHER);
        let left = covariance.total() - energies[..vectors.len()].iter().sum::<f64>();
        let weights = rounded(&vectors, length);
        let lambda = largest_eigenvalue_bound(&weights);
        Ok(Self {
            side,
            weights,
            first,
            lambda,
            usual_narrow: vectors.get(WIDE).map_or(0.0, |vector| usual(&samples, vector)),
            usual_further: vectors.get(first).map_or(0.0, |vector| usual(&samples, vector)),
            usual_residual: left.max(0.0).sqrt(),
        })
    }
}

/// The length along a unit vector that [`UNCLIPPED`] of the samples do not exceed.
fn usual(samples: &[Vec<f32>], vector: &[f32]) -> f64 {
    let mut lengths: Vec<f32> = samples.iter().map(|sample| dot(sample, vector).abs()).collect();
    lengths.sort_unstable_by(f32::total_cmp);
    f64::from(lengths[(UNCLIPPED * (lengths.len() - 1) as f64) as usize])
}

/// The number of vectors of these energies that hold [`ENOUGH`] of the total, filling words.
fn enough(energies: &[f64], total: f64) -> usize {
    let mut held = 0.0;
    let count = energies.iter().take_while(|&&energy| {
        let before = held;
        held += energy;
        before < ENOUGH * total
    });
    count.count().next_multiple_of(WIDE)
}

/// Cells at random places of the exemplars, minus their mean.
fn centred_samples(exemplars: &Quantised, side: usize) -> Vec<Vec<f32>> {
    let mut stream = Stream::new(0, Purpose::KernelSamples, [side as u64]);
    let mut samples: Vec<Vec<f32>> = (0..SAMPLES)
        .map(|_| {
            let texels = &exemplars.texels()[stream.below(exemplars.texels().len())];
            let size = texels.size();
            let (x, y) = (stream.below(size.width - side + 1), stream.below(size.height - side + 1));
            (y..y + side).flat_map(|y| texels.run(x, y, side)).map(|&code| f32::from(code)).collect()
        })
        .collect();
    for i in 0..samples[0].len() {
        let mean = samples.iter().map(|s| s[i]).sum::<f32>() / SAMPLES as f32;
        samples.iter_mut().for_each(|s| s[i] -= mean);
    }
    samples
}

/// The mean products of two codes of a sample.
struct Covariance {
    rows: Vec<Vec<f32>>,
}

impl Covariance {
    fn new(samples: &[Vec<f32>], job: &Job) -> Result<Self> {
        Arch::new().dispatch(
            #[inline(always)]
            || {
                let length = samples[0].len();
                let mut rows = vec![vec![0.0f32; length]; length];
                for sample in samples {
                    job.proceed()?;
                    for (row, share) in rows.iter_mut().zip(sample) {
                        row.iter_mut().zip(sample).for_each(|(sum, x)| *sum += share * x);
                    }
                }
                rows.iter_mut().flatten().for_each(|sum| *sum /= samples.len() as f32);
                Ok(Self { rows })
            },
        )
    }

    /// The mean squared length of the samples.
    fn total(&self) -> f64 {
        self.rows.iter().enumerate().map(|(i, row)| f64::from(row[i])).sum()
    }

    /// The mean squared length along a unit vector.
    fn energy(&self, vector: &[f32]) -> f64 {
        f64::from(dot(&self.times(vector), vector))
    }

    #[inline(always)]
    fn times(&self, vector: &[f32]) -> Vec<f32> {
        self.rows.iter().map(|row| dot(row, vector)).collect()
    }

    /// The leading right singular vectors of the samples, by subspace iteration from a fixed start.
    fn leading_directions(&self, count: usize, job: &Job) -> Result<Vec<Vec<f32>>> {
        Arch::new().dispatch(
            #[inline(always)]
            || self.iterated(count, job),
        )
    }

    #[inline(always)]
    fn iterated(&self, count: usize, job: &Job) -> Result<Vec<Vec<f32>>> {
        let length = self.rows.len();
        let mut stream = Stream::new(0, Purpose::KernelStart, [length as u64]);
        let mut vectors: Vec<Vec<f32>> =
            (0..count).map(|_| (0..length).map(|_| stream.unit() as f32 - 0.5).collect()).collect();
        for _ in 0..ROUNDS {
            let times = vectors.iter().map(|vector| job.proceed().map(|()| self.times(vector)));
            vectors = orthonormal(times.collect::<Result<_>>()?);
        }
        by_energy(self, vectors, job)
    }
}

/// The most energetic products of one function along x, one along y and one plane, orthonormal.
fn most_energetic(
    covariance: &Covariance,
    count: usize,
    products: Vec<Vec<f32>>,
    job: &Job,
) -> Result<Vec<Vec<f32>>> {
    let mut ordered = by_energy(covariance, products, job)?;
    ordered.truncate(count);
    Ok(orthonormal(ordered))
}

/// Unit vectors sorted by the energy of the samples along them; ties keep their order.
fn by_energy(covariance: &Covariance, vectors: Vec<Vec<f32>>, job: &Job) -> Result<Vec<Vec<f32>>> {
    let energy = |vector: Vec<f32>| job.proceed().map(|()| (covariance.energy(&vector), vector));
    let mut ranked: Vec<(f64, Vec<f32>)> = vectors.into_iter().map(energy).collect::<Result<_>>()?;
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(ranked.into_iter().map(|(_, v)| v).collect())
}

/// All low-frequency products of a family of functions along x and y, for each plane.
fn products(planes: usize, side: usize, function: fn(usize, usize, usize) -> f32) -> Vec<Vec<f32>> {
    let mut vectors = Vec::new();
    for fy in 0..FREQUENCIES.min(side) {
        for fx in 0..FREQUENCIES.min(side) {
            for plane in 0..planes {
                let mut vector = vec![0.0; side * side * planes];
                for (texel, value) in vector[plane..].iter_mut().step_by(planes).enumerate() {
                    *value = function(fx, texel % side, side) * function(fy, texel / side, side);
                }
                vectors.push(normalised(vector));
            }
        }
    }
    vectors
}

/// The discrete cosine of a frequency at a position (Ahmed, Natarajan, Rao, 1974).
fn cosine(frequency: usize, place: usize, length: usize) -> f32 {
    (std::f64::consts::PI * frequency as f64 * (place as f64 + 0.5) / length as f64).cos() as f32
}

/// The Walsh function with as many sign changes as `frequency`, over the next power of two.
fn walsh(frequency: usize, place: usize, length: usize) -> f32 {
    let bits = length.next_power_of_two().trailing_zeros();
    let gray = frequency ^ (frequency >> 1);
    let row = if bits == 0 { 0 } else { gray.reverse_bits() >> (usize::BITS - bits) };
    if (row & place).count_ones().is_multiple_of(2) { 1.0 } else { -1.0 }
}

/// Gram-Schmidt, twice for accuracy; linearly dependent vectors are dropped.
#[inline(always)]
fn orthonormal(vectors: Vec<Vec<f32>>) -> Vec<Vec<f32>> {
    let mut done: Vec<Vec<f32>> = Vec::with_capacity(vectors.len());
    for vector in vectors {
        let mut vector = normalised(vector);
        for _ in 0..2 {
            for other in &done {
                let share = dot(&vector, other);
                vector.iter_mut().zip(other).for_each(|(v, o)| *v -= share * o);
            }
            let length = dot(&vector, &vector).sqrt();
            if length < 1e-3 {
                vector.clear();
                break;
            }
            vector.iter_mut().for_each(|v| *v /= length);
        }
        if !vector.is_empty() {
            done.push(vector);
        }
    }
    done
}

fn normalised(mut vector: Vec<f32>) -> Vec<f32> {
    let length = dot(&vector, &vector).sqrt();
    if length > 0.0 {
        vector.iter_mut().for_each(|v| *v /= length);
    }
    vector
}

/// In interleaved sums, so that it vectorises.
#[inline(always)]
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; 32];
    let (heads_a, tail_a) = a.as_chunks::<32>();
    let (heads_b, tail_b) = b.as_chunks::<32>();
    for (x, y) in heads_a.iter().zip(heads_b) {
        for i in 0..32 {
            sums[i] += x[i] * y[i];
        }
    }
    sums.iter().sum::<f32>() + tail_a.iter().zip(tail_b).map(|(x, y)| x * y).sum::<f32>()
}

/// Unit vectors as integers, with a length such that projections of differences of codes fit 31 bits.
fn rounded(vectors: &[Vec<f32>], length: usize) -> Vec<Vec<i16>> {
    let longest_difference = f64::from(MAX_CODE) * (length as f64).sqrt();
    // Rounding lengthens a vector by at most half a unit per component.
    let unit = (f64::from(1u32 << 31) / longest_difference - (length as f64).sqrt()).clamp(1.0, 16_384.0);
    let round = |v: &f32| (f64::from(*v) * unit).round() as i16;
    vectors.iter().map(|v| v.iter().map(round).collect()).collect()
}

/// Gershgorin's bound on the eigenvalues of the inner products of the kernels.
fn largest_eigenvalue_bound(weights: &[Vec<i16>]) -> f64 {
    let inner =
        |a: &[i16], b: &[i16]| -> i64 { a.iter().zip(b).map(|(x, y)| i64::from(*x) * i64::from(*y)).sum() };
    let row = |a: &Vec<i16>| weights.iter().map(|b| inner(a, b).abs()).sum::<i64>();
    weights.iter().map(row).max().unwrap_or(1).max(1) as f64
}
