//! The functions of the types `ptm` and `sh`, in the order of the format.

use std::f64::consts::PI;

use crate::direction::Direction;

/// Monomials by degree, u before v: 1, u, v, u^2, uv, v^2, u^3, ...
pub(super) fn monomials(light: Direction, out: &mut [f64]) {
    let (mut degree, mut of_v) = (0i32, 0i32);
    for value in out {
        *value = light.x().powi(degree - of_v) * light.y().powi(of_v);
        if of_v == degree {
            (degree, of_v) = (degree + 1, 0);
        } else {
            of_v += 1;
        }
    }
}

/// Nine real spherical harmonics: 1, x, z, y, xy, xz, 3z^2 - 1, yz, y^2 - x^2, orthonormal over the sphere.
pub(super) fn spherical(light: Direction, out: &mut [f64]) {
    let [x, y, z] = light.to_array();
    let (first, second) = (0.5 * (3.0 / PI).sqrt(), 0.5 * (15.0 / PI).sqrt());
    let all = [
        0.5 / PI.sqrt(),
        first * x,
        first * z,
        first * y,
        second * x * y,
        second * x * z,
        0.5 * (5.0 / PI).sqrt() * (3.0 * z * z - 1.0),
        second * y * z,
        0.5 * second * (y * y - x * x),
    ];
    out.iter_mut().zip(all).for_each(|(out, value)| *out = value);
}
