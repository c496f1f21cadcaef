//! The biquadratic polynomial of a polynomial texture map.
//!
//! Malzbender, Gelb, Wolters, "Polynomial Texture Maps", SIGGRAPH 2001, equation 5: the six
//! monomials u^2, v^2, uv, u, v, 1 in file order, of the projections (u, v) of the unit light
//! vector on the texture plane.

use super::Domain;
use super::moments;
use crate::numeric::Matrix;

/// Powers of u and v of each function.
const POWERS: [(u32, u32); 6] = [(2, 0), (0, 2), (1, 1), (1, 0), (0, 1), (0, 0)];

/// Names in file order.
pub(super) const NAMES: [&str; 6] = ["u2", "v2", "uv", "u", "v", "1"];

/// 1, u, v, uv, u^2, v^2. Over the square this order gives the orthonormal basis of Hel-Or, Malzbender, Gelb,
/// "Synthesis of Reflectance Function Textures from Examples", HPL-2003-16.
pub(super) const GRADED_ORDER: [usize; 6] = [5, 3, 4, 2, 0, 1];

pub(super) fn weights(u: f64, v: f64) -> [f64; 6] {
    [u * u, v * v, u * v, u, v, 1.0]
}

pub(super) fn gram(domain: Domain) -> Matrix {
    moments::gram(domain, &POWERS)
}
