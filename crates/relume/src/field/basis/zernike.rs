//! Zernike's circle polynomials of (u, v) up to degree 5: 21 functions.
//!
//! F. Zernike, "Beugungstheorie des Schneidenverfahrens und seiner verbesserten Form, der Phasenkontrastmethode",
//! Physica 1, 1934; order and normalisation of ANSI Z80.28 (Thibos, Applegate, Schwiegerling, Webb, "Standards for
//! Reporting the Optical Aberrations of Eyes", Journal of Refractive Surgery 18, 2002): by the degree n, then the
//! azimuthal order m = -n, -n + 2, ..., n, sines before cosines; their mean square over the disk is 1. So they are
//! **orthogonal over the cosine**, and a coefficient is the root mean square that its function contributes.
//!
//! They span all polynomials of their degree. Degrees 1 to 4 have other names here, and 28 functions, those of degree 6,
//! follow noise under the 47 to 63 lights of common captures: on the two of RealRTI in the test data, each photograph
//! predicted from the others has 27.6 dB with degree 6, and 28.4 and 28.6 dB with degree 5.

use std::f64::consts::PI;
use std::sync::LazyLock;

use super::bands::azimuthal_gram;
use super::{Domain, Gram};
use crate::numeric::Matrix;
use crate::numeric::quadrature::integrate_square;

/// The highest degree.
pub(super) const DEGREE: usize = 5;

/// The number of functions.
pub(super) const COUNT: usize = (DEGREE + 1) * (DEGREE + 2) / 2;

/// The most powers of the squared radius in a function.
const TERMS: usize = DEGREE / 2 + 1;

/// Nodes with which products of two functions are integrated exactly, in each of u and v, and in cos t.
const NODES: usize = DEGREE + 1;

/// The degree and the azimuthal order of each function.
fn indices() -> impl Iterator<Item = (usize, i32)> {
    (0..=DEGREE).flat_map(|n| (0..=n).map(move |i| (n, 2 * i as i32 - n as i32)))
}

/// The factors of each function: its norm times those of r^m, r^(m + 2), ... in the radial polynomial
/// R_nm = sum_s (-1)^s (n - s)! / (s! ((n + m)/2 - s)! ((n - m)/2 - s)!) r^(n - 2s).
static FACTORS: LazyLock<[[f64; TERMS]; COUNT]> = LazyLock::new(|| {
    let factorial = |k: usize| (1..=k).map(|i| i as f64).product::<f64>();
    let mut factors = [[0.0; TERMS]; COUNT];
    for ((n, order), factors) in indices().zip(&mut factors) {
        let m = order.unsigned_abs() as usize;
        let norm = ((n + 1) as f64 * if m == 0 { 1.0 } else { 2.0 }).sqrt();
        let half = (n - m) / 2;
        for s in 0..=half {
            let size = factorial(n - s) / (factorial(s) * factorial((n + m) / 2 - s) * factorial(half - s));
            factors[half - s] = if s % 2 == 0 { norm * size } else { -norm * size };
        }
    }
    factors
});

pub(super) fn weights(u: f64, v: f64) -> [f64; COUNT] {
    // (u + iv)^m.
    let mut powers = [(1.0, 0.0); DEGREE + 1];
    for m in 0..DEGREE {
        let (cosine, sine) = powers[m];
        powers[m + 1] = (cosine * u - sine * v, cosine * v + sine * u);
    }
    let square = u * u + v * v;
    let mut out = [0.0; COUNT];
    for (((_, order), [a, b, c]), out) in indices().zip(FACTORS.iter()).zip(&mut out) {
        let (cosine, sine) = powers[order.unsigned_abs() as usize];
        *out = (a + square * (b + square * c)) * if order < 0 { sine } else { cosine };
    }
    out
}

pub(super) fn gram(domain: Domain) -> Gram {
    match domain {
        Domain::Cosine => Gram::Diagonal(vec![PI; COUNT]),
        Domain::Hemisphere => {
            let orders: Vec<i32> = indices().map(|(_, order)| order).collect();
            // For equal orders the products are polynomials in the squared sine, which is 1 - cos^2 t.
            Gram::Dense(azimuthal_gram(&orders, NODES, 0, |direction, out| {
                out.copy_from_slice(&weights(direction.x(), direction.y()));
            }))
        }
        Domain::Square => {
            let product =
                |j, k| integrate_square(NODES, |u: f64, v: f64| weights(u, v)[j] * weights(u, v)[k]);
            Gram::Dense(Matrix::from_fn(COUNT, COUNT, product))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_the_polynomials_of_the_standard() {
        let (u, v) = (0.3f64, -0.6f64);
        let (r, p) = (u.hypot(v), v.atan2(u));
        let found = weights(u, v);
        let standard = [
            (0, 1.0),
            (1, 2.0 * r * p.sin()),
            (2, 2.0 * r * p.cos()),
            (3, 6f64.sqrt() * r.powi(2) * (2.0 * p).sin()),
            (4, 3f64.sqrt() * (2.0 * r.powi(2) - 1.0)),
            (8, 8f64.sqrt() * (3.0 * r.powi(3) - 2.0 * r) * p.cos()),
            (12, 5f64.sqrt() * (6.0 * r.powi(4) - 6.0 * r.powi(2) + 1.0)),
            (17, 12f64.sqrt() * (10.0 * r.powi(5) - 12.0 * r.powi(3) + 3.0 * r) * p.sin()),
            (20, 12f64.sqrt() * r.powi(5) * (5.0 * p).cos()),
        ];
        for (j, value) in standard {
            assert!((found[j] - value).abs() < 1e-12, "function {j}: {} and {value}", found[j]);
        }
    }
}
