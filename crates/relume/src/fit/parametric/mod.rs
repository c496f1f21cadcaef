//! The parameters of a reflectance model for each texel, from photographs under light and view.
//!
//! - Lobes of light and view (Lafortune, Foo, Torrance, Greenberg, "Non-Linear Approximation of Reflectance Functions",
//!   SIGGRAPH 1997; fitted to each texel of a texture: D. K. McAllister, A. Lastra, W. Heidrich, "Efficient Rendering of
//!   Spatial Bi-directional Reflectance Distribution Functions", Graphics Hardware 2002).
//! - Functions of the light for each view: any basis, or lobes (J. Filip, M. Haindl, "Non-linear Reflectance Model for
//!   Bidirectional Texture Function Synthesis", ICPR 2004).
//! - A glossy dielectric on a tilted facet (GGX), as artists' programs have it.
//! - Products of a function of the view and one of the light: the matrix factorisation of each texel by itself.
//!
//! Models are of linear light, with the cosine at the light that photographs hold; what is minimised is the error of encoded
//! values, which is what is seen of it. Lobes and facets are found by the method of Levenberg and Marquardt, lobes from the
//! parameters of the mean of all texels, which is fitted from several starts, facets around the one that is typical of a sample
//! of texels. A texel of these is fitted to
//! [`ParametricOptions::pairs`] pairs spread evenly over all of them, so memory is bounded: photographs are read once for the
//! errors, and those of these pairs once for each band of texels. Functions of each view are fitted view by view, products to
//! all pairs.
//!
//! | file | content |
//! |---|---|
//! | `options` | what is fitted, and how |
//! | `encoded` | residuals of encoded values |
//! | `lobes`, `ggx` | the models with their derivatives |
//! | `typical` | the roughness and specular reflectance of a texture, around which texels are fitted |
//! | `texels` | the values of texels in bands |
//! | `per_view` | functions of the light for each view |
//! | `separable` | products of functions of the view and of the light |
//! | `linear` | the linear form that stages take |

mod encoded;
mod ggx;
mod linear;
mod lobes;
mod options;
mod per_view;
mod sampled;
mod separable;
mod texels;
mod typical;
mod typical_lobes;

pub use linear::{linear_form, linear_remark, remarked_linear_form};
pub use options::{FacetAim, ParametricForm, ParametricOptions};

use std::collections::BTreeSet;

use serde::Serialize;

use super::held_out::HeldOut;
use super::levels::SampleLevels;
use super::pair_errors::{Measurement, PairsReport, PolarReport};
use super::sample::Grid;
use super::stream::PhotographStream;
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::field::{ParametricField, SeparableModel, TexelModel, ViewFunction};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::{LoadRaster, Raster};
use crate::space::Space;
use encoded::TexelReflectance;
use ggx::GgxModel;
use lobes::LobeModel;
use options::LEAST_PAIRS;
use per_view::{ViewSet, mean_of};
use sampled::{SAMPLE_TEXELS, is_black, mean_of_texels, texel_values};
use separable::{PhotographGrid, TexelFactors};
use texels::{ChosenPhotographs, FromMean};
use typical_lobes::with_typical_lobes;

/// The most steps of the fit of a texel.
const STEPS: usize = 16;

/// The errors of a texture of reflectance models.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ParametricReport {
    /// The space of the compared values.
    pub space: Space,
    /// The kind of model.
    pub model: String,
    /// The numbers of a texel.
    pub numbers: usize,
    /// Pairs to which a texel was fitted.
    pub pairs_fitted: usize,
    /// Texels of the field.
    pub texels: usize,
    /// Texels compared, on a regular grid; all when equal to `texels`.
    pub texels_measured: usize,
    /// The photographs that took part.
    pub fitted: PairsReport,
    /// The photographs left out.
    pub held_out: Option<PairsReport>,
    /// All photographs by the polar angle of the view.
    pub by_view: Vec<PolarReport>,
    /// All photographs by the polar angle of the light.
    pub by_light: Vec<PolarReport>,
    /// The name of the photograph with the largest error.
    pub worst: String,
}

/// A texture of reflectance models, and its errors.
#[derive(Debug, Clone)]
pub struct ParametricFit {
    /// The result.
    pub field: ParametricField,
    /// Its errors.
    pub report: ParametricReport,
}

