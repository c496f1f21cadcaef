//! Photometric stereo with one reflectance common to all texels, learned from the photographs themselves.
//!
//! A surface of one material, or of several painted alike, deviates from a matt one in the same way everywhere: its
//! texels reflect I = a f(n . l, n . h) (n . l), with an albedo a of their own, the half vector h between light and
//! viewer, and a common function f. Least squares with f = 1 turns what f does into errors of the normals. Here f is learned
//! from the values of the texels of a grid under all lights; normals and f are estimated in turns, starting from the trimmed
//! solution with f = 1: [`ROUNDS`] with a table of medians ([`super::reflectance_table`]), and as many with a polynomial of
//! both cosines ([`super::bipolynomial`]). The table finds gloss from far away, but its noise, and what light between parts of
//! the surface puts into single cells, stay in the normals; the polynomial is smooth, and both the residuals and the errors of
//! normals end lower with it. Each texel then moves its normal by Gauss-Newton steps, with the weights of Geman and McClure.
//!
//! Near to this are the data-driven table of F. Romeiro, Y. Vasilyev, T. Zickler, Passive reflectometry, ECCV 2008 (for
//! one known shape), and the bi-polynomial model of B. Shi, P. Tan, Y. Matsushita, K. Ikeuchi, Bi-polynomial modeling of
//! low-frequency reflectances, IEEE PAMI 36(6), 2014, which fits a function to every texel by itself. Where materials
//! differ much from texel to texel the common function is a mean, and results approach those of the robust estimator.

use super::bipolynomial::{Bipolynomial, ShadedValue};
use super::reflectance_table::ReflectanceTable;
use crate::direction::Direction;
use crate::numeric::small::solve_spd;
use crate::parallel;

/// Values at cosines below this are not looked at: they are noise, and shadow.
const LEAST_COSINE: f64 = 0.05;
/// Rounds of reflectance and normals with the table and with the polynomial, and steps of the normals in each.
const ROUNDS: usize = 4;
const STEPS: usize = 2;
/// Steps of each texel under the final reflectance.
pub(super) const FINAL_STEPS: usize = 2 * ROUNDS;
/// The largest step in radians.
const LARGEST_STEP: f64 = 0.15;
/// The least height of a normal.
const LEAST_HEIGHT: f64 = 0.02;
/// The distance over which the shading is differenced, in radians.
const PROBE: f64 = 0.02;
/// The scale of the weights in spreads of the residuals, and the least spread in albedos.
const REACH: f64 = 2.0;
const LEAST_SPREAD: f64 = 0.004;
/// A small weight that holds steps back where values say nothing.
const DAMPING: f64 = 1e-4;

/// A light with the half vector between it and the viewer.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightAndHalf {
    light: [f64; 3],
    half: [f64; 3],
}

impl LightAndHalf {
    pub fn new(light: [f64; 3]) -> Self {
        let half = Direction::new(light[0], light[1], light[2] + 1.0);
        Self { light, half: half.map_or(light, Direction::to_array) }
    }
}

/// A texel of the grid.
#[derive(Debug, Clone)]
pub(super) struct GridTexel {
    pub lights: Vec<LightAndHalf>,
    pub values: Vec<f64>,
    /// Albedo times normal.
    pub b: [f64; 3],
}

/// The common function f.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum SharedReflectance {
    Matt,
    Table(ReflectanceTable),
    Polynomial(Bipolynomial),
}

impl SharedReflectance {
    fn at(&self, to_light: f64, to_half: f64) -> f64 {
        match self {
            Self::Matt => 1.0,
            Self::Table(table) => table.at(to_light, to_half),
            Self::Polynomial(polynomial) => polynomial.at(to_light, to_half),
        }
    }

    /// The value of a texel of albedo 1.
    fn shaded(&self, normal: [f64; 3], light: &LightAndHalf) -> f64 {
        let to_light = dot(normal, light.light);
        if to_light <= 0.0 { 0.0 } else { self.at(to_light, dot(normal, light.half).max(0.0)) * to_light }
    }
}

/// The reflectance of texels whose matt solutions are known; their solutions are refined with it.
pub(super) fn learn(texels: &mut [GridTexel]) -> SharedReflectance {
    let mut reflectance = SharedReflectance::Matt;
    for round in 0..2 * ROUNDS {
        let values = shaded_values(texels);
        reflectance = match round {
            0..ROUNDS => SharedReflectance::Table(ReflectanceTable::of(&values)),
            _ => SharedReflectance::Polynomial(Bipolynomial::of(&values)),
        };
        parallel::for_each(texels.iter_mut(), |texel| {
            texel.b = refine(&reflectance, &texel.lights, &texel.values, texel.b, STEPS);
        });
    }
    reflectance
}

