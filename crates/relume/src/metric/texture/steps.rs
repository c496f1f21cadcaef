//! Steps between neighbouring texels.

use crate::planes::Planes;

/// A mean of squared steps.
#[derive(Debug, Clone, Copy, Default)]
pub struct NeighbourSteps {
    sum: f64,
    count: usize,
}

impl NeighbourSteps {
    /// Adds the step between two texels: the sum over planes of squared differences.
    pub fn add(&mut self, planes: &Planes, here: usize, there: usize) {
        self.sum += planes
            .iter()
            .map(|plane| (f64::from(plane[here]) - f64::from(plane[there])).powi(2))
            .sum::<f64>();
        self.count += 1;
    }

    /// Adds the steps of another tally.
    pub fn merge(&mut self, other: Self) {
        self.sum += other.sum;
        self.count += other.count;
    }

    /// The number of steps.
    pub fn count(&self) -> usize {
        self.count
    }

    /// The root mean square step; 0 without steps.
    pub fn rms(&self) -> f64 {
        (self.sum / self.count.max(1) as f64).sqrt()
    }
}

/// One step divided by another; equal ones, including zeros, give 1.
pub fn ratio(across: f64, inside: f64) -> f64 {
    if across == inside { 1.0 } else { across / inside }
}
