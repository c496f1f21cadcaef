//! Windows of the plane that a random-field model makes.

use relume::format::{
    Depth, ExrDepth, FieldFormat, HeightFormat, PictureFormat, PtmEncoding, Streamed, encode_field,
    encode_height,
};
use relume::random_field::realisation::CELL;
use relume::random_field::{FieldModel, Heights, RealisationOptions};
use relume::{Error, ReflectanceField, Result, Size, Space};
use serde_json::json;

use super::bands::{Bands, Cost, Cut};
use super::{Drawing, Window};
use crate::context::Context;
use crate::output::{self, Outputs};
use crate::report::Report;

/// Draws a window.
pub fn draw(
    drawing: &Drawing<'_>,
    model: &FieldModel,
    outputs: &mut Outputs,
    context: &Context,
) -> Result<Report> {
    let window = drawing.window()?;
    let plane = Plane { model, seed: drawing.seed, period: drawing.tile.then_some(window.size), context };
    match model.heights {
        Some(heights) => draw_heights(drawing, &plane, window, heights, outputs)?,
        None => draw_texture(drawing, &plane, window, outputs)?,
    }
    let of = if drawing.tile { "of a model; tiles without a seam" } else { "of a model" };
    Ok(drawing.report(window, of, json!({ "tile": drawing.tile })))
}

/// Draws a window of a height map, with its record.
fn draw_heights(
    drawing: &Drawing<'_>,
    plane: &Plane<'_>,
    window: Window,
    heights: Heights,
    outputs: &mut Outputs,
) -> Result<()> {
    if drawing.args.exr_tile.is_some() {
        return Err(Error::usage(
            "--exr-tile has no meaning for a height map, which is written at once: leave it out",
        ));
    }
    let format = match output::is_stream(drawing.output) {
        true => HeightFormat::Exr,
        false => HeightFormat::from_path(drawing.output)?,
    };
    let field = plane.part(&window)?;
    let bytes = encode_height(field.coefficients(), heights.mm_per_texel, format);
    outputs.write(drawing.output, bytes.map_err(|e| e.at(drawing.output))?)
}

/// Draws a window of what is no height map.
fn draw_texture(
    drawing: &Drawing<'_>,
    plane: &Plane<'_>,
    window: Window,
    outputs: &mut Outputs,
) -> Result<()> {
    match format(drawing, plane.model)? {
        // Files that are not written in rows.
        format @ FieldFormat::Picture(PictureFormat::Jpeg { .. } | PictureFormat::Tiff(_))
            if drawing.args.exr_tile.is_none() =>
        {
            let bytes = encode_field(&plane.part(&window)?, format, None, &plane.context.job);
            outputs.write(drawing.output, bytes.map_err(|e| e.at(drawing.output))?)
        }
        format => stream(drawing, plane, format, window, outputs),
    }
}

/// Writes the window in bands. The scale of a `.ptm` is that of the model's reference window, so that the same texel has the
/// same bytes in every window.
fn stream(
    drawing: &Drawing<'_>,
    plane: &Plane<'_>,
    format: FieldFormat,
    window: Window,
    outputs: &mut Outputs,
) -> Result<()> {
    let (model, job) = (plane.model, &plane.context.job);
    let scale = match format {
        FieldFormat::Ptm => {
            Some(PtmEncoding::chosen(&model.reference_window(job)?).map_err(|e| e.at(drawing.output))?)
        }
        _ => None,
    };
    let encoded = |field: &ReflectanceField| Streamed::made(field, format, scale.as_ref(), job);
    let head = drawing.laid(encoded(&model.texel()?))?;
    let stored = head.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
    let cost = Cost { stored, made: model.bytes_per_texel() };
    let cut = Cut::new(&window, CELL, drawing.args.exr_tile, cost, job).map_err(|e| e.at(drawing.output))?;
    let make = |part: &Window| encoded(&plane.part(part)?);
    let mut bands = Bands::new(window, cut, &make);
    let mut rows = |lane: usize, x: usize, y: usize, row: &mut [u8]| bands.row(lane, x, y, row);
    drawing.write(&head, window.size, outputs, plane.context, &mut rows)
}

/// A model's plane.
struct Plane<'a> {
    model: &'a FieldModel,
    seed: u64,
    period: Option<Size>,
    context: &'a Context,
}

impl Plane<'_> {
    fn part(&self, part: &Window) -> Result<ReflectanceField> {
        let Window { x, y, size } = *part;
        let options = RealisationOptions { origin: [x, y], size, seed: self.seed, period: self.period };
        self.model.synthesize(&options, &self.context.job)
    }
}

/// By the output's name; to standard output a picture for constants, else the lossless form.
fn format(drawing: &Drawing<'_>, model: &FieldModel) -> Result<FieldFormat> {
    if !output::is_stream(drawing.output) {
        return FieldFormat::from_path(drawing.output);
    }
    let is_picture = model.basis.len() == 1 && model.space == Space::Srgb;
    Ok(if is_picture {
        FieldFormat::Picture(PictureFormat::Png(Depth::Eight))
    } else {
        FieldFormat::Exr(ExrDepth::Float)
    })
}
