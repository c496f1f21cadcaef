//! The photographs themselves as coefficients: function i is 1 at the light of photograph i and 0 at all others, and
//! between the lights follows one of three rules of interpolation.
//!
//! - `rbf`: radial basis functions over the lights with a polynomial of first degree in the three components of the
//!   direction. The kernel is the thin plate spline r² ln r of the distance r of unit vectors (Duchon, "Splines minimizing
//!   rotation-invariant semi-norms in Sobolev spaces", 1977); on photographs left out it does as well as the cubic r³ or
//!   better on all four SynthRTI sets of the test data. With K the kernel between lights, P the polynomial at lights and
//!   M = [K P; P' 0], the functions at a direction w are the first n components of M^-1 [k(w); p(w)]. Where lights do
//!   not tell the terms of the polynomial apart, as on one ring, the dependent ones are left out.
//! - `tabulated`: barycentric in the triangles of a Delaunay triangulation of the lights, constant beyond the
//!   outermost ([`crate::numeric::between`]).
//! - `shapes`: as `rbf`, and what its sum loses at the boundaries of shadows and highlights is added by
//!   [`crate::field::Shapes`].
//!
//! A texel has as many numbers as there are photographs, times channels. Inner products are sums over a fixed set of
//! directions ([`NODES`]): those of the quadrature by which polynomials of degree 63 in the height of the light would be
//! exact.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::Domain;
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::numeric::Matrix;
use crate::numeric::between::Between;
use crate::numeric::matrix::Qr;
use crate::numeric::quadrature::hemisphere;

/// Nodes of the quadrature of inner products: rings of directions, each with twice as many azimuths.
pub(super) const NODES: usize = 32;

/// Lights nearer to each other than this in every component are one.
const SAME_LIGHT: f64 = 1e-4;

/// A term of the polynomial is left out when the sine of its angle to the span of the earlier ones over the lights is
/// below this: lights of one ring, rounded in their file, deviate from it by about 1e-4.
const LEAST_SINE: f64 = 1e-2;

/// How functions are interpolated between lights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Radial basis functions with a polynomial of first degree.
    RadialBasis,
    /// Triangles between lights.
    Triangles,
    /// The functions of [`Interpolation::RadialBasis`], and boundaries of shadows and highlights that move between the
    /// lights, which [`crate::field::Shapes`] adds.
    Shapes,
}

/// One function for each light. Copies share the table.
#[derive(Debug, Clone)]
pub struct Interpolated(Arc<LightTable>);

#[derive(Debug)]
struct LightTable {
    lights: Vec<Direction>,
    interpolation: Interpolation,
    rule: Rule,
}

#[derive(Debug)]
enum Rule {
    RadialBasis(RadialBasis),
    Triangles(Between),
}

/// The first columns of M^-1: the functions are the kernel and the polynomial times these.
#[derive(Debug)]
pub(crate) struct RadialBasis {
    lights: Vec<Direction>,
    /// Which of 1, x, y, z take part.
    terms: Vec<usize>,
    /// One row for each light and then for each term; a column for each function.
    mixing: Matrix,
}

impl Interpolation {
    /// All members.
    pub const ALL: [Self; 3] = [Self::RadialBasis, Self::Triangles, Self::Shapes];

    /// The name of the basis.
    pub fn name(self) -> &'static str {
        match self {
            Self::RadialBasis => "rbf",
            Self::Triangles => "tabulated",
            Self::Shapes => "shapes",
        }
    }
}

impl Interpolated {
    /// One function for each of some lights.
    ///
    /// # Errors
    /// No light, and two lights in one direction.
    pub fn new(lights: &[Direction], interpolation: Interpolation) -> Result<Self> {
        if lights.is_empty() {
            return Err(Error::invalid("interpolation between lights needs at least one light, found none"));
        }
        check_distinct(lights)?;
        let rule = match interpolation {
            Interpolation::RadialBasis | Interpolation::Shapes => {
                Rule::RadialBasis(RadialBasis::new(lights)?)
            }
            Interpolation::Triangles => {
                let pairs: Vec<Directions> = lights.iter().map(|&light| light.into()).collect();
                Rule::Triangles(Between::new(&pairs))
            }
        };
        Ok(Self(Arc::new(LightTable { lights: lights.to_vec(), interpolation, rule })))
    }

