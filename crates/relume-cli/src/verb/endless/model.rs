//! Windows of the plane that a random-field model makes.

use relume::format::{Depth, ExrDepth, FieldFormat, PictureFormat, encode_field};
use relume::random_field::{FieldModel, SheetOptions};
use relume::{ReflectanceField, Result, Space};
use serde_json::json;

use super::{Job, Window};
use crate::context::Context;
use crate::output;
use crate::report::Report;

/// Draws a window.
pub fn draw(job: &Job<'_>, model: &FieldModel, context: &Context) -> Result<Report> {
    let window @ Window { x, y, size } = job.window()?;
    let options = SheetOptions { origin: [x, y], size, seed: job.seed, tile: job.tile };
    let field = model.synthesize(&options, &context.limits)?;
    write(job, &field, format(job, model)?, context)?;
    let of = if job.tile { "of a model; tiles without a seam" } else { "of a model" };
    Ok(job.report(window, of, json!({ "tile": job.tile })))
}

/// Writes the field, in tiles where asked.
fn write(job: &Job<'_>, field: &ReflectanceField, format: FieldFormat, context: &Context) -> Result<()> {
    if job.args.exr_tile.is_none() {
        let bytes = encode_field(field, format, None, &context.limits).map_err(|e| e.at(job.output))?;
        return output::write(job.output, &bytes, context);
    }
    let streamed = job.encoded(field, format, None, context)?;
    job.write(&streamed, field.size(), context, &mut |lane, x, y, row| {
        streamed.lanes()[lane].copy_row(field.size().width, x, y, row);
        Ok(())
    })
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
