//! From the sketch to coefficients and functions.

use super::sketch::{ROUNDING, Sketch, combined, gram};
use super::solid_angles::pair_weights;
use super::{MOST_FUNCTIONS, Rank};
use crate::error::Result;
use crate::fit::held_out::HeldOut;
use crate::job::Job;
use crate::numeric::Matrix;
use crate::numeric::eigen;
use crate::parallel;
use crate::planes::Planes;

/// The singular value decomposition within the space of a sketch: B is nearly (products M') (rows M')', with
/// the rows of M for the singular values in order.
pub(super) struct Factors<'a> {
    sketch: &'a Sketch,
    /// One row for each function.
    mixing: Matrix,
    /// The inner products of the planes of the sketch.
    products: Matrix,
    /// Of B, largest first.
    pub singular_values: Vec<f64>,
}

impl<'a> Factors<'a> {
    pub fn new(sketch: &'a Sketch, job: &Job) -> Result<Self> {
        // Z = W R with orthonormal W: R^-1 by the eigenvectors of Z' Z.
        let (squares, vectors) = eigen::symmetric(&weighted_gram(sketch, |_| 1.0));
        let kept = squares.iter().take_while(|square| **square > ROUNDING * squares[0]).count().max(1);
        let norm = |k: usize| if squares[k] > 0.0 { 1.0 / squares[k].sqrt() } else { 0.0 };
        let inverse = Matrix::from_fn(kept, sketch.width, |k, j| norm(k) * vectors[(k, j)]);
        // B W = Y2 R^-1, whose singular values are those of B in the space of W.
        let products = gram(&sketch.products, job)?;
        let (squares, turn) = eigen::symmetric(&inverse.times(&products).times(&inverse.transposed()));
        let singular_values = squares.iter().map(|square| square.max(0.0).sqrt()).collect();
        Ok(Self { sketch, mixing: turn.times(&inverse), products, singular_values })
    }

    /// The root mean square error of the first functions.
    pub fn error(&self, functions: usize) -> f64 {
        let found: f64 = self.singular_values[..functions].iter().map(|s| s * s).sum();
        ((self.sketch.energy - found).max(0.0) / self.sketch.values).sqrt()
    }

    /// The number of functions, unless more are needed than there are.
    pub fn rank(&self, asked: Rank) -> Option<usize> {
        let most = self.singular_values.len().min(MOST_FUNCTIONS);
        match asked {
            Rank::Functions(n) => Some(n.min(most)),
            Rank::Error(error) => (1..=most).find(|&n| self.error(n) <= error),
        }
    }

    /// The values of the first functions for all pairs and channels, orthonormal under the weights of the pairs,
    /// these weights, and the coefficients.
    pub fn finish(
        &self,
        functions: usize,
        held_out: &HeldOut,
        job: &Job,
    ) -> Result<(Vec<f32>, Vec<f64>, Planes)> {
        let weights = pair_weights(&held_out.pairs());
        let channels = self.sketch.rows.len() / self.sketch.width / weights.len();
        let first = Matrix::from_fn(functions, self.sketch.width, |k, j| self.mixing[(k, j)]);
        // Orthonormal under the weights: V' W V = L L', then V L'^-1 and C L.
        let weighted = weighted_gram(self.sketch, |column| weights[column / channels]);
        let factor = first.times(&weighted).times(&first.transposed()).cholesky()?;
        let rows = factor.lower_inverse().times(&first);
        let planes = factor.transposed().times(&first);
        // Uncorrelated: the axes of the coefficients.
        let (_, axes) = eigen::symmetric(&planes.times(&self.products).times(&planes.transposed()));
        let (rows, planes) = (axes.times(&rows), axes.times(&planes));
        let values = functions_of(self.sketch, &rows);
        let bytes = 4 * (functions * self.sketch.products.size().texels()) as u64;
        job.check_bytes("the coefficients", bytes)?;
        Ok((values, weights, combined(&self.sketch.products, &planes)))
    }
}

/// rows matrix': the values of all functions for each column.
fn functions_of(sketch: &Sketch, matrix: &Matrix) -> Vec<f32> {
    let columns = sketch.rows.chunks_exact(sketch.width);
    let mut functions = vec![0.0; columns.len() * matrix.rows()];
    parallel::for_each(functions.chunks_exact_mut(matrix.rows()).zip(columns), |(out, column)| {
        let dot = |k: usize| matrix.row(k).iter().zip(column).map(|(m, &v)| m * f64::from(v)).sum::<f64>();
        out.iter_mut().enumerate().for_each(|(k, value)| *value = dot(k) as f32);
    });
    functions
}

/// Z' W Z for weights of the columns of B.
fn weighted_gram(sketch: &Sketch, weight: impl Fn(usize) -> f64) -> Matrix {
    let mut gram = Matrix::zeros(sketch.width, sketch.width);
    for (column, row) in sketch.rows.chunks_exact(sketch.width).enumerate() {
        let weight = weight(column);
        for (j, &a) in row.iter().enumerate() {
            let factor = weight * f64::from(a);
            gram.row_mut(j)[..=j].iter_mut().zip(row).for_each(|(sum, &b)| *sum += factor * f64::from(b));
        }
    }
    Matrix::from_fn(sketch.width, sketch.width, |j, k| gram[(j.max(k), j.min(k))])
}
