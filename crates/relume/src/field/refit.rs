//! Functions of light expressed in another basis: for each the nearest combination over the hemisphere by solid angle.
//!
//! The integrals are sums over directions spread evenly (a Fibonacci lattice), and the combination solves the same
//! least-squares problem over them: functions that the basis spans are found exactly, whatever the rule.

use super::Basis;
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;

/// The directions of the sums: many more than the functions of any basis of light.
const DIRECTIONS: usize = 1024;

/// Entries this near to a whole number are that number up to rounding.
const WHOLE: f64 = 1e-10;

/// The coefficients in the basis `to` of `count` functions, one column for each: `functions` writes their values under
/// a light.
///
/// # Errors
/// A basis of light and view, and one whose functions these directions do not tell apart.
pub fn refit(to: &Basis, count: usize, functions: impl Fn(Direction, &mut [f64])) -> Result<Matrix> {
    if to.channels() != 1 || to.depends_on_view() {
        return Err(Error::usage(format!("functions cannot be fitted in the basis {}", to.name())));
    }
    let direction = Direction::fibonacci(DIRECTIONS);
    let mut values = Matrix::zeros(DIRECTIONS, to.len());
    let mut wanted = Matrix::zeros(DIRECTIONS, count);
    for i in 0..DIRECTIONS {
        to.weights_into(Directions::lit_from(direction(i)), values.row_mut(i));
        functions(direction(i), wanted.row_mut(i));
    }
    let found = Qr::new(&values).pseudo_inverse().times(&wanted);
    let entry = |v: f64| if (v - v.round()).abs() < WHOLE { v.round() } else { v };
    Ok(Matrix::from_fn(to.len(), count, |r, c| entry(found[(r, c)])))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_basis_in_itself_is_the_identity() {
        for basis in Basis::NAMED {
            let matrix =
                refit(&basis, basis.len(), |light, out| out.copy_from_slice(&basis.weights(light))).unwrap();
            for (r, c) in (0..basis.len()).flat_map(|r| (0..basis.len()).map(move |c| (r, c))) {
                let truth = f64::from(u8::from(r == c));
                assert!(
                    (matrix[(r, c)] - truth).abs() < 1e-9,
                    "{} ({r}, {c}): {}",
                    basis.name(),
                    matrix[(r, c)]
                );
            }
        }
    }

    #[test]
    fn a_lambertian_function_in_polynomials_is_near_and_of_its_symmetry() {
        let matrix = refit(&Basis::Ptm, 1, |light, out| out[0] = light.z()).unwrap();
        // In closed form: over cos t from 0 to 1 the best a + b sin^2 t has a = 9/8 and b = -15/16.
        let truth = [-0.9375, -0.9375, 0.0, 0.0, 0.0, 1.125];
        assert!((0..6).all(|k| (matrix[(k, 0)] - truth[k]).abs() < 1e-3), "{matrix:?}");
    }
}
