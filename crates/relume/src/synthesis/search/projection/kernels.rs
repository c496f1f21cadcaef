//! Projection kernels: a few directions in the space of rectangles of codes that hold most of the
//! differences between rectangles.
//!
//! Hel-Or, Hel-Or, "Real Time Pattern Matching using Projection Kernels", ICCV 2003; Hel-Or,
//! Malzbender, Gelb, HPL-2003-16, section 6. Each basis is made orthonormal and rounded to integers,
//! so that projections of codes are exact in 32 bits whatever the order of their sums. Rounding
//! leaves the kernels nearly orthonormal: A = U / sqrt(lambda), with lambda no less than the largest
//! eigenvalue of U U', never lengthens a vector, which is all that a lower bound needs.

use crate::numeric::random::Stream;
use crate::synthesis::quantise::{MAX_CODE, Quantised};

use crate::synthesis::search::KernelBasis;

/// Rectangles of the exemplars from which a basis is chosen.
const SAMPLES: usize = 384;

/// Rounds of subspace iteration; the energy of the leading directions has settled to a per cent.
const ROUNDS: usize = 5;

/// Frequencies along each side from which trigonometric and Walsh kernels are chosen.
const FREQUENCIES: usize = 8;

/// Integer kernels for rectangles of one size.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernels {
    /// Texels along x and y.
    pub width: usize,
    /// Texels along y.
    pub height: usize,
    /// Kernel after kernel, row after row, the planes of a texel together.
    pub weights: Vec<Vec<i16>>,
    /// At least the largest eigenvalue of the kernels' matrix of inner products.
    pub lambda: f64,
}

impl Kernels {
    /// At most `count` kernels of a basis, the most telling first.
    pub fn new(basis: KernelBasis, count: usize, exemplars: &Quantised, width: usize, height: usize) -> Self {
        let length = width * height * exemplars.planes();
        let samples = centred_samples(exemplars, width, height);
        let count = count.min(length);
        let vectors = match basis {
            KernelBasis::Svd => leading_directions(&samples, count),
            KernelBasis::Dct => {
                most_energetic(&samples, count, products(exemplars.planes(), width, height, cosine))
            }
            KernelBasis::WalshHadamard => {
                most_energetic(&samples, count, products(exemplars.planes(), width, height, walsh))
            }
        };
        let weights = rounded(&vectors, length);
        let lambda = largest_eigenvalue_bound(&weights);
        Self { width, height, weights, lambda }
    }
}

/// Rectangles at random places of the exemplars, less their mean.
fn centred_samples(exemplars: &Quantised, width: usize, height: usize) -> Vec<Vec<f32>> {
    let mut stream = Stream::new(0, (width * 65_536 + height) as u64);
    let mut samples: Vec<Vec<f32>> = (0..SAMPLES)
        .map(|_| {
            let texels = &exemplars.texels()[stream.below(exemplars.texels().len())];
            let size = texels.size();
            let (x, y) = (stream.below(size.width - width + 1), stream.below(size.height - height + 1));
            let rows = (y..y + height).flat_map(|y| texels.run(x, y, width));
            rows.map(|&code| f32::from(code)).collect()
        })
        .collect();
    for i in 0..samples[0].len() {
        let mean = samples.iter().map(|s| s[i]).sum::<f32>() / SAMPLES as f32;
        samples.iter_mut().for_each(|s| s[i] -= mean);
    }
    samples
}

/// The leading right singular vectors of the samples, by subspace iteration from a fixed start.
fn leading_directions(samples: &[Vec<f32>], count: usize) -> Vec<Vec<f32>> {
    let length = samples[0].len();
    let mut stream = Stream::new(1, length as u64);
    let mut vectors: Vec<Vec<f32>> =
        (0..count).map(|_| (0..length).map(|_| stream.unit() as f32 - 0.5).collect()).collect();
    for _ in 0..ROUNDS {
        let mut next = vec![vec![0.0f32; length]; count];
        for sample in samples {
            for (vector, sum) in vectors.iter().zip(&mut next) {
                let share = dot(sample, vector);
                sum.iter_mut().zip(sample).for_each(|(s, x)| *s += share * x);
            }
        }
        vectors = orthonormal(next);
    }
    by_energy(samples, vectors)
}

