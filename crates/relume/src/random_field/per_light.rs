//! Fields under moving light as one model per light direction, all driven by the same noise.
//!
//! This is the method of Haindl, Filip, Arnold (2004): a multispectral texture for each illumination, each
//! with its own model. Levels of the same number draw the same noise at the same place, and components are
//! made in the same order ([`super::mixing`]), so the outputs show one surface under several lights. They are
//! pictures; the functions of light direction are fitted to them by least squares, texel by texel.
//!
//! The joint model of all index planes ([`super::field_model`]) is smaller, and its planes are consistent;
//! `docs/models.md` has a comparison. Limits: pictures are colour or grey, without a structure of tiles.

use super::estimate::{LevelReport, ModelOptions, estimate};
use super::field_model::{FieldModel, Fields};
use super::model::{Model, RealisationOptions};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;
use crate::parallel;
use crate::planes::Planes;

/// The most light directions.
pub const MOST_LIGHTS: usize = 255;

/// The least ratio of pivots of the values of the functions: below it, the lights do not determine the
/// functions.
const LEAST_PIVOT: f64 = 1e-3;

/// The model of a texture under one light.
#[derive(Debug, Clone, PartialEq)]
pub struct LightModel {
    /// The x and y of the light, a point in the unit disk.
    pub disk: [f32; 2],
    /// The random field of its colours.
    pub model: Model,
}

impl LightModel {
    /// The direction towards the light.
    pub fn light(&self) -> Direction {
        direction(self.disk)
    }
}

fn direction(disk: [f32; 2]) -> Direction {
    Direction::from_disk(f64::from(disk[0]), f64::from(disk[1]))
}

/// Fits a model to the `picture` of a field under each light: one plane for luminances, otherwise red, green
/// and blue. Reports on the levels of the models are in the order of the lights.
///
/// # Errors
/// Lights that do not determine the functions of the basis; as [`estimate`](fn@estimate).
pub fn model_lights(
    field: &ReflectanceField,
    lights: &[Direction],
    picture: &dyn Fn(Direction) -> Planes,
    options: &ModelOptions,
    job: &Job,
) -> Result<(FieldModel, Vec<Vec<LevelReport>>)> {
    let disks: Vec<[f32; 2]> = lights.iter().map(|light| [light.x() as f32, light.y() as f32]).collect();
    if !determine(&disks, field.basis()) {
        return Err(Error::usage(format!(
            "{} lights do not determine the {} functions of the basis {}: give as many or more, at most {MOST_LIGHTS}, \
             spread over the hemisphere",
            lights.len(),
            field.basis().len(),
            field.basis().name()
        )));
    }
    job.check("a picture to model", field.size(), 4 * field.layout().channels() as u64)?;
    let color = (field.layout().channels() == 3).then_some(0);
    let options = ModelOptions { color, ..*options };
    let (mut models, mut reports) = (Vec::new(), Vec::new());
    for disk in disks {
        let (model, levels) = estimate(&picture(direction(disk)), &options, job)?;
        models.push(LightModel { disk, model });
        reports.push(levels);
    }
    Ok((FieldModel::of(field, Fields::PerLight(models)), reports))
}

/// The values of the functions, one row per light.
fn values(disks: &[[f32; 2]], basis: &Basis) -> Matrix {
    let rows: Vec<Vec<f64>> = disks.iter().map(|&disk| basis.weights(direction(disk))).collect();
    Matrix::from_fn(disks.len(), basis.len(), |i, k| rows[i][k])
}

/// Whether the functions of a basis are determined by their values under these lights.
pub(super) fn determine(disks: &[[f32; 2]], basis: &Basis) -> bool {
    (basis.len()..=MOST_LIGHTS).contains(&disks.len())
        && Qr::new(&values(disks, basis)).pivot_ratio() > LEAST_PIVOT
}

/// The coefficients of the functions over a part of the plane, channel after channel: those nearest to the
/// pictures of the models.
///
/// # Errors
/// As [`Model::synthesize`].
pub(super) fn functions(
    lights: &[LightModel],
    basis: &Basis,
    options: &RealisationOptions,
    job: &Job,
) -> Result<Planes> {
    let disks: Vec<[f32; 2]> = lights.iter().map(|light| light.disk).collect();
    let inverse = Qr::new(&values(&disks, basis)).pseudo_inverse();
    let (n, channels) = (basis.len(), lights.first().map_or(0, |light| light.model.planes()));
    let mut functions = Planes::zeros_within(job, "the functions of the models", options.size, channels * n)?;
    let texels = options.size.texels();
    for (i, light) in lights.iter().enumerate() {
        let picture = light.model.synthesize(options, job)?;
        parallel::for_each(functions.as_mut_slice().chunks_exact_mut(texels).enumerate(), |(p, function)| {
            let weight = inverse[(p % n, i)] as f32;
            function.iter_mut().zip(picture.plane(p / n)).for_each(|(f, value)| *f += weight * value);
        });
    }
    Ok(functions)
}
