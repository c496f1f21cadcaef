//! From planes to a model.

use std::borrow::Cow;

use serde::Serialize;

use super::candidates::{NeighbourCandidates, StableFit};
use super::combine::matched;
use super::innovations::innovations;
use super::joint_color::{JointColor, in_axes};
use super::level::Level;
use super::levels::completed;
use super::local_gain::LocalGain;
use super::marginal::Marginal;
use super::mixing::Mixing;
use super::model::Model;
use super::normal_wishart::{Posterior, SufficientStatistics};
use super::selection::{SelectionOrder, search};
use super::unevenness;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::pyramid::{self, Kernel};
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// Options of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelOptions {
    /// The most levels of the pyramid, 1 to 16; fewer if the coarsest would be smaller than 16 texels a side, or than
    /// 200 texels for each component.
    pub levels: usize,
    /// Whether fewer levels are tried as well, choosing the number whose field has the autocorrelation
    /// nearest to that of the texture.
    pub fewer: bool,
    /// The factor by which each level is coarser: 2 to 16.
    pub factor: usize,
    /// The number of causal neighbours that may be chosen: 0 to 400.
    pub candidates: usize,
    /// The number of neighbours in the expanded coarser level that may be chosen, up to 100; 0 makes levels
    /// independent.
    pub coarse: usize,
    /// The most neighbours of a level: 0 to 500.
    pub most: usize,
    /// How neighbours are chosen.
    pub search: SelectionOrder,
    /// The weight of the prior, in texels: 1e-6 to 1e9.
    pub prior: f64,
    /// Whether the distributions of values are preserved, or normal ones assumed.
    pub marginals: bool,
    /// The first of three planes that hold a colour, whose joint distribution is preserved.
    pub color: Option<usize>,
}

impl Default for ModelOptions {
    fn default() -> Self {
        Self {
            levels: 4,
            fewer: false,
            factor: 2,
            candidates: 40,
            coarse: 13,
            most: 40,
            search: SelectionOrder::Forward,
            prior: 1.0,
            marginals: true,
            color: None,
        }
    }
}

impl ModelOptions {
    /// The memory of fitting a model to `planes` of `size`: scores, components, pyramid; for each level the
    /// expanded coarser one, and double precision for the products, twice where the finest is fitted both
    /// with a coarser one and without.
    pub fn bytes(&self, size: Size, planes: usize) -> u64 {
        let bytes: u64 = if self.fewer { 96 } else { 56 };
        bytes.saturating_mul((size.texels() * planes) as u64)
    }

    /// Checks the range of every number.
    pub fn validate(&self) -> Result<()> {
        let ranges = [
            ("levels", self.levels, 1, 16),
            ("factor", self.factor, 2, 16),
            ("candidates", self.candidates, 0, 400),
            ("coarse neighbours", self.coarse, 0, 100),
            ("neighbours of a level", self.most, 0, 500),
        ];
        for (name, value, least, most) in ranges {
            if !(least..=most).contains(&value) {
                return Err(Error::usage(format!(
                    "{value} {name}: expected a number from {least} to {most}"
                )));
            }
        }
        if !(1e-6..=1e9).contains(&self.prior) {
            return Err(Error::usage(format!(
                "a prior worth {} texels: expected a number from 0.000001 to 1,000,000,000",
                self.prior
            )));
        }
        Ok(())
    }
}

/// How the neighbours of a level were chosen.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct LevelReport {
    /// Columns of the level.
    pub width: usize,
    /// Rows of the level.
    pub height: usize,
    /// Sizes and log evidences of the sets examined, the most probable first.
    pub path: Vec<(usize, f64)>,
    /// The number of sets more probable than the chosen one, but unstable whatever the prior.
    pub unstable: usize,
    /// The weight of the prior in texels: more than requested where less left the level unstable.
    pub prior: f64,
    /// The share of the variance of the band that its neighbours predict, averaged over components.
    pub predicted: f64,
    /// The largest bound of a spectral radius.
    pub radius: f64,
}

/// A plane with less than this share of its variance left by earlier ones has no component.
const LEAST_SHARE: f64 = 1e-4;

/// Fits a model to planes.
///
/// # Errors
/// Options out of range; planes that are not finite, are constant, or are smaller than the neighbourhood;
/// more memory than the limits allow.
pub fn estimate(planes: &Planes, options: &ModelOptions, job: &Job) -> Result<(Model, Vec<LevelReport>)> {
    let scored = Scored::of(planes, options, job)?;
    let (mut model, reports) = completed(scored, None, &vec![1.0; planes.count()], options, job)?;
    // Scores of a detail that is uneven are not normal.
    if options.marginals && model.has_local_detail() {
        let axes = options.color.map(|first| in_axes(planes.clone(), first));
        let (marginals, color) =
            matched(axes.as_ref().unwrap_or(planes), options.color, &model, Size::new(1, 1), job)?;
        let varying = model.marginals.iter_mut().zip(marginals).filter(|(found, _)| !found.is_constant());
        varying.for_each(|(found, matched)| *found = matched);
        model.color = color;
    }
    Ok((model, reports))
}

/// Planes prepared for modelling.
pub(super) struct Scored {
    pub(super) marginals: Vec<Marginal>,
    pub(super) color: Option<JointColor>,
    pub(super) mixing: Mixing,
    /// The input of the random fields.
    pub(super) components: Planes,
}

