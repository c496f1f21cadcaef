//! Slow changes of light: the polynomial of second degree in x and y closest to each plane.
//!
//! Uneven light and vignetting are mostly of this form. The fit is by least squares: the powers are
//! orthonormalised over the texels by the Cholesky factor of their inner products. The remainder is the
//! texture itself, whose autocorrelation is then independent of the light.

use crate::numeric::Matrix;
use crate::planes::Planes;
use crate::size::Size;

/// Powers (i, j) of x and y, the constant first.
const POWERS: [(i32, i32); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

/// The planes minus their trends (the means stay), and the share of the trends in the variance of all planes.
pub fn removed(planes: &Planes) -> (Planes, f64) {
    let size = planes.size();
    let basis = TrendBasis::new(size);
    let (mut even, mut slow, mut all) = (planes.clone(), 0.0, 0.0);
    for plane in even.iter_mut() {
        let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
        let weights = basis.weights(plane, mean);
        for (i, value) in plane.iter_mut().enumerate() {
            let about = f64::from(*value) - mean;
            let trend = basis.value(&weights, i);
            all += about * about;
            slow += trend * trend;
            *value = (f64::from(*value) - trend) as f32;
        }
    }
    (even, if all > 0.0 { (slow / all).min(1.0) } else { 0.0 })
}

/// The trend of each plane, and the same stretched to another size.
pub fn stretched(planes: &Planes, size: Size) -> [Planes; 2] {
    let basis = TrendBasis::new(planes.size());
    let mean = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
    let weights: Vec<[f64; 6]> = planes.iter().map(|plane| basis.weights(plane, mean(plane))).collect();
    [planes.size(), size].map(|size| {
        let mut trends = Planes::zeros(size, planes.count());
        for (trend, weights) in trends.iter_mut().zip(&weights) {
            trend
                .iter_mut()
                .enumerate()
                .for_each(|(i, value)| *value = sum(weights, &powers(size, i)) as f32);
        }
        trends
    })
}

/// Six polynomials that are orthonormal over the texels.
struct TrendBasis {
    size: Size,
    /// Coefficients of the powers, in columns: polynomial p is sum_k combine[(k, p)] power_k.
    combine: Matrix,
}

impl TrendBasis {
    fn new(size: Size) -> Self {
        // Sums of products over all texels factor into sums over columns and over rows.
        let moments = |n: usize| -> Vec<f64> {
            (0..5).map(|p| (0..n).map(|i| place(i, n).powi(p)).sum::<f64>()).collect()
        };
        let (mx, my) = (moments(size.width), moments(size.height));
        let gram = Matrix::from_fn(6, 6, |a, b| {
            mx[(POWERS[a].0 + POWERS[b].0) as usize] * my[(POWERS[a].1 + POWERS[b].1) as usize]
        });
        let factor = gram.cholesky().expect("powers are independent on sides of three texels and more");
        Self { size, combine: factor.lower_inverse().transposed() }
    }

    fn weights(&self, plane: &[f32], mean: f64) -> [f64; 6] {
        let mut sums = [0.0; 6];
        for (i, &value) in plane.iter().enumerate() {
            let powers = powers(self.size, i);
            (0..6).for_each(|k| sums[k] += powers[k] * (f64::from(value) - mean));
        }
        // The coefficients of the powers: combine combine' sums.
        let along: Vec<f64> = (0..6).map(|p| (0..6).map(|k| self.combine[(k, p)] * sums[k]).sum()).collect();
        std::array::from_fn(|k| (0..6).map(|p| self.combine[(k, p)] * along[p]).sum())
    }

    fn value(&self, weights: &[f64; 6], texel: usize) -> f64 {
        sum(weights, &powers(self.size, texel))
    }
}

/// The powers at a texel.
fn powers(size: Size, texel: usize) -> [f64; 6] {
    let (x, y) = (place(texel % size.width, size.width), place(texel / size.width, size.height));
    [1.0, x, y, x * x, x * y, y * y]
}

fn sum(weights: &[f64; 6], powers: &[f64; 6]) -> f64 {
    powers.iter().zip(weights).map(|(power, weight)| power * weight).sum()
}

/// The position of texel `i` of `n` on [-1, 1].
fn place(i: usize, n: usize) -> f64 {
    (2 * i + 1) as f64 / n as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stretched_trend_runs_from_side_to_side() {
        let size = Size::new(40, 30);
        let ramp = |i: usize| (3.0 * place(i / 40, 30) + place(i % 40, 40).powi(2)) as f32;
        let noisy = (0..size.texels()).map(|i| ramp(i) + if i % 2 == 0 { 0.1 } else { -0.1 }).collect();
        let planes = Planes::from_vec(size, 1, noisy).unwrap();
        let [own, wide] = stretched(&planes, Size::new(80, 90));
        let from = |i: usize| (3.0 * place(i / 80, 90) + place(i % 80, 80).powi(2)) as f32;
        let shift = own.as_slice()[0] - ramp(0);
        assert!(own.as_slice().iter().enumerate().all(|(i, v)| (v - ramp(i) - shift).abs() < 0.02));
        assert!(wide.as_slice().iter().enumerate().all(|(i, v)| (v - from(i) - shift).abs() < 0.02));
    }
}