    /// The lights, one for each function.
    pub fn lights(&self) -> &[Direction] {
        &self.0.lights
    }

    /// How functions are interpolated between lights.
    pub fn interpolation(&self) -> Interpolation {
        self.0.interpolation
    }

    /// As [`super::Basis::lowest_light_cosine`].
    pub(super) fn lowest_light_cosine(&self) -> Option<f64> {
        let lowest = || self.lights().iter().map(|light| light.z()).reduce(f64::min);
        matches!(self.0.rule, Rule::Triangles(_)).then(lowest).flatten()
    }

    /// The radial basis functions, if they are such.
    pub(super) fn radial(&self) -> Option<&RadialBasis> {
        match &self.0.rule {
            Rule::RadialBasis(radial) => Some(radial),
            Rule::Triangles(_) => None,
        }
    }

    /// The same without light `i`, unless there is no other.
    pub(crate) fn without(&self, i: usize) -> Option<Self> {
        self.of(|k| k != i)
    }

    /// The same of the lights that are chosen by their numbers, if there are any.
    pub(crate) fn of(&self, is_chosen: impl Fn(usize) -> bool) -> Option<Self> {
        let chosen = (0..self.0.lights.len()).filter(|i| is_chosen(*i)).map(|i| self.0.lights[i]);
        Self::new(&chosen.collect::<Vec<_>>(), self.interpolation()).ok()
    }

    /// The functions for a light.
    pub(crate) fn weights_into(&self, light: Direction, out: &mut [f64]) {
        assert_eq!(out.len(), self.0.lights.len(), "a number for each function");
        match &self.0.rule {
            Rule::RadialBasis(radial) => radial.values_into(light, out),
            Rule::Triangles(between) => {
                out.fill(0.0);
                let shares = between.shares(Directions::lit_from(light));
                shares.as_slice().iter().for_each(|&(i, share)| out[i] += share);
            }
        }
    }

    /// The inner products; `None` over the square, whose corners are not directions.
    pub(super) fn gram(&self, domain: Domain) -> Option<Matrix> {
        let n = self.0.lights.len();
        let mut gram = Matrix::zeros(n, n);
        let mut values = vec![0.0; n];
        for (light, share) in hemisphere(NODES) {
            self.weights_into(light, &mut values);
            let weight = match domain {
                Domain::Hemisphere => TAU * share,
                Domain::Cosine => TAU * share * light.z(),
                Domain::Square => return None,
            };
            for (j, &a) in values.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                let factor = weight * a;
                gram.row_mut(j).iter_mut().zip(&values).for_each(|(sum, b)| *sum += factor * b);
            }
        }
        Some(gram)
    }
}

/// Tables of the same lights and rule are equal.
impl PartialEq for Interpolated {
    fn eq(&self, other: &Self) -> bool {
        let same = || self.interpolation() == other.interpolation() && self.lights() == other.lights();
        Arc::ptr_eq(&self.0, &other.0) || same()
    }
}

impl RadialBasis {
    pub(super) fn new(lights: &[Direction]) -> Result<Self> {
        let n = lights.len();
        let terms = independent_terms(lights);
        let entry = |r: usize, c: usize| match (r.checked_sub(n), c.checked_sub(n)) {
            (None, None) => kernel(lights[r], lights[c]),
            (None, Some(t)) => term(terms[t], lights[r]),
            (Some(t), None) => term(terms[t], lights[c]),
            (Some(_), Some(_)) => 0.0,
        };
        let qr = Qr::new(&Matrix::from_fn(n + terms.len(), n + terms.len(), entry));
        if qr.pivot_ratio() < 1e-12 {
            return Err(Error::invalid(
                "some lights are too near each other for radial basis functions: leave photographs out",
            ));
        }
        let inverse = qr.pseudo_inverse();
        let mixing = Matrix::from_fn(n + terms.len(), n, |r, c| inverse[(r, c)]);
        Ok(Self { lights: lights.to_vec(), terms, mixing })
    }

