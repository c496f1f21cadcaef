//! Exposures that differ between photographs, found from the photographs themselves.
//!
//! If g_k undoes the exposure of photograph k, a matt texel has g_k v_k = b . l_k. b and g are found in turns: b of each texel with
//! weights that fall with the residual (Cauchy's, squared), and g_k as that by which most texels of photograph k are off
//! ([`shorth`](crate::numeric::shorth)). That converges to gains near those it starts from: from equal exposures, which suits
//! glossy materials, whose highlights are no exposures; and from the [least squares](least_squares) over matt texels. Those
//! are taken with which the texels of a photograph agree better.

mod least_squares;

use rayon::prelude::*;

use super::lambert::{self, BRIGHT};
use super::reading::median;
use super::sample::TexelSample;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::numeric::matrix::{Matrix, Qr};
use crate::numeric::shorth::shorth;
use crate::numeric::small::solve_spd;

/// Rounds of texels and gains, and the part of a step that is taken.
const ROUNDS: usize = 12;
const STEP: f64 = 0.7;
/// A larger gain than this is that of a photograph that is black.
pub const LARGEST_GAIN: f64 = 64.0;
/// The part of a texel's brightest prediction, and the value, from which on it is lit.
const LIT_SHARE: f64 = 0.05;
const LIT: f64 = 0.005;
/// Values below are black.
const BLACK: f64 = 0.002;
/// The fewest photographs, of which five values of a texel are left, and the fewest texels of one.
const FEWEST: usize = 8;
const FEWEST_TEXELS: usize = 20;
/// Where half of the texels differ by more than this (as a natural logarithm) in most photographs, they are not matt.
const MOST_SPREAD: f64 = 0.65;

/// For each photograph the factor that brings its exposure to the common one, from linear values.
///
/// # Errors
/// Fewer than eight photographs, and photographs too dark or too glossy to tell.
pub fn gains(sample: &TexelSample) -> Result<Vec<f64>> {
    let count = sample.lights.len();
    if count < FEWEST {
        return Err(Error::invalid(format!(
            "exposures are compared between at least {FEWEST} photographs, found {count}"
        )));
    }
    let equal = refined(sample, vec![0.0; count]);
    let from_matt = least_squares::gains(sample)
        .map(|gains| refined(sample, gains.into_iter().map(f64::ln).collect()))
        .and_then(Result::ok);
    let found = match (equal, from_matt) {
        (Ok(a), Some(b)) => {
            if b.spread < a.spread {
                b
            } else {
                a
            }
        }
        (Err(_), Some(b)) => b,
        (equal, None) => equal?,
    };
    if found.spread > MOST_SPREAD {
        return Err(Error::invalid(
            "the photographs are too far from matt to compare their exposures: leave out --equalize",
        ));
    }
    let mean = found.log_gains.iter().sum::<f64>() / count as f64;
    let gains: Vec<f64> = found.log_gains.into_iter().map(|g| (g - mean).exp()).collect();
    match gains.iter().position(|g| !(1.0 / LARGEST_GAIN..LARGEST_GAIN).contains(g)) {
        Some(k) => Err(unlike_the_others(k)),
        None => Ok(gains),
    }
}

/// Gains, as natural logarithms, and how far the texels of a photograph differ in what they lack: the median over photographs.
struct Refined {
    log_gains: Vec<f64>,
    spread: f64,
}

/// Finds texels and gains in turns.
fn refined(sample: &TexelSample, mut log_gains: Vec<f64>) -> Result<Refined> {
    let count = sample.lights.len();
    let mut texels: Vec<Option<[f64; 3]>> = vec![None; sample.values.len() / count];
    let mut spread = f64::INFINITY;
    for _ in 0..ROUNDS {
        let gains: Vec<f64> = log_gains.iter().map(|g| f64::exp(*g)).collect();
        let values = sample.values.par_chunks_exact(count);
        texels = values.zip(texels).map(|(v, before)| matt(&sample.lights, v, &gains, before)).collect();
        let steps = (0..count).into_par_iter().map(|k| step(sample, &texels, k, gains[k]));
        let (steps, spreads): (Vec<f64>, Vec<f64>) = steps.collect::<Result<Vec<_>>>()?.into_iter().unzip();
        log_gains.iter_mut().zip(steps).for_each(|(g, step)| *g += STEP * step);
        let centre = median(log_gains.clone());
        log_gains.iter_mut().for_each(|g| *g -= centre);
        spread = median(spreads);
    }
    Ok(Refined { log_gains, spread })
}

