//! The normal and albedo of one texel from its values under many lights, despite shadows and highlights.
//!
//! A matt texel reflects I = b . l, where b is its albedo times its unit normal, while it faces the light (R.
//! J. Woodham, Photometric method for determining surface orientation from multiple images, Optical
//! Engineering 19(1), 1980). Cast shadows are darker and highlights brighter. [`Estimator::Robust`] starts
//! from the middle of the sorted values and then iterates weighted least squares with the weights of Geman
//! and McClure (Statistical methods for tomographic image reconstruction, 1987), 1 / (1 + r^2 / s^2)^2, s
//! from the median of the residuals r; lights behind the surface have no weight. [`Estimator::Cauchy`] starts from least
//! squares, with the weights of Cauchy's distribution, 1 / (1 + r^2 / s^2), s a tenth of the median of the values (P. W.
//! Holland, R. E. Welsch, Robust regression using iteratively reweighted least-squares, Communications in Statistics A6,
//! 1977).

use crate::names::named;
use crate::numeric::small::solve_spd;

/// The treatment of outliers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// All values have equal weight: least squares.
    LeastSquares,
    /// The darkest three tenths and the brightest tenth of the values of a texel are left out.
    Trimmed,
    /// Starting from the trimmed solution, values are weighted by how well they fit.
    Robust,
    /// Starting from least squares, values are weighted by how well they fit, with a wide tail: for surfaces of which less
    /// than half of the values are those of a matt one.
    Cauchy,
    /// As robust, with a reflectance common to all texels that is learned from them.
    Shared,
}

named!(Estimator {
    Robust => "robust",
    Cauchy => "cauchy",
    Trimmed => "trimmed",
    LeastSquares => "least-squares",
    Shared => "shared"
});

/// Whether a constant light common to all photographs is estimated for each texel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Ambient {
    /// Photographs contain the light of their lamp only.
    None,
    /// A constant is added to every value.
    Constant,
}

/// Fractions of the sorted values that the trimmed solution leaves out.
const DARK: f64 = 0.3;
const BRIGHT: f64 = 0.1;
/// The same before a common reflectance is learned: of a surface that is not matt, what is left is most nearly so.
const GLOSSY: f64 = 0.4;
/// Rounds of reweighting; the weights have settled to a few percent by then.
const ROUNDS: usize = 12;
/// The scale of Cauchy's weights, as a part of the median of the values.
const CAUCHY_SCALE: f64 = 0.1;
/// The scale of the weights, in multiples of the spread of the residuals.
const REACH: f64 = 2.0;
/// The least spread, as a fraction of the albedo: rounding in 8-bit files.
const LEAST_SPREAD: f64 = 0.004;

/// The solution of a texel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Matt {
    /// Albedo times normal; for other constants see [`Ambient`].
    pub b: [f64; 3],
    pub ambient: f64,
}

/// Memory reused between texels.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    order: Vec<usize>,
    residuals: Vec<f64>,
    /// The weight of each value, 0 to 1.
    pub weights: Vec<f64>,
}

/// Solves a texel; `None` where its values do not determine a direction. The weights of the values remain in
/// the scratch memory.
pub(super) fn solve(
    lights: &[[f64; 3]],
    values: &[f64],
    (estimator, ambient): (Estimator, Ambient),
    scratch: &mut Scratch,
) -> Option<Matt> {
    match ambient {
        Ambient::None => {
            let b = estimate(values, estimator, |k| lights[k], scratch)?;
            Some(Matt { b, ambient: 0.0 })
        }
        Ambient::Constant => {
            let row = |k: usize| [lights[k][0], lights[k][1], lights[k][2], 1.0];
            let [x, y, z, ambient] = estimate(values, estimator, row, scratch)?;
            Some(Matt { b: [x, y, z], ambient })
        }
    }
}

fn estimate<const N: usize>(
    values: &[f64],
    estimator: Estimator,
    row: impl Fn(usize) -> [f64; N],
    scratch: &mut Scratch,
) -> Option<[f64; N]> {
    scratch.weights.clear();
    scratch.weights.resize(values.len(), 1.0);
    let all = weighted(values, &row, &scratch.weights);
    if estimator == Estimator::LeastSquares {
        return all;
    }
    if estimator == Estimator::Cauchy {
        return all.map(|all| reweighted_by_cauchy(values, &row, all, scratch));
    }
    trim(values, N, if estimator == Estimator::Shared { GLOSSY } else { BRIGHT }, scratch);
    let mut found = weighted(values, &row, &scratch.weights).or(all)?;
    if estimator == Estimator::Robust {
        for _ in 0..ROUNDS {
            if !reweigh(values, &row, &found, scratch) {
                break;
            }
            match weighted(values, &row, &scratch.weights) {
                Some(next) => found = next,
                None => break,
            }
        }
    }
    Some(found)
}

