//! The light under which a function of any basis is largest, by a table and steps that shrink.
//!
//! The functions' values over a grid of directions are found once; a texel's best grid point is then
//! improved by pattern search (Hooke, Jeeves, "Direct Search Solution of Numerical and Statistical
//! Problems", Journal of the ACM 8, 1961): to the best of eight neighbours, or to half the step; and once steps are
//! short, to the maximum of the quadratic through all nine, which converges in a few. Steps go
//! along the meridian and across it, because harmonics have narrow ridges along the horizon, on which
//! steps in u and v get stuck. Functions of much detail have several peaks nearly as high, so the best grid points
//! far from each other are improved too. Limits: a peak narrower than a step of the grid may be missed, and of
//! peaks nearly as high a lower one may be found. The view is the zenith. Functions with a value for each of
//! three channels are combined to their luminance, others to their mean. Functions that are interpolated in triangles between
//! measured lights have their maxima by [`super::measured_peak`].

use std::f64::consts::{FRAC_PI_2, TAU};

use super::argmax::ptm_maximum;
use super::luminance::LUMINANCE;
use super::measured_peak::MeasuredPeaks;
use crate::direction::{Direction, Directions};
use crate::field::{Bands, Basis, PolynomialDegree, RadialSum};

/// Rings of the grid between the zenith and the horizon, which is the last.
const RINGS: u32 = 16;

/// Peaks to improve of functions of much detail.
const PEAKS: usize = 4;

/// The cosine between grid points that may belong to different peaks: 20 degrees.
const SAME_PEAK: f64 = 0.94;

/// The step at which the search ends, in radians.
const LEAST_STEP: f64 = 1e-7;

/// The step below which the function is nearly a quadratic, in radians.
const SHORT_STEP: f64 = 0.02;

/// The part of a step that is left where the quadratic had its maximum within.
const SHRINK: f64 = 1.0 / 32.0;

/// Moves and halvings at most: 20 halvings, and moves along a curved ridge.
const MOST_ROUNDS: usize = 200;

/// Steps along the meridian and across it.
const NEIGHBOURS: [(f64, f64); 8] =
    [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];

/// The functions' values over a grid of lights.
pub(super) struct BrightestSearch<'a> {
    basis: &'a Basis,
    /// The measured lights of functions that are interpolated between them, which are then the grid.
    measured: Option<MeasuredPeaks>,
    /// Lights, ring after ring from the zenith.
    lights: Vec<Direction>,
    /// The functions' values, light after light.
    values: Vec<f64>,
}

impl<'a> BrightestSearch<'a> {
    pub fn new(basis: &'a Basis) -> Self {
        let ring = |i: u32| {
            let polar = FRAC_PI_2 * f64::from(i) / f64::from(RINGS);
            (0..6 * i).map(move |j| Direction::from_angles(polar, TAU * f64::from(j) / f64::from(6 * i)))
        };
        let measured = MeasuredPeaks::of(basis);
        let lights: Vec<Direction> = match &measured {
            Some(peaks) => peaks.lights().to_vec(),
            None => std::iter::once(Direction::ZENITH).chain((1..=RINGS).flat_map(ring)).collect(),
        };
        let n = basis.len();
        let mut search = Self { basis, measured, lights: Vec::new(), values: Vec::new() };
        let mut scratch = search.scratch();
        let mut values = vec![0.0; lights.len() * n];
        for (&light, row) in lights.iter().zip(values.chunks_exact_mut(n)) {
            row.copy_from_slice(search.luminances(light, &mut scratch));
        }
        (search.lights, search.values) = (lights, values);
        search
    }

    /// Memory for the values of the functions.
    pub fn scratch(&self) -> Vec<f64> {
        vec![0.0; self.basis.len() * self.basis.channels()]
    }

