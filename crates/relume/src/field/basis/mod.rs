//! Bases of functions of light and view. A closed family: each member knows its weights for a pair of
//! directions and its Gram matrix over the domains where it is defined; the tests cover all of them.
//!
//! | name | functions | of | defined over |
//! |---|---|---|---|
//! | `constant` | 1 | nothing: a plain picture | hemisphere, cosine, square |
//! | `linear`, `ptm`, `cubic`, `quartic` | 3, 6, 10, 15 | light | hemisphere, cosine, square |
//! | `hsh4`, `hsh9`, `hsh16`, `hsh25` | as named | light | hemisphere (orthonormal), cosine |
//! | `sh4`, `sh9`, `sh16`, `sh25` | as named | light | hemisphere, cosine |
//! | `zernike` | 21 | light | hemisphere, cosine (orthogonal), square |
//! | `rbf`, `tabulated` | one for each photograph | light | hemisphere, cosine |
//! | `learned` | any number | light and view | hemisphere (orthonormal), by its own weights |

mod bands;
mod constant;
mod examples;
mod gram;
mod harmonics;
mod interpolated;
mod learned;
mod moments;
mod packed;
mod polynomial;
mod ptm;
mod roughness;
mod spherical;
mod zernike;

pub use bands::Bands;
#[cfg(test)]
pub(crate) use examples::{learned as learned_example, learned_of_channels as learned_of_channels_example};
pub use gram::Gram;
pub use interpolated::{Interpolated, Interpolation};
pub(crate) use interpolated::{RadialBasis, RadialSum};
pub use learned::Learned;
pub use packed::{MOST_PACKED, PackedFunctions, WeightedDirection};
pub use polynomial::PolynomialDegree;

use serde::{Serialize, Serializer};

use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::names::named;
use crate::numeric::between::PairGrid;

/// A family of functions b_k(light, view). The data of a member is shared: copies are cheap.
#[derive(Debug, Clone, PartialEq)]
pub enum Basis {
    /// The constant 1: a plain picture.
    Constant,
    /// The six monomials of a polynomial texture map.
    Ptm,
    /// All monomials of the light up to a degree other than that of a polynomial texture map.
    Polynomial(PolynomialDegree),
    /// Hemispherical harmonics, in the convention of RTI files.
    Harmonics(Bands),
    /// Real spherical harmonics.
    Spherical(Bands),
    /// Zernike's circle polynomials up to degree 5.
    Zernike,
    /// The photographs, interpolated between their lights.
    Interpolated(Interpolated),
    /// Functions of light and view known at measured pairs of directions.
    Learned(Learned),
}

/// The set of directions, and the measure on it, over which functions are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Domain {
    /// The upper hemisphere, by solid angle: all light directions have equal weight. Every basis is defined
    /// there; a learned one has its own weights.
    Hemisphere,
    /// The upper hemisphere weighted by the cosine, which is the unit disk of (u, v) by area.
    Cosine,
    /// The square [-1, 1]^2 of (u, v), as in HPL-2003-16. Its corners are not directions, so only polynomials
    /// in u and v are defined there.
    Square,
}

named!(Domain { Hemisphere => "hemisphere", Cosine => "cosine", Square => "square" });

impl Basis {
    /// The members identified by their names alone.
    pub const NAMED: [Self; 14] = [
        Self::Constant,
        Self::Polynomial(PolynomialDegree::Linear),
        Self::Ptm,
        Self::Polynomial(PolynomialDegree::Cubic),
        Self::Polynomial(PolynomialDegree::Quartic),
        Self::Harmonics(Bands::Two),
        Self::HSH9,
        Self::Harmonics(Bands::Four),
        Self::Harmonics(Bands::Five),
        Self::Spherical(Bands::Two),
        Self::Spherical(Bands::Three),
        Self::Spherical(Bands::Four),
        Self::Spherical(Bands::Five),
        Self::Zernike,
    ];

    /// The nine hemispherical harmonics that most RTI files hold.
    pub const HSH9: Self = Self::Harmonics(Bands::Three);

    /// One member of each kind, for tests that run over the family.
    pub fn examples() -> Vec<Self> {
        examples::all()
    }