    /// The functions with these values at the lights, a row for each light.
    pub(super) fn of_values(self, values: &Matrix) -> Self {
        Self { mixing: self.mixing.times(values), ..self }
    }

    /// The values of the functions for a light.
    pub(super) fn values_into(&self, light: Direction, out: &mut [f64]) {
        out.fill(0.0);
        for (r, value) in self.terms_of(light).enumerate() {
            out.iter_mut().zip(self.mixing.row(r)).for_each(|(o, m)| *o += value * m);
        }
    }

    /// The kernel of each light and then the polynomial.
    fn terms_of(&self, light: Direction) -> impl Iterator<Item = f64> {
        let kernels = self.lights.iter().map(move |other| kernel(*other, light));
        kernels.chain(self.terms.iter().map(move |k| term(*k, light)))
    }

    /// The sum of the functions times coefficients, as one function.
    pub(crate) fn combined(&self, coefficients: &[f64]) -> RadialSum<'_> {
        let sum = |r: usize| self.mixing.row(r).iter().zip(coefficients).map(|(m, c)| m * c).sum();
        RadialSum { basis: self, factors: (0..self.mixing.rows()).map(sum).collect() }
    }
}

/// One function of the light: a sum of kernels and a polynomial.
pub(crate) struct RadialSum<'a> {
    basis: &'a RadialBasis,
    factors: Vec<f64>,
}

impl RadialSum<'_> {
    /// Its value.
    pub fn value(&self, light: Direction) -> f64 {
        self.basis.terms_of(light).zip(&self.factors).map(|(value, factor)| value * factor).sum()
    }
}

/// r² ln r, by the squared distance of the unit vectors.
fn kernel(a: Direction, b: Direction) -> f64 {
    let (a, b) = (a.to_array(), b.to_array());
    let square: f64 = a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum();
    if square > 0.0 { 0.5 * square * square.ln() } else { 0.0 }
}

/// Term `k` of 1, x, y, z.
fn term(k: usize, light: Direction) -> f64 {
    let [x, y, z] = light.to_array();
    [1.0, x, y, z][k]
}

/// The terms of 1, x, y, z that lights tell apart, by Gram-Schmidt in this order.
fn independent_terms(lights: &[Direction]) -> Vec<usize> {
    let mut kept = Vec::new();
    let mut axes: Vec<Vec<f64>> = Vec::new();
    for k in 0..4 {
        let mut column: Vec<f64> = lights.iter().map(|light| term(k, *light)).collect();
        let norm = |column: &[f64]| column.iter().map(|v| v * v).sum::<f64>().sqrt();
        let before = norm(&column);
        for axis in axes.iter().chain(&axes) {
            let share: f64 = axis.iter().zip(&column).map(|(a, c)| a * c).sum();
            column.iter_mut().zip(axis).for_each(|(c, a)| *c -= share * a);
        }
        let after = norm(&column);
        if after > LEAST_SINE * before && kept.len() < lights.len() {
            column.iter_mut().for_each(|c| *c /= after);
            axes.push(column);
            kept.push(k);
        }
    }
    kept
}

