//! Fields under moving light as a model for each of some light directions, all driven by the same noise.
//!
//! This is the way of Haindl, Filip, Arnold (2004): a multispectral texture for each illumination, each with a
//! model of its own. Levels of the same number draw the same noise at the same place, and components are made in
//! the same order ([`super::mixing`]), so what the models make shows one surface under several lights. They make
//! pictures; the functions of light direction are fitted to these by least squares, texel by texel.
//!
//! The joint model of all index planes ([`super::field_model`]) is smaller, and its planes agree; a comparison is
//! in `docs/models.md`. Limits: pictures are colours or grey, without a structure of tiles.

use rayon::prelude::*;

use super::estimate::{LevelReport, ModelOptions, estimate};
use super::field_model::{FieldModel, Fields};
use super::model::{Model, RealisationOptions};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;
use crate::planes::Planes;

/// Light directions at most.
pub const MOST_LIGHTS: usize = 255;

/// Lights whose functions' values have a smaller ratio of pivots do not determine the functions.
const LEAST_PIVOT: f64 = 1e-3;

/// The model of a texture under one light.
#[derive(Debug, Clone, PartialEq)]
pub struct LightModel {
    /// The light's x and y, a place in the unit disk.
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

/// Fits a model to the `picture` of a field under each light: one plane for luminances, otherwise red, green and
/// blue. Reports of the models' levels come in the order of the lights.
///
/// # Errors
/// Lights that do not determine the functions of the field's basis; as [`estimate`](fn@estimate).
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
    let (mut models, mut reports) = (Vec::new(), Vec::new());
    for disk in disks {
        let (model, levels) = estimate(&picture(direction(disk)), options, job)?;
        models.push(LightModel { disk, model });
        reports.push(levels);
    }
    Ok((FieldModel::of(field, Fields::PerLight(models)), reports))
}

/// The functions' values, a row for each light.
fn values(disks: &[[f32; 2]], basis: &Basis) -> Matrix {
    let rows: Vec<Vec<f64>> = disks.iter().map(|&disk| basis.weights(direction(disk))).collect();
    Matrix::from_fn(disks.len(), basis.len(), |i, k| rows[i][k])
}

/// Whether functions of a basis are known from their values under these lights.
pub(super) fn determine(disks: &[[f32; 2]], basis: &Basis) -> bool {
    (basis.len()..=MOST_LIGHTS).contains(&disks.len())
        && Qr::new(&values(disks, basis)).pivot_ratio() > LEAST_PIVOT
}

/// The functions' coefficients over a part of the plane, channel after channel: those nearest to the pictures that
/// the models make.
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
        functions.as_mut_slice().par_chunks_exact_mut(texels).enumerate().for_each(|(p, function)| {
            let weight = inverse[(p % n, i)] as f32;
            function.iter_mut().zip(picture.plane(p / n)).for_each(|(f, value)| *f += weight * value);
        });
    }
    Ok(functions)
}
