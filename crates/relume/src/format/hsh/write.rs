//! A field to the bytes of `.rti` and `.hsh` files.

use super::HshEncoding;
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::format::codes::code8;
use crate::format::ptm::{WHITE, check_finite};
use crate::format::quantise;
use crate::job::Job;
use crate::memory;
use crate::parallel;
use crate::space::Space;

/// The bytes of a `.rti` file: RGB from RGB and luminance, luminance times colour from LRGB.
///
/// With the encoding of the file from which values were copied, they become its bytes.
///
/// # Errors
/// Fields of other functions than harmonics or with other channels, linear fields, and values that are not finite.
pub(in crate::format) fn encode_rti(
    field: &ReflectanceField,
    stored: Option<&HshEncoding>,
    job: &Job,
) -> Result<Vec<u8>> {
    let terms = check(field, ".rti")?;
    let encoding = stored.filter(|stored| stored.terms == terms).copied().unwrap_or_else(|| chosen(field));
    let size = field.size();
    let kind = if field.layout().is_product() { 1 } else { 2 };
    let head = format!("#HSH1.2\n3\n{} {} 3\n{terms} {kind} 1\n", size.width, size.height);
    let floats = encoding.scale().iter().chain(encoding.bias()).flat_map(|n| n.to_le_bytes());
    let head: Vec<u8> = head.into_bytes().into_iter().chain(floats).collect();
    job.proceed()?;
    texels(field, &encoding, head)
}

/// The bytes of an old `.hsh` file, always of red, green and blue.
///
/// # Errors
/// As [`encode_rti`].
pub(in crate::format) fn encode_hsh(
    field: &ReflectanceField,
    stored: Option<&HshEncoding>,
    job: &Job,
) -> Result<Vec<u8>> {
    let terms = check(field, ".hsh")?;
    if field.layout().is_product() {
        let channels = field.of_channels(&["R", "G", "B"], job)?;
        return encode_hsh(&channels, None, job);
    }
    let encoding = stored.filter(|stored| stored.terms == terms).copied().unwrap_or_else(|| chosen(field));
    job.proceed()?;
    let order = (1..).find(|order| order * order >= terms).unwrap_or(1);
    let size = field.size();
    let integers = [size.width, size.height, 3, order].map(|n| n as u32);
    let high = encoding.bias().iter().zip(encoding.scale()).map(|(low, range)| low + range);
    let floats = encoding.bias().iter().copied().chain(high).flat_map(f32::to_le_bytes);
    let head: Vec<u8> = integers.into_iter().flat_map(u32::to_le_bytes).chain(floats).collect();
    // The range is read as a difference of its ends.
    let read: Vec<f32> =
        encoding.bias().iter().zip(encoding.scale()).map(|(low, range)| (low + range) - low).collect();
    texels(field, &HshEncoding::new(&read, encoding.bias()), head)
}

/// The number of terms of a field that files hold.
fn check(field: &ReflectanceField, kind: &str) -> Result<usize> {
    let name = field.basis().name();
    if !name.starts_with("hsh") {
        return Err(Error::usage(format!(
            "a {kind} file holds hemispherical harmonics, not functions of the basis {name}: `relume convert` makes \
             them of it"
        )));
    }
    if field.layout().is_named() || field.layout().is_shared() {
        return Err(Error::usage(format!(
            "a {kind} file holds red, green and blue, not the channels {}: write .exr instead",
            field.layout().channel_names().join(", ")
        )));
    }
    if field.space() != Space::Srgb {
        return Err(Error::usage(format!(
            "a {kind} file holds sRGB-encoded values and this texture is linear: write .exr, or fit encoded values"
        )));
    }
    check_finite(field, kind)?;
    Ok(field.basis().len())
}

/// Scale and bias for the least expected error. Harmonics are orthonormal, so that each term counts for itself.
fn chosen(field: &ReflectanceField) -> HshEncoding {
    let terms = field.basis().len();
    let planes = field.coefficients();
    let functions = field.layout().functions();
    let of_term = |term: usize| {
        let values =
            (0..functions).flat_map(|function| planes.plane(function * terms + term)).map(|&v| (v, 1.0));
        let (step, bias) = quantise::choose(values);
        // In units of a file of white at 255: (byte - bias) step.
        (step, (-f64::from(bias) * f64::from(step) / WHITE) as f32)
    };
    let chosen: Vec<(f32, f32)> = parallel::map(0..terms, of_term);
    let (scale, bias): (Vec<f32>, Vec<f32>) = chosen.into_iter().unzip();
    HshEncoding::new(&scale, &bias)
}

/// Appends the texels, rows from the top.
fn texels(field: &ReflectanceField, encoding: &HshEncoding, head: Vec<u8>) -> Result<Vec<u8>> {
    let (terms, planes) = (field.basis().len(), field.coefficients());
    let is_product = field.layout().is_product();
    let texel = if is_product { terms + 3 } else { 3 * terms };
    // The planes of the bytes of a texel; luminance is written three times.
    let source: Vec<usize> = (0..texel).map(|k| k % planes.count()).collect();
    let mut out = memory::with_capacity("the file of harmonics", head.len() + texel * field.size().texels())?;
    out.extend_from_slice(&head);
    out.resize(head.len() + texel * field.size().texels(), 0);
    let width = field.size().width;
    parallel::for_each(out[head.len()..].chunks_mut(texel * width).enumerate(), |(y, row)| {
        for (k, &plane) in source.iter().enumerate() {
            let values = &planes.plane(plane)[y * width..][..width];
            let bytes = row.iter_mut().skip(k).step_by(texel).zip(values);
            match is_product && k >= terms {
                true => bytes.for_each(|(out, &value)| *out = code8(value)),
                false => bytes.for_each(|(out, &value)| *out = encoding.byte(k % terms, value)),
            }
        }
    });
    Ok(out)
}