/// The values that the normals face, relative to the albedos.
fn shaded_values(texels: &[GridTexel]) -> Vec<ShadedValue> {
    let of_texel = |texel: &GridTexel| {
        let (normal, albedo) = split(texel.b);
        let of_light = move |(light, value): (&LightAndHalf, &f64)| ShadedValue {
            to_light: dot(normal, light.light),
            to_half: dot(normal, light.half),
            value: value / albedo,
        };
        let all = texel.lights.iter().zip(&texel.values).map(of_light);
        let faced = |at: &ShadedValue| at.to_light > LEAST_COSINE && at.to_half > LEAST_COSINE;
        let seen: Vec<ShadedValue> = if albedo > 0.0 { all.filter(faced).collect() } else { Vec::new() };
        seen
    };
    texels.iter().flat_map(of_texel).collect()
}

/// Albedo times normal after some steps from a solution.
pub(super) fn refine(
    reflectance: &SharedReflectance,
    lights: &[LightAndHalf],
    values: &[f64],
    start: [f64; 3],
    steps: usize,
) -> [f64; 3] {
    let (mut normal, mut albedo) = split(start);
    if albedo <= 0.0 {
        return start;
    }
    // A solution that faces away, misled by shadows, is turned to where it is seen.
    normal[2] = normal[2].max(LEAST_HEIGHT);
    normal = unit(normal);
    let mut weights = Vec::with_capacity(lights.len());
    for _ in 0..steps {
        let shaded: Vec<f64> = lights.iter().map(|light| reflectance.shaded(normal, light)).collect();
        weights.clear();
        weights.extend(shaded.iter().map(|s| f64::from(u8::from(*s > 0.0))));
        for _ in 0..3 {
            albedo = weighted_albedo(&shaded, values, &weights).unwrap_or(albedo);
            if !weigh(&shaded, values, albedo, &mut weights) {
                return normal.map(|n| n * albedo);
            }
        }
        let Some(moved) = step(reflectance, (normal, albedo), lights, (&shaded, values, &weights)) else {
            break;
        };
        normal = moved;
    }
    let shaded: Vec<f64> = lights.iter().map(|light| reflectance.shaded(normal, light)).collect();
    albedo = weighted_albedo(&shaded, values, &weights).unwrap_or(albedo);
    normal.map(|n| n * albedo)
}

fn weighted_albedo(shaded: &[f64], values: &[f64], weights: &[f64]) -> Option<f64> {
    let terms = || shaded.iter().zip(values).zip(weights);
    let below: f64 = terms().map(|((s, _), w)| w * s * s).sum();
    let above: f64 = terms().map(|((s, v), w)| w * s * v).sum();
    (below > 0.0 && above > 0.0).then(|| above / below)
}

/// Weights from the residuals; false where too few lights are faced.
fn weigh(shaded: &[f64], values: &[f64], albedo: f64, weights: &mut [f64]) -> bool {
    let residual = |k: usize| values[k] - albedo * shaded[k];
    let mut sizes: Vec<f64> =
        (0..values.len()).filter(|&k| shaded[k] > 0.0).map(|k| residual(k).abs()).collect();
    if sizes.len() < 4 {
        return false;
    }
    let middle = sizes.len() / 2;
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    let spread = REACH * (1.4826 * median).max(LEAST_SPREAD * albedo).max(1e-9);
    for (k, weight) in weights.iter_mut().enumerate() {
        let ratio = residual(k) / spread;
        *weight = if shaded[k] > 0.0 { (1.0 + ratio * ratio).powi(-2) } else { 0.0 };
    }
    true
}

/// The normal after one Gauss-Newton step of albedo and normal together.
fn step(
    reflectance: &SharedReflectance,
    (normal, albedo): ([f64; 3], f64),
    lights: &[LightAndHalf],
    (shaded, values, weights): (&[f64], &[f64], &[f64]),
) -> Option<[f64; 3]> {
    let tangents = tangents(normal);
    let probes = tangents.map(|t| unit(add(normal, t, PROBE)));
    let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for (k, light) in lights.iter().enumerate().filter(|(k, _)| weights[*k] > 0.0) {
        let slope = |probe: [f64; 3]| albedo * (reflectance.shaded(probe, light) - shaded[k]) / PROBE;
        let row = [shaded[k], slope(probes[0]), slope(probes[1])];
        let residual = values[k] - albedo * shaded[k];
        for i in 0..3 {
            right[i] += weights[k] * row[i] * residual;
            (0..3).for_each(|j| matrix[i][j] += weights[k] * row[i] * row[j]);
        }
    }
    (0..3).for_each(|i| matrix[i][i] *= 1.0 + DAMPING);
    let [_, a, b] = solve_spd(&matrix, &right)?;
    let limited = |v: f64| v.clamp(-LARGEST_STEP, LARGEST_STEP);
    let [x, y, z] = unit(add(add(normal, tangents[0], limited(a)), tangents[1], limited(b)));
    Some(unit([x, y, z.max(LEAST_HEIGHT)]))
}

