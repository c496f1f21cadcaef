//! The discrete Fourier transform of real images, of any size.
//!
//! F(k, l) = sum f(x, y) exp(-2 pi i (k x / width + l y / height)); the inverse divides by the number of
//! texels. Only bins k = 0..=width/2 are kept: the others are their conjugates. A spectrum is stored column
//! after column (all l of one k together), so that both passes run along memory. Rows and columns are
//! transformed independently in parallel: the result does not depend on threads. [`Fourier::forward_direct`]
//! is the slow truth.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

use crate::error::Result;
use crate::job::Job;
use crate::parallel;
use crate::size::Size;

/// Bytes per texel of a transform in progress: the image or the spectrum, and its transpose.
pub const BYTES_PER_TEXEL: u64 = 8 + 8;

const NOT_CANCELLED: &str = "a job of its own is not cancelled";

/// The plans for images of one size.
pub struct Fourier {
    size: Size,
    rows: Arc<dyn RealToComplex<f64>>,
    rows_back: Arc<dyn ComplexToReal<f64>>,
    columns: Arc<dyn Fft<f64>>,
    columns_back: Arc<dyn Fft<f64>>,
}

impl Fourier {
    /// Plans the transforms of images of `size`.
    ///
    /// # Panics
    /// When a side is zero.
    pub fn new(size: Size) -> Self {
        assert!(size.texels() > 0, "an image has texels");
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        Self {
            size,
            rows: real.plan_fft_forward(size.width),
            rows_back: real.plan_fft_inverse(size.width),
            columns: complex.plan_fft_forward(size.height),
            columns_back: complex.plan_fft_inverse(size.height),
        }
    }

    /// The size of the images.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The number of kept columns of a spectrum: width / 2 + 1.
    pub fn columns(&self) -> usize {
        self.size.width / 2 + 1
    }

    /// The spectrum of an image, column after column.
    ///
    /// # Panics
    /// When the image has another size.
    pub fn forward(&self, image: Vec<f64>) -> Vec<Complex64> {
        self.forward_within(image, &Job::default()).expect(NOT_CANCELLED)
    }

    /// [`Fourier::forward`] as a part of a job, which ends it when it is cancelled; memory is the caller's
    /// matter ([`BYTES_PER_TEXEL`]).
    ///
    /// # Errors
    /// [`ErrorKind::Cancelled`](crate::ErrorKind::Cancelled).
    ///
    /// # Panics
    /// As [`Fourier::forward`].
    pub fn forward_within(&self, image: Vec<f64>, job: &Job) -> Result<Vec<Complex64>> {
        assert_eq!(image.len(), self.size.texels(), "an image of the planned size");
        self.spectrum_of_top(image, job)
    }

    /// The spectrum of an image given by its top rows; the others are zero.
    ///
    /// # Panics
    /// When they are not whole rows, or there are too many.
    pub fn forward_top(&self, rows: Vec<f64>) -> Vec<Complex64> {
        self.spectrum_of_top(rows, &Job::default()).expect(NOT_CANCELLED)
    }

    fn spectrum_of_top(&self, mut rows: Vec<f64>, job: &Job) -> Result<Vec<Complex64>> {
        let Size { width, height } = self.size;
        assert!(rows.len().is_multiple_of(width) && rows.len() <= self.size.texels(), "rows of the image");
        let mut by_rows = vec![Complex64::ZERO; self.columns() * (rows.len() / width)];
        let each = by_rows.chunks_exact_mut(self.columns()).zip(rows.chunks_exact_mut(width));
        parallel::try_for_each(each, |(bins, row)| {
            self.rows.process(row, bins).expect("rows and bins have the planned lengths");
            job.proceed()
        })?;
        drop(rows);
        let mut spectrum = turned(&by_rows, self.columns(), height);
        drop(by_rows);
        transform_columns(&mut spectrum, &*self.columns, height, job)?;
        Ok(spectrum)
    }

    /// The image of a spectrum. Imaginary parts that no real image has are discarded.
    ///
    /// # Panics
    /// When the spectrum has another size.
    pub fn inverse(&self, spectrum: Vec<Complex64>) -> Vec<f64> {
        self.inverse_within(spectrum, &Job::default()).expect(NOT_CANCELLED)
    }

