//! Successive rounding: the six coefficients of a function are rounded one after another, and each
//! compensates the errors of those before it.
//!
//! The squared error of relit values is e' G e. With the Cholesky factor of the Gram matrix in units of
//! steps, S G S = L L', it is the squared length of L' (t - b) for positions t and bytes b. Rounding from the
//! last row up, after moving each position to compensate the earlier errors, leaves sum_k L_kk^2 / 12 on
//! average; independent rounding leaves sum_k G_kk s_k^2 / 12, which is never less. This is the nearest-plane
//! method of Babai, "On Lovasz' lattice reduction and the nearest lattice point problem", Combinatorica 6,
//! 1986. The order of rounding is free: of all 720 the one with the least sum is used.

use super::{PtmEncoding, nearest_byte};
use crate::error::Result;
use crate::field::{Basis, Domain};
use crate::numeric::Matrix;

/// The conversion of six coefficients to bytes: the order, and the compensation of earlier errors.
#[derive(Debug, Clone)]
pub(super) struct Rounding {
    encoding: PtmEncoding,
    /// Coefficients in the order of the rows of the factor; rounded from the last.
    order: [usize; 6],
    /// `feedback[p][q]`: the shift of position `p` caused by the error at position `q` > `p`.
    feedback: [[f64; 6]; 6],
}

impl Rounding {
    /// Rounds each coefficient to its nearest byte.
    pub(super) fn nearest(encoding: &PtmEncoding) -> Self {
        Self { encoding: *encoding, order: [0, 1, 2, 3, 4, 5], feedback: [[0.0; 6]; 6] }
    }

    /// Rounds all six for the least error over the hemisphere.
    pub(super) fn successive(encoding: &PtmEncoding) -> Result<Self> {
        let gram = Basis::Ptm.gram(Domain::Hemisphere)?;
        let mut best: Option<(f64, [usize; 6], Matrix)> = None;
        for order in permutations() {
            let factor = Matrix::from_fn(6, 6, |p, q| gram.at(order[p], order[q])).cholesky()?;
            let leaves = |p: usize| (factor[(p, p)] * f64::from(encoding.scale[order[p]])).powi(2);
            let error = (0..6).map(leaves).sum::<f64>();
            if best.as_ref().is_none_or(|(least, ..)| error < *least) {
                best = Some((error, order, factor));
            }
        }
        let (_, order, factor) = best.expect("six things have an order");
        let step = |p: usize| f64::from(encoding.scale[order[p]]);
        let feedback = std::array::from_fn(|p| {
            std::array::from_fn(|q| factor[(q, p)] * step(q) / (factor[(p, p)] * step(p)))
        });
        Ok(Self { encoding: *encoding, order, feedback })
    }

    /// Scale and bias of the bytes.
    pub(super) fn encoding(&self) -> &PtmEncoding {
        &self.encoding
    }

    /// The bytes of a row of texels, interleaved.
    pub(super) fn fill(&self, out: &mut [u8], rows: [&[f32]; 6]) {
        if self.is_nearest() {
            for (k, row) in rows.into_iter().enumerate() {
                let bytes = out[k..].iter_mut().step_by(6);
                bytes.zip(row).for_each(|(out, &v)| *out = nearest_byte(self.encoding.position(k, v)));
            }
            return;
        }
        for (x, bytes) in out.chunks_exact_mut(6).enumerate() {
            bytes.copy_from_slice(&self.bytes(rows.map(|row| row[x])));
        }
    }

    fn is_nearest(&self) -> bool {
        self.feedback.iter().flatten().all(|factor| *factor == 0.0)
    }

    /// The bytes of six coefficients.
    pub(super) fn bytes(&self, coefficients: [f32; 6]) -> [u8; 6] {
        let mut bytes = [0; 6];
        let mut errors = [0.0; 6];
        for p in (0..6).rev() {
            let k = self.order[p];
            let position = self.encoding.position(k, coefficients[k]);
            let moved = (p + 1..6).fold(position, |sum, q| sum + self.feedback[p][q] * errors[q]);
            bytes[k] = nearest_byte(moved);
            errors[p] = position - f64::from(bytes[k]);
        }
        bytes
    }
}

