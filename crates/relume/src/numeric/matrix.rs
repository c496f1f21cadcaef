//! Small dense matrices in `f64`: Cholesky factors, triangular solves and least squares by
//! Householder reflections (Golub and Van Loan, Matrix Computations, 4th ed. 2013, algorithms
//! 4.2.1, 3.1.1 and 5.2.1). For tens of rows and columns; nothing here is blocked.

use crate::error::{Error, Result};

/// A dense matrix, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    rows: usize,
    cols: usize,
    data: Vec<f64>,
}

impl Matrix {
    /// A matrix of zeros.
    pub fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, data: vec![0.0; rows * cols] }
    }

    /// A matrix from its entries.
    pub fn from_fn(rows: usize, cols: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let data = (0..rows * cols).map(|i| entry(i / cols, i % cols)).collect();
        Self { rows, cols, data }
    }

    /// The number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// One row.
    pub fn row(&self, r: usize) -> &[f64] {
        &self.data[r * self.cols..(r + 1) * self.cols]
    }

    /// One row.
    pub fn row_mut(&mut self, r: usize) -> &mut [f64] {
        &mut self.data[r * self.cols..(r + 1) * self.cols]
    }

    /// The transpose.
    pub fn transposed(&self) -> Self {
        Self::from_fn(self.cols, self.rows, |r, c| self[(c, r)])
    }

    /// The product with another matrix.
    ///
    /// # Panics
    /// When the inner sizes differ.
    pub fn times(&self, other: &Self) -> Self {
        assert_eq!(self.cols, other.rows, "inner sizes of a product");
        Self::from_fn(self.rows, other.cols, |r, c| {
            (0..self.cols).map(|k| self[(r, k)] * other[(k, c)]).sum()
        })
    }

    /// The lower Cholesky factor L of a symmetric positive definite matrix, L L' = self.
    ///
    /// # Errors
    /// When a pivot is not positive.
    pub fn cholesky(&self) -> Result<Self> {
        let n = self.rows;
        let mut l = Self::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                let inner: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum();
                let rest = self[(i, j)] - inner;
                if i > j {
                    l[(i, j)] = rest / l[(j, j)];
                } else if rest > 0.0 {
                    l[(j, j)] = rest.sqrt();
                } else {
                    return Err(Error::invalid(format!(
                        "a matrix of inner products is not positive definite (pivot {j} is {rest:.3e})"
                    )));
                }
            }
        }
        Ok(l)
    }

    /// The inverse of a lower triangular matrix with a non-zero diagonal.
    pub fn lower_inverse(&self) -> Self {
        let n = self.rows;
        let mut inverse = Self::zeros(n, n);
        for j in 0..n {
            for i in j..n {
                let unit = f64::from(u8::from(i == j));
                let known: f64 = (j..i).map(|k| self[(i, k)] * inverse[(k, j)]).sum();
                inverse[(i, j)] = (unit - known) / self[(i, i)];
            }
        }
        inverse
    }
}

impl std::ops::Index<(usize, usize)> for Matrix {
    type Output = f64;
    fn index(&self, (r, c): (usize, usize)) -> &f64 {
        &self.data[r * self.cols + c]
    }
}

impl std::ops::IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (r, c): (usize, usize)) -> &mut f64 {
        &mut self.data[r * self.cols + c]
    }
}

/// The orthogonal factorisation A = Q R of a tall matrix, by Householder reflections.
#[derive(Debug, Clone)]
pub struct Qr {
    /// Orthonormal columns that span those of A (thin: the same number as A).
    pub q: Matrix,
    /// Upper triangular.
    pub r: Matrix,
}

