//! Functions of a polar coordinate times cosines and sines of multiples of the azimuth: the products of associated
//! Legendre functions that make spherical and hemispherical harmonics, and inner products of such functions.

use std::f64::consts::{PI, SQRT_2};
use std::sync::LazyLock;

use crate::direction::Direction;
use crate::numeric::Matrix;
use crate::numeric::quadrature::gauss_legendre;

/// The highest number of bands.
const MOST: usize = 5;

/// The number of bands of harmonics: degrees from 0, with 1, 3, 5, ... functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bands {
    /// Degrees 0 and 1: 4 functions.
    Two,
    /// Degrees 0 to 2: 9 functions.
    Three,
    /// Degrees 0 to 3: 16 functions.
    Four,
    /// Degrees 0 to 4: 25 functions.
    Five,
}

impl Bands {
    /// All members.
    pub const ALL: [Self; 4] = [Self::Two, Self::Three, Self::Four, Self::Five];

    /// The number of bands, which is the highest degree and one.
    pub fn count(self) -> usize {
        match self {
            Self::Two => 2,
            Self::Three => 3,
            Self::Four => 4,
            Self::Five => 5,
        }
    }

    /// The number of functions: the square of the number of bands.
    pub fn functions(self) -> usize {
        self.count().pow(2)
    }

    /// The azimuthal order of each function, positive for cosines and negative for sines: within a degree l from l
    /// down to -l.
    pub(super) fn orders(self) -> Vec<i32> {
        (0..self.count() as i32).flat_map(|l| (-l..=l).rev()).collect()
    }
}

/// sqrt((2l + 1) (l - m)! / (4 pi (l + m)!)), times the root of 2 for m > 0: what makes real spherical harmonics
/// orthonormal on the sphere.
static NORMS: LazyLock<[[f64; MOST]; MOST]> = LazyLock::new(|| {
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    std::array::from_fn(|l| {
        std::array::from_fn(|m| {
            if m > l {
                return 0.0;
            }
            let square = (2 * l + 1) as f64 * factorial(l - m) / (4.0 * PI * factorial(l + m));
            square.sqrt() * if m > 0 { SQRT_2 } else { 1.0 }
        })
    })
});

/// Real spherical harmonics N_lm P_lm(t) cos(m p) and N_lm P_lm(t) sin(m p), without the sign (-1)^m of Condon and
/// Shortley, where (x, y) = sqrt(1 - t^2) (cos p, sin p): as these components the pole needs no azimuth. The Legendre
/// functions by the recurrence (l - m) P_lm = (2l - 1) t P_(l-1)m - (l + m - 1) P_(l-2)m.
pub(super) fn harmonics_into(bands: Bands, t: f64, [x, y]: [f64; 2], out: &mut [f64]) {
    assert_eq!(out.len(), bands.functions(), "a number for each function");
    // (x + iy)^m, and P_mm without the factor sqrt(1 - t^2)^m, which is (2m - 1)!!.
    let (mut cosine, mut sine, mut diagonal) = (1.0, 0.0, 1.0);
    for m in 0..bands.count() {
        let (mut before, mut legendre) = (0.0, diagonal);
        for l in m..bands.count() {
            let middle = l * l + l;
            let value = NORMS[l][m] * legendre;
            out[middle + m] = value * sine;
            out[middle - m] = value * cosine;
            let next = ((2 * l + 1) as f64 * t * legendre - (l + m) as f64 * before) / (l + 1 - m) as f64;
            (before, legendre) = (legendre, next);
        }
        (cosine, sine) = (cosine * x - sine * y, cosine * y + sine * x);
        diagonal *= (2 * m + 1) as f64;
    }
}

/// The inner products by solid angle, times a power of the cosine, of functions with azimuthal `orders`: zero for
/// different orders; for equal ones 2 pi or pi, the integral of the squared azimuthal function, times a quadrature
/// with `nodes` nodes in cos t, which is exact for polynomials in cos t of degree 2 nodes - 1.
pub(super) fn azimuthal_gram(
    orders: &[i32],
    nodes: usize,
    cosine_power: i32,
    weights_into: impl Fn(Direction, &mut [f64]),
) -> Matrix {
    let n = orders.len();
    let mut gram = Matrix::zeros(n, n);
    let mut values = vec![0.0; n];
    for order in orders.iter().collect::<std::collections::BTreeSet<_>>() {
        // The azimuth at which the azimuthal function is 1: cos(m p), or sin(m p).
        let azimuth = if *order < 0 { 0.5 * PI / f64::from(-order) } else { 0.0 };
        let mean_square = if *order == 0 { 2.0 * PI } else { PI };
        for (t, weight) in gauss_legendre(nodes) {
            let c = 0.5 * (t + 1.0);
            weights_into(Direction::from_angles(c.acos(), azimuth), &mut values);
            let factor = mean_square * 0.5 * weight * c.powi(cosine_power);
            for (j, k) in (0..n).flat_map(|j| (0..n).map(move |k| (j, k))) {
                if orders[j] == *order && orders[k] == *order {
                    gram[(j, k)] += factor * values[j] * values[k];
                }
            }
        }
    }
    gram
}
