//! Hemispherical harmonics, in the convention of RTI files (`.rti`, `.hsh`).
//!
//! Gautron, Krivanek, Pattanaik, Bouatouch, "A Novel Hemispherical Basis for Accurate and
//! Efficient Rendering", Eurographics Symposium on Rendering 2004, equation 3: real spherical
//! harmonics whose associated Legendre polynomials take 2 cos t - 1, so that the polar range
//! 0..pi/2 fills -1..1. Since dw = dcos t dp, they are **orthonormal by solid angle**. RTI files
//! give those of azimuthal order 2 (H4 and H8, H10 and H14) a minus sign, which stays here; such files have no degree
//! above 3.
//!
//! With c = cos t and s = sqrt(c - c^2), the customary formulas have cos p s, cos 2p (c^2 - c) and so on, and
//! the azimuth p is undefined at the zenith. In the components of the direction cos p s = x sqrt(c / (1 + c))
//! and cos 2p (c^2 - c) = -(x^2 - y^2) c / (1 + c), which are finite and smooth there. On the horizon s is
//! zero with an infinite slope in c. Directions below the horizon, where s is imaginary, get the values on
//! the horizon at the same azimuth.

use std::f64::consts::SQRT_2;

use super::bands::{azimuthal_gram, harmonics_into};
use super::{Bands, Domain, Gram};
use crate::direction::Direction;

/// The azimuthal order whose functions are negative.
const NEGATIVE_ORDER: usize = 2;

pub(super) fn weights_into(bands: Bands, direction: Direction, out: &mut [f64]) {
    let c = direction.z().max(0.0);
    let ring = 2.0 * (c / (1.0 + c)).sqrt();
    harmonics_into(bands, 2.0 * c - 1.0, [direction.x() * ring, direction.y() * ring], out);
    // Orthonormal on the hemisphere instead of the sphere.
    out.iter_mut().for_each(|value| *value *= SQRT_2);
    for l in NEGATIVE_ORDER..bands.count() {
        let middle = l * l + l;
        out[middle - NEGATIVE_ORDER] *= -1.0;
        out[middle + NEGATIVE_ORDER] *= -1.0;
    }
}

/// `None` over the square, whose corners are not directions.
pub(super) fn gram(bands: Bands, domain: Domain) -> Option<Gram> {
    match domain {
        Domain::Hemisphere => Some(Gram::Diagonal(vec![1.0; bands.functions()])),
        // For equal orders the products are polynomials in cos t of twice the highest degree, times the cosine.
        Domain::Cosine => {
            let weights = |direction, out: &mut [f64]| weights_into(bands, direction, out);
            Some(Gram::Dense(azimuthal_gram(&bands.orders(), bands.count(), 1, weights)))
        }
        Domain::Square => None,
    }
}

/// The name of the basis.
pub(super) fn name(bands: Bands) -> &'static str {
    match bands {
        Bands::Two => "hsh4",
        Bands::Three => "hsh9",
        Bands::Four => "hsh16",
        Bands::Five => "hsh25",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::integrate_hemisphere;
    use std::f64::consts::PI;

    fn weights(bands: Bands, direction: Direction) -> Vec<f64> {
        let mut out = vec![0.0; bands.functions()];
        weights_into(bands, direction, &mut out);
        out
    }

    /// The formulas of `.rti` readers, with the azimuth.
    fn customary(direction: Direction) -> [f64; 16] {
        let p = direction.y().atan2(direction.x());
        let c = direction.z();
        let (cc, s, t) = (c * c - c, (c - c * c).sqrt(), 2.0 * c - 1.0);
        let root = |number: f64| (number / PI).sqrt();
        [
            1.0 / (2.0 * PI).sqrt(),
            root(6.0) * p.cos() * s,
            root(1.5) * t,
            root(6.0) * p.sin() * s,
            root(30.0) * (2.0 * p).cos() * cc,
            root(30.0) * p.cos() * t * s,
            root(2.5) * (1.0 + 6.0 * cc),
            root(30.0) * t * s * p.sin(),
            root(30.0) * cc * (2.0 * p).sin(),
            2.0 * root(35.0) * (3.0 * p).cos() * s.powi(3),
            root(210.0) * (2.0 * p).cos() * t * cc,
            2.0 * root(21.0) * p.cos() * s * (1.0 + 5.0 * cc),
            root(3.5) * (-1.0 + 12.0 * c - 30.0 * c * c + 20.0 * c.powi(3)),
            2.0 * root(21.0) * s * (1.0 + 5.0 * cc) * p.sin(),
            root(210.0) * t * cc * (2.0 * p).sin(),
            2.0 * root(35.0) * s.powi(3) * (3.0 * p).sin(),
        ]
    }

    #[test]
    fn the_formulas_without_azimuth_are_the_customary_ones() {
        for i in 0..40 {
            let direction = Direction::from_angles(0.03 + 0.0385 * f64::from(i), 1.7 * f64::from(i));
            let found = weights(Bands::Four, direction);
            for (k, (a, b)) in found.into_iter().zip(customary(direction)).enumerate() {
                assert!((a - b).abs() < 1e-12, "function {k} at {direction:?}: {a} and {b}");
            }
        }
    }

    #[test]
    fn fewer_bands_are_the_first_of_more() {
        let direction = Direction::from_angles(0.9, -2.0);
        let all = weights(Bands::Five, direction);
        for bands in Bands::ALL {
            assert_eq!(weights(bands, direction), all[..bands.functions()]);
        }
    }

    #[test]
    fn they_are_orthonormal_by_solid_angle() {
        let n = Bands::Five.functions();
        for (j, k) in (0..n).flat_map(|j| (0..n).map(move |k| (j, k))) {
            let of = |w| weights(Bands::Five, w);
            let product = integrate_hemisphere(9, |w| of(w)[j] * of(w)[k]);
            let truth = f64::from(u8::from(j == k));
            assert!((product - truth).abs() < 1e-12, "({j}, {k}): {product}");
        }
    }

    #[test]
    fn zenith_and_horizon_are_ordinary_directions() {
        let zenith = weights(Bands::Five, Direction::ZENITH);
        for (value, order) in zenith.into_iter().zip(Bands::Five.orders()) {
            assert!(value.is_finite() && (value == 0.0) == (order != 0), "order {order}: {value}");
        }
        let below = Direction::new(0.6, 0.8, -1e-3).unwrap();
        let horizon = Direction::new(0.6, 0.8, 0.0).unwrap();
        let pairs = weights(Bands::Five, below).into_iter().zip(weights(Bands::Five, horizon));
        pairs.for_each(|(a, b)| assert!((a - b).abs() < 1e-12));
    }
}
