//! The roughness of functions: what a penalised fit keeps small.

use std::f64::consts::TAU;

use super::{Bands, Basis};
use crate::numeric::Matrix;
use crate::numeric::quadrature::hemisphere;

/// Nodes with which second derivatives of polynomials up to degree 5 are integrated.
const NODES: usize = 6;

/// The step of second differences.
const STEP: f64 = 1e-3;

impl Basis {
    /// The matrix D for which c' D c is the roughness of the function with coefficients c; `None` for interpolated and
    /// learned functions, which have their detail from the photographs.
    ///
    /// For harmonics the integral of the squared Laplacian on the sphere on which they are orthonormal, l² (l + 1)² for
    /// degree l. For polynomials the bending energy of a thin plate over the disk of (u, v), ∫ f_uu² + 2 f_uv² + f_vv².
    /// Constants have none, and polynomials of first degree have none.
    pub fn roughness(&self) -> Option<Matrix> {
        match self {
            Self::Harmonics(bands) | Self::Spherical(bands) => Some(laplacian_energy(*bands)),
            Self::Interpolated(_) | Self::Learned(_) => None,
            Self::Constant | Self::Ptm | Self::Polynomial(_) | Self::Zernike => Some(self.bending_energy()),
        }
    }

    fn bending_energy(&self) -> Matrix {
        let n = self.len();
        let mut energy = Matrix::zeros(n, n);
        for (direction, share) in hemisphere(NODES) {
            let (u, v) = (direction.x(), direction.y());
            let weight = TAU * share * direction.z();
            for (derivative, times) in self.second_derivatives(u, v).into_iter().zip([1.0, 2.0, 1.0]) {
                for j in 0..n {
                    let factor = weight * times * derivative[j];
                    energy.row_mut(j).iter_mut().zip(&derivative).for_each(|(sum, d)| *sum += factor * d);
                }
            }
        }
        energy
    }

    /// f_uu, f_uv and f_vv of each function, by central differences.
    fn second_derivatives(&self, u: f64, v: f64) -> [Vec<f64>; 3] {
        let at = |i: f64, j: f64| self.polynomial_weights(u + i * STEP, v + j * STEP);
        let middle = at(0.0, 0.0);
        let along = |i: f64, j: f64| {
            let (ahead, behind) = (at(i, j), at(-i, -j));
            let second = |k: usize| (ahead[k] + behind[k] - 2.0 * middle[k]) / (STEP * STEP);
            (0..middle.len()).map(second).collect::<Vec<f64>>()
        };
        let (uu, vv, diagonal) = (along(1.0, 0.0), along(0.0, 1.0), along(1.0, 1.0));
        // Along (1, 1) the second derivative is f_uu + 2 f_uv + f_vv.
        let uv = (0..middle.len()).map(|k| 0.5 * (diagonal[k] - uu[k] - vv[k])).collect();
        [uu, uv, vv]
    }
}

fn laplacian_energy(bands: Bands) -> Matrix {
    let degree = |k: usize| (k as f64).sqrt().floor();
    let square = |k: usize| (degree(k) * (degree(k) + 1.0)).powi(2);
    Matrix::from_fn(bands.functions(), bands.functions(), |j, k| if j == k { square(j) } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bowl_bends_and_a_plane_does_not() {
        let ptm = Basis::Ptm.roughness().unwrap();
        let energy = |c: [f64; 6]| -> f64 {
            (0..6).flat_map(|j| (0..6).map(move |k| (j, k))).map(|(j, k)| c[j] * c[k] * ptm[(j, k)]).sum()
        };
        assert!(energy([0.0, 0.0, 0.0, 1.0, -2.0, 3.0]) < 1e-6);
        // u² + v²: f_uu = f_vv = 2, over a disk of area pi.
        let bowl = energy([1.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((bowl - 8.0 * std::f64::consts::PI).abs() < 1e-4, "{bowl}");
        // uv: f_uv = 1, counted twice.
        let saddle = energy([0.0, 0.0, 1.0, 0.0, 0.0, 0.0]);
        assert!((saddle - 2.0 * std::f64::consts::PI).abs() < 1e-4, "{saddle}");
        let harmonics = Basis::HSH9.roughness().unwrap();
        assert_eq!((harmonics[(0, 0)], harmonics[(2, 2)], harmonics[(8, 8)]), (0.0, 4.0, 36.0));
        assert!(Basis::examples().pop().unwrap().roughness().is_none());
    }
}
