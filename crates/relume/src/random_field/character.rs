//! Whether a random field suits a material, predicted before it is modelled.
//!
//! A Gaussian field represents the spectrum of a texture and nothing else. Two measures reveal other
//! structure. Periods: the autocorrelation rises again far from the centre, because the material repeats.
//! Shapes: the errors of one-step prediction, normal noise for a Gaussian field, are mostly small and
//! sometimes large, at edges; their excess kurtosis measures this, and is 0 for a normal distribution. Both
//! are measured on the scores of the luminance, whose own distribution is normal.

use std::fmt;

use serde::Serialize;

use super::candidates::NeighbourCandidates;
use super::marginal::Marginal;
use super::neighbourhood::causal;
use super::selection::posterior;
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::planes::Planes;
use crate::size::Size;

/// The kind of material of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Character {
    /// The highest peak of the autocorrelation away from the centre: near 1 for exact repetition.
    pub regularity: f64,
    /// Excess kurtosis of one-step prediction errors: 0 for a Gaussian field.
    pub edges: f64,
}

/// The regularity above which a material is called regular.
const REGULAR: f64 = 0.25;

/// The excess kurtosis above which a material is called structured.
const STRUCTURED: f64 = 3.0;

impl Character {
    /// Whether it has periods.
    pub fn is_regular(&self) -> bool {
        self.regularity > REGULAR
    }

    /// Whether it has shapes with edges.
    pub fn is_structured(&self) -> bool {
        self.edges > STRUCTURED
    }
}

impl fmt::Display for Character {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = match (self.is_regular(), self.is_structured()) {
            (true, _) => "regular",
            (false, true) => "structured",
            (false, false) => "neither regular nor structured",
        };
        write!(f, "regularity {:.2}, edges {:.1}: {verdict}", self.regularity, self.edges)
    }
}

/// The character of a field, from the mean of its first coefficient plane over the channels.
///
/// # Errors
/// A field smaller than a small neighbourhood.
pub fn character(field: &ReflectanceField, job: &Job) -> Result<Character> {
    let scores = luminance_scores(field);
    Ok(Character { regularity: regularity(&scores, job)?, edges: edges(&scores, job)? })
}

/// Normal scores of the sum of all index planes that represent brightness: those of the first function in
/// graded order.
fn luminance_scores(field: &ReflectanceField) -> Planes {
    let n = field.basis().len();
    let constant = field.basis().graded_order()[0];
    let mut sum = Planes::zeros(field.size(), 1);
    for c in 0..field.layout().functions() {
        let plane = field.coefficients().plane(c * n + constant);
        sum.as_mut_slice().iter_mut().zip(plane).for_each(|(s, v)| *s += v);
    }
    let score = Marginal::curve(sum.as_slice()).scores();
    sum.as_mut_slice().iter_mut().for_each(|v| *v = score(*v));
    sum
}

/// The highest local maximum of the autocorrelation, which is 1 at the centre, between the first position
/// along its direction where it falls below zero and a third of the sides.
fn regularity(scores: &Planes, job: &Job) -> Result<f64> {
    let third = Size::new(scores.size().width / 3, scores.size().height / 3);
    let correlation = Autocorrelation::new(scores, third, job)?;
    Ok(highest_peak(|dx, dy| correlation.at(dx, dy), third.width as isize, third.height as isize))
}

/// The highest local maximum over shifts of half a plane that lie beyond a valley on their ray.
fn highest_peak(at: impl Fn(isize, isize) -> f64, across: isize, down: isize) -> f64 {
    let mut best = 0.0f64;
    for dy in 0..down {
        for dx in -across + 1..across {
            let here = at(dx, dy);
            let neighbours = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];
            if here <= best || neighbours.iter().any(|(i, j)| at(dx + i, dy + j) > here) {
                continue;
            }
            let steps = dx.abs().max(dy);
            let on_ray = |s: isize| at(dx * s / steps.max(1), dy * s / steps.max(1));
            let valley = (1..steps).map(on_ray).fold(f64::INFINITY, f64::min);
            if valley < 0.0 {
                best = here;
            }
        }
    }
    best
}

/// Excess kurtosis of the errors of prediction from the twelve nearest causal neighbours.
fn edges(scores: &Planes, job: &Job) -> Result<f64> {
    let set = NeighbourCandidates { near: causal(12), coarse: Vec::new() };
    let statistics = set.statistics(scores, 1, job)?;
    let all: Vec<usize> = (0..set.near.len()).collect();
    let weights = posterior(&statistics, &statistics.prior(1.0), &all)?.weights;
    let (size, margin) = (scores.size(), 3);
    let (mut square, mut fourth, mut n) = (0.0, 0.0, 0.0);
    for y in margin..size.height {
        for x in margin..size.width.saturating_sub(margin) {
            let neighbour = |o: &super::neighbourhood::Offset| {
                let (x, y) = (x.wrapping_add_signed(o.dx as isize), y.wrapping_add_signed(o.dy as isize));
                f64::from(scores.at(0, x, y))
            };
            let predicted: f64 =
                set.near.iter().enumerate().map(|(r, o)| weights[(r, 0)] * neighbour(o)).sum();
            let error = (f64::from(scores.at(0, x, y)) - predicted).powi(2);
            square += error;
            fourth += error * error;
            n += 1.0;
        }
    }
    Ok(if square > 0.0 { n * fourth / (square * square) - 3.0 } else { 0.0 })
}

#[cfg(test)]
mod tests {
    use super::super::recursion::Recursion;
    use super::super::recursion::RecursionRun;
    use super::super::recursion::tests::random_level;
    use super::*;
    use crate::picture::Picture;
    use crate::space::Space;

    fn of(planes: Planes) -> Character {
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Srgb });
        character(&field, &Job::default()).unwrap()
    }

    #[test]
    fn a_gaussian_field_is_neither_regular_nor_structured() {
        let run =
            RecursionRun { size: Size::new(128, 128), drive: None, strength: None, seed: 4, period: None };
        let kind = of(Recursion::new(&random_level(1, 6, 3), 0).run_slow([0, 0], &run));
        assert!(!kind.is_regular() && !kind.is_structured(), "{kind}");
        assert!(kind.edges.abs() < 0.3, "{kind}");
    }

    #[test]
    fn repetition_is_regular_and_flat_patches_are_structured() {
        let size = Size::new(96, 80);
        let made = |value: &dyn Fn(usize, usize) -> f32| {
            let data = (0..size.texels()).map(|i| value(i % size.width, i / size.width)).collect();
            of(Planes::from_vec(size, 1, data).unwrap())
        };
        let grain = |x: usize, y: usize| ((x * 7919 + y * 104_729 + x * y * 31) % 101) as f32 / 101.0;
        let stripes = made(&|x, y| (x % 12) as f32 / 12.0 + 0.3 * grain(x, y));
        assert!(stripes.is_regular() && stripes.regularity > 0.6, "{stripes}");
        let patches = made(&|x, y| grain(x / 9 * 37, y / 11 * 53) + 0.02 * grain(x, y));
        assert!(patches.is_structured(), "{patches}");
    }
}
