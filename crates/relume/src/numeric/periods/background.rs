//! How far the mean correlation at some shifts deviates by chance.
//!
//! The correlation of unrelated parts of a texture is a sum of products; its variance at a shift is the sum of
//! the squared correlation over all shifts, divided by the texels of the overlap (M. S. Bartlett, On the
//! theoretical specification and sampling properties of autocorrelated time-series, 1946, for the plane). That
//! sum is an area: as many texels as count for one observation. It is taken over all shifts within reach where
//! lattices are believed or not, which counts repeats as evidence only as far as they exceed what the texture
//! does anyway, and over the nearest shifts where lattices are compared.

use crate::numeric::autocorrelation::Autocorrelation;

/// The least share of what is not grain: a tenth of the variance, below which extrapolation is noise.
const LEAST_SMOOTH: f64 = 0.1;

/// The correlation of a texture with itself in general.
#[derive(Debug, Clone)]
pub struct Background {
    /// The texels that count for one observation, over all shifts.
    area: f64,
    /// The same, of the shifts shorter than each whole length.
    near: Vec<f64>,
    /// The share of the variance that is not the grain of single texels.
    smooth: f64,
}

impl Background {
    /// Sums a correlation.
    pub fn new(correlation: &Autocorrelation) -> Self {
        let (across, down) = (correlation.reach().width as isize, correlation.reach().height as isize);
        let mut near = vec![0.0; across.unsigned_abs() + down.unsigned_abs() + 1];
        let (mut squares, mut weights) = (0.0, 0.0);
        for (dx, dy) in (0..=down).flat_map(|dy| (-across..=across).map(move |dx| (dx, dy))) {
            if dy == 0 && dx <= 0 {
                continue;
            }
            let shift = [dx as f64, dy as f64];
            let (square, weight) = (correlation.at(dx, dy).powi(2), correlation.overlap(shift));
            near[shift[0].hypot(shift[1]) as usize] += 2.0 * square;
            squares += weight * square;
            weights += weight;
        }
        let mut sum = 1.0;
        for value in &mut near {
            sum += *value;
            *value = sum;
        }
        let area = 1.0 + squares / f64::max(weights, 1.0) * correlation.size().texels() as f64;
        Self { area, near, smooth: smooth(correlation) }
    }

    /// The standard deviation of a mean correlation whose overlaps sum to `texels`.
    pub fn deviation(&self, texels: f64) -> f64 {
        (self.area / texels.max(1.0)).sqrt()
    }

    /// The same where only shifts shorter than `length` are counted.
    pub fn near_deviation(&self, texels: f64, length: f64) -> f64 {
        let area = self.near[(length as usize).min(self.near.len() - 1)];
        (area / texels.max(1.0)).sqrt()
    }

    /// A share of the variance as a share of what is not grain, at most 1.
    pub fn of_smooth(&self, share: f64) -> f64 {
        (share / self.smooth).clamp(0.0, 1.0)
    }
}

/// The correlation at shift 0 extrapolated from shifts of one and two texels (the nugget of a variogram: G.
/// Matheron, Principles of geostatistics, 1963).
fn smooth(correlation: &Autocorrelation) -> f64 {
    let mean = |step: isize| 0.5 * (correlation.at(step, 0) + correlation.at(0, step));
    (2.0 * mean(1) - mean(2)).max(mean(1)).clamp(LEAST_SMOOTH, 1.0)
}