/// The solution that Cauchy's weights lead to from another one.
fn reweighted_by_cauchy<const N: usize>(
    values: &[f64],
    row: &impl Fn(usize) -> [f64; N],
    mut found: [f64; N],
    scratch: &mut Scratch,
) -> [f64; N] {
    scratch.residuals.clear();
    scratch.residuals.extend_from_slice(values);
    let middle = values.len() / 2;
    let (_, median, _) = scratch.residuals.select_nth_unstable_by(middle, f64::total_cmp);
    let scale = (CAUCHY_SCALE * *median).max(1e-9);
    for _ in 0..ROUNDS {
        for (k, weight) in scratch.weights.iter_mut().enumerate() {
            let predicted: f64 = row(k).iter().zip(&found).map(|(l, b)| l * b).sum();
            *weight = 1.0 / (1.0 + ((values[k] - predicted) / scale).powi(2));
        }
        match weighted(values, row, &scratch.weights) {
            Some(next) => found = next,
            None => break,
        }
    }
    found
}

/// Weight 1 for the middle of the sorted values and 0 for the others; at least `least` values remain.
fn trim(values: &[f64], least: usize, bright: f64, scratch: &mut Scratch) {
    let n = values.len();
    scratch.order.clear();
    scratch.order.extend(0..n);
    scratch.order.sort_by(|&i, &j| values[i].total_cmp(&values[j]).then(i.cmp(&j)));
    let spare = n.saturating_sub(least);
    let most_dark = (spare as f64 * DARK / (DARK + bright)) as usize;
    let dark = ((DARK * n as f64) as usize).min(most_dark);
    let bright = ((bright * n as f64) as usize).min(spare / 4);
    for &i in scratch.order[..dark].iter().chain(&scratch.order[n - bright..]) {
        scratch.weights[i] = 0.0;
    }
}

/// Weights from the residuals; false where nothing faces a light.
fn reweigh<const N: usize>(
    values: &[f64],
    row: &impl Fn(usize) -> [f64; N],
    found: &[f64; N],
    scratch: &mut Scratch,
) -> bool {
    let facing = |k: usize| row(k)[..3].iter().zip(&found[..3]).map(|(l, b)| l * b).sum::<f64>();
    let predicted = |k: usize| row(k).iter().zip(found).map(|(l, b)| l * b).sum::<f64>();
    scratch.residuals.clear();
    let lit = (0..values.len()).filter(|&k| facing(k) > 0.0);
    scratch.residuals.extend(lit.map(|k| (values[k] - predicted(k)).abs()));
    if scratch.residuals.len() < N {
        return false;
    }
    let middle = scratch.residuals.len() / 2;
    let (_, median, _) = scratch.residuals.select_nth_unstable_by(middle, f64::total_cmp);
    let albedo = found[..3].iter().map(|b| b * b).sum::<f64>().sqrt();
    let spread = REACH * (1.4826 * *median).max(LEAST_SPREAD * albedo).max(1e-9);
    for (k, weight) in scratch.weights.iter_mut().enumerate() {
        let ratio = (values[k] - predicted(k)) / spread;
        *weight = if facing(k) > 0.0 { (1.0 + ratio * ratio).powi(-2) } else { 0.0 };
    }
    true
}

/// Weighted least squares.
fn weighted<const N: usize>(
    values: &[f64],
    row: &impl Fn(usize) -> [f64; N],
    weights: &[f64],
) -> Option<[f64; N]> {
    let (mut normal, mut right) = ([[0.0; N]; N], [0.0; N]);
    for (k, (value, weight)) in values.iter().zip(weights).enumerate() {
        let l = row(k);
        for i in 0..N {
            let scaled = weight * l[i];
            right[i] += scaled * value;
            (0..=i).for_each(|j| normal[i][j] += scaled * l[j]);
        }
    }
    solve_spd(&normal, &right)
}
