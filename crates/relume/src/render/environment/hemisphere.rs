//! Functions over the hemisphere of a surface, orthonormal where light fades out towards the horizon as it does in
//! pictures of objects.
//!
//! All polynomials of degree d and less in the components of the direction: (d + 1)² functions s^m cos(m a) p(c) and
//! s^m sin(m a) p(c), where c and s are the cosine and the sine of the angle from the normal and a is the azimuth. For
//! each m the polynomials p are orthonormal under s^2m times the fade; so the functions are those of a polynomial
//! texture map and more, and turning a frame about its normal mixes two of them at a time.

use std::f64::consts::{PI, TAU};

use super::super::horizon::AttachedShadow;
use crate::direction::Direction;
use crate::numeric::orthogonal::OrthogonalPolynomials;
use crate::numeric::quadrature::gauss_legendre;

/// Nodes on either side of the end of the fade: exact for the products of functions of degree 12 and the fade.
const NODES: usize = 32;
/// The degree of the polynomials beyond that of the functions, for the rules of integration.
const BEYOND: usize = 6;
/// Azimuths of the fine rule.
const AZIMUTHS: usize = 128;

/// What happens to light at the horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum HorizonEdge {
    /// It counts fully down to the horizon.
    Sharp,
    /// It fades out: the attached shadow of objects.
    Faded(AttachedShadow),
}

impl HorizonEdge {
    /// The share of light at a cosine that counts.
    fn share(self, cosine: f64) -> f64 {
        match self {
            Self::Sharp => f64::from(u8::from(cosine > 0.0)),
            Self::Faded(shadow) => shadow.share(cosine),
        }
    }

    /// Cosines with weights that integrate what counts of them.
    fn cosines(self) -> impl Iterator<Item = (f64, f64)> {
        let part = |low: f64, high: f64| {
            let scale = 0.5 * (high - low);
            gauss_legendre(NODES).into_iter().map(move |(t, w)| (low + scale * (t + 1.0), w * scale))
        };
        let begins = match self {
            Self::Sharp => 0.5,
            Self::Faded(shadow) => shadow.begins(),
        };
        part(0.0, begins).chain(part(begins, 1.0)).map(move |(c, w)| (c, w * self.share(c)))
    }
}

/// The functions of a degree.
#[derive(Debug, Clone)]
pub(super) struct HemisphereSpace {
    degree: usize,
    edge: HorizonEdge,
    /// For each m.
    radial: Vec<OrthogonalPolynomials>,
}

impl HemisphereSpace {
    pub fn new(degree: usize, edge: HorizonEdge) -> Self {
        let measure = |m: usize| -> Vec<(f64, f64)> {
            edge.cosines().map(|(c, w)| (c, w * (1.0 - c * c).powi(m as i32))).collect()
        };
        let radial = (0..=degree).map(|m| OrthogonalPolynomials::new(&measure(m), degree + BEYOND)).collect();
        Self { degree, edge, radial }
    }

    pub fn degree(&self) -> usize {
        self.degree
    }

    /// The number of functions.
    pub fn len(&self) -> usize {
        (self.degree + 1) * (self.degree + 1)
    }

    /// The share of light at a cosine that counts.
    pub fn share(&self, cosine: f64) -> f64 {
        self.edge.share(cosine)
    }

    /// The values of all functions for a unit vector in the frame of the surface: those of m = 0 by degree, and for
    /// each further m and degree the one of the cosine and that of the sine.
    pub fn values_into(&self, [x, y, c]: [f64; 3], out: &mut [f64]) {
        let d = self.degree;
        let mut radial = [0.0; 16];
        self.radial[0].values_into(c, &mut radial[..=d]);
        let norm = 1.0 / TAU.sqrt();
        out[..=d].iter_mut().zip(radial).for_each(|(out, p)| *out = norm * p);
        let norm = 1.0 / PI.sqrt();
        let (mut cos, mut sin, mut at) = (x, y, d + 1);
        for m in 1..=d {
            let count = d + 1 - m;
            self.radial[m].values_into(c, &mut radial[..count]);
            for p in &radial[..count] {
                out[at] = norm * cos * p;
                out[at + 1] = norm * sin * p;
                at += 2;
            }
            (cos, sin) = (cos * x - sin * y, cos * y + sin * x);
        }
    }

    /// As [`HemisphereSpace::rule`], of thousands of directions: for functions with edges.
    pub fn fine_rule(&self) -> impl Iterator<Item = (Direction, f64)> {
        self.edge.cosines().flat_map(|(c, w)| ring(c, w, AZIMUTHS))
    }

    /// Directions with weights that integrate over the hemisphere, fade included: Gaussian in the cosine with `rings`
    /// nodes, evenly in azimuth.
    ///
    /// # Panics
    /// When there are more than the degree and 6 rings.
    pub fn rule(&self, rings: usize) -> Vec<(Direction, f64)> {
        self.radial[0].gauss(rings).into_iter().flat_map(|(c, w)| ring(c, w, 2 * rings)).collect()
    }
}

/// A number of directions of one cosine, and their weights, which sum to that of the cosine times 2 pi.
fn ring(cosine: f64, weight: f64, azimuths: usize) -> impl Iterator<Item = (Direction, f64)> {
    let polar = cosine.clamp(0.0, 1.0).acos();
    (0..azimuths).map(move |k| {
        let azimuth = TAU * k as f64 / azimuths as f64;
        (Direction::from_angles(polar, azimuth), weight * TAU / azimuths as f64)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_functions_are_orthonormal_over_the_faded_hemisphere() {
        let faded =
            [AttachedShadow::Smooth, AttachedShadow::Proportional { from: 0.26 }].map(HorizonEdge::Faded);
        for edge in [HorizonEdge::Sharp].into_iter().chain(faded) {
            for degree in [0, 1, 2, 4, 6] {
                let space = HemisphereSpace::new(degree, edge);
                let n = space.len();
                let mut products = vec![0.0; n * n];
                let mut values = vec![0.0; n];
                for (direction, weight) in space.rule(degree + 2) {
                    space.values_into(direction.to_array(), &mut values);
                    for (j, k) in (0..n).flat_map(|j| (0..n).map(move |k| (j, k))) {
                        products[j * n + k] += weight * values[j] * values[k];
                    }
                }
                for (i, product) in products.into_iter().enumerate() {
                    let truth = f64::from(u8::from(i / n == i % n));
                    assert!((product - truth).abs() < 1e-9, "{edge:?} degree {degree}: {i} {product}");
                }
            }
        }
    }
}