    /// The number of functions.
    #[expect(clippy::len_without_is_empty, reason = "no basis is empty")]
    pub fn len(&self) -> usize {
        match self {
            Self::Constant => 1,
            Self::Ptm => ptm::NAMES.len(),
            Self::Polynomial(degree) => degree.functions(),
            Self::Harmonics(bands) | Self::Spherical(bands) => bands.functions(),
            Self::Zernike => zernike::COUNT,
            Self::Interpolated(interpolated) => interpolated.lights().len(),
            Self::Learned(learned) => learned.functions(),
        }
    }

    /// The number of values of a function for a pair of directions: 1, or one for each channel of a learned
    /// basis whose channels have common coefficients ([`PlaneLayout::shared`](super::PlaneLayout::shared)).
    pub fn channels(&self) -> usize {
        match self {
            Self::Learned(learned) => learned.channels(),
            _ => 1,
        }
    }

    /// Whether the functions differ between views.
    pub fn depends_on_view(&self) -> bool {
        match self {
            Self::Learned(learned) => learned.pairs().iter().any(|pair| pair.view != learned.pairs()[0].view),
            _ => false,
        }
    }

    /// The cosine of the polar angle of the lowest light of functions that are, beyond their lights, those of the nearest ones; `None`
    /// of functions that go on to the horizon.
    pub(crate) fn lowest_light_cosine(&self) -> Option<f64> {
        match self {
            Self::Interpolated(interpolated) => interpolated.lowest_light_cosine(),
            Self::Learned(learned) => learned.lowest_light_cosine(),
            _ => None,
        }
    }

    /// The radial basis functions by which the functions are interpolated, if they are.
    pub(crate) fn radial(&self) -> Option<&RadialBasis> {
        match self {
            Self::Interpolated(interpolated) => interpolated.radial(),
            Self::Learned(learned) => learned.radial(),
            _ => None,
        }
    }

    /// The grid in whose triangles of lights and of views the functions are interpolated, if they are.
    pub(crate) fn measured_grid(&self) -> Option<&PairGrid> {
        match self {
            Self::Learned(learned) => learned.grid(),
            _ => None,
        }
    }

