//! How many levels a model has, and the model of all of them.
//!
//! Fewer levels take fewer bytes and leave no grid; more of them remember coarse grain. Evidence cannot say
//! how many: the evidence of two levels is that of other data than the evidence of one, since a coarse level
//! is a function of the fine one. What can be compared is what models make. A Gaussian field is its
//! autocorrelation, so the number is taken whose field resembles itself at shifts most nearly as the texture
//! does ([`Autocorrelation::distance`]); figures are in `docs/models.md`.

use std::ops::RangeInclusive;

use rayon::prelude::*;

use super::estimate::{LevelReport, ModelOptions, Scored, level};
use super::level::Level;
use super::model::Model;
use super::realisation::Realisation;
use super::structure::Structure;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::pyramid::{self, Kernel};
use crate::planes::{Planes, Size};
use crate::rect::Rect;

/// Coarsest levels have at least this many texels a side.
const LEAST_SIDE: usize = 16;

/// And at least so many texels for each component: fewer say too little of its weights, and what is wrong at
/// a coarse level shows as a grid.
const LEAST_TEXELS: usize = 200;

/// Texels a side of the reference window, on which the gains are measured.
pub(super) const REFERENCE_WINDOW: usize = 512;

/// The model of some components, besides what a structure makes of them already, whose planes' scores have
/// the given deviations.
pub(super) fn completed(
    scored: Scored,
    structure: Option<Structure>,
    deviations: &[f64],
    options: &ModelOptions,
    job: &Job,
) -> Result<(Model, Vec<LevelReport>)> {
    let Scored { marginals, mixing, components } = scored;
    let kernel = Kernel::new(options.factor)?;
    let fits = Fits::of(&components, &kernel, options, job)?;
    let gains = vec![1.0; marginals.len()];
    let mut model = Model { marginals, mixing, gains, kernel, levels: Vec::new(), structure };
    let count = if options.fewer { nearest_count(&components, &fits, &model, job)? } else { fits.most };
    let (levels, reports) = fits.levels(count);
    model.levels = levels;
    model.gains = gains_of(&model, deviations, job)?;
    Ok((model, reports))
}

/// The levels of models with each number of levels that is tried.
struct Fits {
    most: usize,
    tried: RangeInclusive<usize>,
    /// All levels but the coarsest of the largest model, which are the same in smaller ones; then the
    /// coarsest level of each model.
    fitted: Vec<(Level, LevelReport)>,
}

impl Fits {
    fn of(components: &Planes, kernel: &Kernel, options: &ModelOptions, job: &Job) -> Result<Self> {
        let most = fitting_levels(components.size(), components.count(), options);
        let gaussian = pyramid::gaussian(components, kernel, most);
        let tried = if options.fewer { 1..=most } else { most..=most };
        let coarsest = tried.clone().map(|count| (count - 1, count));
        let jobs: Vec<(usize, usize)> = (0..most - 1).map(|k| (k, k + 2)).chain(coarsest).collect();
        job.start("estimating levels", jobs.len() as u64);
        let fit = |&(k, count): &(usize, usize)| {
            let fitted = level(&gaussian[..count], k, kernel, options);
            job.advance(1)?;
            fitted
        };
        let fitted = jobs.par_iter().map(fit).collect::<Result<_>>()?;
        Ok(Self { most, tried, fitted })
    }

    /// The levels of the model of so many.
    fn levels(&self, count: usize) -> (Vec<Level>, Vec<LevelReport>) {
        let coarsest = self.most - 1 + count - self.tried.start();
        self.fitted[..count - 1].iter().chain(&self.fitted[coarsest..=coarsest]).cloned().unzip()
    }
}

/// How many of some levels make the field whose autocorrelation is nearest to that of the components.
fn nearest_count(components: &Planes, fits: &Fits, model: &Model, job: &Job) -> Result<usize> {
    let area = Rect::new(0, 0, Size::new(REFERENCE_WINDOW, REFERENCE_WINDOW));
    let half = Autocorrelation::half(components.size());
    let reach = Size::new(half.width.min(REFERENCE_WINDOW / 2), half.height.min(REFERENCE_WINDOW / 2));
    let resemblance =
        |components: &Planes| Autocorrelation::new(&model.mixing.planes_of(components), reach, job);
    let truth = resemblance(components)?;
    let mut best = (f64::INFINITY, 1);
    for count in fits.tried.clone() {
        let (levels, _) = fits.levels(count);
        let made = Realisation::new(&levels, &model.kernel, 0, None).field(area);
        let distance = resemblance(&made)?.distance(&truth);
        if distance < best.0 {
            best = (distance, count);
        }
    }
    Ok(best.1)
}

/// As many levels as asked for and the texture is large enough for.
fn fitting_levels(mut size: Size, components: usize, options: &ModelOptions) -> usize {
    let mut levels = 1;
    while levels < options.levels {
        size = Size::new(size.width.div_ceil(options.factor), size.height.div_ceil(options.factor));
        if size.width.min(size.height) < LEAST_SIDE || size.texels() < LEAST_TEXELS * components {
            break;
        }
        levels += 1;
    }
    levels
}

/// What gives each plane's scores their deviation, measured on the reference window.
fn gains_of(model: &Model, deviations: &[f64], job: &Job) -> Result<Vec<f32>> {
    let area = Rect::new(0, 0, Size::new(REFERENCE_WINDOW, REFERENCE_WINDOW));
    let scores = model.scores(area, 0, None, job)?;
    let deviation = |plane: &[f32]| {
        let square: f64 = plane.iter().map(|&v| f64::from(v) * f64::from(v)).sum();
        (square / plane.len() as f64).sqrt()
    };
    let gain = |(made, wanted): (f64, &f64)| {
        if made > 0.0 { half::f16::from_f64(wanted / made).to_f32() } else { 1.0 }
    };
    Ok(scores.iter().map(deviation).zip(deviations).map(gain).collect())
}
