//! `relume synth` where the output is any window of an endless plane: from a set of tiles, by noise, or from a
//! random-field model, written row by row.

mod bands;
mod model;
mod noise;
mod tiles;

use std::io::Cursor;
use std::path::{Path, PathBuf};

use relume::format::{Encoding, FieldFormat, PictureFormat, Rows, Streamed};
use relume::random_field::FieldModel;
use relume::{Error, ReflectanceField, Result, Size};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;
use crate::tile_set::{self, TileSetFile};
use crate::{args, input, output};

/// Arguments for endless textures.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct EndlessArgs {
    /// Draw this part of the endless plane that tiles, noise or a model make: left, top, width and height in
    /// texels. Parts are identical however the plane is cut; --size draws from 0,0
    #[arg(
        long,
        value_name = "X,Y,W,H",
        value_parser = window,
        allow_hyphen_values = true,
        conflicts_with = "size"
    )]
    window: Option<Window>,
    /// Store the .exr output in tiles of this size instead of in rows, so that readers can take any
    /// part of it without the rest: 256x256, or 256 for squares
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    exr_tile: Option<Size>,
    /// Side of the triangles of noise in texels [default: 0.29 of the exemplar's smaller side]
    #[arg(long, value_name = "N")]
    triangle: Option<f64>,
}

/// A rectangle of the plane.
#[derive(Debug, Clone, Copy)]
struct Window {
    x: i64,
    y: i64,
    size: Size,
}

/// What `relume synth` was asked for.
pub struct Drawing<'a> {
    /// Arguments for endless textures.
    pub args: &'a EndlessArgs,
    /// The files to make a texture from.
    pub exemplars: &'a [PathBuf],
    /// The file to write.
    pub output: &'a Path,
    /// The size asked for.
    pub size: Option<Size>,
    /// The seed of the random choices.
    pub seed: u64,
    /// Whether noise is asked for.
    pub noise: bool,
    /// Whether the output is to continue itself, which only a model can make it do.
    pub tile: bool,
    /// Options given that have no meaning for an endless plane.
    pub other_options: Vec<String>,
}

/// Draws a window of an endless plane; none where blocks are to be laid instead.
pub fn run(drawing: &Drawing<'_>, context: &Context) -> Result<Option<Report>> {
    let Some(source) = source(drawing, context)? else {
        return match drawing.args.exr_tile {
            Some(_) => Err(Error::usage(
                "--exr-tile stores endless textures, which tiles, a model or --method noise make: leave it out",
            )),
            None => Ok(None),
        };
    };
    let unused = drawing.other_options.iter().find(|option| *option != "--tile" || !source.can_tile());
    if let Some(option) = unused {
        return Err(Error::usage(format!("{option} has no meaning for an endless plane: leave it out")));
    }
    let inputs: Vec<&Path> = drawing.exemplars.iter().map(PathBuf::as_path).collect();
    let mut outputs = Outputs::new(context);
    outputs.file(drawing.output, &inputs)?;
    let report = match source {
        Source::Tiles(tiles) => tiles::draw(drawing, &tiles, &mut outputs, context),
        Source::Model(model) => model::draw(drawing, &model, &mut outputs, context),
        Source::Noise => noise::draw(drawing, &mut outputs, context),
    }?;
    Ok(Some(report.with_outputs(outputs.commit()?)))
}

/// What makes an endless plane.
enum Source {
    Tiles(TileSetFile),
    Model(Box<FieldModel>),
    Noise,
}

impl Source {
    /// Whether a part of the plane can be made to continue itself.
    fn can_tile(&self) -> bool {
        matches!(self, Self::Model(_))
    }
}

/// What the drawing draws from; none where blocks are to be laid.
fn source(drawing: &Drawing<'_>, context: &Context) -> Result<Option<Source>> {
    let mut own = None;
    if let [path] = drawing.exemplars {
        own = tile_set::open(path, &context.job)?.map(Source::Tiles);
        if own.is_none() {
            own = input::model(path, &context.job)?.map(|model| Source::Model(Box::new(model)));
        }
    }
    match (own, drawing.noise) {
        (Some(_), true) => Err(Error::usage(
            "--method noise takes an exemplar, and this is a set of tiles or a model: leave it out",
        )),
        (None, true) => Ok(Some(Source::Noise)),
        (None, false) if drawing.args.window.is_some() => Err(Error::usage(
            "--window draws from a set of tiles made by relume roll, from a model, or with --method noise: \
             this is none of them",
        )),
        (own, false) => Ok(own),
    }
}

