//! Bytes of a `.ptm` file to a field.

use std::cmp::Ordering;

use super::header::{Comb, Header, Layout};
use super::{PtmEncoding, lum};
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::job::Job;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// The field in a `.ptm` file, and the storage of its coefficients.
///
/// # Errors
/// Invalid headers with the position of the fault, unsupported sub-formats by name, and a number of bytes
/// that does not match the size.
pub(in crate::format) fn decode(bytes: &[u8], job: &Job) -> Result<(ReflectanceField, PtmEncoding)> {
    let header = Header::parse(bytes)?;
    let payload = &bytes[header.payload..];
    let layout = if header.layout == Layout::Rgb { PlaneLayout::RGB } else { PlaneLayout::LRGB };
    let planes = match &header.jpeg {
        Some(jpeg) => {
            let samples = jpeg.decode(payload, header.size, job)?;
            let mut planes = Planes::zeros_within(job, "the texture map", header.size, samples.len())?;
            fill(&mut planes, &header, |k| (&samples[k][..], Comb { start: 0, stride: 1 }));
            planes
        }
        None => {
            check_length(&header, payload.len())?;
            let mut planes =
                Planes::zeros_within(job, "the texture map", header.size, header.layout.planes())?;
            fill(&mut planes, &header, |k| (payload, header.layout.comb(k, header.size.texels())));
            planes
        }
    };
    if let Some(matrix) = &header.matrix {
        return lum::field(&planes, matrix, job);
    }
    Ok((ReflectanceField::new(Basis::Ptm, layout, Space::Srgb, planes)?, header.encoding))
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

/// Fills planes from their bytes, of which `source` gives the place for each plane. Rows are taken across all planes, so
/// that interleaved bytes are in the cache when the next plane needs them.
fn fill<'a>(planes: &mut Planes, header: &Header, source: impl Fn(usize) -> (&'a [u8], Comb) + Sync) {
    let Size { width, height } = header.size;
    let values: Vec<[f32; 256]> =
        (0..planes.count()).map(|k| values(&header.encoding, header.layout.is_color(k), k)).collect();
    parallel::for_each(planes.rows_mut().into_iter().enumerate(), |(y, rows)| {
        for ((k, row), values) in rows.into_iter().enumerate().zip(&values) {
            let (bytes, comb) = source(k);
            let first = comb.start + (height - 1 - y) * width * comb.stride;
            let bytes = bytes[first..].iter().step_by(comb.stride);
            row.iter_mut().zip(bytes).for_each(|(out, &byte)| *out = values[usize::from(byte)]);
        }
    });
}

/// The value of each byte in plane `k`.
fn values(encoding: &PtmEncoding, is_color: bool, k: usize) -> [f32; 256] {
    std::array::from_fn(|byte| match is_color {
        true => byte as f32 / 255.0,
        false => encoding.value(k % 6, byte as u8),
    })
}
