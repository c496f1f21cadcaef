//! Reflectance models as functions of light, fitted to what the models show from straight above; and what a texture in another
//! form loses of what it showed.

use std::borrow::Cow;

use super::convert::{CHECKED_LIGHTS, ConvertOptions, RefitLoss, SAMPLED_LIGHTS, arranged};
use crate::direction::{Direction, Directions};
use crate::error::{Error, Result};
use crate::field::{ParametricField, PlaneLayout, ReflectanceField};
use crate::fit::parametric::remarked_linear_form;
use crate::job::Job;
use crate::numeric::Matrix;
use crate::numeric::matrix::Qr;
use crate::parallel;
use crate::picture::Picture;
use crate::planes::Planes;
use crate::render::ShownForm;

/// The views at which a loss is measured take so many steps through the directions where the lights take one.
const VIEW_STEP: usize = 24;

/// Models as a texture of functions: of those that `options` name, which are of the light, fitted under many lights to what is seen
/// from straight above; without any, the learned functions of the linear form.
///
/// # Errors
/// A basis with data of its own, another space without a basis, colours that the models do not have, limits exceeded, and a
/// cancelled job.
pub fn convert_models(
    models: &ParametricField,
    options: &ConvertOptions,
    job: &Job,
) -> Result<ReflectanceField> {
    let made = match (&options.basis, options.space) {
        (Some(_), _) => seen_from_above(models, options, job)?,
        (None, None) => remarked_linear_form(models, job)?,
        (None, Some(space)) => {
            return Err(Error::usage(format!(
                "the values of the reflectance model {} are not converted to {space} ones: name functions of light, such as \
                 --basis hsh9",
                models.model().name()
            )));
        }
    };
    arranged(Cow::Owned(made), options.layout.as_ref(), job).map(Cow::into_owned)
}

/// Least squares under lights spread evenly, in the space asked for.
fn seen_from_above(
    models: &ParametricField,
    options: &ConvertOptions,
    job: &Job,
) -> Result<ReflectanceField> {
    let basis = options.basis.as_ref().filter(|basis| basis.channels() == 1 && !basis.depends_on_view());
    let basis =
        basis.ok_or_else(|| Error::usage("reflectance models are fitted by functions of the light"))?;
    let space = options.space.unwrap_or(models.model().space());
    job.remark("reflectance models depend on the view: they are taken as seen from straight above");
    let light = Direction::fibonacci(SAMPLED_LIGHTS);
    let mut design = Matrix::zeros(SAMPLED_LIGHTS, basis.len());
    for i in 0..SAMPLED_LIGHTS {
        basis.weights_into(Directions::lit_from(light(i)), design.row_mut(i));
    }
    let inverse = Qr::new(&design).pseudo_inverse();
    let (m, channels) = (basis.len(), models.channels());
    let mut planes = Planes::zeros_within(job, "the converted texture", models.size(), channels * m)?;
    for i in 0..SAMPLED_LIGHTS {
        let picture = models.picture(light(i), job)?.to_space(space);
        for (k, plane) in planes.iter_mut().enumerate() {
            let weight = inverse[(k % m, i)] as f32;
            plane.iter_mut().zip(picture.planes.plane(k / m)).for_each(|(out, v)| *out += weight * v);
        }
    }
    let layout = if channels == 1 { PlaneLayout::LUMINANCE } else { PlaneLayout::RGB };
    ReflectanceField::new(basis.clone(), layout, space, planes)
}

/// The differences between the pictures of two textures of one size, in the space of the second, over lights spread evenly; where
/// both depend on the view, each under another view.
///
/// # Errors
/// Limits exceeded, and a cancelled job.
pub fn shown_loss<'a>(
    from: impl Into<ShownForm<'a>>,
    made: impl Into<ShownForm<'a>>,
    job: &Job,
) -> Result<RefitLoss> {
    let (from, made) = (from.into(), made.into());
    let turns = from.depends_on_view() && made.depends_on_view();
    let (from, made) = (from.pictures(job)?, made.pictures(job)?);
    let direction = Direction::fibonacci(CHECKED_LIGHTS);
    let of_light = |i: usize| {
        let view = if turns { direction(i * VIEW_STEP % CHECKED_LIGHTS) } else { Direction::ZENITH };
        let pair = Directions { light: direction(i), view };
        let made = made.picture(pair, job)?;
        let from = from.picture(pair, job)?.to_space(made.space);
        let channels = from.planes.count().max(made.planes.count());
        let (mut squares, mut largest, mut count) = (0.0, 0.0f64, 0usize);
        for c in 0..channels {
            let plane = |picture: &Picture| c.min(picture.planes.count() - 1);
            let (from_plane, made_plane) = (from.planes.plane(plane(&from)), made.planes.plane(plane(&made)));
            for (a, b) in from_plane.iter().zip(made_plane) {
                let error = f64::from(*b) - f64::from(*a);
                (squares, largest, count) = (squares + error * error, largest.max(error.abs()), count + 1);
            }
        }
        Ok((squares, largest, count))
    };
    let all: Vec<(f64, f64, usize)> = parallel::try_map(0..CHECKED_LIGHTS, of_light)?;
    Ok(RefitLoss::of(all))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Basis;
    use crate::field::parametric::examples::all;
    use crate::space::Space;

    #[test]
    fn functions_of_single_views_come_back_as_those_seen_from_above() {
        let job = Job::default();
        for models in all() {
            let Some(above) = models.from_above(&job).unwrap() else { continue };
            let options = ConvertOptions { basis: Some(above.basis().clone()), ..ConvertOptions::default() };
            let made = convert_models(&models, &options, &job).unwrap();
            let pairs = made.coefficients().as_slice().iter().zip(above.coefficients().as_slice());
            assert!(pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-4));
            assert!(shown_loss(&above, &made, &job).unwrap().largest < 1e-4);
        }
    }

    #[test]
    fn the_loss_is_that_of_the_models_and_not_of_their_linear_form() {
        let job = Job::default();
        for models in all() {
            assert_eq!(shown_loss(&models, &models, &job).unwrap().largest, 0.0);
            let linear = convert_models(&models, &ConvertOptions::default(), &job).unwrap();
            assert!(shown_loss(&models, &linear, &job).unwrap().rms > 0.0, "{}", models.model().name());
            let ptm = ConvertOptions { basis: Some(Basis::Ptm), space: Some(Space::Srgb), layout: None };
            let made = convert_models(&models, &ptm, &job).unwrap();
            assert_eq!((made.basis(), made.space()), (&Basis::Ptm, Space::Srgb));
            let space = ConvertOptions { space: Some(Space::Srgb), ..ConvertOptions::default() };
            assert!(convert_models(&models, &space, &job).unwrap_err().to_string().contains("--basis hsh9"));
        }
    }
}