fn unlike_the_others(k: usize) -> Error {
    Error::invalid(format!(
        "the exposure of photograph {} cannot be told from the others: it may be too dark or too bright, or not of this surface",
        k + 1
    ))
}

/// Albedo times normal of a texel from its values at equal exposure, by weights from the residuals of that before; at first from its
/// values of middle rank.
fn matt(lights: &[[f64; 3]], values: &[f64], gains: &[f64], before: Option<[f64; 3]>) -> Option<[f64; 3]> {
    let evened: Vec<f64> = values.iter().zip(gains).map(|(v, g)| v * g).collect();
    let Some(before) = before else { return lambert::solve(lights, &evened, &lambert::used(&evened)?) };
    let residuals: Vec<f64> =
        evened.iter().zip(lights).map(|(v, light)| (v - lambert::shaded(&before, light)).abs()).collect();
    let deviation = 1.4826 * median(residuals.clone()) + 1e-6;
    let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (k, light) in lights.iter().enumerate().filter(|(k, _)| values[*k] < BRIGHT) {
        let weight = (1.0 + (residuals[k] / deviation).powi(2)).powi(-2);
        for i in 0..3 {
            right[i] += weight * light[i] * evened[k];
            (0..3).for_each(|j| matrix[i][j] += weight * light[i] * light[j]);
        }
    }
    solve_spd(&matrix, &right)
}

/// The logarithm of the factor that photograph `k` still lacks at most of its lit texels, and how far it differs between these.
fn step(sample: &TexelSample, texels: &[Option<[f64; 3]>], k: usize, gain: f64) -> Result<(f64, f64)> {
    let lacking = |(values, texel): (&[f64], &Option<[f64; 3]>)| {
        let texel = texel.as_ref()?;
        let predicted = lambert::shaded(texel, &sample.lights[k]);
        let norm = texel.iter().map(|b| b * b).sum::<f64>().sqrt();
        let is_lit = predicted > LIT.max(LIT_SHARE * norm);
        let is_measured = (BLACK..BRIGHT).contains(&values[k]);
        (is_lit && is_measured).then(|| (predicted / (gain * values[k])).ln())
    };
    let mut factors: Vec<f64> = sample.texels().zip(texels).filter_map(lacking).collect();
    if factors.len() < FEWEST_TEXELS {
        return Err(unlike_the_others(k));
    }
    shorth(&mut factors).ok_or_else(|| unlike_the_others(k))
}

/// How far gains follow the direction of the light: the share of the variance of their logarithms that a biquadratic polynomial of
/// the direction explains, adjusted for its six terms; `None` for fewer than eighteen lights. So does the shading of a surface
/// that is not matt.
pub fn share_by_direction(lights: &[(String, Direction)], gains: &[f64]) -> Option<f64> {
    let (count, terms) = (lights.len(), 6);
    if count < 3 * terms {
        return None;
    }
    let polynomial = Matrix::from_fn(count, terms, |i, k| {
        let (x, y) = (lights[i].1.x(), lights[i].1.y());
        [1.0, x, y, x * x, x * y, y * y][k]
    });
    let mean = gains.iter().map(|g| g.ln()).sum::<f64>() / count as f64;
    let values: Vec<f64> = gains.iter().map(|g| g.ln() - mean).collect();
    let square = values.iter().map(|v| v * v).sum::<f64>();
    let Qr { q, r } = Qr::new(&polynomial);
    // On a ring of lights the terms depend on each other.
    let largest = (0..terms).map(|k| r[(k, k)].abs()).fold(0.0, f64::max);
    let told_apart = (0..terms).filter(|&k| r[(k, k)].abs() > 1e-6 * largest);
    let along = |k: usize| (0..count).map(|i| q[(i, k)] * values[i]).sum::<f64>();
    let (used, explained) = told_apart.fold((0, 0.0), |(n, sum), k| (n + 1, sum + along(k).powi(2)));
    let adjusted = 1.0 - (1.0 - explained / square) * (count - 1) as f64 / (count - used) as f64;
    (square > 0.0).then_some(adjusted)
}
