//! A field to the bytes of a `.ptm` file.

use std::borrow::Cow;

use rayon::prelude::*;

use super::rounding::Rounding;
use super::{PtmEncoding, compress, header};
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::format::codes::code8;
use crate::format::quantise;
use crate::job::Job;
use crate::memory;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// The scale and bias under which values become bytes.
#[derive(Debug, Clone, Copy)]
pub(in crate::format) enum Under<'a> {
    /// That of the file from which the values were copied: each value becomes its nearest byte, and values
    /// read from bytes under this encoding give the same bytes.
    Stored(&'a PtmEncoding),
    /// A given one, for new values: those of a function are rounded for the least error of relit values.
    Given(&'a PtmEncoding),
    /// One chosen for the least error of relit values, which are then rounded in the same way.
    Chosen,
}

/// The bytes of a `.ptm` file, version 1.2, raw: RGB from RGB, LRGB from LRGB, LRGB with white from
/// luminance.
///
/// # Errors
/// Fields of another basis or with other channels, linear fields, and values that are not finite.
pub(in crate::format) fn encode(field: &ReflectanceField, under: Under<'_>, job: &Job) -> Result<Vec<u8>> {
    check(field)?;
    let parts = CoefficientParts::of(field, matches!(under, Under::Stored(_)));
    job.proceed()?;
    let rounding = match under {
        Under::Stored(encoding) => Rounding::nearest(encoding),
        Under::Given(encoding) => Rounding::successive(encoding)?,
        Under::Chosen => Rounding::successive(&parts.chosen())?,
    };
    job.proceed()?;
    parts.bytes(&rounding)
}

/// As [`encode`], in the compressed format: RGB from RGB, LRGB from LRGB and luminance. `quality` is that of JPEG files.
///
/// # Errors
/// As [`encode`]; sides that no JPEG file has.
pub(in crate::format) fn encode_compressed(
    field: &ReflectanceField,
    under: Under<'_>,
    quality: u8,
    job: &Job,
) -> Result<Vec<u8>> {
    compress::compressed(&encode(field, under, job)?, quality, job)
}

impl PtmEncoding {
    /// The scale and bias chosen for a field, with the least expected error.
    ///
    /// # Errors
    /// When a `.ptm` file cannot hold the field.
    pub fn chosen(field: &ReflectanceField) -> Result<Self> {
        check(field)?;
        Ok(CoefficientParts::of(field, false).chosen())
    }
}

fn check(field: &ReflectanceField) -> Result<()> {
    if *field.basis() != Basis::Ptm {
        return Err(Error::usage(format!(
            "a .ptm file holds functions of the basis ptm, not {}: write .exr instead",
            field.basis().name()
        )));
    }
    if field.layout().is_named() {
        return Err(Error::usage(format!(
            "a .ptm file holds luminance or red, green and blue, not the channels {}: write .exr instead",
            field.layout().channel_names().join(", ")
        )));
    }
    if field.space() != Space::Srgb {
        return Err(Error::usage(
            "a .ptm file holds sRGB-encoded values and this texture is linear: write .exr, or fit encoded values",
        ));
    }
    check_finite(field, ".ptm")
}

/// Refuses coefficients that files of bytes cannot hold.
pub(in crate::format) fn check_finite(field: &ReflectanceField, kind: &str) -> Result<()> {
    for (k, plane) in field.coefficients().iter().enumerate() {
        if let Some(texel) = plane.iter().position(|v| !v.is_finite()) {
            let (x, y) = (texel % field.size().width, texel / field.size().width);
            return Err(Error::invalid(format!(
                "coefficient plane {k} is {} at texel ({x}, {y}): a {kind} file holds finite numbers only",
                plane[texel]
            )));
        }
    }
    Ok(())
}

/// The contents of the blocks of a file.
struct CoefficientParts<'a> {
    /// Six planes of luminance, or of each channel.
    functions: Cow<'a, Planes>,
    /// Three bytes per texel, rows from the top, if the functions are luminances.
    colors: Option<Vec<u8>>,
}

impl<'a> CoefficientParts<'a> {
    /// The parts of a field whose values are copies of bytes, or new.
    fn of(field: &'a ReflectanceField, copies: bool) -> Self {
        let planes = field.coefficients();
        let functions = Cow::Borrowed(planes);
        match (field.layout().is_product(), copies) {
            (false, _) => {
                let white = || vec![255; 3 * field.size().texels()];
                let colors = (field.layout().channels() == 1).then(white);
                Self { functions, colors }
            }
            (true, true) => Self { functions, colors: Some(nearest_colors(planes)) },
            (true, false) => {
                let (luminance, colors) = rounded_products(planes);
                Self { functions: Cow::Owned(luminance), colors: Some(colors) }
            }
        }
    }