    /// The name used in files, options and messages.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::Ptm => "ptm",
            Self::Polynomial(degree) => degree.name(),
            Self::Harmonics(bands) => harmonics::name(*bands),
            Self::Spherical(bands) => spherical::name(*bands),
            Self::Zernike => "zernike",
            Self::Interpolated(interpolated) => interpolated.interpolation().name(),
            Self::Learned(_) => "learned",
        }
    }

    /// The basis of that name; `None` for bases with their own data.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMED.into_iter().find(|basis| basis.name() == name)
    }

    /// A short name for each function: `1`, `u`, `u2`.
    pub fn function_names(&self) -> Vec<String> {
        match self {
            Self::Constant => vec!["1".to_owned()],
            Self::Ptm => ptm::NAMES.map(str::to_owned).to_vec(),
            Self::Polynomial(degree) => degree.function_names(),
            Self::Harmonics(_) => self.numbered("h"),
            Self::Spherical(_) => self.numbered("y"),
            Self::Zernike => self.numbered("z"),
            Self::Interpolated(_) => self.numbered("p"),
            Self::Learned(_) => self.numbered("f"),
        }
    }

    fn numbered(&self, letter: &str) -> Vec<String> {
        (0..self.len()).map(|k| format!("{letter}{k}")).collect()
    }

    /// The values of the functions for a light and a view, channel after channel, without an allocation.
    ///
    /// # Panics
    /// When `out` does not hold [`Basis::len`] numbers for each of [`Basis::channels`].
    pub fn weights_into(&self, directions: Directions, out: &mut [f64]) {
        let light = directions.light;
        match self {
            Self::Constant => out.copy_from_slice(&[1.0]),
            Self::Ptm => out.copy_from_slice(&ptm::weights(light.x(), light.y())),
            Self::Polynomial(degree) => degree.weights_into(light.x(), light.y(), out),
            Self::Harmonics(bands) => harmonics::weights_into(*bands, light, out),
            Self::Spherical(bands) => spherical::weights_into(*bands, light, out),
            Self::Zernike => out.copy_from_slice(&zernike::weights(light.x(), light.y())),
            Self::Interpolated(interpolated) => interpolated.weights_into(light, out),
            Self::Learned(learned) => {
                let expected = learned.channels() * learned.functions();
                assert_eq!(out.len(), expected, "a number for each function and channel");
                learned.weights_into(directions, out);
            }
        }
    }

    /// The values of the functions for a light and a view; a light alone implies the view from straight
    /// above. For many directions, [`Basis::weights_into`] saves the allocations.
    pub fn weights(&self, directions: impl Into<Directions>) -> Vec<f64> {
        let mut out = vec![0.0; self.channels() * self.len()];
        self.weights_into(directions.into(), &mut out);
        out
    }

    /// Whether the functions can be compared over a domain.
    pub fn is_defined_over(&self, domain: Domain) -> bool {
        match self {
            Self::Constant | Self::Polynomial(_) | Self::Ptm | Self::Zernike => true,
            Self::Harmonics(_) | Self::Spherical(_) | Self::Interpolated(_) => domain != Domain::Square,
            Self::Learned(_) => domain == Domain::Hemisphere,
        }
    }

    /// The inner products of the functions over a domain: in closed form, or by a quadrature that is exact for
    /// their degree; of interpolated ones by a fine quadrature.
    ///
    /// # Errors
    /// When the basis is not defined over the domain.
    pub fn gram(&self, domain: Domain) -> Result<Gram> {
        let gram = match self {
            Self::Constant => Some(Gram::Dense(constant::gram(domain))),
            Self::Ptm => Some(Gram::Dense(ptm::gram(domain))),
            Self::Polynomial(degree) => Some(Gram::Dense(degree.gram(domain))),
            Self::Harmonics(bands) => harmonics::gram(*bands, domain),
            Self::Spherical(bands) => spherical::gram(*bands, domain),
            Self::Zernike => Some(zernike::gram(domain)),
            Self::Interpolated(interpolated) => interpolated.gram(domain).map(Gram::Dense),
            Self::Learned(learned) if domain == Domain::Hemisphere => {
                Some(Gram::Diagonal(vec![1.0; learned.functions()]))
            }
            Self::Learned(_) => None,
        };
        gram.ok_or_else(|| self.undefined(domain))
    }

    /// The functions from the smoothest to the most detailed: the order in which they are made
    /// orthonormal, so that the first index plane is the mean.
    pub fn graded_order(&self) -> Vec<usize> {
        match self {
            Self::Ptm => ptm::GRADED_ORDER.to_vec(),
            _ => (0..self.len()).collect(),
        }
    }

    /// Integrates a function of the values of the functions over a domain numerically, with `nodes` nodes per
    /// dimension (for interpolated functions no fewer than their own), or over the measured pairs and the channels: the
    /// slow truth of every Gram matrix.
    ///
    /// # Errors
    /// When the basis is not defined over the domain.
    pub fn integrate(&self, domain: Domain, nodes: usize, mut f: impl FnMut(&[f64]) -> f64) -> Result<f64> {
        use crate::numeric::quadrature::{integrate_hemisphere, integrate_square};
        let nodes =
            if matches!(self, Self::Interpolated(_)) { nodes.max(interpolated::NODES) } else { nodes };
        match (self, domain) {
            (Self::Learned(learned), Domain::Hemisphere) => Ok(learned.integrate(f)),
            _ if !self.is_defined_over(domain) => Err(self.undefined(domain)),
            (_, Domain::Hemisphere) => Ok(integrate_hemisphere(nodes, |w| f(&self.weights(w)))),
            (_, Domain::Cosine) => Ok(integrate_hemisphere(nodes, |w| w.z() * f(&self.weights(w)))),
            (_, Domain::Square) => Ok(integrate_square(nodes, |u, v| f(&self.polynomial_weights(u, v)))),
        }
    }

    /// The values of polynomials of u and v anywhere on the square.
    fn polynomial_weights(&self, u: f64, v: f64) -> Vec<f64> {
        let mut out = vec![1.0; self.len()];
        match self {
            Self::Ptm => out.copy_from_slice(&ptm::weights(u, v)),
            Self::Polynomial(degree) => degree.weights_into(u, v, &mut out),
            Self::Zernike => out.copy_from_slice(&zernike::weights(u, v)),
            Self::Constant | Self::Harmonics(_) | Self::Spherical(_) => {}
            Self::Interpolated(_) | Self::Learned(_) => {}
        }
        out
    }

    fn undefined(&self, domain: Domain) -> Error {
        let defined: Vec<&str> =
            Domain::ALL.iter().filter(|d| self.is_defined_over(**d)).map(|d| d.name()).collect();
        Error::usage(format!(
            "functions of the basis {} cannot be compared over the {}: choose the {}",
            self.name(),
            domain.name(),
            defined.join(" or the ")
        ))
    }
}

