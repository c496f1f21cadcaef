//! Windows of the plane that noise makes of an exemplar.

use relume::field::{Domain, IndexSpace, Metric};
use relume::format::{Encoding, FieldFile, FieldFormat, PtmEncoding, Streamed};
use relume::synthesis::noise::{Noise, NoiseOptions};
use relume::{Error, Result};
use serde_json::json;

use super::bands::{Bands, Cost, Cut};
use super::{Job, Window};
use crate::context::Context;
use crate::input;
use crate::report::Report;

/// Computes the window in bands of rows, or of the tiles of the file.
pub fn draw(job: &Job<'_>, context: &Context) -> Result<Report> {
    let [path] = job.exemplars else {
        return Err(Error::usage("--method noise makes a texture of one exemplar: give one"));
    };
    let (window, limits) = (job.window()?, &context.limits);
    let file = input::field(path, limits)?;
    let space = IndexSpace::new(&file.field, Metric::Function, Domain::Hemisphere)?;
    limits.check("the index of the exemplar", file.field.size(), 4 * space.planes() as u64)?;
    let options = NoiseOptions { side: job.args.triangle, seed: job.seed };
    let noise = Noise::new(&space.index_planes(&file.field), &options, limits).map_err(|e| e.at(path))?;
    let format = job.format(&file.encoding)?;
    let scale = scale(&file, format).map_err(|e| e.at(job.output))?;
    let head = job.laid(Streamed::made(&file.field, format, scale.as_ref(), limits))?;
    let make = |part: &Window| {
        let index = noise.window(part.x, part.y, part.size, limits)?;
        Streamed::made(&space.field(&file.field, &index)?, format, scale.as_ref(), limits)
    };
    let stored = head.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
    // Index planes twice, and the field's.
    let made = 4 * (2 * space.planes() + file.field.coefficients().count()) as u64;
    let cost = Cost { stored, made };
    let cut = Cut::new(&window, CELL, job.args.exr_tile, cost, limits).map_err(|e| e.at(job.output))?;
    let mut bands = Bands::new(window, cut, &make);
    job.write(&head, window.size, context, &mut |lane, x, y, row| bands.row(lane, x, y, row))?;
    let details = json!({ "triangle": noise.side(), "measured": noise.suitability() });
    Ok(job.report(window, &format!("of noise in triangles of {:.1}", noise.side()), details))
}

/// Rows of bands and columns of pieces are multiples of this.
const CELL: usize = 64;

/// The scale of a `.ptm`: the exemplar's, or what is chosen for it. The same for all bands.
fn scale(file: &FieldFile, format: FieldFormat) -> Result<Option<PtmEncoding>> {
    match (format, file.encoding) {
        (FieldFormat::Ptm, Encoding::Ptm(stored)) => Ok(Some(stored)),
        (FieldFormat::Ptm, _) => PtmEncoding::chosen(&file.field).map(Some),
        _ => Ok(None),
    }
}
