//! The matrix of a fit: the values of the functions under each light, factored once.

use std::collections::BTreeSet;

use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, Interpolated};
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;

/// A function counts as linearly dependent when, over the lights, the sine of its angle to the span of the
/// others is below this. In light files of three or four decimals the lights of one ring deviate from it by
/// about 1e-4; two rings one degree apart give 2e-2.
const LEAST_SINE: f64 = 1e-3;

/// Directions closer than this in every component count as one.
const SAME_DIRECTION: f64 = 1e-4;

/// The factored matrix A of a fit: row i holds the values of the functions under light i.
#[derive(Debug)]
pub(super) struct Design {
    basis: Basis,
    lights: Vec<Direction>,
    values: Matrix,
    /// Upper triangular R: R'R is A'A, and with a ridge its sum with the penalty.
    whitening: Matrix,
    pseudo_inverse: Matrix,
    leverages: Vec<f64>,
    penalty: Option<Penalty>,
}

/// A quadratic penalty on coefficients, added to the sum of squares over lights.
#[derive(Debug, Clone)]
struct Penalty {
    roughness: Matrix,
    weight: f64,
    matrix: Matrix,
}

impl Design {
    /// Factors the matrix of a basis under lights.
    ///
    /// # Errors
    /// When the lights do not determine the functions; the message says what is missing.
    pub fn new(basis: &Basis, lights: &[Direction]) -> Result<Self> {
        let missing = |reason: String| {
            Error::invalid(format!(
                "the lights do not determine a {basis} fit: {reason}",
                basis = basis.name()
            ))
        };
        if lights.len() < basis.len() {
            return Err(missing(format!(
                "its {} functions need at least as many lights, found {}",
                basis.len(),
                lights.len()
            )));
        }
        let values = match basis {
            Basis::Interpolated(table) if table.lights() == lights => {
                Matrix::from_fn(lights.len(), lights.len(), |i, k| f64::from(u8::from(i == k)))
            }
            _ => matrix(lights, basis.len(), |light| basis.weights(light)),
        };
        let qr = Qr::new(&values);
        if is_dependent(&qr) {
            return Err(missing(reason(basis, lights)));
        }
        let leverage = |i: usize| qr.q.row(i).iter().map(|q| q * q).sum();
        Ok(Self {
            basis: basis.clone(),
            lights: lights.to_vec(),
            leverages: (0..lights.len()).map(leverage).collect(),
            pseudo_inverse: qr.pseudo_inverse(),
            whitening: qr.r,
            values,
            penalty: None,
        })
    }

    /// The design with a penalty on the roughness of functions: its `weight` times the number of lights.
    pub fn with_ridge(&self, roughness: &Matrix, weight: f64) -> Result<Self> {
        let n = self.functions();
        let scale = weight * self.lights.len() as f64;
        let matrix = Matrix::from_fn(n, n, |j, k| scale * roughness[(j, k)]);
        let transposed = self.values.transposed();
        let squares = transposed.times(&self.values);
        let factor = Matrix::from_fn(n, n, |j, k| squares[(j, k)] + matrix[(j, k)]).cholesky()?;
        let inverse = factor.lower_inverse();
        let pseudo_inverse = inverse.transposed().times(&inverse).times(&transposed);
        let leverage = |i: usize| (0..n).map(|k| self.values[(i, k)] * pseudo_inverse[(k, i)]).sum();
        Ok(Self {
            basis: self.basis.clone(),
            lights: self.lights.clone(),
            values: self.values.clone(),
            leverages: (0..self.lights.len()).map(leverage).collect(),
            whitening: factor.transposed(),
            pseudo_inverse,
            penalty: Some(Penalty { roughness: roughness.clone(), weight, matrix }),
        })
    }

    /// The design without light `i`, where the others suffice.
    pub fn without(&self, i: usize) -> Option<Self> {
        let mut lights = self.lights.clone();
        lights.remove(i);
        let remaining = Self::new(&self.basis, &lights).ok()?;
        let Some(penalty) = &self.penalty else { return Some(remaining) };
        // The same penalty, which is scaled by the number of lights.
        let weight = penalty.weight * self.lights.len() as f64 / lights.len() as f64;
        remaining.with_ridge(&penalty.roughness, weight).ok()
    }

    /// The functions.
    pub fn basis(&self) -> &Basis {
        &self.basis
    }

    /// The number of lights.
    pub fn lights(&self) -> usize {
        self.lights.len()
    }

    /// The matrix of the ridge, if there is one.
    pub fn penalty(&self) -> Option<&Matrix> {
        self.penalty.as_ref().map(|penalty| &penalty.matrix)
    }

    /// The weight of the ridge, if there is one.
    pub fn ridge_weight(&self) -> Option<f64> {
        self.penalty.as_ref().map(|penalty| penalty.weight)
    }

    /// The interpolation between the lights of the fit, whose coefficients are the photographs.
    pub fn interpolated(&self) -> Option<&Interpolated> {
        match &self.basis {
            Basis::Interpolated(table) if table.lights() == self.lights => Some(table),
            _ => None,
        }
    }

    /// The number of functions.
    pub fn functions(&self) -> usize {
        self.basis.len()
    }

    /// The values of the functions under light `i`.
    pub fn values(&self, i: usize) -> &[f64] {
        self.values.row(i)
    }

    /// The share of photograph `i` in coefficient `k`.
    pub fn share(&self, k: usize, i: usize) -> f64 {
        self.pseudo_inverse[(k, i)]
    }

    /// The upper triangular R of A = Q R: the coordinates R c are orthonormal for the sum over lights, and with a ridge
    /// for that and the penalty.
    pub fn whitening(&self) -> &Matrix {
        &self.whitening
    }