/// As [`Basis::name`].
impl Serialize for Basis {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

impl Domain {
    /// All members.
    pub const ALL: [Self; 3] = [Self::Hemisphere, Self::Cosine, Self::Square];

    /// The name used in options and messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hemisphere => "hemisphere",
            Self::Cosine => "cosine",
            Self::Square => "square",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::direction::Direction;

    #[test]
    fn every_gram_matrix_equals_its_numerical_integral() {
        for (basis, domain) in Basis::examples().into_iter().flat_map(|b| Domain::ALL.map(|d| (b.clone(), d)))
        {
            let Ok(gram) = basis.gram(domain) else {
                assert!(!basis.is_defined_over(domain));
                assert!(basis.integrate(domain, 4, |_| 1.0).is_err(), "{basis:?} over {domain:?}");
                continue;
            };
            assert!(basis.is_defined_over(domain));
            // The sums of a learned basis are as accurate as its values.
            let tolerance = if matches!(basis, Basis::Learned(_)) { 1e-6 } else { 1e-12 };
            for (j, k) in (0..basis.len()).flat_map(|j| (0..basis.len()).map(move |k| (j, k))) {
                let truth = basis.integrate(domain, 12, |weights| weights[j] * weights[k]).unwrap();
                let error = (gram.at(j, k) - truth).abs();
                assert!(error < tolerance, "{} over {domain:?} ({j}, {k}): off by {error:.1e}", basis.name());
            }
        }
    }

    #[test]
    fn domains_without_a_basis_are_refused_in_a_sentence() {
        let message = |basis: &Basis, domain| basis.gram(domain).unwrap_err().to_string();
        let harmonics = message(&Basis::HSH9, Domain::Square);
        assert!(harmonics.contains("hsh9 cannot be compared over the square"), "{harmonics}");
        assert!(harmonics.contains("choose the hemisphere or the cosine"), "{harmonics}");
        let learned = Basis::examples().pop().unwrap();
        assert!(message(&learned, Domain::Cosine).ends_with("choose the hemisphere"));
    }

    #[test]
    fn graded_orders_are_permutations_and_names_are_unique() {
        for basis in Basis::examples() {
            let mut order = basis.graded_order();
            order.sort_unstable();
            assert_eq!(order, (0..basis.len()).collect::<Vec<_>>());
            let found = Basis::from_name(basis.name());
            let has_data = matches!(basis, Basis::Interpolated(_) | Basis::Learned(_));
            assert_eq!(found, (!has_data).then_some(basis.clone()));
            let mut names = basis.function_names();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), basis.len());
            assert_eq!(basis.weights(Direction::ZENITH).len(), basis.channels() * basis.len());
        }
    }

    #[test]
    fn bases_of_light_ignore_the_view_and_learned_ones_do_not() {
        let light = Direction::from_angles(0.5, 1.0);
        let aside = Directions { light, view: Direction::from_angles(1.0, -2.0) };
        for basis in Basis::examples() {
            let same = basis.weights(light) == basis.weights(aside);
            assert_eq!(same, !matches!(basis, Basis::Learned(_)), "{}", basis.name());
            assert_eq!(basis.depends_on_view(), !same);
        }
    }

    /// A copy of a basis shares its table, however large.
    #[test]
    fn the_basis_of_6561_pairs_is_copied_without_its_table() {
        let basis = Basis::Learned(examples::learned(81, 81, 6));
        let copy = basis.clone();
        let (Basis::Learned(a), Basis::Learned(b)) = (&basis, &copy) else { panic!("learned bases") };
        assert_eq!(a.pairs().len(), 6561);
        assert!(std::ptr::eq(a.values(), b.values()));
    }
}
