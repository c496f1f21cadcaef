//! Structural similarity: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility to
//! Structural Similarity", IEEE Transactions on Image Processing 13, 2004, with its constants: a Gaussian window of 11 x
//! 11 with a deviation of 1.5, K1 = 0.01, K2 = 0.03, for values with a peak of 1.

use crate::error::{Error, Result};
use crate::planes::Planes;
use crate::size::Size;

/// Texels from the middle of the window to its side.
const RADIUS: usize = 5;
const DEVIATION: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The mean similarity over all windows inside the picture, and over planes: 1 for equal planes. Smaller pictures have
/// one window, the whole picture.
///
/// # Errors
/// When sizes or numbers of planes differ.
pub fn ssim(a: &Planes, b: &Planes) -> Result<f64> {
    if (a.size(), a.count()) != (b.size(), b.count()) {
        return Err(Error::usage(format!(
            "{} planes of {} have no similarity to {} planes of {}: both must have the same size",
            a.count(),
            a.size(),
            b.count(),
            b.size()
        )));
    }
    let sum: f64 = a.iter().zip(b.iter()).map(|(x, y)| of_plane(x, y, a.size())).sum();
    Ok(sum / a.count() as f64)
}

fn of_plane(a: &[f32], b: &[f32], size: Size) -> f64 {
    let mean = |f: &dyn Fn(f64, f64) -> f64| {
        let values: Vec<f64> = a.iter().zip(b).map(|(x, y)| f(f64::from(*x), f64::from(*y))).collect();
        blurred(&values, size)
    };
    let (mean_a, mean_b) = (mean(&|x, _| x), mean(&|_, y| y));
    let (aa, bb, ab) = (mean(&|x, _| x * x), mean(&|_, y| y * y), mean(&|x, y| x * y));
    let similarity = |i: usize| {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (va, vb, cov) = (aa[i] - ma * ma, bb[i] - mb * mb, ab[i] - ma * mb);
        (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
    };
    (0..mean_a.len()).map(similarity).sum::<f64>() / mean_a.len() as f64
}

/// The means over all windows inside: along the rows of the picture, and along those of its transpose.
fn blurred(values: &[f64], size: Size) -> Vec<f64> {
    let across = row_means_transposed(values, size.width);
    row_means_transposed(&across, size.height)
}

/// Weighted means along rows of `width` values, as columns.
fn row_means_transposed(values: &[f64], width: usize) -> Vec<f64> {
    let radius = RADIUS.min((width - 1) / 2);
    let weights: Vec<f64> =
        (0..=2 * radius).map(|i| (-0.5 * ((i as f64 - radius as f64) / DEVIATION).powi(2)).exp()).collect();
    let sum: f64 = weights.iter().sum();
    let (rows, places) = (values.len() / width, width - 2 * radius);
    let mut out = vec![0.0; places * rows];
    for (y, row) in values.chunks_exact(width).enumerate() {
        for (x, window) in row.windows(weights.len()).enumerate() {
            let value: f64 = weights.iter().zip(window).map(|(w, v)| w * v).sum();
            out[x * rows + y] = value / sum;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn noise(size: Size, count: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32).collect();
        Planes::from_vec(size, count, data).unwrap()
    }

    /// The definition: every window by itself.
    fn slow(a: &Planes, b: &Planes) -> f64 {
        let size = a.size();
        let mut sum = 0.0;
        let (columns, rows) = (size.width - 10, size.height - 10);
        for k in 0..a.count() {
            for (x0, y0) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
                let mut m = [0.0; 6];
                for (x, y) in (0..11).flat_map(|y| (0..11).map(move |x| (x, y))) {
                    let square = (x as f64 - 5.0).powi(2) + (y as f64 - 5.0).powi(2);
                    let weight = (-square / (2.0 * DEVIATION * DEVIATION)).exp();
                    let (p, q) = (f64::from(a.at(k, x0 + x, y0 + y)), f64::from(b.at(k, x0 + x, y0 + y)));
                    [1.0, p, q, p * p, q * q, p * q].iter().zip(&mut m).for_each(|(v, m)| *m += weight * v);
                }
                let [_, ma, mb, aa, bb, ab] = m.map(|v| v / m[0]);
                sum += (2.0 * ma * mb + C1) * (2.0 * (ab - ma * mb) + C2)
                    / ((ma * ma + mb * mb + C1) * (aa - ma * ma + bb - mb * mb + C2));
            }
        }
        sum / (a.count() * columns * rows) as f64
    }

    #[test]
    fn similarity_is_that_of_the_definition() {
        let (a, b) = (noise(Size::new(23, 17), 3, 1), noise(Size::new(23, 17), 3, 2));
        let found = ssim(&a, &b).unwrap();
        assert!((found - slow(&a, &b)).abs() < 1e-9, "{found} and {}", slow(&a, &b));
        assert!((ssim(&a, &a).unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn small_pictures_and_other_sizes() {
        let one = noise(Size::new(1, 1), 1, 3);
        assert!((ssim(&one, &one).unwrap() - 1.0).abs() < 1e-12);
        let thin = noise(Size::new(1, 30), 1, 4);
        assert!((ssim(&thin, &thin).unwrap() - 1.0).abs() < 1e-12);
        assert!(ssim(&one, &thin).is_err());
    }
}
