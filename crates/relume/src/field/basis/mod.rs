//! Bases of functions of light direction. A closed family: each member knows its weights for a
//! direction and its Gram matrix over a domain; the tests run over all of them.

mod constant;
mod moments;
mod ptm;

use serde::Serialize;

use crate::direction::Direction;
use crate::numeric::Matrix;

/// A family of functions b_k(w).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Basis {
    /// The constant 1: a plain picture.
    Constant,
    /// The six monomials of a polynomial texture map.
    Ptm,
}

/// The set of directions, and the measure on it, over which functions are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Domain {
    /// The upper hemisphere, by solid angle: every light direction counts equally.
    Hemisphere,
    /// The upper hemisphere weighted by the cosine, which is the unit disk of (u, v) by area.
    Cosine,
    /// The square [-1, 1]^2 of (u, v): the documents' domain. Its corners are no directions.
    Square,
}

impl Basis {
    /// All members.
    pub const ALL: [Self; 2] = [Self::Constant, Self::Ptm];

    /// The number of functions.
    #[expect(clippy::len_without_is_empty, reason = "no basis is empty")]
    pub fn len(self) -> usize {
        self.graded_order().len()
    }

    /// The name used in files, options and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Ptm => "ptm",
        }
    }

    /// The basis of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|basis| basis.name() == name)
    }

    /// A short name for each function: `1`, `u`, `u2`.
    pub fn function_names(self) -> &'static [&'static str] {
        match self {
            Self::Constant => &["1"],
            Self::Ptm => &ptm::NAMES,
        }
    }

    /// The values of the functions in one direction.
    pub fn weights(self, light: Direction) -> Vec<f64> {
        self.weights_at(light.x(), light.y())
    }

    /// The values of the functions over the point (u, v), inside the unit disk or not.
    pub fn weights_at(self, u: f64, v: f64) -> Vec<f64> {
        match self {
            Self::Constant => constant::weights().to_vec(),
            Self::Ptm => ptm::weights(u, v).to_vec(),
        }
    }

    /// The inner products of the functions over a domain, in closed form.
    pub fn gram(self, domain: Domain) -> Matrix {
        match self {
            Self::Constant => constant::gram(domain),
            Self::Ptm => ptm::gram(domain),
        }
    }

    /// The functions from the smoothest to the most detailed: the order in which they are made
    /// orthonormal, so that the first index plane is the mean.
    pub fn graded_order(self) -> &'static [usize] {
        match self {
            Self::Constant => &[0],
            Self::Ptm => &ptm::GRADED_ORDER,
        }
    }
}

impl Domain {
    /// All members.
    pub const ALL: [Self; 3] = [Self::Hemisphere, Self::Cosine, Self::Square];

    /// Integrates numerically with `n` nodes a dimension: the slow truth of every Gram matrix.
    pub fn integrate(self, n: usize, f: impl Fn(f64, f64) -> f64) -> f64 {
        use crate::numeric::quadrature::{integrate_hemisphere, integrate_square};
        match self {
            Self::Hemisphere => integrate_hemisphere(n, |w| f(w.x(), w.y())),
            Self::Cosine => integrate_hemisphere(n, |w| w.z() * f(w.x(), w.y())),
            Self::Square => integrate_square(n, f),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_gram_matrix_equals_its_numerical_integral() {
        for basis in Basis::ALL {
            for domain in Domain::ALL {
                let gram = basis.gram(domain);
                for j in 0..basis.len() {
                    for k in 0..basis.len() {
                        let truth = domain.integrate(12, |u, v| {
                            let weights = basis.weights_at(u, v);
                            weights[j] * weights[k]
                        });
                        let error = (gram[(j, k)] - truth).abs();
                        assert!(error < 1e-12, "{basis:?} over {domain:?} ({j}, {k}): off by {error:.1e}");
                    }
                }
            }
        }
    }

    #[test]
    fn graded_orders_are_permutations_and_names_are_unique() {
        for basis in Basis::ALL {
            let mut order = basis.graded_order().to_vec();
            order.sort_unstable();
            assert_eq!(order, (0..basis.len()).collect::<Vec<_>>());
            assert_eq!(Basis::from_name(basis.name()), Some(basis));
            assert_eq!(basis.function_names().len(), basis.len());
            assert_eq!(basis.weights(Direction::ZENITH).len(), basis.len());
        }
    }
}
