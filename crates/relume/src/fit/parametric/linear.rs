//! The linear form of a texture of reflectance models: functions learned from its pictures (docs/decisions/0013).

use crate::capture::dome::sampling::all_pairs;
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::{ParametricField, ReflectanceField, TexelModel};
use crate::fit::learned::{self, LearnedOptions, Rank};
use crate::job::Job;
use crate::raster::{Raster, Samples};
use crate::space::Space;

/// Functions of the linear form.
const FUNCTIONS: usize = 32;

/// Rings of the directions at which models are evaluated: degrees from the zenith and azimuths.
const RINGS: [(f64, u32); 5] = [(0.0, 1), (22.5, 8), (45.0, 12), (62.5, 14), (77.5, 14)];

/// A texture of learned functions that is nearly that of the models, and by how much it differs from it: a root mean square
/// of encoded values with white at 1, over the pairs at which it was learned.
///
/// # Errors
/// Limits exceeded, and a cancelled job.
pub fn linear_form(field: &ParametricField, job: &Job) -> Result<(ReflectanceField, f64)> {
    let rings = rings();
    let few = |own: &[Direction]| match own.len() <= 2 * rings.len() {
        true => own.to_vec(),
        false => rings.clone(),
    };
    let (views, lights) = match field.model() {
        TexelModel::PerView(model) => (few(model.views()), rings.clone()),
        TexelModel::Separable(model) => (few(model.views()), few(model.lights())),
        TexelModel::Lafortune { .. } | TexelModel::Ggx => (rings.clone(), rings.clone()),
    };
    let pairs: Vec<(String, Directions)> = all_pairs(&lights, &views)
        .into_iter()
        .enumerate()
        .map(|(i, pair)| (format!("picture {i}"), pair))
        .collect();
    let most = field.size().texels().min(pairs.len() * field.channels());
    let options = LearnedOptions {
        rank: Rank::Functions(FUNCTIONS.min(most)),
        report_texels: 1,
        ..LearnedOptions::default()
    };
    let load = |i: usize| picture(field, pairs[i].1, job);
    let fit = learned::fit(&pairs, &load, &options, &job.unheard())?;
    Ok((fit.field, fit.report.error.rmse))
}

/// The linear form, with a remark on its error.
///
/// # Errors
/// As [`linear_form`].
pub fn remarked_linear_form(models: &ParametricField, job: &Job) -> Result<ReflectanceField> {
    let (field, rmse) = linear_form(models, job)?;
    job.remark(linear_remark(models, &field, rmse));
    Ok(field)
}

/// What is to be said where the linear form stands for the models, from which it differs by `rmse`.
pub fn linear_remark(models: &ParametricField, linear: &ReflectanceField, rmse: f64) -> String {
    format!(
        "the texture of the reflectance model {} is taken as {} learned functions, which differ from it by {:.2} of 255 (root \
         mean square)",
        models.model().name(),
        linear.basis().len(),
        255.0 * rmse
    )
}

/// The directions at which models are evaluated.
fn rings() -> Vec<Direction> {
    let ring = |&(polar, count): &(f64, u32)| {
        (0..count).map(move |k| {
            Direction::from_angles(
                polar.to_radians(),
                std::f64::consts::TAU * f64::from(k) / f64::from(count),
            )
        })
    };
    RINGS.iter().flat_map(ring).collect()
}

/// The picture of a model as a photograph of linear values from 0 to 1.
fn picture(field: &ParametricField, pair: Directions, job: &Job) -> Result<Raster> {
    let picture = field.picture(pair, job)?.to_space(Space::Linear);
    let channels = picture.planes.count();
    let samples = (0..field.size().texels() * channels)
        .map(|i| picture.planes.plane(i % channels)[i / channels].clamp(0.0, 1.0));
    Raster::new(field.size(), channels, Samples::F32(samples.collect()))
}
