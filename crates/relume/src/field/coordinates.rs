//! Coordinates of functions in an orthonormal basis.

use super::basis::Gram;
use super::{Basis, Domain};
use crate::error::Result;
use crate::numeric::Matrix;
use crate::planes::Planes;

/// The conversion between coefficients c and coordinates b whose Euclidean distance is that of the functions.
#[derive(Debug, Clone)]
pub(super) enum OrthonormalMap {
    /// b = forward c, c = backward b.
    Dense { forward: Matrix, backward: Matrix },
    /// b_k = norm_k c_k: the functions are orthogonal already.
    Diagonal(Vec<f64>),
}

impl OrthonormalMap {
    /// The coordinates of a basis over a domain. With the functions in graded order and G = L L', b = L' c.
    ///
    /// # Errors
    /// When the basis is not defined over the domain.
    pub fn new(basis: &Basis, domain: Domain) -> Result<Self> {
        let gram = match basis.gram(domain)? {
            Gram::Dense(gram) => gram,
            Gram::Diagonal(squares) => {
                return Ok(Self::Diagonal(squares.into_iter().map(f64::sqrt).collect()));
            }
        };
        let n = basis.len();
        let order = basis.graded_order();
        let factor = Matrix::from_fn(n, n, |j, k| gram[(order[j], order[k])]).cholesky()?;
        let inverse = factor.lower_inverse();
        let place = |k: usize| order.iter().position(|&o| o == k).expect("graded orders are permutations");
        Ok(Self::Dense {
            forward: Matrix::from_fn(n, n, |j, k| factor[(place(k), j)]),
            backward: Matrix::from_fn(n, n, |k, j| inverse[(j, place(k))]),
        })
    }

    /// Coordinate `j` of the function whose coefficients are the planes from `first` on, for the texels from
    /// `texel` on.
    pub fn forward(&self, j: usize, planes: &Planes, first: usize, texel: usize, out: &mut [f32]) {
        match self {
            Self::Dense { forward, .. } => combine(forward.row(j), planes, first, texel, out),
            Self::Diagonal(norms) => scale(norms[j], &planes.plane(first + j)[texel..], out),
        }
    }

    /// Coefficient `k` of the function whose coordinates are the planes from `first` on.
    pub fn backward(&self, k: usize, planes: &Planes, first: usize, out: &mut [f32]) {
        match self {
            Self::Dense { backward, .. } => combine(backward.row(k), planes, first, 0, out),
            Self::Diagonal(norms) => scale(1.0 / norms[k], planes.plane(first + k), out),
        }
    }

    /// Coefficient `k` of one function from its coordinates.
    pub fn coefficient(&self, k: usize, coordinates: &[f32]) -> f32 {
        match self {
            Self::Dense { backward, .. } => {
                backward.row(k).iter().zip(coordinates).map(|(w, &b)| w * f64::from(b)).sum::<f64>() as f32
            }
            Self::Diagonal(norms) => (f64::from(coordinates[k]) / norms[k]) as f32,
        }
    }
}

/// out = sum_k weights_k plane_(first + k) for the texels from `texel` on, skipping zero weights.
fn combine(weights: &[f64], planes: &Planes, first: usize, texel: usize, out: &mut [f32]) {
    out.fill(0.0);
    for (k, &weight) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
        let weight = weight as f32;
        out.iter_mut().zip(&planes.plane(first + k)[texel..]).for_each(|(o, v)| *o += weight * v);
    }
}

fn scale(factor: f64, plane: &[f32], out: &mut [f32]) {
    let factor = factor as f32;
    out.iter_mut().zip(plane).for_each(|(o, v)| *o = factor * v);
}
