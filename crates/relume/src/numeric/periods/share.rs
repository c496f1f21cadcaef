//! The share of the variance that repeats with a period: the correlation at multiples of the period, minus
//! the background.
//!
//! With the mean correlation m at the multiples and the mean b over the cells between them, the share is (m -
//! b) / (1 - b): slow changes raise both and cancel, and a purely periodic texture has share 1.

/// The mean correlations at multiples and in between.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tally {
    at: f64,
    points: usize,
    between: f64,
    places: usize,
}

impl Tally {
    /// Adds the correlation at a multiple.
    pub fn add_point(&mut self, correlation: f64) {
        self.at += correlation;
        self.points += 1;
    }

    /// Adds a correlation in between.
    pub fn add_between(&mut self, correlation: f64) {
        self.between += correlation;
        self.places += 1;
    }

    /// The number of multiples counted.
    pub fn points(&self) -> usize {
        self.points
    }

    /// The share of the variance that repeats; 0 without data.
    pub fn share(&self) -> f64 {
        let mean = |sum: f64, count: usize| if count == 0 { 0.0 } else { sum / count as f64 };
        let background = mean(self.between, self.places);
        (mean(self.at, self.points) - background) / (1.0 - background).max(1e-9)
    }
}
