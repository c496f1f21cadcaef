//! Windows of the plane that a random-field model makes.

use relume::format::{
    Depth, ExrDepth, FieldFormat, HeightFormat, PictureFormat, PtmEncoding, Streamed, encode_field,
    encode_height,
};
use relume::random_field::sheet::CELL;
use relume::random_field::{FieldModel, Heights, SheetOptions};
use relume::{Error, ReflectanceField, Result, Size, Space};
use serde_json::json;

use super::bands::{Bands, Cost, Cut};
use super::{Job, Window};
use crate::context::Context;
use crate::output;
use crate::report::Report;

/// Draws a window.
pub fn draw(job: &Job<'_>, model: &FieldModel, context: &Context) -> Result<Report> {
    let window = job.window()?;
    let plane = Plane { model, seed: job.seed, period: job.tile.then_some(window.size), context };
    match model.heights {
        Some(heights) => draw_heights(job, &plane, window, heights)?,
        None => draw_texture(job, &plane, window)?,
    }
    let of = if job.tile { "of a model; tiles without a seam" } else { "of a model" };
    Ok(job.report(window, of, json!({ "tile": job.tile })))
}

/// Draws a window of a height map, with its record.
fn draw_heights(job: &Job<'_>, plane: &Plane<'_>, window: Window, heights: Heights) -> Result<()> {
    if job.args.exr_tile.is_some() {
        return Err(Error::usage(
            "--exr-tile has no meaning for a height map, which is written at once: leave it out",
        ));
    }
    let format = match output::is_stream(job.output) {
        true => HeightFormat::Exr,
        false => HeightFormat::from_path(job.output)?,
    };
    let field = plane.part(&window)?;
    let bytes = encode_height(field.coefficients(), heights.mm_per_texel, format);
    output::write(job.output, &bytes.map_err(|e| e.at(job.output))?, plane.context)
}

/// Draws a window of what is no height map.
fn draw_texture(job: &Job<'_>, plane: &Plane<'_>, window: Window) -> Result<()> {
    match format(job, plane.model)? {
        // Files that are not written in rows.
        format @ FieldFormat::Picture(PictureFormat::Jpeg { .. } | PictureFormat::Tiff(_))
            if job.args.exr_tile.is_none() =>
        {
            let bytes = encode_field(&plane.part(&window)?, format, None, &plane.context.limits);
            output::write(job.output, &bytes.map_err(|e| e.at(job.output))?, plane.context)
        }
        format => stream(job, plane, format, window),
    }
}

/// Writes the window in bands. The scale of a `.ptm` is that of the model's gauge, so that the same texel has the
/// same bytes in every window.
fn stream(job: &Job<'_>, plane: &Plane<'_>, format: FieldFormat, window: Window) -> Result<()> {
    let (model, limits) = (plane.model, &plane.context.limits);
    let scale = match format {
        FieldFormat::Ptm => Some(PtmEncoding::chosen(&model.gauge(limits)?).map_err(|e| e.at(job.output))?),
        _ => None,
    };
    let encoded = |field: &ReflectanceField| Streamed::made(field, format, scale.as_ref(), limits);
    let head = job.laid(encoded(&model.texel()?))?;
    let stored = head.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
    let cost = Cost { stored, made: model.bytes_per_texel() };
    let cut = Cut::new(&window, CELL, job.args.exr_tile, cost, limits).map_err(|e| e.at(job.output))?;
    let make = |part: &Window| encoded(&plane.part(part)?);
    let mut bands = Bands::new(window, cut, &make);
    job.write(&head, window.size, plane.context, &mut |lane, x, y, row| bands.row(lane, x, y, row))
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
        let options = SheetOptions { origin: [x, y], size, seed: self.seed, period: self.period };
        self.model.synthesize(&options, &self.context.limits)
    }
}

/// By the output's name; to standard output a picture for constants, else the lossless form.
fn format(job: &Job<'_>, model: &FieldModel) -> Result<FieldFormat> {
    if !output::is_stream(job.output) {
        return FieldFormat::from_path(job.output);
    }
    let is_picture = model.basis.len() == 1 && model.space == Space::Srgb;
    Ok(if is_picture {
        FieldFormat::Picture(PictureFormat::Png(Depth::Eight))
    } else {
        FieldFormat::Exr(ExrDepth::Float)
    })
}
