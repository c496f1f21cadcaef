//! Bytes of `.rti` and `.hsh` files to a field.

use super::HshEncoding;
use super::header::{HshHeader, TexelColor};
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::space::Space;

/// The field in a file, and the storage of its coefficients.
///
/// # Errors
/// Heads with the place of the fault, other kinds by name, and a number of bytes that does not match the size.
pub(in crate::format) fn decode(bytes: &[u8], job: &Job) -> Result<(ReflectanceField, HshEncoding)> {
    let HshHeader { size, color, encoding, payload } = HshHeader::parse(bytes)?;
    let terms = encoding.scale().len();
    let basis = basis(terms)?;
    let texel = color.texel_bytes(terms);
    let (expected, found) = (size.width as u128 * size.height as u128 * texel as u128, bytes.len() - payload);
    if expected != found as u128 {
        return Err(Error::invalid(format!(
            "{size} texels of {terms} terms need {expected} bytes from byte {payload} on, found {found}: the file is \
             truncated, or its head is wrong"
        )));
    }
    if color == TexelColor::Lrgb {
        job.remark(
            "the RTI file has one luminance for each texel: its colour is taken as the three bytes after it",
        );
    }
    let layout = if color == TexelColor::Rgb { PlaneLayout::RGB } else { PlaneLayout::LRGB };
    let mut planes = Planes::zeros_within(job, "the harmonics", size, texel)?;
    parallel::for_each(planes.as_mut_slice().chunks_mut(size.texels()).enumerate(), |(k, plane)| {
        let is_color = color == TexelColor::Lrgb && k >= terms;
        let values: [f32; 256] = std::array::from_fn(|byte| match is_color {
            true => byte as f32 / 255.0,
            false => encoding.value(k % terms, byte as u8),
        });
        let bytes = bytes[payload + k..].iter().step_by(texel);
        plane.iter_mut().zip(bytes).for_each(|(out, &byte)| *out = values[usize::from(byte)]);
    });
    Ok((ReflectanceField::new(basis, layout, Space::Srgb, planes)?, encoding))
}

/// The basis of a number of terms.
fn basis(terms: usize) -> Result<Basis> {
    if terms == 1 {
        return Err(Error::unsupported(
            "the file has one term, a picture that no light changes: expected 4, 9, 16 or 25 harmonics",
        ));
    }
    Basis::from_name(&format!("hsh{terms}"))
        .ok_or_else(|| Error::unsupported(format!("{terms} harmonics are not read: expected 9")))
}
