//! Eigenvectors of small symmetric matrices.

use super::Matrix;

/// The eigenvalues of a symmetric matrix, largest first, and its eigenvectors in the same order as rows, by
/// Jacobi rotations (C. G. J. Jacobi 1846; cyclic, as in Golub, Van Loan, "Matrix Computations", section
/// 8.5). The largest entry of each vector is positive.
///
/// # Panics
/// When the matrix is not square.
pub fn symmetric(matrix: &Matrix) -> (Vec<f64>, Matrix) {
    let n = matrix.rows();
    assert_eq!(n, matrix.cols(), "a square matrix");
    let mut a = matrix.clone();
    let mut vectors = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)));
    // Convergence is quadratic: a dozen sweeps are more than enough at the sizes used here.
    for _ in 0..30 {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|at| a[at].powi(2)).sum();
        let on: f64 = (0..n).map(|i| a[(i, i)].powi(2)).sum();
        if off <= 1e-30 * on {
            break;
        }
        for q in 1..n {
            (0..q).for_each(|p| rotate(&mut a, &mut vectors, p, q));
        }
    }
    sorted(&a, &vectors)
}

/// The rotation of rows and columns p and q that makes the entry (p, q) zero.
fn rotate(a: &mut Matrix, vectors: &mut Matrix, p: usize, q: usize) {
    if a[(p, q)] == 0.0 {
        return;
    }
    let tau = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
    let t = tau.signum() / (tau.abs() + tau.hypot(1.0));
    let cosine = 1.0 / t.hypot(1.0);
    let sine = t * cosine;
    let turn = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
    let n = a.rows();
    for k in 0..n {
        (a[(k, p)], a[(k, q)]) = turn(a[(k, p)], a[(k, q)]);
    }
    for k in 0..n {
        (a[(p, k)], a[(q, k)]) = turn(a[(p, k)], a[(q, k)]);
        (vectors[(p, k)], vectors[(q, k)]) = turn(vectors[(p, k)], vectors[(q, k)]);
    }
}

fn sorted(a: &Matrix, vectors: &Matrix) -> (Vec<f64>, Matrix) {
    let n = a.rows();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| a[(j, j)].total_cmp(&a[(i, i)]).then(i.cmp(&j)));
    let sign = |row: &[f64]| {
        let largest = row.iter().fold(0.0f64, |m, &v| if v.abs() > m.abs() { v } else { m });
        if largest < 0.0 { -1.0 } else { 1.0 }
    };
    let rows = Matrix::from_fn(n, n, |i, k| sign(vectors.row(order[i])) * vectors[(order[i], k)]);
    (order.iter().map(|&i| a[(i, i)]).collect(), rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn vectors_are_orthonormal_and_turn_the_matrix_diagonal() {
        for n in 1..20 {
            let mut stream = Stream::new(n as u64, Purpose::Sample, [0]);
            let half = Matrix::from_fn(n, n, |_, _| stream.unit() - 0.5);
            let matrix = half.times(&half.transposed());
            let (values, vectors) = symmetric(&matrix);
            let diagonal = vectors.times(&matrix).times(&vectors.transposed());
            let unit = vectors.times(&vectors.transposed());
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let same = f64::from(u8::from(i == j));
                assert!((unit[(i, j)] - same).abs() < 1e-12);
                assert!((diagonal[(i, j)] - same * values[i]).abs() < 1e-11);
            }
            assert!(values.windows(2).all(|w| w[0] >= w[1]));
        }
    }

    #[test]
    fn equal_values_and_zeros_are_no_trouble() {
        let (values, _) = symmetric(&Matrix::from_fn(4, 4, |i, j| f64::from(u8::from(i == j)) * 3.0));
        assert_eq!(values, [3.0; 4]);
        assert_eq!(symmetric(&Matrix::zeros(3, 3)).0, [0.0; 3]);
    }
}
