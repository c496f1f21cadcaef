//! Bytes of a `.ptm` file to a field.

use std::cmp::Ordering;

use rayon::prelude::*;

use super::PtmEncoding;
use super::header::{Header, Layout};
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::planes::Planes;
use crate::space::Space;

/// The field in a `.ptm` file, and the storage of its coefficients.
///
/// # Errors
/// Invalid headers with the position of the fault, unsupported sub-formats by name, and a number of bytes
/// that does not match the size.
pub(in crate::format) fn decode(bytes: &[u8], job: &Job) -> Result<(ReflectanceField, PtmEncoding)> {
    let header = Header::parse(bytes)?;
    let payload = &bytes[header.payload..];
    check_length(&header, payload.len())?;
    let color = match header.layout {
        Layout::Rgb => PlaneLayout::RGB,
        Layout::LrgbBlocks | Layout::LrgbInterleaved => PlaneLayout::LRGB,
    };
    let mut planes = Planes::zeros_within(job, "the texture map", header.size, color.planes(6))?;
    fill(&mut planes, &header, payload);
    Ok((ReflectanceField::new(Basis::Ptm, color, Space::Srgb, planes)?, header.encoding))
}

/// Compares the number of bytes with that required by the size; sizes that overflow match no file.
fn check_length(header: &Header, found: usize) -> Result<()> {
    let (width, height) = (header.size.width as u128, header.size.height as u128);
    let expected = width.saturating_mul(height).saturating_mul(header.layout.bytes_per_texel() as u128);
    let verdict = match expected.cmp(&(found as u128)) {
        Ordering::Equal => return Ok(()),
        Ordering::Greater => "the file is truncated, or the size in its header is wrong",
        Ordering::Less => "the header does not match the coefficients",
    };
    Err(Error::invalid(format!(
        "{} texels need {expected} bytes of coefficients from byte {} on, found {found}: {verdict}",
        header.size, header.payload
    )))
}

fn fill(planes: &mut Planes, header: &Header, payload: &[u8]) {
    let (size, layout) = (header.size, header.layout);
    let texels = size.texels();
    planes.as_mut_slice().par_chunks_mut(texels).enumerate().for_each(|(k, plane)| {
        let values = values(&header.encoding, layout, k);
        let comb = layout.comb(k, texels);
        for (y, row) in plane.chunks_exact_mut(size.width).enumerate() {
            let first = comb.start + (size.height - 1 - y) * size.width * comb.stride;
            let bytes = payload[first..].iter().step_by(comb.stride);
            row.iter_mut().zip(bytes).for_each(|(out, &byte)| *out = values[usize::from(byte)]);
        }
    });
}

/// The value of each byte in plane `k`.
fn values(encoding: &PtmEncoding, layout: Layout, k: usize) -> [f32; 256] {
    let is_color = layout != Layout::Rgb && k >= 6;
    std::array::from_fn(|byte| match is_color {
        true => byte as f32 / 255.0,
        false => encoding.value(k % 6, byte as u8),
    })
}
