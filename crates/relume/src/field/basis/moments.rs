//! Closed integrals of u^a v^b over the domains of light directions.

use std::f64::consts::PI;

use super::Domain;
use crate::numeric::Matrix;

/// The inner products of monomials, given as their powers of u and v.
pub(super) fn gram(domain: Domain, powers: &[(u32, u32)]) -> Matrix {
    Matrix::from_fn(powers.len(), powers.len(), |j, k| {
        let ((uj, vj), (uk, vk)) = (powers[j], powers[k]);
        moment(domain, uj + uk, vj + vk)
    })
}

/// The integral of u^a v^b over a domain; zero when a power is odd.
///
/// With m = (a + b) / 2 and the azimuthal integral A = 2 pi (a-1)!! (b-1)!! / (a+b)!!, the solid angle gives
/// A (2m)!! / (2m+1)!!, the cosine-weighted one A / (a + b + 2), and the square 2/(a+1) 2/(b+1).
fn moment(domain: Domain, a: u32, b: u32) -> f64 {
    if a % 2 == 1 || b % 2 == 1 {
        return 0.0;
    }
    let degree = a + b;
    let azimuth = || {
        2.0 * PI * double_factorial(i64::from(a) - 1) * double_factorial(i64::from(b) - 1)
            / double_factorial(i64::from(degree))
    };
    match domain {
        Domain::Square => 4.0 / f64::from((a + 1) * (b + 1)),
        Domain::Cosine => azimuth() / f64::from(degree + 2),
        Domain::Hemisphere => {
            azimuth() * double_factorial(i64::from(degree)) / double_factorial(i64::from(degree) + 1)
        }
    }
}

/// n!! = n (n-2) (n-4) ..., 1 for n < 1.
fn double_factorial(n: i64) -> f64 {
    (1..=n).rev().step_by(2).map(|k| k as f64).product()
}