    /// The functions for a light, seen from above, as one value each.
    fn luminances<'s>(&self, light: Direction, scratch: &'s mut [f64]) -> &'s [f64] {
        let n = self.basis.len();
        self.basis.weights_into(Directions::lit_from(light), scratch);
        if self.basis.channels() > 1 {
            for k in 0..n {
                scratch[k] = self.shares().enumerate().map(|(c, share)| share * scratch[c * n + k]).sum();
            }
        }
        &scratch[..n]
    }

    /// The share of each channel of the functions.
    fn shares(&self) -> impl Iterator<Item = f64> {
        let channels = self.basis.channels();
        (0..channels).map(move |c| match channels {
            1 => 1.0,
            3 => LUMINANCE[c],
            _ => 1.0 / channels as f64,
        })
    }

    /// The function of these coefficients: of radial basis functions as one sum of kernels, which is quicker than all
    /// of them.
    fn function<'c>(&'c self, coefficients: &'c [f64], scratch: &'c mut [f64]) -> TexelFunction<'c> {
        match self.basis.radial() {
            Some(radial) => {
                let columns = self.shares().flat_map(|share| coefficients.iter().map(move |c| share * c));
                TexelFunction::Radial(radial.combined(&columns.collect::<Vec<_>>()))
            }
            None => TexelFunction::Functions { search: self, coefficients, scratch },
        }
    }

    /// The light under which the function of these coefficients is largest; of equal ones of the grid
    /// the nearest to the zenith. `scratch` is that of [`BrightestSearch::scratch`].
    pub fn maximum(&self, coefficients: &[f64], scratch: &mut [f64]) -> Direction {
        if let Some(peaks) = &self.measured {
            let n = coefficients.len();
            return peaks.maximum(|i| dot(&self.values[i * n..][..n], coefficients));
        }
        let mut function = self.function(coefficients, scratch);
        let mut starts: Vec<Direction> = Vec::with_capacity(PEAKS);
        let (mut place, mut best) = (Direction::ZENITH, f64::NEG_INFINITY);
        for _ in 0..peaks(self.basis) {
            let Some(start) = self.best_apart(coefficients, &starts) else { break };
            let (light, value) = improved(start, &mut |light| function.value(light));
            if value > best {
                (place, best) = (light, value);
            }
            starts.push(start.0);
        }
        place
    }

    /// The best light of the grid that is not near others, and the value there.
    fn best_apart(&self, coefficients: &[f64], others: &[Direction]) -> Option<(Direction, f64)> {
        let mut best: Option<(Direction, f64)> = None;
        for (&light, row) in self.lights.iter().zip(self.values.chunks_exact(coefficients.len())) {
            let value = dot(row, coefficients);
            let is_apart = || others.iter().all(|other| other.dot(light) < SAME_PEAK);
            if best.is_none_or(|best| value > best.1) && is_apart() {
                best = Some((light, value));
            }
        }
        best
    }
}

/// The function of one texel.
enum TexelFunction<'a> {
    Radial(RadialSum<'a>),
    Functions { search: &'a BrightestSearch<'a>, coefficients: &'a [f64], scratch: &'a mut [f64] },
}

impl TexelFunction<'_> {
    fn value(&mut self, light: Direction) -> f64 {
        match self {
            Self::Radial(sum) => sum.value(light),
            Self::Functions { search, coefficients, scratch } => {
                dot(search.luminances(light, scratch), coefficients)
            }
        }
    }
}

/// Moves a light to a maximum near it: the light and the value there.
fn improved(
    (mut place, mut best): (Direction, f64),
    value: &mut dyn FnMut(Direction) -> f64,
) -> (Direction, f64) {
    let mut step = FRAC_PI_2 / f64::from(RINGS);
    for _ in 0..MOST_ROUNDS {
        if step < LEAST_STEP {
            break;
        }
        let (middle, of_middle) = (place, best);
        let around = NEIGHBOURS.map(|(along, across)| {
            let light = moved(middle, step * along, step * across);
            let found = value(light);
            if found > best {
                (place, best) = (light, found);
            }
            found
        });
        if step < SHORT_STEP {
            let (along, across) = quadratic_maximum(of_middle, around);
            let light = moved(middle, step * along, step * across);
            let found = value(light);
            if found > best {
                (place, best) = (light, found);
                // On the rim the maximum is farther away.
                step *= if along.hypot(across) < 0.7 { SHRINK } else { 1.0 };
                continue;
            }
        }
        if place == middle {
            step *= 0.5;
        }
    }
    (place, best)
}

/// The place, in steps, at which the quadratic through a value and those of its [`NEIGHBOURS`] is largest.
fn quadratic_maximum(middle: f64, [s, n, e, w, se, sw, ne, nw]: [f64; 8]) -> (f64, f64) {
    ptm_maximum([
        0.5 * (s + n) - middle,
        0.5 * (e + w) - middle,
        0.25 * (se - sw - ne + nw),
        0.5 * (s - n),
        0.5 * (e - w),
        middle,
    ])
}

