//! Inner products of the functions of a basis.

use crate::numeric::Matrix;

/// The inner products `G_jk` = ∫ b_j b_k dw of `n` functions over a domain.
#[derive(Debug, Clone, PartialEq)]
pub enum Gram {
    /// The full n x n matrix.
    Dense(Matrix),
    /// The functions are orthogonal: the `n` squared norms.
    Diagonal(Vec<f64>),
}

impl Gram {
    /// The inner product of functions `j` and `k`.
    pub fn at(&self, j: usize, k: usize) -> f64 {
        match self {
            Self::Dense(matrix) => matrix[(j, k)],
            Self::Diagonal(norms) if j == k => norms[j],
            Self::Diagonal(_) => 0.0,
        }
    }
}