impl Scored {
    pub(super) fn of(planes: &Planes, options: &ModelOptions, job: &Job) -> Result<Self> {
        options.validate()?;
        job.check_bytes("the planes to model", options.bytes(planes.size(), planes.count()))?;
        if let Some(k) = (0..planes.count()).find(|&k| planes.plane(k).iter().any(|v| !v.is_finite())) {
            return Err(Error::invalid(format!("plane {k} holds values that are not finite")));
        }
        if options.color.is_some_and(|first| first + 3 > planes.count()) {
            return Err(Error::usage(format!("{} planes do not hold the colour to model", planes.count())));
        }
        let (marginals, color, scores) = normalised(planes, options);
        let mixing = Mixing::of(&scores, LEAST_SHARE);
        if mixing.components() == 0 {
            return Err(Error::invalid(
                "the texture is the same everywhere: a random field needs values that vary",
            ));
        }
        Ok(Self { marginals, color, components: mixing.components_of(&scores), mixing })
    }
}

/// The distribution of each plane, that of a colour, and the scores minus their mean.
fn normalised(planes: &Planes, options: &ModelOptions) -> (Vec<Marginal>, Option<JointColor>, Planes) {
    let texels = planes.size().texels();
    let color = options.color.filter(|_| options.marginals);
    let single: Vec<usize> = outside(color, planes.count()).collect();
    let marginal = |&k: &usize| match options.marginals {
        true => Marginal::curve(planes.plane(k)),
        false => Marginal::normal(planes.plane(k)),
    };
    let marginals: Vec<Marginal> = parallel::map(single.iter(), marginal);
    let mut scores = match color {
        Some(first) => in_axes(planes.clone(), first),
        None => planes.clone(),
    };
    for (marginal, k) in marginals.iter().zip(single) {
        score(scores.plane_mut(k), marginal);
    }
    let color = color.map(|first| JointColor::scored(&mut scores, first));
    parallel::for_each(scores.as_mut_slice().chunks_exact_mut(texels), |plane| {
        let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / texels as f64;
        plane.iter_mut().for_each(|v| *v -= mean as f32);
    });
    (marginals, color, scores)
}

/// The numbers of the planes that do not belong to a colour.
pub(super) fn outside(color: Option<usize>, planes: usize) -> impl Iterator<Item = usize> {
    (0..planes).filter(move |k| color.is_none_or(|first| !(first..first + 3).contains(k)))
}

/// The scores of planes with these distributions; 0 for constant planes.
pub(super) fn scores_of(planes: &Planes, marginals: &[Marginal]) -> Planes {
    let mut scores = planes.clone();
    scores.iter_mut().zip(marginals).for_each(|(plane, marginal)| score(plane, marginal));
    scores
}

/// Scores instead of values; 0 for constant planes.
pub(super) fn score(plane: &mut [f32], marginal: &Marginal) {
    if marginal.is_constant() {
        return plane.fill(0.0);
    }
    let score = marginal.scores();
    parallel::for_each_value(plane, |_, v| *v = score(*v));
}

/// The model of level `k` of a Gaussian pyramid; `structure` is that level of the pyramid of what the planes are added to.
pub(super) fn level(
    gaussian: &[Planes],
    k: usize,
    structure: Option<&Planes>,
    kernel: &Kernel,
    options: &ModelOptions,
    job: &Job,
) -> Result<(Level, LevelReport)> {
    let expanded = gaussian.get(k + 1).map(|coarse| pyramid::expand(coarse, kernel, gaussian[k].size()));
    let mut band = gaussian[k].clone();
    if let Some(expanded) = &expanded {
        pyramid::subtract(&mut band, expanded);
    }
    let known = match (expanded, structure) {
        (Some(mut expanded), Some(structure)) => {
            pyramid::add(&mut expanded, structure);
            Some(Cow::Owned(expanded))
        }
        (Some(expanded), None) => Some(Cow::Owned(expanded)),
        (None, structure) => structure.map(Cow::Borrowed),
    };
    let gain = known.as_deref().filter(|_| options.marginals).and_then(|known| LocalGain::of(&band, known));
    if let (Some(gain), Some(known)) = (&gain, &known) {
        gain.divide(&mut band, known);
    }
    let candidates = NeighbourCandidates::of(band.size(), k, known.is_some(), options);
    let stack = match &known {
        Some(known) if !candidates.coarse.is_empty() => band.followed_by(known).expect("stacks of one size"),
        _ => band,
    };
    let m = gaussian[k].count();
    let statistics = candidates.statistics(&stack, m, job)?;
    let prior = statistics.prior(options.prior);
    let choices = search(&statistics, &prior, options.search, options.most, job)?;
    for (unstable, choice) in choices.iter().enumerate() {
        let fitted = candidates.shrunk_until_stable(choice, &statistics, options.prior, job)?;
        let Some(StableFit { level, radius, prior, posterior }) = fitted else { continue };
        let report = LevelReport {
            width: gaussian[k].size().width,
            height: gaussian[k].size().height,
            path: choices.iter().map(|c| (c.candidates.len(), c.log_evidence)).collect(),
            unstable,
            prior,
            predicted: predicted(&posterior, &statistics),
            radius,
        };
        return Ok((Level { gain, unevenness: uneven(&level, &stack, options), ..level }, report));
    }
    Err(Error::invalid(format!("no model of level {k} is stable, not even noise without neighbours")))
}

/// How uneven the noise of a level is.
fn uneven(level: &Level, stack: &Planes, options: &ModelOptions) -> u8 {
    if options.marginals { unevenness::of(&innovations(level, stack)) } else { 0 }
}

/// The mean over planes of the share of variance predicted.
fn predicted(posterior: &Posterior, statistics: &SufficientStatistics) -> f64 {
    let d = statistics.planes;
    let left = |j: usize| posterior.scatter[(j, j)] / statistics.products[(j, j)].max(f64::MIN_POSITIVE);
    1.0 - (0..d).map(left).sum::<f64>() / d as f64
}
