//! From planes to a model.

use rayon::prelude::*;
use serde::Serialize;

use super::joint_color::{JointColor, in_axes};
use super::level::{Level, Weights};
use super::levels::completed;
use super::marginal::Marginal;
use super::mixing::Mixing;
use super::model::Model;
use super::neighbourhood::{Offset, Reach, all_around, causal};
use super::normal_wishart::{Posterior, SufficientStatistics};
use super::selection::{Selected, SelectionOrder, posterior, search};
use super::stability::{Stability, burn_in};
use super::statistics::{Regressor, inner_products, inside};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::Matrix;
use crate::numeric::pyramid::{self, Kernel};
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

/// The most doublings of the weight of a prior: to a million texels, which leave no weight to speak of.
const MOST_DOUBLINGS: u32 = 20;

/// Fits a model to planes.
///
/// # Errors
/// Options out of range; planes that are not finite, are constant, or are smaller than the neighbourhood;
/// more memory than the limits allow.
pub fn estimate(planes: &Planes, options: &ModelOptions, job: &Job) -> Result<(Model, Vec<LevelReport>)> {
    let scored = Scored::of(planes, options, job)?;
    completed(scored, None, &vec![1.0; planes.count()], options, job)
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
    let marginals: Vec<Marginal> = single.par_iter().map(marginal).collect();
    let mut scores = match color {
        Some(first) => in_axes(planes.clone(), first),
        None => planes.clone(),
    };
    for (marginal, k) in marginals.iter().zip(single) {
        score(scores.plane_mut(k), marginal);
    }
    let color = color.map(|first| JointColor::scored(&mut scores, first));
    scores.as_mut_slice().par_chunks_exact_mut(texels).for_each(|plane| {
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
    plane.par_iter_mut().for_each(|v| *v = score(*v));
}

/// The model of level `k` of a Gaussian pyramid.
pub(super) fn level(
    gaussian: &[Planes],
    k: usize,
    kernel: &Kernel,
    options: &ModelOptions,
    job: &Job,
) -> Result<(Level, LevelReport)> {
    let expanded = gaussian.get(k + 1).map(|coarse| pyramid::expand(coarse, kernel, gaussian[k].size()));
    let mut band = gaussian[k].clone();
    if let Some(expanded) = &expanded {
        pyramid::subtract(&mut band, expanded);
    }
    let candidates = NeighbourCandidates::of(band.size(), k, expanded.is_some(), options);
    let stack = match &expanded {
        Some(expanded) if !candidates.coarse.is_empty() => stacked(&band, expanded),
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
        return Ok((level, report));
    }
    Err(Error::invalid(format!("no model of level {k} is stable, not even noise without neighbours")))
}

/// A stable level, the bound of its spectral radius, the weight of its prior and its posterior.
struct StableFit {
    level: Level,
    radius: f64,
    prior: f64,
    posterior: Posterior,
}

/// All planes of one stack and then of another.
fn stacked(first: &Planes, second: &Planes) -> Planes {
    let data = [first.as_slice(), second.as_slice()].concat();
    Planes::from_vec(first.size(), first.count() + second.count(), data).expect("stacks of one size")
}

/// The mean over planes of the share of variance predicted.
fn predicted(posterior: &Posterior, statistics: &SufficientStatistics) -> f64 {
    let d = statistics.planes;
    let left = |j: usize| posterior.scatter[(j, j)] / statistics.products[(j, j)].max(f64::MIN_POSITIVE);
    1.0 - (0..d).map(left).sum::<f64>() / d as f64
}

/// The candidate neighbours of a level: causal ones first.
#[derive(Debug, Clone, PartialEq)]
pub struct NeighbourCandidates {
    /// In the level itself.
    pub near: Vec<Offset>,
    /// In the expanded coarser level.
    pub coarse: Vec<Offset>,
}

impl NeighbourCandidates {
    fn of(size: Size, number: usize, has_coarser: bool, options: &ModelOptions) -> Self {
        // Coarse levels may be too small for far neighbours; the texture itself may not.
        let reach = if number == 0 { usize::MAX } else { size.width.min(size.height) / 6 };
        let near_enough = |o: &Offset| (o.square() as f64) <= (reach as f64).powi(2);
        let coarse = if has_coarser { options.coarse } else { 0 };
        Self {
            near: causal(options.candidates).into_iter().filter(near_enough).collect(),
            coarse: all_around(coarse).into_iter().filter(near_enough).collect(),
        }
    }

    /// The inner products of the first `m` planes with the planes of all candidates, over the same texels for
    /// every candidate.
    ///
    /// # Errors
    /// When the planes are smaller than the reach of the candidates.
    pub fn statistics(&self, stack: &Planes, m: usize, job: &Job) -> Result<SufficientStatistics> {
        let all: Vec<Offset> = self.near.iter().chain(&self.coarse).copied().collect();
        let window = inside(stack.size(), Reach::of(&all))?;
        let here = [Offset::new(0, 0)];
        let own = here
            .iter()
            .chain(&self.near)
            .flat_map(|&offset| (0..m).map(move |plane| Regressor { plane, offset }));
        let coarse =
            self.coarse.iter().flat_map(|&offset| (m..2 * m).map(move |plane| Regressor { plane, offset }));
        let regressors: Vec<Regressor> = own.chain(coarse).collect();
        let products = inner_products(stack, &regressors, window, job)?;
        Ok(SufficientStatistics { products, planes: m, texels: window.size.texels() })
    }

    /// The level of a choice, with a prior of the given weight, or of the least of its doublings that makes it
    /// stable; `None` if none does.
    ///
    /// A heavier prior adds white noise to the statistics: it takes the sharpest resonances, which are those
    /// that make a fit unstable, and leaves the rest of the spectrum. Of the alternatives in `docs/models.md`
    /// it kept the most.
    fn shrunk_until_stable(
        &self,
        choice: &Selected,
        statistics: &SufficientStatistics,
        weight: f64,
        job: &Job,
    ) -> Result<Option<StableFit>> {
        for doubling in 0..=MOST_DOUBLINGS {
            job.proceed()?;
            let weight = weight * f64::from(1 << doubling);
            let posterior = posterior(statistics, &statistics.prior(weight), &choice.candidates)?;
            if let Some((level, radius)) = self.stable_level(choice, &posterior, statistics)? {
                return Ok(Some(StableFit { level, radius, prior: weight, posterior }));
            }
        }
        Ok(None)
    }

    /// The level of a choice, rounded as it will be stored, and the bound of its spectral radius; `None` if
    /// it is unstable.
    fn stable_level(
        &self,
        choice: &Selected,
        posterior: &Posterior,
        statistics: &SufficientStatistics,
    ) -> Result<Option<(Level, f64)>> {
        let m = statistics.planes;
        // Causal neighbours first, each set in the order of the candidates.
        let mut order: Vec<usize> = (0..choice.candidates.len()).collect();
        order.sort_unstable_by_key(|&c| choice.candidates[c]);
        let chosen = |c: &usize| choice.candidates[*c];
        let weights: Vec<f64> = order
            .iter()
            .flat_map(|c| (0..m * m).map(move |e| posterior.weights[(c * m + e / m, e % m)]))
            .collect();
        let near: Vec<usize> = order.iter().map(chosen).filter(|&c| c < self.near.len()).collect();
        let far = order.iter().map(chosen).filter(|&c| c >= self.near.len());
        let covariance = posterior.noise_covariance();
        let (rows, columns) = self.steps(statistics, &covariance)?;
        let mut level = Level {
            neighbours: near.iter().map(|&c| self.near[c]).collect(),
            coarse: far.map(|c| self.coarse[c - self.near.len()]).collect(),
            weights: Weights::nearest(&weights, near.len(), rows, columns),
            noise: lower_triangle(&covariance.cholesky()?),
            burn_in: 0,
            log_evidence: choice.log_evidence as f32,
            texels: u32::try_from(statistics.texels).unwrap_or(u32::MAX),
        };
        let stability = Stability::of(&level);
        if !stability.is_stable() {
            return Ok(None);
        }
        let Some(texels) = burn_in(&level) else { return Ok(None) };
        level.burn_in = texels;
        Ok(Some((level, stability.left.max(stability.rows))))
    }

    /// Steps that round each weight to sqrt(12) of its standard error given all others, where bits
    /// spent on precision balance bits lost in likelihood (Wallace and Freeman, "Estimation and
    /// Inference by Compact Coding", J. Royal Statistical Society B 49, 1987): sqrt(12 / (V_ii P_jj)),
    /// P = Sigma^-1.
    fn steps(&self, statistics: &SufficientStatistics, covariance: &Matrix) -> Result<(Vec<f32>, Vec<f32>)> {
        let m = statistics.planes;
        let root = covariance.cholesky()?.lower_inverse();
        let precision = |j: usize| (0..m).map(|i| root[(i, j)].powi(2)).sum::<f64>();
        let storable = |v: f64| half::f16::from_f64(v.clamp(1e-4, 3e4)).to_f32();
        let row =
            |regressor: usize| storable(1.0 / statistics.products[(regressor, regressor)].max(1e-8).sqrt());
        // Without coarse neighbours their steps have no meaning: use those of the planes of the level itself.
        let first = if self.coarse.is_empty() { 0 } else { m * (1 + self.near.len()) };
        let rows = (0..m).map(row).chain((first..first + m).map(row)).collect();
        let columns = (0..m).map(|j| storable((12.0 / precision(j)).sqrt())).collect();
        Ok((rows, columns))
    }
}

/// The entries of a lower triangular matrix, row by row.
fn lower_triangle(factor: &Matrix) -> Vec<f32> {
    (0..factor.rows()).flat_map(|i| (0..=i).map(move |j| factor[(i, j)] as f32)).collect()
}
