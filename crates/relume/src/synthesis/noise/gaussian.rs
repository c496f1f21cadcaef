//! Transport between the values of a plane and normal values: one-dimensional optimal transport.
//!
//! A value is mapped to the normal quantile of its rank; equal values share the mean of their ranks. The
//! inverse is a table over evenly spaced normal values, interpolated linearly.

use crate::numeric::normal::{cumulative, quantile};

/// Entries of the inverse table. Normal values are half a hundredth apart: finer than the gaps of the 65,536
/// ranks of a 256 x 256 exemplar except in the tails.
const ENTRIES: usize = 1601;

/// The largest normal value of the table; one value in 31,000 lies beyond it.
pub const REACH: f64 = 4.0;

/// The inverse transport from normal values to the values of a plane.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussianTransport {
    table: Vec<f32>,
}

/// Normal values for the values of a plane, with the inverse. The values of the plane are finite.
pub fn transport(plane: &[f32]) -> (Vec<f32>, GaussianTransport) {
    let mut order: Vec<usize> = (0..plane.len()).collect();
    order.sort_by(|&a, &b| plane[a].total_cmp(&plane[b]));
    let mut normal = vec![0.0; plane.len()];
    let mut start = 0;
    while start < order.len() {
        let value = plane[order[start]];
        let end = start + order[start..].partition_point(|&i| plane[i] <= value);
        let middle = 0.5 * (start + end) as f64 / order.len() as f64;
        let shared = quantile(middle) as f32;
        order[start..end].iter().for_each(|&i| normal[i] = shared);
        start = end;
    }
    let sorted: Vec<f32> = order.iter().map(|&i| plane[i]).collect();
    (normal, GaussianTransport::of_sorted(&sorted))
}

impl GaussianTransport {
    fn of_sorted(sorted: &[f32]) -> Self {
        let last = sorted.len() - 1;
        let entry = |i: usize| {
            let g = REACH * (2.0 * i as f64 / (ENTRIES - 1) as f64 - 1.0);
            let place = (cumulative(g) * sorted.len() as f64 - 0.5).clamp(0.0, last as f64);
            let (below, share) = (place.floor() as usize, place.fract() as f32);
            sorted[below] + share * (sorted[(below + 1).min(last)] - sorted[below])
        };
        Self { table: (0..ENTRIES).map(entry).collect() }
    }

    /// The values of the plane for evenly spaced normal ones from -[`REACH`] to [`REACH`].
    pub fn table(&self) -> &[f32] {
        &self.table
    }

    /// The value of the plane for a normal one.
    pub fn value(&self, normal: f32) -> f32 {
        let place = (normal / REACH as f32 * 0.5 + 0.5) * (ENTRIES - 1) as f32;
        let place = place.clamp(0.0, (ENTRIES - 1) as f32);
        let (below, share) = (place as usize, place.fract());
        let next = self.table[(below + 1).min(ENTRIES - 1)];
        self.table[below] + share * (next - self.table[below])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn values_become_normal_and_come_back() {
        let mut stream = Stream::new(5, Purpose::Sample, [0]);
        let plane: Vec<f32> = (0..40_000).map(|_| stream.unit().powi(3) as f32).collect();
        let (normal, back) = transport(&plane);
        let moment = |p: i32| normal.iter().map(|&g| f64::from(g).powi(p)).sum::<f64>() / 40_000.0;
        for (power, expected) in [(1, 0.0), (2, 1.0), (3, 0.0), (4, 3.0)] {
            assert!((moment(power) - expected).abs() < 0.01, "moment {power}: {}", moment(power));
        }
        for (value, g) in plane.iter().zip(&normal).filter(|(_, g)| g.abs() < 3.0) {
            assert!((back.value(*g) - value).abs() < 0.005);
        }
    }

    #[test]
    fn equal_values_stay_equal_and_single_ones_are_found() {
        let (normal, back) = transport(&[2.0, 1.0, 2.0, 1.0, 2.0, 2.0]);
        assert_eq!(normal[0], normal[5]);
        assert!((f64::from(normal[1]) - quantile(1.0 / 6.0)).abs() < 1e-6);
        assert_eq!((back.value(-9.0), back.value(9.0)), (1.0, 2.0));
        let (normal, back) = transport(&[0.7]);
        assert!(normal[0].abs() < 1e-6 && back.value(1.0) == 0.7);
    }
}
