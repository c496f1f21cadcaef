//! Real spherical harmonics on the upper hemisphere.
//!
//! Ramamoorthi, Hanrahan, "An Efficient Representation for Irradiance Environment Maps", SIGGRAPH 2001, with the signs
//! of that paper, in which x, y, z, xy, ... have positive factors. Within a degree l the azimuthal orders run from l
//! down to -l, as those of the hemispherical harmonics: 1; x, z, y; x^2 - y^2, xz, 3z^2 - 1, yz, xy; and so on. They
//! are orthonormal on the whole sphere; on the hemisphere functions of odd and even degree overlap, the more so the
//! more bands there are.

use super::bands::{azimuthal_gram, harmonics_into};
use super::{Bands, Domain, Gram};
use crate::direction::Direction;

pub(super) fn weights_into(bands: Bands, direction: Direction, out: &mut [f64]) {
    harmonics_into(bands, direction.z(), [direction.x(), direction.y()], out);
}

/// `None` over the square, whose corners are not directions.
pub(super) fn gram(bands: Bands, domain: Domain) -> Option<Gram> {
    let cosine_power = match domain {
        Domain::Hemisphere => 0,
        Domain::Cosine => 1,
        Domain::Square => return None,
    };
    // For equal orders the products are polynomials in cos t of twice the highest degree.
    let weights = |direction, out: &mut [f64]| weights_into(bands, direction, out);
    Some(Gram::Dense(azimuthal_gram(&bands.orders(), bands.count(), cosine_power, weights)))
}

/// The name of the basis.
pub(super) fn name(bands: Bands) -> &'static str {
    match bands {
        Bands::Two => "sh4",
        Bands::Three => "sh9",
        Bands::Four => "sh16",
        Bands::Five => "sh25",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The constants of the paper, equation 3.
    #[test]
    fn the_first_nine_have_the_published_factors() {
        for i in 0..20 {
            let direction = Direction::from_angles(0.075 * f64::from(i), 2.1 * f64::from(i));
            let [x, y, z] = direction.to_array();
            let published = [
                0.282_095,
                0.488_603 * x,
                0.488_603 * z,
                0.488_603 * y,
                0.546_274 * (x * x - y * y),
                1.092_548 * x * z,
                0.315_392 * (3.0 * z * z - 1.0),
                1.092_548 * y * z,
                1.092_548 * x * y,
            ];
            let mut found = [0.0; 9];
            weights_into(Bands::Three, direction, &mut found);
            for (k, (a, b)) in found.into_iter().zip(published).enumerate() {
                assert!((a - b).abs() < 2e-6, "function {k} at {direction:?}: {a} and {b}");
            }
        }
    }

    /// The mean of the products over a direction and its opposite is half the product over the sphere.
    #[test]
    fn they_are_orthonormal_on_the_sphere() {
        let bands = Bands::Five;
        let values = |x, y, z| {
            let mut out = vec![0.0; bands.functions()];
            harmonics_into(bands, z, [x, y], &mut out);
            out
        };
        for (j, k) in (0..bands.functions()).flat_map(|j| (0..=j).map(move |k| (j, k))) {
            let product = crate::numeric::quadrature::integrate_hemisphere(9, |w| {
                let [x, y, z] = w.to_array();
                let (above, below) = (values(x, y, z), values(-x, -y, -z));
                above[j] * above[k] + below[j] * below[k]
            });
            assert!((product - f64::from(u8::from(j == k))).abs() < 1e-12, "({j}, {k}): {product}");
        }
    }
}