/// Fits a reflectance model to each texel: `pairs` names each photograph and its directions, and `load(i)` reads the i-th,
/// perhaps more than once. The result is the same at any number of threads.
///
/// # Errors
/// Options without meaning; too few photographs; lights of a view that do not determine the functions; errors of `load`,
/// photographs that differ in size or channels, samples that are not finite, and sizes beyond the limits of the job.
pub fn fit(
    pairs: &[(String, Directions)],
    load: &LoadRaster,
    options: &ParametricOptions,
    job: &Job,
) -> Result<ParametricFit> {
    options.validate()?;
    let directions: Vec<Directions> = pairs.iter().map(|(_, pair)| *pair).collect();
    let held_out = HeldOut::new(&directions, options.hold_out)?;
    let names = pairs.iter().map(|(name, _)| name.as_str()).collect();
    let stream = PhotographStream::open(names, load, |channels| 2 * channels, job)?;
    let grid = Grid::new(stream.size(), options.report_texels);
    let _sample = job.hold("the sample for the error report", stream.sample_bytes(&grid))?;
    let task = ParametricTask { pairs, stream: &stream, held_out: &held_out, grid: &grid, options };
    let (field, kept, pairs_fitted) = match &options.form {
        ParametricForm::PerView(function) => task.views(function, job)?,
        ParametricForm::Lafortune(lobes) => {
            let model = |pairs: &[Directions], sample: &[Vec<f32>]| {
                let model = LobeModel::of_pairs(stream.channels(), *lobes, pairs);
                with_typical_lobes(model, &mean_of_texels(sample), sample)
            };
            task.texels(TexelModel::Lafortune { lobes: *lobes }, model, job)?
        }
        ParametricForm::Ggx => {
            let model = |pairs: &[Directions], sample: &[Vec<f32>]| {
                GgxModel::new(stream.channels(), pairs, options.aim, sample)
            };
            task.texels(TexelModel::Ggx, model, job)?
        }
        ParametricForm::Separable(products, space) => task.separable(*products, *space, job)?,
    };
    let report = task.report(&field, &kept, pairs_fitted, job)?;
    Ok(ParametricFit { field, report })
}

/// At most `count` of `all` numbers, spread evenly by multiples of the golden section: steps of one length would meet the
/// number of lights of a view, and show few of them.
fn spread(all: usize, count: usize) -> BTreeSet<usize> {
    const GOLDEN: u64 = 0x9e37_79b9;
    let multiple = |i: u64| i.wrapping_mul(GOLDEN) & 0xffff_ffff;
    let mut chosen = BTreeSet::new();
    let numbers = (0..).map(|i| ((u128::from(multiple(i)) * all as u128) >> 32) as usize);
    for number in numbers {
        if chosen.len() >= count.min(all) {
            break;
        }
        chosen.insert(number);
    }
    chosen
}

/// What all fits need.
struct ParametricTask<'a> {
    pairs: &'a [(String, Directions)],
    stream: &'a PhotographStream<'a>,
    held_out: &'a HeldOut,
    grid: &'a Grid,
    options: &'a ParametricOptions,
}

/// A texture, the texels of the grid in all photographs, and the pairs to which a texel was fitted.
type FittedTexels = (ParametricField, Vec<Raster>, usize);

