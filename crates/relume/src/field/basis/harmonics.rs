//! Nine hemispherical harmonics, in the convention of RTI files (`.rti`, `.hsh`).
//!
//! Gautron, Krivanek, Pattanaik, Bouatouch, "A Novel Hemispherical Basis for Accurate and
//! Efficient Rendering", Eurographics Symposium on Rendering 2004, equation 3: real spherical
//! harmonics whose associated Legendre polynomials take 2 cos t - 1, so that the polar range
//! 0..pi/2 fills -1..1. Since dw = dcos t dp, they are **orthonormal by solid angle**. RTI files
//! give H4 and H8 a minus sign, which stays here.
//!
//! With c = cos t and s = sqrt(c - c^2), the customary formulas have cos p s, cos 2p (c^2 - c) and so on, and
//! the azimuth p is undefined at the zenith. In the components of the direction cos p s = x sqrt(c / (1 + c))
//! and cos 2p (c^2 - c) = -(x^2 - y^2) c / (1 + c), which are finite and smooth there. On the horizon s is
//! zero with an infinite slope in c. Directions below the horizon, where s is imaginary, get the values on
//! the horizon at the same azimuth.

use std::f64::consts::PI;

use super::{Domain, Gram};
use crate::direction::Direction;
use crate::numeric::Matrix;
use crate::numeric::quadrature::gauss_legendre;

/// The number of functions: degrees 0, 1 and 2.
pub(super) const COUNT: usize = 9;

/// The azimuthal order of each function: positive for cosines, negative for sines.
const ORDERS: [i32; COUNT] = [0, 1, 0, -1, 2, 1, 0, -1, -2];

/// Nodes in cos t that integrate products of two functions and a cosine exactly: for equal orders
/// they are polynomials of degree 5 at most.
const NODES: usize = 3;

pub(super) fn weights(direction: Direction) -> [f64; COUNT] {
    let (x, y, c) = (direction.x(), direction.y(), direction.z().max(0.0));
    let ratio = c / (1.0 + c);
    let ring = ratio.sqrt();
    let t = 2.0 * c - 1.0;
    let (first, second) = ((6.0 / PI).sqrt(), (30.0 / PI).sqrt());
    [
        (0.5 / PI).sqrt(),
        first * x * ring,
        (1.5 / PI).sqrt() * t,
        first * y * ring,
        -second * (x * x - y * y) * ratio,
        second * x * t * ring,
        (2.5 / PI).sqrt() * (1.0 - 6.0 * c + 6.0 * c * c),
        second * y * t * ring,
        -second * 2.0 * x * y * ratio,
    ]
}

/// `None` over the square, whose corners are not directions.
pub(super) fn gram(domain: Domain) -> Option<Gram> {
    match domain {
        Domain::Hemisphere => Some(Gram::Diagonal(vec![1.0; COUNT])),
        Domain::Cosine => Some(Gram::Dense(Matrix::from_fn(COUNT, COUNT, cosine_product))),
        Domain::Square => None,
    }
}

/// ∫ H_j H_k cos t dw: zero for different orders; for equal ones a polynomial in cos t times the mean square
/// of the azimuthal function.
fn cosine_product(j: usize, k: usize) -> f64 {
    if ORDERS[j] != ORDERS[k] {
        return 0.0;
    }
    // The azimuth at which the azimuthal function is 1: cos(m p), or sin(m p).
    let azimuth = match ORDERS[j] {
        m if m < 0 => 0.5 * PI / f64::from(-m),
        _ => 0.0,
    };
    let mean_square = if ORDERS[j] == 0 { 2.0 * PI } else { PI };
    let node = |(t, weight): (f64, f64)| {
        let c = 0.5 * (t + 1.0);
        let values = weights(Direction::from_angles(c.acos(), azimuth));
        0.5 * weight * c * values[j] * values[k]
    };
    mean_square * gauss_legendre(NODES).into_iter().map(node).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::integrate_hemisphere;

    /// The formulas of `.rti` readers, with the azimuth.
    fn customary(direction: Direction) -> [f64; COUNT] {
        let p = direction.y().atan2(direction.x());
        let c = direction.z();
        let s = (c - c * c).sqrt();
        let (a, b) = ((6.0 / PI).sqrt(), (30.0 / PI).sqrt());
        [
            1.0 / (2.0 * PI).sqrt(),
            a * p.cos() * s,
            (3.0 / (2.0 * PI)).sqrt() * (2.0 * c - 1.0),
            a * p.sin() * s,
            b * (2.0 * p).cos() * (c * c - c),
            b * p.cos() * (2.0 * c - 1.0) * s,
            (5.0 / (2.0 * PI)).sqrt() * (1.0 - 6.0 * c + 6.0 * c * c),
            b * (2.0 * c - 1.0) * s * p.sin(),
            b * (c * c - c) * (2.0 * p).sin(),
        ]
    }

    #[test]
    fn the_formulas_without_azimuth_are_the_customary_ones() {
        for i in 0..40 {
            let direction = Direction::from_angles(0.03 + 0.0385 * f64::from(i), 1.7 * f64::from(i));
            for (k, (a, b)) in weights(direction).into_iter().zip(customary(direction)).enumerate() {
                assert!((a - b).abs() < 1e-12, "function {k} at {direction:?}: {a} and {b}");
            }
        }
    }

    #[test]
    fn they_are_orthonormal_by_solid_angle() {
        for (j, k) in (0..COUNT).flat_map(|j| (0..COUNT).map(move |k| (j, k))) {
            let product = integrate_hemisphere(5, |w| weights(w)[j] * weights(w)[k]);
            let truth = f64::from(u8::from(j == k));
            assert!((product - truth).abs() < 1e-12, "({j}, {k}): {product}");
        }
    }

    #[test]
    fn zenith_and_horizon_are_ordinary_directions() {
        let zenith = weights(Direction::ZENITH);
        for (k, value) in zenith.into_iter().enumerate() {
            assert!(value.is_finite() && (value == 0.0) == (ORDERS[k] != 0), "function {k}: {value}");
        }
        let below = Direction::new(0.6, 0.8, -1e-3).unwrap();
        let horizon = Direction::new(0.6, 0.8, 0.0).unwrap();
        for (a, b) in weights(below).into_iter().zip(weights(horizon)) {
            assert!((a - b).abs() < 1e-12);
        }
    }
}
