//! Windows of the plane that noise makes of an exemplar.

use relume::field::{Domain, IndexSpace, Metric};
use relume::format::{Encoding, FieldFile, FieldFormat, PtmEncoding, Streamed};
use relume::synthesis::noise::{Noise, NoiseOptions};
use relume::{Error, Result};
use serde_json::json;

use super::bands::{Bands, Cost, Cut};
use super::{Drawing, Window};
use crate::context::Context;
use crate::input;
use crate::output::Outputs;
use crate::report::Report;

/// Computes the window in bands of rows, or of the tiles of the file.
pub fn draw(drawing: &Drawing<'_>, outputs: &mut Outputs, context: &Context) -> Result<Report> {
    let [path] = drawing.exemplars else {
        return Err(Error::usage("--method noise makes a texture of one exemplar: give one"));
    };
    let (window, job) = (drawing.window()?, &context.job);
    let file = input::field(path, job)?;
    let space = IndexSpace::new(&file.field, Metric::Function, Domain::Hemisphere)?;
    job.check("the index of the exemplar", file.field.size(), 4 * space.planes() as u64)?;
    let options = NoiseOptions { side: drawing.args.triangle, seed: drawing.seed };
    let noise = Noise::new(&space.index_planes(&file.field), &options, job).map_err(|e| e.at(path))?;
    let format = drawing.format(&file.encoding)?;
    let scale = scale(&file, format).map_err(|e| e.at(drawing.output))?;
    let head = drawing.laid(Streamed::made(&file.field, format, scale.as_ref(), job))?;
    let make = |part: &Window| {
        let index = noise.window(part.x, part.y, part.size, job)?;
        Streamed::made(&space.field(&file.field, &index)?, format, scale.as_ref(), job)
    };
    let stored = head.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
    // Index planes twice, and the field's.
    let made = 4 * (2 * space.planes() + file.field.coefficients().count()) as u64;
    let cost = Cost { stored, made };
    let cut = Cut::new(&window, CELL, drawing.args.exr_tile, cost, job).map_err(|e| e.at(drawing.output))?;
    let mut bands = Bands::new(window, cut, &make);
    drawing.write(&head, window.size, outputs, context, &mut |lane, x, y, row| bands.row(lane, x, y, row))?;
    let details = json!({ "triangle": noise.side(), "measured": noise.suitability() });
    Ok(drawing.report(window, &format!("of noise in triangles of {:.1}", noise.side()), details))
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
