//! A field to the bytes of a `.ptm` file.

use std::borrow::Cow;

use super::rounding::Rounding;
use super::{PtmEncoding, compress, header};
use crate::error::{Error, Result};
use crate::field::{Basis, ReflectanceField};
use crate::format::codes::code8;
use crate::format::quantise;
use crate::job::Job;
use crate::memory;
use crate::parallel;
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
    let parts = CoefficientParts::of(field, matches!(under, Under::Stored(_)))?;
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
        Ok(CoefficientParts::of(field, false)?.chosen())
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
    let planes: Vec<&[f32]> = field.coefficients().iter().collect();
    let not_finite = |plane: &&[f32]| plane.iter().position(|v| !v.is_finite());
    let found: Vec<Option<usize>> = parallel::map(planes.iter(), not_finite);
    match found.into_iter().enumerate().find_map(|(k, texel)| texel.map(|texel| (k, texel))) {
        None => Ok(()),
        Some((k, texel)) => {
            let (x, y) = (texel % field.size().width, texel / field.size().width);
            Err(Error::invalid(format!(
                "coefficient plane {k} is {} at texel ({x}, {y}): a {kind} file holds finite numbers only",
                planes[k][texel]
            )))
        }
    }
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
    fn of(field: &'a ReflectanceField, copies: bool) -> Result<Self> {
        let planes = field.coefficients();
        let functions = Cow::Borrowed(planes);
        match (field.layout().is_product(), copies) {
            (false, _) => {
                let white = || vec![255; 3 * field.size().texels()];
                let colors = (field.layout().channels() == 1).then(white);
                Ok(Self { functions, colors })
            }
            (true, true) => Ok(Self { functions, colors: Some(nearest_colors(planes)?) }),
            (true, false) => {
                let (luminance, colors) = rounded_products(planes)?;
                Ok(Self { functions: Cow::Owned(luminance), colors: Some(colors) })
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
        let chosen: Vec<(f32, f32)> = parallel::map(0..6, choose);
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
        let (texels, width) = (planes.size().texels(), planes.size().width);
        let color_bytes = if self.colors.is_some() { 3 * texels } else { 0 };
        let mut out = memory::zeros("the .ptm file", header.len() + 6 * blocks * texels + color_bytes)?;
        out[..header.len()].copy_from_slice(&header);
        let (functions, colors) = out[header.len()..].split_at_mut(6 * blocks * texels);
        let channels = functions.chunks_exact_mut(6 * texels).enumerate();
        channels.for_each(|(channel, out)| fill_functions(out, planes, 6 * channel, rounding));
        if let Some(rows) = &self.colors {
            // Rows from the bottom.
            let rows = rows.chunks_exact(3 * width).rev();
            colors.chunks_exact_mut(3 * width).zip(rows).for_each(|(out, row)| out.copy_from_slice(row));
        }
        Ok(out)
    }
}

/// Six bytes per texel, rows from the bottom, of the six planes from `first` on.
fn fill_functions(out: &mut [u8], planes: &Planes, first: usize, rounding: &Rounding) {
    let Size { width, height } = planes.size();
    let functions: [&[f32]; 6] = std::array::from_fn(|k| planes.plane(first + k));
    parallel::for_each(out.chunks_exact_mut(6 * width).enumerate(), |(from_bottom, row)| {
        let texel = (height - 1 - from_bottom) * width;
        rounding.fill(row, functions.map(|plane| &plane[texel..texel + width]));
    });
}

/// The colours of an LRGB field as the nearest bytes, interleaved.
fn nearest_colors(planes: &Planes) -> Result<Vec<u8>> {
    let colors = [6, 7, 8].map(|k| planes.plane(k));
    let mut out = memory::zeros("the colours of the .ptm file", 3 * planes.size().texels())?;
    let width = planes.size().width;
    parallel::for_each(out.chunks_exact_mut(3 * width).enumerate(), |(y, row)| {
        let [red, green, blue] = colors.map(|plane| &plane[y * width..(y + 1) * width]);
        for (out, ((&r, &g), &b)) in row.chunks_exact_mut(3).zip(red.iter().zip(green).zip(blue)) {
            out.copy_from_slice(&[r, g, b].map(code8));
        }
    });
    Ok(out)
}

/// Colours rounded to bytes with the largest at 255, and the luminance whose product with the rounded colour
/// q is nearest to the product c l: l (c . q) / (q . q).
fn rounded_products(planes: &Planes) -> Result<(Planes, Vec<u8>)> {
    let width = planes.size().width;
    let mut colors = memory::zeros("the colours of the .ptm file", 3 * planes.size().texels())?;
    let mut luminance = Planes::zeros(planes.size(), 6);
    let rows = luminance.rows_mut().into_iter().zip(colors.chunks_exact_mut(3 * width));
    parallel::for_each(rows.enumerate(), |(y, (functions, colors))| {
        let row = |k: usize| &planes.plane(k)[y * width..(y + 1) * width];
        let of_colors = [6, 7, 8].map(row);
        let gains: Vec<f64> = colors
            .chunks_exact_mut(3)
            .enumerate()
            .map(|(x, code)| rounded_color(of_colors.map(|row| row[x]), code))
            .collect();
        for (k, out) in functions.into_iter().enumerate() {
            for (out, (&value, gain)) in out.iter_mut().zip(row(k).iter().zip(&gains)) {
                *out = (f64::from(value) * gain) as f32;
            }
        }
    });
    Ok((luminance, colors))
}

/// Rounds a colour, and gives the factor of its luminance.
fn rounded_color(color: [f32; 3], code: &mut [u8]) -> f64 {
    let color = color.map(|c| f64::from(c.max(0.0)));
    let largest = color.iter().fold(0.0f64, |a, &b| a.max(b));
    if largest <= 0.0 {
        return 1.0;
    }
    code.iter_mut().zip(color).for_each(|(code, c)| *code = code8((c / largest) as f32));
    let product: f64 = color.iter().zip(&*code).map(|(c, &q)| c * f64::from(q) / 255.0).sum();
    product / norm_squared(code)
}

/// The squared length of a colour of bytes, with white at 1 in each: the weight of the squared error of its
/// luminance.
fn norm_squared(color: &[u8]) -> f64 {
    color.iter().map(|&c| (f64::from(c) / 255.0).powi(2)).sum()
}
