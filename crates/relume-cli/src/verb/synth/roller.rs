//! `relume synth --method roller`: tiles of whole periods laid in random order, in one step.

use relume::synthesis::roller::{RollerOptions, lay, roll};
use relume::synthesis::{BlockOptions, Boundary, Exemplar, SourceMap};
use relume::{Error, Result, Size};
use serde_json::json;

use crate::context::Context;
use crate::report::Report;
use crate::tile_set::in_words;

/// Tiles to make, and the texture to lay of them.
#[derive(Debug)]
pub struct Laid {
    options: RollerOptions,
    size: Size,
    boundary: Boundary,
    seed: u64,
}

impl Laid {
    /// Tiles of a set unless asked otherwise: each holds about a quarter of the exemplar.
    pub const TILES: usize = 4;

    /// So many tiles in a texture of the blocks' size, boundary and seed.
    pub fn new(tiles: usize, blocks: &BlockOptions) -> Result<Self> {
        // Only rectangles close on the output's own sides.
        let oblique = blocks.boundary == Boundary::Open;
        let options = RollerOptions { tiles, oblique, ..RollerOptions::default() };
        options.validate()?;
        if blocks.guidance.is_some() {
            return Err(Error::usage("--method roller lays tiles in random order and follows no guides"));
        }
        Ok(Self { options, size: blocks.size, boundary: blocks.boundary, seed: blocks.seed })
    }

    /// Makes the tiles and lays them.
    pub fn run(
        &self,
        args: &super::Args,
        exemplars: &[Exemplar<'_>],
        context: &Context,
    ) -> Result<(SourceMap, Report)> {
        let [exemplar] = exemplars else {
            return Err(Error::usage("--method roller makes tiles of one exemplar: give one"));
        };
        let rolled = roll(exemplar, &self.options, &context.job)?;
        let map = lay(&rolled.tiles, self.size, self.boundary, self.seed, &context.job)?;
        let (count, tile, cells) = (rolled.tiles.count(), rolled.tiles.tile(), rolled.tiles.cells());
        let good = rolled.report.is_acceptable();
        let text = format!(
            "{}: {} texels of {} in random order; {}",
            args.output.display(),
            self.size,
            in_words(count, cells),
            if good { "seams are acceptable" } else { "seams may be seen" }
        );
        let json = json!({
            "width": self.size.width,
            "height": self.size.height,
            "method": "roller",
            "tile": self.boundary == Boundary::Torus,
            "seed": self.seed,
            "tiles": count,
            "tile_width": tile.width,
            "tile_height": tile.height,
            "cells": cells,
            "acceptable": good,
            "roller": rolled.report,
        });
        Ok((map, Report::new(text, json)))
    }
}
