//! The model of one level of the pyramid.

use super::local_gain::LocalGain;
use super::neighbourhood::{Offset, Reach};

/// A causal autoregressive field of m planes, driven by noise and by the expanded coarser level.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// Causal neighbours of the level itself.
    pub neighbours: Vec<Offset>,
    /// Neighbours in the expanded coarser level, in any direction.
    pub coarse: Vec<Offset>,
    /// What each neighbour's planes contribute, the causal ones first.
    pub weights: Weights,
    /// The lower triangular factor of the noise covariance, row after row, m (m + 1) / 2 numbers.
    pub noise: Vec<f32>,
    /// What the field is multiplied by from place to place, given the expanded coarser level.
    pub gain: Option<LocalGain>,
    /// The deviation of the logarithm of its random strength from place to place, in steps of
    /// [`super::unevenness`].
    pub unevenness: u8,
    /// Texels after which a start from nothing no longer shows; see [`super::stability`].
    pub burn_in: usize,
    /// ln p(Y) of the neighbourhood, in nats.
    pub log_evidence: f32,
    /// Texels that the estimate rests on.
    pub texels: u32,
}

impl Level {
    /// The number of planes m.
    pub fn planes(&self) -> usize {
        self.weights.columns.len()
    }

    /// How far the causal neighbours lie.
    pub fn reach(&self) -> Reach {
        Reach::of(&self.neighbours)
    }
}

/// Weights as whole multiples of steps: row step times column step. Regressor rows come neighbour
/// after neighbour, the m planes of each together; rows of one plane have one step, the causal
/// neighbours' other than the coarse ones'.
#[derive(Debug, Clone, PartialEq)]
pub struct Weights {
    /// One for each regressor and predicted plane, regressor after regressor.
    pub codes: Vec<i32>,
    /// Steps of the m planes of causal neighbours, then of the m planes of coarse ones.
    pub rows: Vec<f32>,
    /// Steps of the m predicted planes.
    pub columns: Vec<f32>,
    /// How many neighbours are causal.
    pub causal: usize,
}

/// Codes are at most this in size.
pub const MAX_CODE: i32 = 1 << 20;

impl Weights {
    /// The codes nearest to some weights.
    ///
    /// # Panics
    /// When there are not as many weights as steps ask for.
    pub fn nearest(weights: &[f64], causal: usize, rows: Vec<f32>, columns: Vec<f32>) -> Self {
        let m = columns.len();
        assert!(rows.len() == 2 * m && weights.len().is_multiple_of(m * m), "weights of whole neighbours");
        let mut coded = Self { codes: vec![0; weights.len()], rows, columns, causal };
        for (i, &weight) in weights.iter().enumerate() {
            let code = (weight / f64::from(coded.step(i))).round();
            coded.codes[i] = code.clamp(-f64::from(MAX_CODE), f64::from(MAX_CODE)) as i32;
        }
        coded
    }

    /// The step of weight number `i`.
    fn step(&self, i: usize) -> f32 {
        let m = self.columns.len();
        let (row, column) = (i / m, i % m);
        let set = if row / m < self.causal { 0 } else { m };
        self.rows[set + row % m] * self.columns[column]
    }

    /// The weights of the causal neighbours, or of the coarse ones: for each neighbour and each of its
    /// planes the m weights in the predicted planes.
    pub fn values(&self, coarse: bool) -> Vec<f32> {
        let split = self.causal * self.columns.len().pow(2);
        let range = if coarse { split..self.codes.len() } else { 0..split };
        range.map(|i| self.codes[i] as f32 * self.step(i)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_rounded_to_their_own_steps() {
        let truth: Vec<f64> = (0..12).map(|i| 0.37 * f64::from(i) - 1.9).collect();
        let rows = vec![0.5, 0.25, 0.125, 1.0];
        let columns = vec![0.1, 0.02];
        let weights = Weights::nearest(&truth, 2, rows.clone(), columns.clone());
        let values = [weights.values(false), weights.values(true)].concat();
        assert_eq!((weights.values(false).len(), values.len()), (8, 12));
        for (i, (value, truth)) in values.iter().zip(&truth).enumerate() {
            let set = if i < 8 { 0 } else { 2 };
            let step = rows[set + i / 2 % 2] * columns[i % 2];
            assert!((f64::from(*value) - truth).abs() <= f64::from(step) * 0.5 + 1e-6, "{i}");
        }
    }
}
