//! The division in the Fourier domain. With d the factor of a derivative and g that of the comparison of
//! slopes, the sum of squares is least for
//!
//! Z = (conj(a_x) P + conj(a_y) Q) / (b_x + b_y),
//!
//! where, for the frequency w along an axis, a = i w, b = w^2 (Frankot and Chellappa), or, from forward
//! differences against means of neighbours, a = i sin w, b = 4 sin^2 (w / 2) (Poisson). The frequencies that
//! no slope can show, the mean and the highest of an axis, have a = 0.

use std::f64::consts::{PI, TAU};

use realfft::num_complex::Complex64;

use super::IntegrationMethod;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::fourier::Fourier;
use crate::size::Size;
use crate::surface::slopes::Slopes;

/// Heights on the torus, zero on average, row after row from the top.
pub(super) fn solve(slopes: Slopes, method: IntegrationMethod, job: &Job) -> Result<Vec<f64>> {
    let plan = Fourier::new(slopes.size());
    let spectrum = heights(slopes, method, 0.0, &plan, job)?;
    plan.inverse_within(spectrum, job)
}

/// The slopes of the surface of Frankot and Chellappa, damped by springs of the given strength.
pub(super) fn project(slopes: &Slopes, spring: f64, job: &Job) -> Result<Slopes> {
    let plan = Fourier::new(slopes.size());
    let spectrum = heights(slopes.clone(), IntegrationMethod::FrankotChellappa, spring, &plan, job)?;
    let (columns, rows) = axes(slopes.size(), IntegrationMethod::FrankotChellappa);
    let slope = |along: &dyn Fn(usize, usize) -> f64| {
        let bin = |(i, z): (usize, &Complex64)| z * Complex64::i() * along(i / rows.len(), i % rows.len());
        plan.inverse_within(spectrum.iter().enumerate().map(bin).collect(), job)
    };
    let mut projected = Slopes::level(slopes.size());
    projected.p = slope(&|k, _| columns[k].0)?;
    projected.q = slope(&|_, l| -rows[l].0)?;
    Ok(projected)
}

/// The spectrum of the heights; a spring adds its strength to the denominator.
fn heights(
    slopes: Slopes,
    method: IntegrationMethod,
    spring: f64,
    plan: &Fourier,
    job: &Job,
) -> Result<Vec<Complex64>> {
    let (columns, rows) = axes(slopes.size(), method);
    let mut spectrum = plan.forward_within(slopes.p, job)?;
    let along_y = plan.forward_within(slopes.q, job)?;
    for (i, (bin, q)) in spectrum.iter_mut().zip(&along_y).enumerate() {
        let ((a_x, b_x), (a_y, b_y)) = (columns[i / rows.len()], rows[i % rows.len()]);
        // Rows run down, y runs up.
        let sum = (*bin * a_x - q * a_y) * -Complex64::i();
        let below = b_x + b_y + spring;
        *bin = if below > 0.0 { sum / below } else { Complex64::ZERO };
    }
    Ok(spectrum)
}

/// (a / i, b) of the kept columns and of all rows.
#[allow(clippy::type_complexity, reason = "two lists of one kind of pair")]
fn axes(size: Size, method: IntegrationMethod) -> (Vec<(f64, f64)>, Vec<(f64, f64)>) {
    let Size { width, height } = size;
    let columns = (0..width / 2 + 1).map(|k| factors(k, width, method)).collect();
    (columns, (0..height).map(|l| factors(l, height, method)).collect())
}

/// (a / i, b) of frequency `k` of `n`.
pub(super) fn factors(k: usize, n: usize, method: IntegrationMethod) -> (f64, f64) {
    let signed = if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
    let w = TAU * signed / n as f64;
    let highest = 2 * k == n;
    match method {
        IntegrationMethod::FrankotChellappa if highest => (0.0, PI * PI),
        IntegrationMethod::FrankotChellappa => (w, w * w),
        IntegrationMethod::Poisson if highest => (0.0, 4.0),
        IntegrationMethod::Poisson => (w.sin(), 4.0 * (0.5 * w).sin().powi(2)),
    }
}