/// All orders of six things: Heap, "Permutations by Interchanges", The Computer Journal 6, 1963.
fn permutations() -> Vec<[usize; 6]> {
    fn exchange(n: usize, order: &mut [usize; 6], all: &mut Vec<[usize; 6]>) {
        if n == 1 {
            all.push(*order);
            return;
        }
        for i in 0..n {
            exchange(n - 1, order, all);
            order.swap(if n.is_multiple_of(2) { i } else { 0 }, n - 1);
        }
    }
    let mut all = Vec::with_capacity(720);
    exchange(6, &mut [0, 1, 2, 3, 4, 5], &mut all);
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn there_are_720_different_orders() {
        let mut all = permutations();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 720);
    }

    #[test]
    fn a_row_has_the_bytes_of_its_texels() {
        let encoding = PtmEncoding { scale: [1.1, 0.7, 0.9, 2.0, -1.3, 0.8], bias: [128.0; 6] };
        let mut random = Stream::new(9, Purpose::Sample, [0]);
        let rows: [Vec<f32>; 6] =
            std::array::from_fn(|_| (0..37).map(|_| random.unit() as f32 - 0.5).collect());
        for rounding in [Rounding::nearest(&encoding), Rounding::successive(&encoding).unwrap()] {
            let mut row = [0; 6 * 37];
            rounding.fill(&mut row, std::array::from_fn(|k| &rows[k][..]));
            for (x, bytes) in row.chunks_exact(6).enumerate() {
                assert_eq!(bytes, rounding.bytes(std::array::from_fn(|k| rows[k][x])));
            }
        }
    }

    #[test]
    fn successive_rounding_errs_as_predicted_and_less_than_rounding_each() {
        let encoding = PtmEncoding { scale: [1.1, 0.7, 0.9, 2.0, -1.3, 0.8], bias: [128.0; 6] };
        let nearest = Rounding::nearest(&encoding);
        let rounding = Rounding::successive(&encoding).unwrap();
        let gram = Basis::Ptm.gram(Domain::Hemisphere).unwrap();
        let error = |coefficients: &[f32; 6], bytes: [u8; 6]| -> f64 {
            let e: [f64; 6] =
                std::array::from_fn(|k| 255.0 * f64::from(coefficients[k] - encoding.value(k, bytes[k])));
            (0..36).map(|i| e[i / 6] * gram.at(i / 6, i % 6) * e[i % 6]).sum()
        };
        let mut random = Stream::new(8, Purpose::Sample, [0]);
        let (mut each, mut successive) = (0.0, 0.0);
        let texels = 20_000;
        for _ in 0..texels {
            let coefficients: [f32; 6] = std::array::from_fn(|_| 0.2 * (random.unit() as f32 - 0.5));
            each += error(&coefficients, nearest.bytes(coefficients));
            successive += error(&coefficients, rounding.bytes(coefficients));
        }
        let predicted: f64 =
            (0..6).map(|k| gram.at(k, k) * f64::from(encoding.scale[k]).powi(2) / 12.0).sum();
        assert!((each / f64::from(texels) / predicted - 1.0).abs() < 0.05);
        let order = rounding.order;
        let factor = Matrix::from_fn(6, 6, |p, q| gram.at(order[p], order[q])).cholesky().unwrap();
        let leaves = |p: usize| (factor[(p, p)] * f64::from(encoding.scale[order[p]])).powi(2) / 12.0;
        let predicted: f64 = (0..6).map(leaves).sum();
        assert!((successive / f64::from(texels) / predicted - 1.0).abs() < 0.05);
        assert!(successive < 0.85 * each, "{successive} against {each}");
    }
}
