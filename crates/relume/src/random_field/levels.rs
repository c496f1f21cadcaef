//! The number of levels of a model, and the model of all levels.
//!
//! Fewer levels take fewer bytes and leave no grid; more levels represent coarse grain. The evidence cannot
//! choose: the evidence of two levels refers to other data than that of one, since a coarse level is a
//! function of the fine one. The outputs of models can be compared. A Gaussian field is determined by its
//! autocorrelation, so the number is chosen whose field has the autocorrelation nearest to that of the
//! texture ([`Autocorrelation::distance`]); figures are in `docs/models.md`.

use std::ops::RangeInclusive;

use super::estimate::{LevelReport, ModelOptions, Scored, level};
use super::level::Level;
use super::model::Model;
use super::realisation::Realisation;
use super::structure::Structure;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::pyramid::{self, Kernel};
use crate::parallel;
use crate::planes::Planes;
use crate::rect::Rect;
use crate::size::Size;

/// The least side of a coarsest level, in texels.
const LEAST_SIDE: usize = 16;

/// The least number of texels per component: with fewer, its weights are poorly determined, and errors at a
/// coarse level show as a grid.
const LEAST_TEXELS: usize = 200;

/// Half of the eight neighbours of a texel: the others are opposite.
const NEIGHBOURS: [[isize; 2]; 4] = [[1, 0], [0, 1], [1, 1], [-1, 1]];

/// How much a logarithm of steps counts beside a correlation.
const STEP_WEIGHT: f64 = 0.05;

/// The side of the reference window in texels, on which the gains are measured.
pub(super) const REFERENCE_WINDOW: usize = 512;

/// The model of the components, or of the residual left by the structure, for planes whose scores have the
/// given deviations.
pub(super) fn completed(
    scored: Scored,
    structure: Option<Structure>,
    deviations: &[f64],
    options: &ModelOptions,
    job: &Job,
) -> Result<(Model, Vec<LevelReport>)> {
    let Scored { marginals, color, mixing, components } = scored;
    let kernel = Kernel::new(options.factor)?;
    let decoded = structure.as_ref().map(Structure::decoded);
    let fits = Fits::of(&components, decoded.as_ref(), &kernel, options, job)?;
    let gains = vec![1.0; mixing.own.len()];
    let mut model = Model { marginals, color, mixing, gains, kernel, levels: Vec::new(), structure };
    let count = if options.fewer { nearest_count(&components, &fits, &model, job)? } else { fits.most };
    let (levels, reports) = fits.levels(count);
    model.levels = levels;
    model.gains = gains_of(&model, deviations, job)?;
    Ok((model, reports))
}

/// The levels of models with each number of levels tried.
struct Fits {
    most: usize,
    tried: RangeInclusive<usize>,
    /// All levels but the coarsest of the largest model, which are the same in smaller models; then the
    /// coarsest level of each model.
    fitted: Vec<(Level, LevelReport)>,
}

impl Fits {
    /// Of the components of a texture, or of the residual left by a structure.
    fn of(
        components: &Planes,
        structure: Option<&Planes>,
        kernel: &Kernel,
        options: &ModelOptions,
        job: &Job,
    ) -> Result<Self> {
        let most = fitting_levels(components.size(), components.count(), options);
        let gaussian = pyramid::gaussian(components, kernel, most);
        let known = structure.map(|structure| pyramid::gaussian(structure, kernel, most));
        let tried = if options.fewer { 1..=most } else { most..=most };
        let coarsest = tried.clone().map(|count| (count - 1, count));
        let jobs: Vec<(usize, usize)> = (0..most - 1).map(|k| (k, k + 2)).chain(coarsest).collect();
        job.start("estimating levels", jobs.len() as u64);
        let fit = |&(k, count): &(usize, usize)| {
            let fitted =
                level(&gaussian[..count], k, known.as_ref().map(|known| &known[k]), kernel, options, job);
            job.advance(1)?;
            fitted
        };
        let fitted = parallel::try_map(jobs.iter(), fit)?;
        Ok(Self { most, tried, fitted })
    }

    /// The levels of the model with `count` levels.
    fn levels(&self, count: usize) -> (Vec<Level>, Vec<LevelReport>) {
        let coarsest = self.most - 1 + count - self.tried.start();
        self.fitted[..count - 1].iter().chain(&self.fitted[coarsest..=coarsest]).cloned().unzip()
    }
}

/// The number of levels whose field has the autocorrelation nearest to that of the components.
fn nearest_count(components: &Planes, fits: &Fits, model: &Model, job: &Job) -> Result<usize> {
    let area = Rect::new(0, 0, Size::new(REFERENCE_WINDOW, REFERENCE_WINDOW));
    let half = Autocorrelation::half(components.size());
    let reach = Size::new(half.width.min(REFERENCE_WINDOW / 2), half.height.min(REFERENCE_WINDOW / 2));
    let resemblance =
        |components: &Planes| Autocorrelation::new(&model.mixing.planes_of(components), reach, job);
    // The window, and the planes that are made of its components.
    let planes = model.mixing.components() + model.planes();
    let _window = job.hold("the reference window", 4 * (area.size.texels() * planes) as u64)?;
    let truth = resemblance(components)?;
    let mut best = (f64::INFINITY, 1);
    for count in fits.tried.clone() {
        let (levels, _) = fits.levels(count);
        let made =
            Realisation::new(&levels, &model.kernel, model.structure.as_ref(), 0, None).field(area, job)?;
        let found = resemblance(&made)?;
        let distance = found.distance(&truth) + STEP_WEIGHT * step_distance(&found, &truth);
        if distance < best.0 {
            best = (distance, count);
        }
    }
    Ok(best.1)
}

/// How far the mean squared steps to the neighbours are apart, as the mean magnitude of the logarithm of their ratio: twice the
/// variance times 1 minus the correlation, which is near 1 in smooth textures, so that the distance of the correlations hardly
/// sees grain that is too strong, or of another direction.
fn step_distance(a: &Autocorrelation, b: &Autocorrelation) -> f64 {
    const LEAST: f64 = 1e-4;
    let step = |of: &Autocorrelation, [dx, dy]: [isize; 2]| (1.0 - of.at(dx, dy)).max(LEAST);
    let ratios = NEIGHBOURS.map(|shift| (step(a, shift) / step(b, shift)).ln().abs());
    ratios.iter().sum::<f64>() / ratios.len() as f64
}

/// The number of levels, as requested and as the size of the texture allows.
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

/// The gains that give the scores of each plane their deviation, measured on the reference window.
fn gains_of(model: &Model, deviations: &[f64], job: &Job) -> Result<Vec<f32>> {
    let area = Rect::new(0, 0, Size::new(REFERENCE_WINDOW, REFERENCE_WINDOW));
    job.check("the reference window", area.size, model.bytes_per_texel())?;
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
