//! Complete polynomials of the projections (u, v) of the unit light vector on the texture plane: all monomials up
//! to a degree, in the order 1, u, v, u^2, uv, v^2, u^3, ... of the web formats.
//!
//! Those of degree 2 have the order of `.ptm` files instead ([`super::ptm`]). On matt surfaces the fitted polynomial
//! follows the cosine without its zero in shadow; each degree adds detail, and needs lights that tell its terms
//! apart. The first-order polynomial is largest on the horizon: of a normal it has the azimuth only.

use super::Domain;
use super::moments;
use crate::numeric::Matrix;

/// The degree of a complete polynomial.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PolynomialDegree {
    /// Degree 1: 3 terms.
    Linear,
    /// Degree 3: 10 terms.
    Cubic,
    /// Degree 4: 15 terms.
    Quartic,
}

impl PolynomialDegree {
    /// All members.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Cubic, Self::Quartic];

    /// The highest sum of the powers of u and v.
    pub fn degree(self) -> u32 {
        match self {
            Self::Linear => 1,
            Self::Cubic => 3,
            Self::Quartic => 4,
        }
    }

    /// The number of monomials.
    pub(super) fn functions(self) -> usize {
        let d = self.degree() as usize;
        (d + 1) * (d + 2) / 2
    }

    /// The name of the basis.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Cubic => "cubic",
            Self::Quartic => "quartic",
        }
    }

    /// The monomials, such as `u2v`.
    pub(super) fn function_names(self) -> Vec<String> {
        let factor = |letter: &str, power: u32| match power {
            0 => String::new(),
            1 => letter.to_owned(),
            power => format!("{letter}{power}"),
        };
        let name =
            |(a, b): (u32, u32)| if a + b == 0 { "1".into() } else { factor("u", a) + &factor("v", b) };
        self.powers().map(name).collect()
    }

    pub(super) fn weights_into(self, u: f64, v: f64, out: &mut [f64]) {
        assert_eq!(out.len(), self.functions(), "a number for each function");
        let mut k = 0;
        for degree in 0..=self.degree() as i32 {
            for b in 0..=degree {
                out[k] = u.powi(degree - b) * v.powi(b);
                k += 1;
            }
        }
    }

    pub(super) fn gram(self, domain: Domain) -> Matrix {
        moments::gram(domain, &self.powers().collect::<Vec<_>>())
    }

    /// The powers of u and v of each function.
    fn powers(self) -> impl Iterator<Item = (u32, u32)> {
        (0..=self.degree()).flat_map(|degree| (0..=degree).map(move |b| (degree - b, b)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_run_by_degree_and_then_by_the_power_of_v() {
        assert_eq!(PolynomialDegree::Linear.function_names(), ["1", "u", "v"]);
        let names = ["1", "u", "v", "u2", "uv", "v2", "u3", "u2v", "uv2", "v3"];
        assert_eq!(PolynomialDegree::Cubic.function_names(), names);
        for degree in PolynomialDegree::ALL {
            let mut weights = vec![0.0; degree.functions()];
            degree.weights_into(0.5, -0.25, &mut weights);
            let powers: Vec<(u32, u32)> = degree.powers().collect();
            assert_eq!(powers.len(), weights.len());
            for ((a, b), weight) in powers.into_iter().zip(weights) {
                assert_eq!(weight, 0.5f64.powi(a as i32) * (-0.25f64).powi(b as i32));
            }
        }
    }
}