    /// The leverage h_ii: how much photograph `i` determines its own prediction, 0 to 1.
    pub fn leverage(&self, i: usize) -> f64 {
        self.leverages[i]
    }

    /// The condition number of A in the Frobenius norm, |R| |R^-1|: at least the number of
    /// functions, and at most that many times the ratio of extreme singular values.
    pub fn condition_number(&self) -> f64 {
        let inverse = self.whitening.transposed().lower_inverse();
        frobenius(&self.whitening) * frobenius(&inverse)
    }
}

fn matrix(lights: &[Direction], cols: usize, row: impl Fn(Direction) -> Vec<f64>) -> Matrix {
    let mut matrix = Matrix::zeros(lights.len(), cols);
    lights.iter().enumerate().for_each(|(i, &light)| matrix.row_mut(i).copy_from_slice(&row(light)));
    matrix
}

fn frobenius(m: &Matrix) -> f64 {
    (0..m.rows()).flat_map(|r| m.row(r)).map(|x| x * x).sum::<f64>().sqrt()
}

/// Whether some column is nearly a linear combination of the earlier ones.
fn is_dependent(qr: &Qr) -> bool {
    (0..qr.r.cols()).any(|j| {
        let norm = (0..=j).map(|i| qr.r[(i, j)].powi(2)).sum::<f64>().sqrt();
        qr.r[(j, j)].abs() <= LEAST_SINE * norm
    })
}

/// Why the lights, although numerous enough, do not determine the functions.
fn reason(basis: &Basis, lights: &[Direction]) -> String {
    let key = |light: &Direction| light.to_array().map(|x| (x / SAME_DIRECTION).round() as i64);
    let distinct = lights.iter().map(key).collect::<BTreeSet<_>>().len();
    let dependent =
        |cols: usize, row: fn(Direction) -> Vec<f64>| is_dependent(&Qr::new(&matrix(lights, cols, row)));
    if distinct < basis.len() {
        format!(
            "the {} lights have only {distinct} different directions, and {} are needed",
            lights.len(),
            basis.len()
        )
    } else if dependent(3, |l| vec![1.0, l.x(), l.y()]) {
        "seen from above, all lights lie on one straight line: add lights on both sides of it".into()
    } else if dependent(2, |l| vec![1.0, l.x().powi(2) + l.y().powi(2)]) {
        format!(
            "all lights stand at one polar angle ({:.0} degrees), so u^2 + v^2 is the same for all and cannot be \
             told from the constant: add lights at another polar angle, such as overhead",
            lights[0].z().acos().to_degrees()
        )
    } else {
        "seen from above, all lights lie on one ellipse or other conic section, or too near each other, so \
         that some functions cannot be told apart: add lights elsewhere"
            .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    fn ring(n: usize, polar_deg: f64) -> Vec<Direction> {
        (0..n)
            .map(|i| {
                Direction::from_angles(polar_deg.to_radians(), std::f64::consts::TAU * i as f64 / n as f64)
            })
            .collect()
    }

    /// As rounded by a light file of four decimals.
    fn rounded(lights: Vec<Direction>) -> Vec<Direction> {
        let round = |x: f64| (x * 1e4).round() / 1e4;
        lights
            .into_iter()
            .map(|l| Direction::new(round(l.x()), round(l.y()), round(l.z())).unwrap())
            .collect()
    }

    fn message(lights: &[Direction]) -> String {
        Design::new(&Basis::Ptm, lights).unwrap_err().to_string()
    }

    #[test]
    fn degenerate_lights_say_what_is_missing() {
        assert!(message(&ring(5, 40.0)).contains("need at least as many lights, found 5"));
        let five_places: Vec<_> = ring(5, 40.0).into_iter().cycle().take(20).collect();
        assert!(message(&five_places).contains("20 lights have only 5 different directions"));
        for lights in [ring(24, 45.0), rounded(ring(24, 45.0)), rounded(ring(31, 63.0))] {
            assert!(message(&lights).contains("one polar angle"), "{}", message(&lights));
        }
        let line: Vec<_> = (0..20).map(|i| Direction::from_disk(0.2, i as f64 / 12.0 - 0.8)).collect();
        assert!(message(&rounded(line)).contains("one straight line"));
        let ellipse: Vec<_> = (0..20)
            .map(|i| Direction::from_disk(0.9 * f64::from(i).cos(), 0.4 * f64::from(i).sin()))
            .collect();
        assert!(message(&ellipse).contains("conic"));
    }

    #[test]
    fn lights_that_suffice_are_accepted() {
        for extra in [Direction::ZENITH, Direction::from_angles(0.7, 0.1)] {
            let mut lights = rounded(ring(8, 45.0));
            lights.push(extra);
            assert!(Design::new(&Basis::Ptm, &lights).is_ok());
        }
        let two_rings = [ring(12, 44.0), ring(12, 45.0)].concat();
        assert!(Design::new(&Basis::Ptm, &rounded(two_rings)).is_ok());
        assert!(Design::new(&Basis::Constant, &[Direction::ZENITH]).is_ok());
        assert!(Design::new(&Basis::Constant, &[]).is_err());
    }

    #[test]
    fn leverages_sum_to_the_number_of_functions() {
        let mut stream = Stream::new(3, Purpose::Sample, [0]);
        let lights: Vec<_> = (0..17)
            .map(|_| Direction::from_disk(1.4 * stream.unit() - 0.7, 1.4 * stream.unit() - 0.7))
            .collect();
        let design = Design::new(&Basis::Ptm, &lights).unwrap();
        let sum: f64 = (0..17).map(|i| design.leverage(i)).sum();
        assert!((sum - 6.0).abs() < 1e-9);
        assert!(design.condition_number() >= 6.0);
    }
}
