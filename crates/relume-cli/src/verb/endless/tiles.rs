//! Windows of the plane that a set of tiles makes.

use relume::synthesis::roller::Endless;
use relume::{Error, Result, Size};
use serde_json::json;

use super::Drawing;
use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;
use crate::tile_set::{TileSetFile, in_words};

/// Copies the tiles into place, in the bytes that the file stores.
pub fn draw(
    drawing: &Drawing<'_>,
    tiles: &TileSetFile,
    outputs: &mut Outputs,
    context: &Context,
) -> Result<Report> {
    if drawing.args.triangle.is_some() {
        return Err(Error::usage(
            "--triangle belongs to --method noise, and this is a set of tiles: leave it out",
        ));
    }
    let (window, file, cells) = (drawing.window()?, &tiles.file, tiles.cells);
    let plane = Endless::of(cells, tiles.count, drawing.seed)?;
    let format = drawing.format(&file.encoding)?;
    let streamed = drawing.encoded(&file.field, format, Some(&file.encoding), context)?;
    let lanes = streamed.lanes();
    let mut rows = |lane: usize, x: usize, y: usize, row: &mut [u8]| {
        let (lane, x, y) = (&lanes[lane], window.x + x as i64, window.y + y as i64);
        plane.copy_row(&lane.data, lane.bytes_per_texel, x, y, row);
        Ok(())
    };
    drawing.write(&streamed, window.size, outputs, context, &mut rows)?;
    let Size { width, height } = cells.bounds();
    let details = json!({ "tiles": tiles.count, "tile_width": width, "tile_height": height, "cells": cells });
    Ok(drawing.report(window, &format!("of {}", in_words(tiles.count, &cells)), details))
}
