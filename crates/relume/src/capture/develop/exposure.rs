//! Exposures that differ between photographs, found from the photographs themselves.
//!
//! If g_k undoes the exposure of photograph k, a matt texel has g_k v_k = b . l_k. b and g are found in turns: b of each texel with
//! weights that fall with the residual (Cauchy's, squared), and g_k as that by which most texels of photograph k are off
//! ([`shorth`](crate::numeric::shorth)). That converges to gains near those it starts from: from equal exposures, which suits
//! glossy materials, whose highlights are no exposures; and from the [least squares](least_squares) over matt texels. Those
//! are taken with which the texels of a photograph agree better. Shadows that cover most of what would be lit look like a dark
//! exposure: where the texels of a photograph do not agree, and it seems much darker than those of near lights, its exposure is
//! theirs.

mod least_squares;

use super::lambert::{self, BRIGHT};
use super::reading::median;
use super::sample::TexelSample;
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::numeric::matrix::{Matrix, Qr};
use crate::numeric::shorth::shorth;
use crate::numeric::small::solve_spd;
use crate::parallel;

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
/// Where half of the lit texels of a photograph differ by more than a factor of two, they do not tell that it is darker by another such
/// factor than those of the nearest lights (as natural logarithms).
const TOLD_WITHIN: f64 = std::f64::consts::LN_2;
const DARKER: f64 = std::f64::consts::LN_2;
const NEAREST: usize = 6;
/// Where half of the texels differ by more than this (as a natural logarithm) in most photographs, they are not matt.
const MOST_SPREAD: f64 = 0.65;

/// What photographs tell of their exposures.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposures {
    /// For each photograph the factor that brings its exposure to the common one. Their product is 1.
    pub gains: Vec<f64>,
    /// The photographs that are too dark, or too much in shadow, to tell: they have the factor of those of near lights.
    pub untold: Vec<usize>,
}

/// Finds the exposures of photographs from linear values.
///
/// # Errors
/// Fewer than eight photographs, and photographs too dark or too glossy to tell.
pub fn exposures(sample: &TexelSample) -> Result<Exposures> {
    let count = sample.lights.len();
    if count < FEWEST {
        return Err(Error::invalid(format!(
            "exposures are compared between at least {FEWEST} photographs, found {count}"
        )));
    }
    let equal = refined(sample, vec![0.0; count]);
    let from_matt = least_squares::gains(sample)
        .map(|gains| refined(sample, gains.into_iter().map(f64::ln).collect()))
        .filter(|found| found.spread < equal.spread);
    let found = from_matt.unwrap_or(equal);
    if found.spread == f64::INFINITY {
        return Err(Error::invalid("the photographs are too dark or too bright to compare their exposures"));
    }
    if found.spread > MOST_SPREAD {
        return Err(Error::invalid(
            "the photographs are too far from matt to compare their exposures: leave out --equalize",
        ));
    }
    let mean = found.log_gains.iter().sum::<f64>() / count as f64;
    let gains: Vec<f64> = found.log_gains.into_iter().map(|g| (g - mean).exp()).collect();
    match gains.iter().position(|g| !(1.0 / LARGEST_GAIN..LARGEST_GAIN).contains(g)) {
        Some(k) => Err(Error::invalid(format!(
            "the exposure of photograph {} cannot be told from the others: it may be too dark or too bright, or not of this surface",
            k + 1
        ))),
        None => Ok(Exposures { gains, untold: found.untold }),
    }
}

/// Gains, as natural logarithms, those that are not told, and how far the texels of a photograph differ in what they lack: the median
/// over photographs.
struct Refined {
    log_gains: Vec<f64>,
    untold: Vec<usize>,
    spread: f64,
}

/// Finds texels and gains in turns.
fn refined(sample: &TexelSample, mut log_gains: Vec<f64>) -> Refined {
    let count = sample.lights.len();
    let mut texels: Vec<Option<[f64; 3]>> = vec![None; sample.values.len() / count];
    let mut spreads = vec![f64::INFINITY; count];
    for _ in 0..ROUNDS {
        let gains: Vec<f64> = log_gains.iter().map(|g| f64::exp(*g)).collect();
        parallel::for_each_value(&mut texels, |at, texel| {
            *texel = matt(&sample.lights, &sample.values[at * count..][..count], &gains, *texel);
        });
        let lacking: Vec<(f64, f64)> = parallel::map(0..count, |k| lacking(sample, &texels, k, gains[k]));
        spreads = lacking.iter().map(|(_, spread)| *spread).collect();
        log_gains.iter_mut().zip(lacking).for_each(|(gain, (factor, _))| *gain += STEP * factor);
        let centre = median(log_gains.clone());
        log_gains.iter_mut().for_each(|g| *g -= centre);
    }
    let of_near: Vec<f64> = (0..count).map(|k| of_nearest(&sample.lights, &log_gains, k)).collect();
    let is_untold = |k: &usize| {
        spreads[*k] == f64::INFINITY || spreads[*k] > TOLD_WITHIN && log_gains[*k] - of_near[*k] > DARKER
    };
    let untold: Vec<usize> = (0..count).filter(is_untold).collect();
    untold.iter().for_each(|k| log_gains[*k] = of_near[*k]);
    Refined { log_gains, untold, spread: median(spreads) }
}

/// The median gain of the lights that are nearest to light `k`.
fn of_nearest(lights: &[[f64; 3]], log_gains: &[f64], k: usize) -> f64 {
    let cosine = |i: usize| lights[i].iter().zip(&lights[k]).map(|(a, b)| a * b).sum::<f64>();
    let mut others: Vec<usize> = (0..lights.len()).filter(|i| *i != k).collect();
    others.sort_by(|a, b| cosine(*b).total_cmp(&cosine(*a)));
    median(others.iter().take(NEAREST).map(|i| log_gains[*i]).collect())
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

/// The logarithm of the factor that photograph `k` still lacks at most of its lit texels, and how far it differs between these; without
/// bound where few are lit.
fn lacking(sample: &TexelSample, texels: &[Option<[f64; 3]>], k: usize, gain: f64) -> (f64, f64) {
    let of_texel = |(values, texel): (&[f64], &Option<[f64; 3]>)| {
        let texel = texel.as_ref()?;
        let predicted = lambert::shaded(texel, &sample.lights[k]);
        let norm = texel.iter().map(|b| b * b).sum::<f64>().sqrt();
        let is_lit = predicted > LIT.max(LIT_SHARE * norm);
        let is_measured = (BLACK..BRIGHT).contains(&values[k]);
        (is_lit && is_measured).then(|| (predicted / (gain * values[k])).ln())
    };
    let mut factors: Vec<f64> = sample.texels().zip(texels).filter_map(of_texel).collect();
    let told = (factors.len() >= FEWEST_TEXELS).then(|| shorth(&mut factors)).flatten();
    told.unwrap_or((0.0, f64::INFINITY))
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