impl ParametricTask<'_> {
    fn planes(&self, model: &TexelModel, job: &Job) -> Result<Planes> {
        let count = model.numbers(self.stream.channels());
        Planes::zeros_within(job, "the numbers of the models", self.stream.size(), count)
    }

    fn views(&self, function: &ViewFunction, job: &Job) -> Result<FittedTexels> {
        let takes_part = |i: usize| !self.held_out.is_out(i);
        let set =
            ViewSet { stream: self.stream, pairs: self.pairs, takes_part: &takes_part, grid: self.grid };
        let model = TexelModel::PerView(set.model(function)?);
        let mut planes = self.planes(&model, job)?;
        let kept = set.fit(function, &mut planes, job)?;
        let field = ParametricField::new(model, self.stream.channels(), planes)?;
        Ok((field, kept, self.held_out.kept()))
    }

    /// Fits every texel by itself; `model` gets the pairs and the values of a sample of texels under them.
    fn texels<M: TexelReflectance>(
        &self,
        kind: TexelModel,
        model: impl Fn(&[Directions], &[Vec<f32>]) -> M,
        job: &Job,
    ) -> Result<FittedTexels> {
        let chosen = self.chosen()?;
        let directions: Vec<Directions> = chosen.iter().map(|&i| self.pairs[i].1).collect();
        let levels = SampleLevels::new(Space::Srgb);
        let mut planes = self.planes(&kind, job)?;
        let sample = Grid::new(self.stream.size(), SAMPLE_TEXELS);
        let values = 4 * (sample.texels() * self.stream.channels() * chosen.len()) as u64;
        let _sample = job.hold("the sample of texels", self.stream.sample_bytes(&sample) + values)?;
        let [kept, of_sample] = self.texels_of([self.grid, &sample], job)?;
        if kept.iter().chain(&of_sample).all(is_black) {
            return Err(Error::invalid("all photographs are black: there is no reflectance to fit"));
        }
        let of_sample = chosen.iter().map(|&i| &of_sample[i]).collect::<Vec<_>>();
        let model = model(&directions, &texel_values(&of_sample, &levels));
        let on_grid: Vec<Raster> = chosen.iter().map(|&i| kept[i].clone()).collect();
        let from = FromMean::new(&model, &mean_of(&on_grid, self.grid, &levels), STEPS);
        let photographs = ChosenPhotographs { stream: self.stream, levels: &levels, chosen: &chosen };
        photographs.fit_bands(&mut planes, &|observed| from.fit(observed), job)?;
        let field = ParametricField::new(kind, self.stream.channels(), planes)?;
        Ok((field, kept, chosen.len()))
    }

    /// Factors the values of every texel by itself.
    fn separable(&self, products: usize, space: Space, job: &Job) -> Result<FittedTexels> {
        let photographs = PhotographGrid::new(&self.taking_part(), |i| self.pairs[i].1)?;
        let model = SeparableModel::new(&photographs.views, &photographs.lights, products, space)?;
        let factors = TexelFactors::new(&photographs, self.stream.channels(), products);
        let kind = TexelModel::Separable(model);
        let mut planes = self.planes(&kind, job)?;
        let [kept] = self.texels_of([self.grid], job)?;
        let chosen = ChosenPhotographs {
            stream: self.stream,
            levels: &SampleLevels::new(space),
            chosen: &photographs.photographs,
        };
        chosen.fit_bands(&mut planes, &|values| factors.fit(values), job)?;
        let field = ParametricField::new(kind, self.stream.channels(), planes)?;
        Ok((field, kept, photographs.photographs.len()))
    }

    /// The texels of some grids in every photograph.
    fn texels_of<const N: usize>(&self, grids: [&Grid; N], job: &Job) -> Result<[Vec<Raster>; N]> {
        job.start("reading photographs", self.stream.len() as u64);
        let mut kept = grids.map(|_| Vec::with_capacity(self.stream.len()));
        self.stream.for_each_batch(job, |_, batch| {
            for (grid, kept) in grids.iter().zip(&mut kept) {
                kept.extend(parallel::map(batch.iter(), |photograph| grid.raster(photograph)));
            }
            job.advance(batch.len() as u64)
        })?;
        Ok(kept)
    }

    /// The numbers of the photographs that take part.
    fn taking_part(&self) -> Vec<usize> {
        (0..self.pairs.len()).filter(|i| !self.held_out.is_out(*i)).collect()
    }

    /// The numbers of the photographs to which lobes and facets are fitted.
    fn chosen(&self) -> Result<Vec<usize>> {
        let kept = self.taking_part();
        if kept.len() < LEAST_PAIRS {
            return Err(Error::usage(format!(
                "{} photographs do not determine a reflectance model: at least {LEAST_PAIRS} are needed",
                kept.len()
            )));
        }
        Ok(spread(kept.len(), self.options.pairs).into_iter().map(|i| kept[i]).collect())
    }

    fn report(
        &self,
        field: &ParametricField,
        kept: &[Raster],
        pairs_fitted: usize,
        job: &Job,
    ) -> Result<ParametricReport> {
        let levels = SampleLevels::new(Space::Srgb);
        let measured =
            Measurement { pairs: self.pairs, grid: self.grid, levels: &levels, held_out: self.held_out };
        let on_grid = field.with_planes(self.grid.planes(field.planes()))?;
        let predict = |i: usize, out: &mut [f64]| {
            let picture = on_grid.picture(self.pairs[i].1, job)?.to_space(Space::Srgb);
            out.iter_mut().zip(picture.planes.as_slice()).for_each(|(o, v)| *o = f64::from(*v));
            Ok(())
        };
        let errors = measured.errors(kept, &predict, job)?;
        Ok(ParametricReport {
            space: Space::Srgb,
            model: field.model().name(),
            numbers: field.planes().count(),
            pairs_fitted,
            texels: self.grid.full_texels(),
            texels_measured: self.grid.texels(),
            fitted: errors.fitted,
            held_out: errors.held_out,
            by_view: errors.by_view,
            by_light: errors.by_light,
            worst: errors.worst,
        })
    }
}

#[cfg(test)]
mod tests;
