//! The candidate neighbours of a level, and the stable fits among them.

use super::estimate::ModelOptions;
use super::level::{Level, Weights};
use super::neighbourhood::{Offset, Reach, all_around, causal};
use super::normal_wishart::{Posterior, SufficientStatistics};
use super::selection::{Selected, posterior};
use super::stability::{Stability, burn_in};
use super::statistics::{Regressor, inner_products, inside};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::Matrix;
use crate::planes::Planes;
use crate::size::Size;

/// The most doublings of the weight of a prior: to a million texels, which leave no weight to speak of.
const MOST_DOUBLINGS: u32 = 20;

/// A stable level, the bound of its spectral radius, the weight of its prior and its posterior.
pub(super) struct StableFit {
    pub level: Level,
    pub radius: f64,
    pub prior: f64,
    pub posterior: Posterior,
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
    pub(super) fn of(size: Size, number: usize, has_coarser: bool, options: &ModelOptions) -> Self {
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
    pub(super) fn shrunk_until_stable(
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
            gain: None,
            unevenness: 0,
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