impl Qr {
    /// Factors a matrix with at least as many rows as columns.
    ///
    /// # Panics
    /// When there are fewer rows than columns.
    pub fn new(a: &Matrix) -> Self {
        let (m, n) = (a.rows, a.cols);
        assert!(m >= n, "a thin QR needs at least as many rows as columns");
        let mut r = a.clone();
        let mut reflectors = Vec::with_capacity(n);
        for j in 0..n {
            let v = householder_vector(&r, j);
            reflect(&mut r, &v, j);
            reflectors.push(v);
        }
        let mut q = Matrix::from_fn(m, n, |i, j| f64::from(u8::from(i == j)));
        for (j, v) in reflectors.iter().enumerate().rev() {
            reflect(&mut q, v, j);
        }
        let r = Matrix::from_fn(n, n, |i, j| if i <= j { r[(i, j)] } else { 0.0 });
        Self { q, r }
    }

    /// The ratio of the smallest to the largest pivot: near zero for nearly dependent columns.
    pub fn pivot_ratio(&self) -> f64 {
        let pivots = (0..self.r.cols).map(|i| self.r[(i, i)].abs());
        let (least, most) = pivots.fold((f64::INFINITY, 0.0f64), |(a, b), p| (a.min(p), b.max(p)));
        if most > 0.0 { least / most } else { 0.0 }
    }

    /// The pseudo-inverse R^-1 Q' of a matrix of full column rank.
    pub fn pseudo_inverse(&self) -> Matrix {
        let r_inverse = self.r.transposed().lower_inverse().transposed();
        r_inverse.times(&self.q.transposed())
    }
}

/// The unit vector whose reflection maps column `j` of `a`, from row `j` on, to its first axis.
fn householder_vector(a: &Matrix, j: usize) -> Vec<f64> {
    let mut v: Vec<f64> = (j..a.rows).map(|i| a[(i, j)]).collect();
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v[0] += norm.copysign(v[0]);
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length > 0.0 {
        v.iter_mut().for_each(|x| *x /= length);
    }
    v
}

/// Applies the reflection I - 2 v v' to the rows of `a` from row `first` on.
fn reflect(a: &mut Matrix, v: &[f64], first: usize) {
    for c in 0..a.cols {
        let dot: f64 = v.iter().enumerate().map(|(i, x)| x * a[(first + i, c)]).sum();
        for (i, x) in v.iter().enumerate() {
            a[(first + i, c)] -= 2.0 * dot * x;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(rows: usize, cols: usize) -> Matrix {
        Matrix::from_fn(rows, cols, |r, c| ((r * 7 + c * 13) % 11) as f64 / 3.0 + f64::from(u8::from(r == c)))
    }

    fn assert_near(a: &Matrix, b: &Matrix) {
        assert_eq!((a.rows, a.cols), (b.rows, b.cols));
        for (x, y) in a.data.iter().zip(&b.data) {
            assert!((x - y).abs() < 1e-9, "{a:?}\n{b:?}");
        }
    }

    fn identity(n: usize) -> Matrix {
        Matrix::from_fn(n, n, |r, c| f64::from(u8::from(r == c)))
    }

    #[test]
    fn cholesky_factors_multiply_back_and_invert() {
        let a = sample(6, 4);
        let spd = a.transposed().times(&a);
        let l = spd.cholesky().unwrap();
        assert_near(&l.times(&l.transposed()), &spd);
        assert_near(&l.times(&l.lower_inverse()), &identity(4));
        assert!(Matrix::from_fn(2, 2, |_, _| 1.0).cholesky().is_err());
    }

    #[test]
    fn qr_multiplies_back_and_its_pseudo_inverse_is_a_left_inverse() {
        let a = sample(9, 5);
        let qr = Qr::new(&a);
        assert_near(&qr.q.times(&qr.r), &a);
        assert_near(&qr.q.transposed().times(&qr.q), &identity(5));
        assert_near(&qr.pseudo_inverse().times(&a), &identity(5));
    }

    #[test]
    fn dependent_columns_show_in_the_pivots() {
        let a = Matrix::from_fn(6, 3, |r, c| [1.0, r as f64, 2.0 * r as f64 + 1.0][c]);
        assert!(Qr::new(&a).pivot_ratio() < 1e-12);
    }
}
