//! Gauss-Legendre rules, the numerical truth against which closed integrals are tested.

use crate::direction::Direction;

/// Nodes and weights of the `n`-point Gauss-Legendre rule on [-1, 1], exact for polynomials of degree 2n - 1.
/// Newton's method on P_n from Chebyshev's initial guess.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (value, derivative) = legendre(n, x);
                slope = derivative;
                let step = value / derivative;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// P_n(x) and its derivative.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (previous, current) = (current, ((2.0 * k - 1.0) * x * current - (k - 1.0) * previous) / k);
    }
    (current, n as f64 * (x * current - previous) / (x * x - 1.0))
}

/// Integrates over the square [-1, 1]^2 with `n` x `n` points.
pub fn integrate_square(n: usize, mut f: impl FnMut(f64, f64) -> f64) -> f64 {
    let rule = gauss_legendre(n);
    let points = rule.iter().flat_map(|&(u, wu)| rule.iter().map(move |&(v, wv)| (u, v, wu * wv)));
    points.map(|(u, v, w)| w * f(u, v)).sum()
}

/// Directions of the upper hemisphere and their shares of its solid angle, which sum to 1: Gauss-Legendre in z, the
/// trapezoid rule (exact for trigonometric polynomials) in azimuth.
pub fn hemisphere(n: usize) -> impl Iterator<Item = (Direction, f64)> {
    let azimuths = 2 * n;
    gauss_legendre(n).into_iter().flat_map(move |(t, weight)| {
        let polar = (0.5 * (t + 1.0)).acos();
        (0..azimuths).map(move |k| {
            let azimuth = std::f64::consts::TAU * k as f64 / azimuths as f64;
            (Direction::from_angles(polar, azimuth), 0.5 * weight / azimuths as f64)
        })
    })
}

/// Integrates over the solid angle of the upper hemisphere by [`hemisphere`].
pub fn integrate_hemisphere(n: usize, mut f: impl FnMut(Direction) -> f64) -> f64 {
    hemisphere(n).map(|(direction, share)| share * f(direction)).sum::<f64>() * std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn rules_integrate_polynomials_exactly() {
        for n in 1..12 {
            for degree in 0..2 * n {
                let sum: f64 = gauss_legendre(n).iter().map(|(x, w)| w * x.powi(degree as i32)).sum();
                let truth = if degree % 2 == 0 { 2.0 / (degree as f64 + 1.0) } else { 0.0 };
                assert!((sum - truth).abs() < 1e-13, "n {n}, degree {degree}: {sum} vs {truth}");
            }
        }
    }

    #[test]
    fn areas_and_cosines_are_known() {
        assert!((integrate_square(3, |_, _| 1.0) - 4.0).abs() < 1e-13);
        assert!((integrate_hemisphere(4, |_| 1.0) - 2.0 * PI).abs() < 1e-12);
        assert!((integrate_hemisphere(4, Direction::z) - PI).abs() < 1e-12);
    }
}