    /// [`Fourier::inverse`] as a part of a job, as [`Fourier::forward_within`].
    ///
    /// # Errors
    /// [`ErrorKind::Cancelled`](crate::ErrorKind::Cancelled).
    ///
    /// # Panics
    /// As [`Fourier::inverse`].
    pub fn inverse_within(&self, mut spectrum: Vec<Complex64>, job: &Job) -> Result<Vec<f64>> {
        let Size { width, height } = self.size;
        assert_eq!(spectrum.len(), self.columns() * height, "a spectrum of the planned size");
        transform_columns(&mut spectrum, &*self.columns_back, height, job)?;
        let mut by_rows = turned(&spectrum, height, self.columns());
        drop(spectrum);
        let mut image = vec![0.0; self.size.texels()];
        let each = image.chunks_exact_mut(width).zip(by_rows.chunks_exact_mut(self.columns()));
        parallel::try_for_each(each, |(row, bins)| {
            bins[0].im = 0.0;
            if width.is_multiple_of(2) {
                bins[width / 2].im = 0.0;
            }
            self.rows_back.process(bins, row).expect("rows and bins have the planned lengths");
            job.proceed()
        })?;
        let scale = 1.0 / self.size.texels() as f64;
        image.iter_mut().for_each(|value| *value *= scale);
        Ok(image)
    }

    /// The slow truth of [`Fourier::forward`]: the defining sum.
    pub fn forward_direct(&self, image: &[f64]) -> Vec<Complex64> {
        let Size { width, height } = self.size;
        let bin = |k: usize, l: usize| -> Complex64 {
            let turn =
                |i: usize| (k * (i % width)) as f64 / width as f64 + (l * (i / width)) as f64 / height as f64;
            image.iter().enumerate().map(|(i, value)| value * Complex64::cis(-TAU * turn(i))).sum()
        };
        (0..self.columns()).flat_map(|k| (0..height).map(move |l| (k, l))).map(|(k, l)| bin(k, l)).collect()
    }
}

/// Transforms each column of a spectrum in place.
fn transform_columns(
    spectrum: &mut [Complex64],
    transform: &dyn Fft<f64>,
    height: usize,
    job: &Job,
) -> Result<()> {
    parallel::try_for_each(spectrum.chunks_exact_mut(height), |column| {
        transform.process(column);
        job.proceed()
    })
}

/// The transpose of a matrix with rows of `length` entries, each resulting row padded with zeros to `filled`
/// entries.
fn turned(matrix: &[Complex64], length: usize, filled: usize) -> Vec<Complex64> {
    let mut out = vec![Complex64::ZERO; length * filled];
    parallel::for_each(out.chunks_exact_mut(filled).enumerate(), |(column, entries)| {
        let from = matrix[column.min(matrix.len())..].iter().step_by(length);
        entries.iter_mut().zip(from).for_each(|(entry, value)| *entry = *value);
    });
    out
}

/// The least length of at least `n` that transforms fast: a product of twos, threes and fives.
pub fn fast_length(n: usize) -> usize {
    let smooth = |mut m: usize| {
        for factor in [2, 3, 5] {
            while m.is_multiple_of(factor) {
                m /= factor;
            }
        }
        m == 1
    };
    (n.max(1)..).find(|&m| smooth(m)).expect("there is a power of two")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    const SIZES: [(usize, usize); 9] =
        [(1, 1), (2, 1), (1, 3), (5, 2), (4, 4), (7, 11), (12, 9), (16, 6), (13, 17)];

    fn noise(size: Size) -> Vec<f64> {
        let mut stream = Stream::new(9, Purpose::Sample, [size.texels() as u64]);
        (0..size.texels()).map(|_| stream.unit() - 0.3).collect()
    }

    #[test]
    fn transforms_are_the_defining_sum_and_come_back() {
        for (width, height) in SIZES {
            let plan = Fourier::new(Size::new(width, height));
            let image = noise(plan.size());
            let spectrum = plan.forward(image.clone());
            let truth = plan.forward_direct(&image);
            assert_eq!(spectrum.len(), truth.len());
            for (fast, slow) in spectrum.iter().zip(&truth) {
                assert!((fast - slow).norm() < 1e-12 * image.len() as f64, "{width} x {height}");
            }
            let filled = height / 2;
            let mut top = image.clone();
            top[filled * width..].fill(0.0);
            assert_eq!(plan.forward_top(top[..filled * width].to_vec()), plan.forward(top));
            let back = plan.inverse(spectrum);
            assert!(back.iter().zip(&image).all(|(a, b)| (a - b).abs() < 1e-14), "{width} x {height}");
        }
    }

    #[test]
    fn fast_lengths_are_the_least() {
        let expected =
            [(0, 1), (1, 1), (7, 8), (11, 12), (13, 15), (17, 18), (97, 100), (257, 270), (1000, 1000)];
        assert!(expected.into_iter().all(|(n, fast)| fast_length(n) == fast));
    }
}