/// The most energetic products of one function along x, one along y and one plane, orthonormal.
fn most_energetic(samples: &[Vec<f32>], count: usize, products: Vec<Vec<f32>>) -> Vec<Vec<f32>> {
    let mut ordered = by_energy(samples, products);
    ordered.truncate(count);
    orthonormal(ordered)
}

/// Unit vectors sorted by the energy of the samples along them; ties keep their order.
fn by_energy(samples: &[Vec<f32>], vectors: Vec<Vec<f32>>) -> Vec<Vec<f32>> {
    let energy = |v: &Vec<f32>| samples.iter().map(|s| f64::from(dot(s, v)).powi(2)).sum::<f64>();
    let mut ranked: Vec<(f64, Vec<f32>)> = vectors.into_iter().map(|v| (energy(&v), v)).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    ranked.into_iter().map(|(_, v)| v).collect()
}

/// All low-frequency products of a family of functions along x and y, for each plane.
fn products(
    planes: usize,
    width: usize,
    height: usize,
    function: fn(usize, usize, usize) -> f32,
) -> Vec<Vec<f32>> {
    let mut vectors = Vec::new();
    for fy in 0..FREQUENCIES.min(height) {
        for fx in 0..FREQUENCIES.min(width) {
            for plane in 0..planes {
                let mut vector = vec![0.0; width * height * planes];
                for (texel, value) in vector[plane..].iter_mut().step_by(planes).enumerate() {
                    *value = function(fx, texel % width, width) * function(fy, texel / width, height);
                }
                vectors.push(normalised(vector));
            }
        }
    }
    vectors
}

/// The discrete cosine of a frequency at a place (Ahmed, Natarajan, Rao, 1974).
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

/// Gram-Schmidt, twice for accuracy; vectors that depend on earlier ones are left out.
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

/// In eight interleaved sums, so that it can use vector units.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let mut sums = [0.0f32; 8];
    let (heads_a, tail_a) = a.as_chunks::<8>();
    let (heads_b, tail_b) = b.as_chunks::<8>();
    for (x, y) in heads_a.iter().zip(heads_b) {
        (0..8).for_each(|i| sums[i] += x[i] * y[i]);
    }
    sums.iter().sum::<f32>() + tail_a.iter().zip(tail_b).map(|(x, y)| x * y).sum::<f32>()
}

/// Unit vectors as integers of a length such that projections of differences of codes fit 31 bits.
fn rounded(vectors: &[Vec<f32>], length: usize) -> Vec<Vec<i16>> {
    let longest_difference = f64::from(MAX_CODE) * (length as f64).sqrt();
    // Rounding lengthens a vector by half a unit a component at most.
    let unit = (f64::from(1u32 << 31) / longest_difference - (length as f64).sqrt()).clamp(1.0, 16_384.0);
    let round = |v: &f32| (f64::from(*v) * unit).round() as i16;
    vectors.iter().map(|v| v.iter().map(round).collect()).collect()
}

/// Gershgorin's bound on the eigenvalues of the kernels' inner products.
fn largest_eigenvalue_bound(weights: &[Vec<i16>]) -> f64 {
    let inner =
        |a: &[i16], b: &[i16]| -> i64 { a.iter().zip(b).map(|(x, y)| i64::from(*x) * i64::from(*y)).sum() };
    let row = |a: &Vec<i16>| weights.iter().map(|b| inner(a, b).abs()).sum::<i64>();
    weights.iter().map(row).max().unwrap_or(1).max(1) as f64
}
