//! The slow and obvious factorisation: the whole matrix in memory, and the eigenvectors of the smaller of its
//! Gram matrices.

use crate::numeric::Matrix;
use crate::numeric::eigen;

/// The root mean square errors of the best approximations of a matrix by 1, 2, and so on terms, up to its smaller
/// side: the truth for [`fit`](super::fit). Rows are texels, columns the channels of pairs. For small sizes.
pub fn exact(matrix: &Matrix) -> Vec<f64> {
    let other = matrix.transposed();
    let gram = if matrix.rows() <= matrix.cols() { matrix.times(&other) } else { other.times(matrix) };
    let (squares, _) = eigen::symmetric(&gram);
    let values = (matrix.rows() * matrix.cols()) as f64;
    let mut left: f64 = squares.iter().sum();
    let mut after = |square: &f64| {
        left -= square;
        (left.max(0.0) / values).sqrt()
    };
    squares.iter().map(&mut after).collect()
}