fn dot(weights: &[f64], coefficients: &[f64]) -> f64 {
    weights.iter().zip(coefficients).map(|(w, c)| w * c).sum()
}

/// How many peaks of a function to improve.
fn peaks(basis: &Basis) -> usize {
    match basis {
        Basis::Polynomial(PolynomialDegree::Quartic) | Basis::Zernike => PEAKS,
        Basis::Harmonics(Bands::Four | Bands::Five) | Basis::Spherical(Bands::Four | Bands::Five) => PEAKS,
        _ => 1,
    }
}

/// A light moved by angles down its meridian, to the horizon at most, and then at a right angle to it.
fn moved(light: Direction, along_rad: f64, across_rad: f64) -> Direction {
    let radius = light.x().hypot(light.y());
    let (east, north) = if radius > 1e-9 { (light.x() / radius, light.y() / radius) } else { (1.0, 0.0) };
    let (sin, _) = (radius.atan2(light.z()) + along_rad).min(FRAC_PI_2).sin_cos();
    let (side, ahead) = across_rad.sin_cos();
    Direction::from_disk(sin * east * ahead - north * side, sin * north * ahead + east * side)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Interpolated, Interpolation};
    use crate::numeric::random::{Purpose, Stream};
    use crate::surface::argmax::maximum_by_search;

    #[test]
    fn no_light_is_brighter_than_the_one_found() {
        let mut stream = Stream::new(9, Purpose::Sample, [0]);
        for basis in Basis::NAMED {
            let search = BrightestSearch::new(&basis);
            let mut scratch = vec![0.0; basis.len()];
            // Of random functions of much detail a narrow peak may be missed.
            let (mut missed, allowed) = (0, if peaks(&basis) == 1 { 0 } else { 6 });
            for _ in 0..60 {
                let coefficients: Vec<f64> = (0..basis.len()).map(|_| 2.0 * stream.unit() - 1.0).collect();
                let value = |u: f64, v: f64| -> f64 {
                    let weights = basis.weights(Direction::from_disk(u, v));
                    weights.iter().zip(&coefficients).map(|(w, c)| w * c).sum()
                };
                let light = search.maximum(&coefficients, &mut scratch);
                let (a, b) = maximum_by_search(value);
                let (found, truth) = (value(light.x(), light.y()), value(a, b));
                assert!(
                    found >= truth - 0.05 * truth.abs() - 1e-6,
                    "{}: {found} below {truth}",
                    basis.name()
                );
                missed += usize::from(found < truth - 1e-6);
            }
            assert!(missed <= allowed, "{}: {missed} of 60 maxima missed", basis.name());
        }
    }

    /// Radial basis functions through the shading of a matt texel have its maximum near the normal.
    #[test]
    fn the_maximum_of_radial_functions_is_that_of_their_sum() {
        let lights: Vec<Direction> = (0..40).map(Direction::fibonacci(40)).collect();
        let table = Interpolated::new(&lights, Interpolation::RadialBasis).unwrap();
        let basis = Basis::Interpolated(table);
        let search = BrightestSearch::new(&basis);
        for k in 0..12 {
            let normal = Direction::from_angles(0.1 + 0.06 * f64::from(k), 1.9 * f64::from(k));
            let coefficients: Vec<f64> = lights.iter().map(|light| light.dot(normal).max(0.0)).collect();
            let value = |light: Direction| dot(&basis.weights(light), &coefficients);
            let light = search.maximum(&coefficients, &mut search.scratch());
            let (u, v) = maximum_by_search(|u, v| value(Direction::from_disk(u, v)));
            let truth = value(Direction::from_disk(u, v));
            assert!((value(light) - truth).abs() < 1e-7, "{} and {truth}", value(light));
            assert!(light.dot(normal) > 0.99, "{light:?} {normal:?}");
        }
    }

    #[test]
    fn polynomials_have_the_maximum_of_the_closed_form() {
        let coefficients = [-1.0, -2.0, 1.0, 1.0, -1.9, 0.0];
        let light = BrightestSearch::new(&Basis::Ptm).maximum(&coefficients, &mut [0.0; 6]);
        let (u, v) = ptm_maximum(coefficients);
        assert!((light.x() - u).hypot(light.y() - v) < 1e-5, "{light:?} and ({u}, {v})");
    }
}
