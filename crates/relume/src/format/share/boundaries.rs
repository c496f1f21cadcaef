//! Boundaries of shadows and highlights that move between the lights ([`Shapes`]) as readers find them on a graphics card:
//! the numbers of [`ShapeLookup`](crate::field::ShapeLookup), whose corrections they add to the linear values.
//!
//! A gzip file: of shadows and then of highlights the distances of each light, a byte a texel, plane after plane, with 128
//! at the boundary; then the contrasts as half floats, little-endian: for each channel those of shadows and those of
//! highlights, four planes each.

use half::f16;

use super::header::ShareShapes;
use super::planes::compressed;
use crate::error::Result;
use crate::field::{Basis, Interpolation, ReflectanceField, Shapes};
use crate::job::Job;

const FILE_NAME: &str = "shapes.gz";
/// The code of a texel on the boundary.
const MIDDLE: f32 = 128.0;

/// The header's entry of a field of the basis `shapes`, and its file; `None` for other fields.
pub(super) fn shared(
    field: &ReflectanceField,
    files: &mut Vec<(String, Vec<u8>)>,
    job: &Job,
) -> Result<Option<ShareShapes>> {
    let Some(shapes) = Shapes::of(field, job)? else { return Ok(None) };
    let (lookup, lights) = (shapes.lookup(), field.basis().len());
    job.check("the shapes of shadows", field.size(), 8 * lookup.len() as u64)?;
    let (texels, steps) = (field.size().texels(), lookup.steps());
    let mut codes = vec![0u8; 2 * lights * texels];
    let mut contrasts = vec![f16::ZERO; (lookup.len() - 2 * lights) * texels];
    let mut numbers = vec![0.0; lookup.len()];
    for texel in 0..texels {
        shapes.numbers_into(texel, &mut numbers);
        let (distances, polynomials) = numbers.split_at(2 * lights);
        for (k, distance) in distances.iter().enumerate() {
            codes[k * texels + texel] = (MIDDLE + distance * steps[k / lights]).round() as u8;
        }
        for (k, term) in polynomials.iter().enumerate() {
            contrasts[k * texels + texel] = f16::from_f32(*term);
        }
    }
    codes.extend(contrasts.iter().flat_map(|half| half.to_le_bytes()));
    files.push((FILE_NAME.to_owned(), compressed(&codes)));
    Ok(Some(ShareShapes {
        file: FILE_NAME.to_owned(),
        strengths: lookup.strengths(),
        steps,
        most: lookup.most_contrasts(),
        softness: lookup.softness(),
    }))
}

/// Says that textures that are shared in tiles have the linear form.
pub(super) fn remark_linear(field: &ReflectanceField, job: &Job) {
    if matches!(field.basis(), Basis::Interpolated(lights) if lights.interpolation() == Interpolation::Shapes)
    {
        job.remark(
            "shadows and highlights fade between the lights of the photographs instead of moving: textures from two million \
             texels on and sets of tiles are shown in their linear form"
                .to_owned(),
        );
    }
}