impl Drawing<'_> {
    /// The part of the plane to draw.
    fn window(&self) -> Result<Window> {
        let from_origin = self.size.map(|size| Window { x: 0, y: 0, size });
        let window = self.args.window.or(from_origin);
        window.ok_or_else(|| Error::usage("the output has no size: give --size or --window"))
    }

    /// The format of the output; on standard output that of the input.
    fn format(&self, encoding: &Encoding) -> Result<FieldFormat> {
        if !output::is_stream(self.output) {
            return Ok(FieldFormat::from_path(self.output)?.in_depth_of(encoding));
        }
        Ok(match *encoding {
            Encoding::Ptm(_) => FieldFormat::Ptm,
            Encoding::Picture(depth) => FieldFormat::Picture(PictureFormat::Png(depth)),
            Encoding::Exr(depth) => FieldFormat::Exr(depth),
        })
    }

    /// A field as the output's format stores it.
    fn encoded(
        &self,
        field: &ReflectanceField,
        format: FieldFormat,
        encoding: Option<&Encoding>,
        context: &Context,
    ) -> Result<Streamed> {
        self.laid(Streamed::new(field, format, encoding, &context.job))
    }

    /// In tiles where these are asked for.
    fn laid(&self, streamed: Result<Streamed>) -> Result<Streamed> {
        let laid = streamed.and_then(|streamed| match self.args.exr_tile {
            Some(tile) => streamed.in_tiles(tile),
            None => Ok(streamed),
        });
        laid.map_err(|e| e.at(self.output))
    }

    /// Writes the output, whose rows are copied by `rows`.
    fn write(
        &self,
        streamed: &Streamed,
        size: Size,
        outputs: &mut Outputs,
        context: &Context,
        rows: &mut Rows<'_>,
    ) -> Result<()> {
        let texel: usize = streamed.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
        context.job.check("the output", size, 0)?;
        context.job.check_bytes("the rows of the output", streamed.working_bytes(size))?;
        let across = size.width.div_ceil(streamed.block(size).width);
        let steps = size.height * streamed.lanes().len() * across;
        context.job.start("drawing rows", steps as u64);
        let mut rows = |lane: usize, x: usize, y: usize, row: &mut [u8]| {
            context.job.advance(1)?;
            rows(lane, x, y, row)
        };
        if !output::is_stream(self.output) {
            return outputs.write_with(self.output, |out| streamed.write(size, out, &mut rows));
        }
        context.job.check("the output", size, texel as u64)?;
        let mut bytes = Cursor::new(Vec::new());
        streamed.write(size, &mut bytes, &mut rows)?;
        outputs.write(self.output, bytes.into_inner())
    }

    /// What was drawn, of what.
    fn report(&self, window: Window, of: &str, details: Value) -> Report {
        let Window { x, y, size } = window;
        let text = format!("{}: {size} texels of the plane from ({x}, {y}), {of}", self.output.display());
        let mut json = json!({
            "x": x,
            "y": y,
            "width": size.width,
            "height": size.height,
            "seed": self.seed,
        });
        if let (Some(all), Value::Object(details)) = (json.as_object_mut(), details) {
            all.extend(details);
        }
        Report::new(text, json)
    }
}

/// The farthest that a window may lie from the origin: far beyond any picture, and without overflow.
const FARTHEST: i64 = 1 << 52;

/// `X,Y,W,H` in whole texels.
fn window(text: &str) -> Result<Window, String> {
    let numbers: Option<Vec<i64>> = text.split(',').map(|s| s.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, w, h]) if w > 0 && h > 0 && x.abs().max(y.abs()).max(w).max(h) <= FARTHEST => {
            Ok(Window { x, y, size: Size::new(w as usize, h as usize) })
        }
        _ => Err("expected left, top, width and height such as -200,1000,512,512 in whole texels".to_owned()),
    }
}
