//! A field to the bytes of a `.ptm` file.

use rayon::prelude::*;

use super::rounding::Rounding;
use super::{PtmEncoding, header, quantise};
use crate::error::{Error, Result};
use crate::field::{Basis, ColorModel, ReflectanceField};
use crate::format::codes::code8;
use crate::planes::{Planes, Size};
use crate::space::Space;

/// The bytes of a `.ptm` file, version 1.2, raw: RGB from RGB, LRGB from LRGB, LRGB with white from
/// luminance.
///
/// With an encoding, every value is stored as the nearest byte under it: values that were read
/// from bytes under this encoding give the same bytes. Without one, scale and bias are chosen, and
/// coefficients rounded, for the least error of relit values.
///
/// # Errors
/// Fields of another basis, linear fields, and values that are not finite.
pub(in crate::format) fn encode(field: &ReflectanceField, stored: Option<&PtmEncoding>) -> Result<Vec<u8>> {
    check(field)?;
    let planes = field.coefficients();
    match (field.color(), stored) {
        (ColorModel::Rgb, _) => rgb(planes, stored),
        (ColorModel::Luminance, _) => lrgb(planes, &vec![255; 3 * field.size().texels()], stored),
        (ColorModel::Lrgb, Some(_)) => lrgb(planes, &nearest_colors(planes), stored),
        (ColorModel::Lrgb, None) => {
            let (luminance, colors) = rounded_products(planes);
            lrgb(&luminance, &colors, None)
        }
    }
}

fn check(field: &ReflectanceField) -> Result<()> {
    if field.basis() != Basis::Ptm {
        return Err(Error::usage(format!(
            "a .ptm file holds functions of the basis ptm, not {}: write .exr instead",
            field.basis().name()
        )));
    }
    if field.space() != Space::Srgb {
        return Err(Error::usage(
            "a .ptm file holds sRGB-encoded values and this texture is linear: write .exr, or fit encoded values",
        ));
    }
    for (k, plane) in field.coefficients().iter().enumerate() {
        if let Some(texel) = plane.iter().position(|v| !v.is_finite()) {
            let (x, y) = (texel % field.size().width, texel / field.size().width);
            return Err(Error::invalid(format!(
                "coefficient plane {k} is {} at texel ({x}, {y}): a .ptm file holds finite numbers only",
                plane[texel]
            )));
        }
    }
    Ok(())
}

fn rgb(planes: &Planes, stored: Option<&PtmEncoding>) -> Result<Vec<u8>> {
    let rounding = rounding(stored, |k| {
        let channels = [k, 6 + k, 12 + k].map(|plane| planes.plane(plane));
        quantise::choose(channels.into_iter().flatten().map(|&v| (v, 1.0)))
    })?;
    let mut out = header::to_text("PTM_FORMAT_RGB", planes.size(), rounding.encoding()).into_bytes();
    (0..3).for_each(|channel| append_functions(&mut out, planes, 6 * channel, &rounding));
    Ok(out)
}

/// `colors` are three bytes a texel, rows from the top.
fn lrgb(planes: &Planes, colors: &[u8], stored: Option<&PtmEncoding>) -> Result<Vec<u8>> {
    let rounding = rounding(stored, |k| {
        let weights = colors.chunks_exact(3).map(|color| norm_squared(color) as f32);
        quantise::choose(planes.plane(k).iter().copied().zip(weights))
    })?;
    let mut out = header::to_text("PTM_FORMAT_LRGB", planes.size(), rounding.encoding()).into_bytes();
    append_functions(&mut out, planes, 0, &rounding);
    colors.chunks_exact(3 * planes.size().width).rev().for_each(|row| out.extend_from_slice(row));
    Ok(out)
}

/// Appends six bytes a texel, rows from the bottom, of the six planes from `first` on.
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

/// Rounding under the stored encoding, or under one chosen coefficient by coefficient.
fn rounding(
    stored: Option<&PtmEncoding>,
    choose: impl Fn(usize) -> (f32, f32) + Sync + Send,
) -> Result<Rounding> {
    if let Some(encoding) = stored {
        return Ok(Rounding::nearest(encoding));
    }
    let chosen: Vec<(f32, f32)> = (0..6).into_par_iter().map(choose).collect();
    let encoding = PtmEncoding {
        scale: std::array::from_fn(|k| chosen[k].0),
        bias: std::array::from_fn(|k| chosen[k].1),
    };
    Rounding::successive(&encoding)
}

/// The colours of an LRGB field as the nearest bytes, interleaved.
fn nearest_colors(planes: &Planes) -> Vec<u8> {
    let colors = [6, 7, 8].map(|k| planes.plane(k));
    (0..planes.size().texels()).flat_map(|texel| colors.map(|plane| code8(plane[texel]))).collect()
}

/// Colours rounded to bytes with the largest at 255, and the luminance that is nearest to the
/// product c l under the rounded colour q: l (c . q) / (q . q).
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

/// The squared length of a colour of bytes, white being 1 in each: how much the squared error of
/// its luminance counts.
fn norm_squared(color: &[u8]) -> f64 {
    color.iter().map(|&c| (f64::from(c) / 255.0).powi(2)).sum()
}