fn check_distinct(lights: &[Direction]) -> Result<()> {
    let near = |a: &Direction, b: &Direction| {
        a.to_array().iter().zip(b.to_array()).all(|(x, y)| (x - y).abs() < SAME_LIGHT)
    };
    for (i, light) in lights.iter().enumerate() {
        if let Some(j) = lights[..i].iter().position(|other| near(light, other)) {
            let [x, y, z] = light.to_array();
            return Err(Error::invalid(format!(
                "photographs {} and {} have the same light ({x:.4}, {y:.4}, {z:.4}): interpolation between lights needs \
                 different ones, so leave one out",
                j + 1,
                i + 1
            )));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dome(count: usize) -> Vec<Direction> {
        (0..count).map(Direction::fibonacci(count)).collect()
    }

    fn weights(basis: &Interpolated, light: Direction) -> Vec<f64> {
        let mut out = vec![0.0; basis.lights().len()];
        basis.weights_into(light, &mut out);
        out
    }

    fn ring(count: usize, polar_rad: f64) -> Vec<Direction> {
        (0..count).map(|i| Direction::from_angles(polar_rad, TAU * i as f64 / count as f64)).collect()
    }

    #[test]
    fn each_function_is_one_at_its_light_and_zero_at_all_others() {
        let in_line: Vec<Direction> =
            (0..5).map(|i| Direction::from_angles(0.3 * f64::from(i), 0.0)).collect();
        for lights in [dome(1), dome(2), dome(3), dome(49), ring(12, 0.8), in_line] {
            for interpolation in Interpolation::ALL {
                let basis = Interpolated::new(&lights, interpolation).unwrap();
                for (i, light) in lights.iter().enumerate() {
                    for (k, value) in weights(&basis, *light).into_iter().enumerate() {
                        let truth = f64::from(u8::from(i == k));
                        assert!((value - truth).abs() < 1e-6, "{interpolation:?} {i} {k}: {value}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_sum_of_functions_is_one_function() {
        let basis = Interpolated::new(&dome(20), Interpolation::RadialBasis).unwrap();
        let coefficients: Vec<f64> = (0..20).map(|k| (f64::from(k) * 1.7).sin()).collect();
        let sum = basis.radial().unwrap().combined(&coefficients);
        for light in (0..30).map(Direction::fibonacci(30)) {
            let truth: f64 = weights(&basis, light).iter().zip(&coefficients).map(|(w, c)| w * c).sum();
            assert!((sum.value(light) - truth).abs() < 1e-9, "{light:?}");
        }
    }

    /// A first-degree polynomial of the direction, such as the shading of a matt surface in the light, is exact.
    #[test]
    fn radial_basis_functions_reproduce_the_shading_of_a_plane() {
        let lights = dome(30);
        let basis = Interpolated::new(&lights, Interpolation::RadialBasis).unwrap();
        let shading = |w: Direction| 0.2 + 0.3 * w.x() - 0.1 * w.y() + 0.9 * w.z();
        for i in 0..50 {
            let light = Direction::from_angles(0.031 * f64::from(i), 2.4 * f64::from(i));
            let found: f64 = weights(&basis, light).iter().zip(&lights).map(|(w, l)| w * shading(*l)).sum();
            assert!((found - shading(light)).abs() < 1e-9, "{light:?}: {found}");
        }
    }

    #[test]
    fn inner_products_are_near_those_of_a_finer_quadrature() {
        let lights = dome(12);
        for interpolation in Interpolation::ALL {
            let basis = Interpolated::new(&lights, interpolation).unwrap();
            let gram = basis.gram(Domain::Hemisphere).unwrap();
            for (j, k) in [(0, 0), (3, 4), (11, 11)] {
                let fine = hemisphere(200).map(|(light, share)| {
                    let values = weights(&basis, light);
                    TAU * share * values[j] * values[k]
                });
                let fine: f64 = fine.sum();
                assert!((gram[(j, k)] - fine).abs() < 1e-3, "{interpolation:?} {j} {k}: {fine}");
            }
            assert!(basis.gram(Domain::Square).is_none());
        }
    }

    #[test]
    fn lights_in_one_direction_are_refused_by_number() {
        let mut lights = dome(9);
        lights.push(lights[3]);
        for interpolation in Interpolation::ALL {
            let error = Interpolated::new(&lights, interpolation).unwrap_err().to_string();
            assert!(error.contains("photographs 4 and 10 have the same light"), "{error}");
            assert!(Interpolated::new(&[], interpolation).is_err());
        }
    }
}
