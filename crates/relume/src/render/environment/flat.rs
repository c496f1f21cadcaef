//! The texture itself under an environment, as `relight` shows it under a light: one frame,
//! so one set of weights for the whole picture.

use super::super::material::linear;
use super::super::vector::Vec3;
use super::Environment;
use super::cells::{LightCell, cells};
use super::frames::{TangentFrame, moments_of};
use super::hemisphere::HorizonEdge;
use super::moved;
use super::prefiltered::{EnvironmentResponse, TexelValues};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::job::Job;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::space::Space;

/// Lights that stand for the environment.
pub(super) const CELLS: usize = 8192;
/// Texels of one task.
const TASK: usize = 4096;

/// The linear picture of a field under an environment, seen from straight above: three planes, for luminance as well.
/// The texture lies in the world as a picture does: x right, y up, facing +z. Light from below its horizon is left out,
/// without a fade. The weights of linear functions are sums over the map, as one integral for all texels; encoded
/// functions are decoded at the nodes of a rule. Boundaries that move between the lights are added.
///
/// # Errors
/// Channels that form no colour, limits exceeded, a cancelled job.
pub fn relight_under(field: &ReflectanceField, environment: &Environment, job: &Job) -> Result<Picture> {
    if field.layout().is_named() {
        return Err(Error::usage(format!(
            "a texture of the channels {} has no colour to light: choose red, green and blue, or one",
            field.layout().channel_names().join(", ")
        )));
    }
    let lights = cells(environment, CELLS);
    let (response, weights) = weights(field, &lights, job)?;
    let mut planes = Planes::zeros_within(job, "the picture under the environment", field.size(), 3)?;
    let (n, layout) = (field.basis().len(), field.layout());
    let (coefficients, plain) = (field.coefficients(), linear(layout));
    parallel::try_for_each(planes.bands_mut(TASK).into_iter().enumerate(), |(band, mut out)| {
        let (mut own, mut room) = (vec![0.0; plain.planes(n)], Vec::new());
        for i in 0..out[0].len() {
            let texel = band * TASK + i;
            for (k, value) in own.iter_mut().enumerate() {
                let function = coefficients.plane(layout.function_plane(k / n, n) + k % n)[texel];
                let color = layout.color_plane(k / n, n);
                *value = color.map_or(function, |color| function * coefficients.plane(color)[texel]);
            }
            let values = TexelValues { layout: &plain, functions: n, values: &own };
            let color = response.color(&weights, &values, Direction::ZENITH, &mut room);
            (0..3).for_each(|c| out[c][i] = color[c] as f32);
        }
        job.proceed()
    })?;
    moved::add(field, environment, &mut planes, job)?;
    Ok(Picture { planes, space: Space::Linear })
}

/// The weights of the picture's colours for the coefficients of a texel, or for its values at nodes.
fn weights(
    field: &ReflectanceField,
    lights: &[LightCell],
    job: &Job,
) -> Result<(EnvironmentResponse, Vec<[f32; 3]>)> {
    let (space, response) =
        EnvironmentResponse::of_basis(field.basis(), field.space(), HorizonEdge::Sharp, job)?;
    if field.space() == Space::Linear {
        return Ok((response, integrals(field.basis(), lights)));
    }
    let frame = TangentFrame {
        tangent: Vec3::new(1.0, 0.0, 0.0),
        bitangent: Vec3::new(0.0, 1.0, 0.0),
        normal: Vec3::new(0.0, 0.0, 1.0),
    };
    let moments: Vec<f32> = moments_of(&space, lights, &frame).into_iter().map(|m| m as f32).collect();
    let mut weights = Vec::new();
    response.weights_into(&moments, Direction::ZENITH, &mut Vec::new(), &mut weights);
    Ok((response, weights))
}

/// 1/pi ∫ b_k(l) L(l) dl for each function and colour.
fn integrals(basis: &Basis, lights: &[LightCell]) -> Vec<[f32; 3]> {
    let count = basis.channels() * basis.len();
    let mut values = vec![0.0; count];
    let mut sums = vec![[0.0; 3]; count];
    for LightCell { direction, power, .. } in lights.iter().filter(|light| light.direction.z > 0.0) {
        let light = Direction::from_disk(direction.x, direction.y);
        basis.weights_into(Directions::lit_from(light), &mut values);
        for (sum, value) in sums.iter_mut().zip(&values) {
            (0..3).for_each(|c| sum[c] += value * power[c] / std::f64::consts::PI);
        }
    }
    sums.into_iter().map(|sum| sum.map(|v| v as f32)).collect()
}
