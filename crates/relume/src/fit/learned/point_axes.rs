//! The mean and the main axes of a set of points.

use crate::numeric::{Matrix, eigen};

/// Steps of subspace iteration in each round; the axes of the round before are near.
const STEPS: usize = 3;

/// A squared length below this share of what it was is that of rounding errors.
const NOTHING: f64 = 1e-20;

/// A mean and orthonormal axes.
#[derive(Debug, Clone)]
pub(super) struct PointCluster {
    mean: Vec<f64>,
    /// One row for each axis.
    axes: Matrix,
}

impl PointCluster {
    /// A point, without axes.
    pub fn at(mean: &[f32]) -> Self {
        let mean: Vec<f64> = mean.iter().map(|&v| f64::from(v)).collect();
        Self { axes: Matrix::zeros(0, mean.len()), mean }
    }

    /// With the first axes of the space.
    pub fn with_axes(self, axes: usize) -> Self {
        let axes = Matrix::from_fn(axes, self.mean.len(), |j, k| f64::from(u8::from(j == k)));
        Self { axes, ..self }
    }

    /// The mean and main axes of points, found from these; without points these.
    pub fn of_points(&self, points: &[&[f32]]) -> Self {
        if points.is_empty() {
            return self.clone();
        }
        let n = self.mean.len();
        let mut mean = vec![0.0; n];
        for point in points {
            mean.iter_mut().zip(*point).for_each(|(sum, v)| *sum += f64::from(*v));
        }
        mean.iter_mut().for_each(|sum| *sum /= points.len() as f64);
        let mut moments = Matrix::zeros(n, n);
        let mut from_mean = vec![0.0; n];
        for point in points {
            from_mean.iter_mut().zip(*point).zip(&mean).for_each(|((d, v), m)| *d = f64::from(*v) - m);
            for j in 0..n {
                let factor = from_mean[j];
                moments.row_mut(j)[..=j].iter_mut().zip(&from_mean).for_each(|(sum, v)| *sum += factor * v);
            }
        }
        let moments = Matrix::from_fn(n, n, |j, k| moments[(j.max(k), j.min(k))]);
        let mut axes = self.axes.clone();
        for _ in 0..STEPS {
            axes = orthonormal(&axes.times(&moments), &axes);
        }
        // Along the main axes of the subspace, the longest first.
        let (_, turn) = eigen::symmetric(&axes.times(&moments).times(&axes.transposed()));
        Self { mean, axes: turn.times(&axes) }
    }

    /// As it is stored, in `f32`.
    pub fn rounded(&self) -> Self {
        let round = |v: f64| f64::from(v as f32);
        let axes = Matrix::from_fn(self.axes.rows(), self.axes.cols(), |j, k| round(self.axes[(j, k)]));
        Self { mean: self.mean.iter().map(|v| round(*v)).collect(), axes }
    }

    /// The mean, then each axis.
    pub fn coefficients(&self) -> impl Iterator<Item = f32> + '_ {
        let axes = (0..self.axes.rows()).flat_map(|j| self.axes.row(j));
        self.mean.iter().chain(axes).map(|v| *v as f32)
    }

    /// A point from the mean.
    pub fn subtract_mean(&self, point: &[f32], out: &mut [f64]) {
        out.iter_mut().zip(point).zip(&self.mean).for_each(|((d, v), m)| *d = f64::from(*v) - m);
    }

    /// The coordinate along an axis.
    pub fn along(&self, axis: usize, from_mean: &[f64]) -> f64 {
        self.axes.row(axis).iter().zip(from_mean).map(|(a, d)| a * d).sum()
    }

    /// The squared distance of a point from the plane of the axes through the mean; `scratch` is of the length of the
    /// point.
    pub fn square_distance(&self, point: &[f32], scratch: &mut [f64]) -> f64 {
        self.subtract_mean(point, scratch);
        let whole: f64 = scratch.iter().map(|d| d * d).sum();
        whole - (0..self.axes.rows()).map(|j| self.along(j, scratch).powi(2)).sum::<f64>()
    }
}

/// Rows made orthonormal in order; where one is a combination of those before, the row of `fallback`, and then the axes
/// of the space take its place.
fn orthonormal(rows: &Matrix, fallback: &Matrix) -> Matrix {
    let n = rows.cols();
    let mut found = Matrix::zeros(rows.rows(), n);
    for j in 0..rows.rows() {
        let unit = (0..n).map(|k| (0..n).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>());
        let candidates = [rows.row(j).to_vec(), fallback.row(j).to_vec()].into_iter().chain(unit);
        let row = candidates.filter_map(|row| outside(&found, j, row)).next();
        found.row_mut(j).copy_from_slice(&row.expect("fewer axes than dimensions"));
    }
    found
}

/// The direction of what is left of a row outside the space of the first `count` rows of an orthonormal matrix.
fn outside(found: &Matrix, count: usize, mut row: Vec<f64>) -> Option<Vec<f64>> {
    let square = |row: &[f64]| row.iter().map(|v| v * v).sum::<f64>();
    let before = square(&row);
    // Twice, for full precision.
    for i in (0..count).chain(0..count) {
        let share: f64 = found.row(i).iter().zip(&row).map(|(a, b)| a * b).sum();
        row.iter_mut().zip(found.row(i)).for_each(|(v, a)| *v -= share * a);
    }
    let left = square(&row);
    if left.is_nan() || left <= NOTHING * before || left == 0.0 {
        return None;
    }
    row.iter_mut().for_each(|v| *v /= left.sqrt());
    Some(row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn the_axes_are_those_of_the_eigenvectors() {
        let mut stream = Stream::new(2, Purpose::Sample, [0]);
        let scale = [4.0, 3.0, 2.0, 0.3, 0.1];
        let points: Vec<Vec<f32>> =
            (0..200).map(|_| scale.iter().map(|s| (s * (stream.unit() - 0.5)) as f32).collect()).collect();
        let points: Vec<&[f32]> = points.iter().map(Vec::as_slice).collect();
        let mut cluster = PointCluster::at(&[0.0, 1.0, 0.0, 0.0, 1.0]).with_axes(3);
        (0..12).for_each(|_| cluster = cluster.of_points(&points));
        let mut scratch = [0.0; 5];
        let found: f64 = points.iter().map(|p| cluster.square_distance(p, &mut scratch)).sum();
        let moments = Matrix::from_fn(5, 5, |j, k| {
            let centred = |p: &[f32], i: usize| f64::from(p[i]) - cluster.mean[i];
            points.iter().map(|p| centred(p, j) * centred(p, k)).sum()
        });
        let (values, _) = eigen::symmetric(&moments);
        let truth: f64 = values[3..].iter().sum();
        assert!((found / truth - 1.0).abs() < 1e-4, "{found} and {truth}");
    }

    #[test]
    fn few_points_and_equal_ones_have_axes_too() {
        let cluster = PointCluster::at(&[0.0; 4]).with_axes(3);
        for points in
            [&[][..], &[&[1.0f32, 2.0, 0.0, 0.0][..]; 3], &[&[1.0, 0.0, 0.0, 0.0], &[0.0, 1.0, 0.0, 0.0]]]
        {
            let found = cluster.of_points(points);
            let products = found.axes.times(&found.axes.transposed());
            for (j, k) in (0..3).flat_map(|j| (0..3).map(move |k| (j, k))) {
                assert!((products[(j, k)] - f64::from(u8::from(j == k))).abs() < 1e-12);
            }
            for point in points {
                assert!(found.square_distance(point, &mut [0.0; 4]) < 1e-12);
            }
        }
    }
}
