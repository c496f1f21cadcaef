//! Polynomials that are orthonormal under a measure, and the Gaussian rules of that measure.
//!
//! The recurrence p_(k+1) b_(k+1) = (x - a_k) p_k - b_k p_(k-1) is found by Stieltjes' procedure on a discrete measure
//! (W. Gautschi, Orthogonal Polynomials: Computation and Approximation, 2004, section 2.2.3), which is exact where the
//! nodes integrate the products of polynomials exactly. The nodes of the rule of n points are the roots of p_n, its
//! weights the Christoffel numbers 1 / (p_0² + ... + p_(n-1)²).

/// The recurrence of the first polynomials of a measure.
#[derive(Debug, Clone, PartialEq)]
pub struct OrthogonalPolynomials {
    /// The constant p_0.
    first: f64,
    a: Vec<f64>,
    b: Vec<f64>,
}

/// Halvings of an interval that leave no bit of a double undetermined.
const HALVINGS: usize = 60;
/// Intervals in which roots are looked for, for each root.
const INTERVALS_A_ROOT: usize = 64;

impl OrthogonalPolynomials {
    /// The polynomials of degrees 0 to `degree` of a measure given as nodes with weights.
    pub fn new(measure: &[(f64, f64)], degree: usize) -> Self {
        let first = 1.0 / measure.iter().map(|(_, w)| w).sum::<f64>().sqrt();
        let (mut a, mut b) = (Vec::new(), Vec::new());
        let (mut before, mut current) = (vec![0.0; measure.len()], vec![first; measure.len()]);
        for k in 0..degree {
            a.push(measure.iter().zip(&current).map(|((x, w), p)| w * x * p * p).sum());
            let last = if k == 0 { 0.0 } else { b[k - 1] };
            let next = measure.iter().zip(current.iter().zip(&before));
            let next: Vec<f64> = next.map(|((x, _), (p, q))| (x - a[k]) * p - last * q).collect();
            let norm = measure.iter().zip(&next).map(|((_, w), p)| w * p * p).sum::<f64>().sqrt();
            b.push(norm);
            (before, current) = (current, next.into_iter().map(|p| p / norm).collect());
        }
        Self { first, a, b }
    }

    /// The values of the first polynomials at x, as many as `out` holds.
    ///
    /// # Panics
    /// When `out` is empty or holds more than there are.
    pub fn values_into(&self, x: f64, out: &mut [f64]) {
        out[0] = self.first;
        for k in 1..out.len() {
            let last = if k == 1 { 0.0 } else { self.b[k - 2] * out[k - 2] };
            out[k] = ((x - self.a[k - 1]) * out[k - 1] - last) / self.b[k - 1];
        }
    }

    /// The nodes in 0..1 and weights of the Gaussian rule of `n` points, exact to degree 2n - 1, for a measure on that
    /// interval; `n` is at most the degree of the polynomials.
    pub fn gauss(&self, n: usize) -> Vec<(f64, f64)> {
        let mut values = vec![0.0; n + 1];
        let mut at = |x: f64| {
            self.values_into(x, &mut values);
            (values[n], values[..n].iter().map(|p| p * p).sum::<f64>())
        };
        // Roots crowd towards the ends like those of Chebyshev's polynomials.
        let count = INTERVALS_A_ROOT * n;
        let place = |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / count as f64).cos();
        let mut rule = Vec::with_capacity(n);
        for i in 0..count {
            let (mut low, mut high) = (place(i), place(i + 1));
            let sign = at(low).0.signum();
            if sign == at(high).0.signum() {
                continue;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if at(middle).0.signum() == sign { low = middle } else { high = middle }
            }
            rule.push((low, 1.0 / at(low).1));
        }
        rule
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::quadrature::gauss_legendre;

    /// The measure x^power on 0..1.
    fn measure(power: i32) -> Vec<(f64, f64)> {
        let halved = gauss_legendre(24).into_iter().map(|(t, w)| (0.5 * (t + 1.0), 0.5 * w));
        halved.map(|(x, w)| (x, w * x.powi(power))).collect()
    }

    #[test]
    fn polynomials_are_orthonormal() {
        for power in [0, 1, 4] {
            let measure = measure(power);
            let polynomials = OrthogonalPolynomials::new(&measure, 12);
            let values: Vec<Vec<f64>> = measure
                .iter()
                .map(|(x, _)| {
                    let mut out = vec![0.0; 13];
                    polynomials.values_into(*x, &mut out);
                    out
                })
                .collect();
            for (j, k) in (0..13).flat_map(|j| (0..13).map(move |k| (j, k))) {
                let product: f64 = measure.iter().zip(&values).map(|((_, w), p)| w * p[j] * p[k]).sum();
                assert!(
                    (product - f64::from(u8::from(j == k))).abs() < 1e-9,
                    "{power}: ({j}, {k}) {product}"
                );
            }
        }
    }

    #[test]
    fn gaussian_rules_are_exact() {
        for power in [0, 1, 4] {
            let polynomials = OrthogonalPolynomials::new(&measure(power), 12);
            for n in 1..=12 {
                let rule = polynomials.gauss(n);
                assert_eq!(rule.len(), n);
                for degree in 0..2 * n as i32 {
                    let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(degree)).sum();
                    let truth = 1.0 / f64::from(degree + power + 1);
                    assert!((sum - truth).abs() < 1e-12, "{power}, {n} points, degree {degree}: {sum}");
                }
            }
        }
    }
}
