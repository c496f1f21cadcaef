//! The principal axes of the values of planes (K. Pearson, On lines and planes of closest fit to systems of
//! points in space, 1901): the eigenvectors of their covariance.

use super::Matrix;
use super::eigen;
use crate::planes::Planes;

/// The mean of each plane, and the principal axes of the values as rows, largest variance first.
pub fn axes(planes: &Planes) -> (Vec<f32>, Matrix) {
    let texels = planes.size().texels() as f64;
    let mean = |plane: &[f32]| plane.iter().map(|&v| f64::from(v)).sum::<f64>() / texels;
    let means: Vec<f64> = planes.iter().map(mean).collect();
    let covariance = Matrix::from_fn(planes.count(), planes.count(), |j, k| {
        let values = planes.plane(j).iter().zip(planes.plane(k));
        values.map(|(a, b)| (f64::from(*a) - means[j]) * (f64::from(*b) - means[k])).sum::<f64>() / texels
    });
    (means.iter().map(|&m| m as f32).collect(), eigen::symmetric(&covariance).1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    #[test]
    fn the_first_axis_is_that_of_the_spread() {
        // Values along (3, 4) / 5, and a little across.
        let along = |i: usize| i as f32 - 50.0;
        let across = |i: usize| if i.is_multiple_of(2) { 0.1 } else { -0.1 };
        let first = (0..100).map(|i| 0.6 * along(i) - 0.8 * across(i) + 7.0);
        let second = (0..100).map(|i| 0.8 * along(i) + 0.6 * across(i));
        let planes = Planes::from_vec(Size::new(10, 10), 2, first.chain(second).collect()).unwrap();
        let (means, axes) = axes(&planes);
        assert!((means[0] - 6.7).abs() < 1e-4);
        assert!((axes[(0, 0)].abs() - 0.6).abs() < 1e-3 && (axes[(0, 1)].abs() - 0.8).abs() < 1e-3);
    }
}