/// Two unit vectors across a normal.
fn tangents(normal: [f64; 3]) -> [[f64; 3]; 2] {
    let [x, y, z] = normal;
    // Across the axis that the normal is farthest from.
    let first = if x.abs() < y.abs() { unit([0.0, z, -y]) } else { unit([z, 0.0, -x]) };
    let [a, b, c] = first;
    [first, [y * c - z * b, z * a - x * c, x * b - y * a]]
}

fn split(b: [f64; 3]) -> ([f64; 3], f64) {
    let length = dot(b, b).sqrt();
    if length > 0.0 { (b.map(|v| v / length), length) } else { ([0.0, 0.0, 1.0], 0.0) }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(a: [f64; 3], b: [f64; 3], times: f64) -> [f64; 3] {
    std::array::from_fn(|k| a[k] + times * b[k])
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = dot(v, v).sqrt();
    v.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::surface::robust::{self, Ambient, Estimator, Scratch};

    fn lights(count: usize) -> Vec<LightAndHalf> {
        let light = |i: usize| Direction::from_angles(0.15 + 0.2 * (i % 5) as f64, 2.4 * i as f64);
        (0..count).map(|i| LightAndHalf::new(light(i).to_array())).collect()
    }

    /// Texels of a surface with a wide gloss.
    fn texels(count: usize, lights: &[LightAndHalf]) -> (Vec<GridTexel>, Vec<[f64; 3]>) {
        let mut stream = Stream::new(5, Purpose::Sample, [2]);
        let mut truth = Vec::new();
        let texels = (0..count).map(|_| {
            let normal = Direction::from_angles(0.8 * stream.unit(), 6.2 * stream.unit()).to_array();
            let albedo = 0.2 + 0.5 * stream.unit();
            truth.push(normal);
            let value = |light: &LightAndHalf| {
                let cosine = dot(normal, light.light).max(0.0);
                albedo * cosine * (0.9 + 1.5 * dot(normal, light.half).max(0.0).powi(20))
            };
            let values: Vec<f64> = lights.iter().map(value).collect();
            let how = (Estimator::Shared, Ambient::None);
            let all: Vec<[f64; 3]> = lights.iter().map(|light| light.light).collect();
            let b = robust::solve(&all, &values, how, &mut Scratch::default()).unwrap().b;
            GridTexel { lights: lights.to_vec(), values, b }
        });
        (texels.collect(), truth)
    }

    fn mean_deg(texels: &[GridTexel], truth: &[[f64; 3]]) -> f64 {
        let off = |(texel, truth): (&GridTexel, &[f64; 3])| {
            dot(split(texel.b).0, *truth).clamp(-1.0, 1.0).acos().to_degrees()
        };
        texels.iter().zip(truth).map(off).sum::<f64>() / texels.len() as f64
    }

    #[test]
    fn a_common_reflectance_is_learned_and_normals_gain_by_it() {
        let lights = lights(40);
        let (mut texels, truth) = texels(700, &lights);
        let before = mean_deg(&texels, &truth);
        learn(&mut texels);
        let after = mean_deg(&texels, &truth);
        assert!(after < 0.85 * before, "{before} to {after}");
    }

    /// Photometric stereo left such texels level: a twentieth of the texels of a virtual bark.
    #[test]
    fn a_start_that_faces_away_is_turned_to_where_it_is_seen() {
        let lights = lights(20);
        let (texels, truth) = texels(3, &lights);
        for (texel, normal) in texels.iter().zip(truth) {
            let values: Vec<f64> = lights.iter().map(|l| 0.5 * dot(normal, l.light).max(0.0)).collect();
            let away = [normal[0], normal[1], -0.1];
            let b = refine(&SharedReflectance::Matt, &texel.lights, &values, away, 40);
            assert!(dot(split(b).0, normal) > 0.999, "{b:?} instead of {normal:?}");
        }
    }

    #[test]
    fn a_matt_surface_stays_as_it_is() {
        let lights = lights(20);
        let (texels, truth) = texels(3, &lights);
        for (texel, normal) in texels.iter().zip(truth) {
            let values: Vec<f64> = lights.iter().map(|l| 0.5 * dot(normal, l.light).max(0.0)).collect();
            let b = refine(&SharedReflectance::Matt, &texel.lights, &values, normal.map(|n| 0.5 * n), 4);
            assert!(dot(split(b).0, normal) > 1.0 - 1e-9);
        }
    }
}
