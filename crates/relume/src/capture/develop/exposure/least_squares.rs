//! Exposures by least squares: Cho, Matsushita, Tai, Kweon, "Semi-calibrated photometric stereo", ECCV 2016, section 3.1, by the
//! orthogonal projection.
//!
//! The values of a matt texel times g lie in the space that the lights span: their part across it, P (g v), is zero. The sum of its
//! squares over all texels is least for the g that solves M g = (1, ..., 1) times a scale, M = sum of diag(v) P diag(v).
//! Shadows and highlights are left out by their residuals, in a few rounds.

use crate::capture::develop::lambert::{self, BRIGHT};
use crate::capture::develop::sample::TexelSample;
use crate::numeric::matrix::Matrix;
use crate::numeric::small::solve_spd;

/// Rounds of exposures and of the values that are left out.
const ROUNDS: usize = 4;
/// At first, values below this part of a texel's largest are taken for shadows.
const SHADOW: f64 = 0.1;
/// Residuals beyond this many spreads are left out.
const REACH: f64 = 2.5;
/// The fewest values of a texel, and the fewest texels.
const FEWEST: usize = 5;
const FEWEST_TEXELS: usize = 20;

/// The gains of all photographs, or `None` where they are not determined.
pub(super) fn gains(sample: &TexelSample) -> Option<Vec<f64>> {
    let mut gains = vec![1.0; sample.lights.len()];
    for round in 0..ROUNDS {
        let chosen = |values: &[f64]| match round {
            0 => bright(values),
            _ => consistent(&sample.lights, values, &gains),
        };
        gains = solved(sample, &chosen)?;
    }
    Some(gains)
}

/// The gains, whose product is 1, from some of the values of each texel.
fn solved(sample: &TexelSample, chosen: &dyn Fn(&[f64]) -> Option<Vec<usize>>) -> Option<Vec<f64>> {
    let count = sample.lights.len();
    let mut matrix = Matrix::zeros(count, count);
    let mut texels = 0;
    for values in sample.texels() {
        if let Some(used) = chosen(values)
            && add(&mut matrix, &sample.lights, values, &used).is_some()
        {
            texels += 1;
        }
    }
    if texels < FEWEST_TEXELS {
        return None;
    }
    let trace: f64 = (0..count).map(|k| matrix[(k, k)]).sum();
    (0..count).for_each(|k| matrix[(k, k)] += 1e-9 * trace / count as f64);
    let inverse = matrix.cholesky().ok()?.lower_inverse();
    let forward: Vec<f64> = (0..count).map(|i| inverse.row(i).iter().sum()).collect();
    let found: Vec<f64> =
        (0..count).map(|k| (0..count).map(|i| inverse[(i, k)] * forward[i]).sum()).collect();
    if found.iter().any(|g| !(*g > 0.0 && g.is_finite())) {
        return None;
    }
    let mean = (found.iter().map(|g| g.ln()).sum::<f64>() / count as f64).exp();
    Some(found.into_iter().map(|g| g / mean).collect())
}

/// Adds diag(v) P diag(v) of one texel, with its values scaled to a square sum of 1.
fn add(matrix: &mut Matrix, lights: &[[f64; 3]], values: &[f64], used: &[usize]) -> Option<()> {
    let mut spread = [[0.0; 3]; 3];
    for &k in used {
        (0..3).for_each(|i| (0..3).for_each(|j| spread[i][j] += lights[k][i] * lights[k][j]));
    }
    let solved: Vec<[f64; 3]> =
        used.iter().map(|&k| solve_spd(&spread, &lights[k])).collect::<Option<Vec<_>>>()?;
    let scale: f64 = used.iter().map(|&k| values[k] * values[k]).sum();
    for (&a, inverse) in used.iter().zip(&solved) {
        for &b in used {
            let same = f64::from(u8::from(a == b));
            matrix[(a, b)] += values[a] * values[b] * (same - lambert::shaded(inverse, &lights[b])) / scale;
        }
    }
    Some(())
}

/// The values that are neither saturated nor dark beside the largest.
fn bright(values: &[f64]) -> Option<Vec<usize>> {
    let least = SHADOW * values.iter().copied().fold(0.0, f64::max);
    let used: Vec<usize> =
        (0..values.len()).filter(|&k| values[k] > least.max(1e-4) && values[k] < BRIGHT).collect();
    (used.len() >= FEWEST).then_some(used)
}

/// The values that a matt texel explains.
fn consistent(lights: &[[f64; 3]], values: &[f64], gains: &[f64]) -> Option<Vec<usize>> {
    let evened: Vec<f64> = values.iter().zip(gains).map(|(v, g)| v * g).collect();
    let texel = lambert::solve(lights, &evened, &bright(values)?)?;
    let least = 0.05 * texel.iter().map(|b| b * b).sum::<f64>().sqrt();
    let lit = (0..values.len())
        .filter(|&k| lambert::shaded(&texel, &lights[k]) > least && values[k] > 1e-4 && values[k] < BRIGHT);
    let lit: Vec<usize> = lit.collect();
    let residual = |k: usize| (evened[k] - lambert::shaded(&texel, &lights[k])).abs();
    let mut sizes: Vec<f64> = lit.iter().map(|&k| residual(k)).collect();
    if sizes.len() < FEWEST {
        return None;
    }
    let middle = sizes.len() / 2;
    let most = REACH * 1.4826 * *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 + 1e-9;
    let used: Vec<usize> = lit.into_iter().filter(|&k| residual(k) <= most).collect();
    (used.len() >= FEWEST).then_some(used)
}