    /// Scale and bias for the least expected error, coefficient by coefficient.
    fn chosen(&self) -> PtmEncoding {
        let choose = |k: usize| match &self.colors {
            Some(colors) => {
                let weights = colors.chunks_exact(3).map(|color| norm_squared(color) as f32);
                quantise::choose(self.functions.plane(k).iter().copied().zip(weights))
            }
            None => {
                let channels = [k, 6 + k, 12 + k].map(|plane| self.functions.plane(plane));
                quantise::choose(channels.into_iter().flatten().map(|&v| (v, 1.0)))
            }
        };
        let chosen: Vec<(f32, f32)> = (0..6).into_par_iter().map(choose).collect();
        PtmEncoding {
            scale: std::array::from_fn(|k| chosen[k].0),
            bias: std::array::from_fn(|k| chosen[k].1),
        }
    }

    fn bytes(&self, rounding: &Rounding) -> Result<Vec<u8>> {
        let planes = &self.functions;
        let (name, blocks) =
            if self.colors.is_some() { ("PTM_FORMAT_LRGB", 1) } else { ("PTM_FORMAT_RGB", 3) };
        let header = header::to_text(name, planes.size(), rounding.encoding()).into_bytes();
        let texel = 6 * blocks + if self.colors.is_some() { 3 } else { 0 };
        let length = header.len() + texel * planes.size().texels();
        let mut out = memory::with_capacity("the .ptm file", length)?;
        out.extend_from_slice(&header);
        (0..blocks).for_each(|channel| append_functions(&mut out, planes, 6 * channel, rounding));
        let colors = self.colors.iter().flat_map(|colors| colors.chunks_exact(3 * planes.size().width).rev());
        colors.for_each(|row| out.extend_from_slice(row));
        Ok(out)
    }
}

/// Appends six bytes per texel, rows from the bottom, of the six planes from `first` on.
fn append_functions(out: &mut Vec<u8>, planes: &Planes, first: usize, rounding: &Rounding) {
    let Size { width, height } = planes.size();
    let functions: [&[f32]; 6] = std::array::from_fn(|k| planes.plane(first + k));
    let start = out.len();
    out.resize(start + 6 * planes.size().texels(), 0);
    out[start..].par_chunks_exact_mut(6 * width).enumerate().for_each(|(from_bottom, row)| {
        let texel = (height - 1 - from_bottom) * width;
        for (x, bytes) in row.chunks_exact_mut(6).enumerate() {
            bytes.copy_from_slice(&rounding.bytes(functions.map(|plane| plane[texel + x])));
        }
    });
}

/// The colours of an LRGB field as the nearest bytes, interleaved.
fn nearest_colors(planes: &Planes) -> Vec<u8> {
    let colors = [6, 7, 8].map(|k| planes.plane(k));
    (0..planes.size().texels()).flat_map(|texel| colors.map(|plane| code8(plane[texel]))).collect()
}

/// Colours rounded to bytes with the largest at 255, and the luminance whose product with the rounded colour
/// q is nearest to the product c l: l (c . q) / (q . q).
fn rounded_products(planes: &Planes) -> (Planes, Vec<u8>) {
    let texels = planes.size().texels();
    let mut colors = Vec::with_capacity(3 * texels);
    let mut gains = Vec::with_capacity(texels);
    for texel in 0..texels {
        let color = [6, 7, 8].map(|k| f64::from(planes.plane(k)[texel].max(0.0)));
        let largest = color.iter().fold(0.0f64, |a, &b| a.max(b));
        let code = color.map(|c| if largest > 0.0 { code8((c / largest) as f32) } else { 0 });
        let product: f64 = color.iter().zip(code).map(|(c, q)| c * f64::from(q) / 255.0).sum();
        gains.push(if largest > 0.0 { product / norm_squared(&code) } else { 1.0 });
        colors.extend_from_slice(&code);
    }
    let mut luminance = Planes::zeros(planes.size(), 6);
    for (out, plane) in luminance.iter_mut().zip(planes.iter()) {
        for (out, (&value, gain)) in out.iter_mut().zip(plane.iter().zip(&gains)) {
            *out = (f64::from(value) * gain) as f32;
        }
    }
    (luminance, colors)
}

/// The squared length of a colour of bytes, with white at 1 in each: the weight of the squared error of its
/// luminance.
fn norm_squared(color: &[u8]) -> f64 {
    color.iter().map(|&c| (f64::from(c) / 255.0).powi(2)).sum()
}
