//! `relume synth` for windows of an endless plane: from a tile set, by noise, or from a random-field model,
//! written row by row.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use relume::format::tile_set::in_words;
use relume::format::{Content, FieldFormat, HeightFormat, MapRole, Opened, TileSetFile};
use relume::random_field::FieldModel;
use relume::synthesis::noise::NoiseOptions;
use relume::workflow::endless::{Drawing, FileTarget, ModelPlane, NoisePlane, PlaneWindow, TilePlane};
use relume::{Error, Result, Size};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;
use crate::{args, gathered, input, output};

/// Arguments for endless textures.
#[derive(Debug, Clone, clap::Args)]
#[group(skip)]
pub struct EndlessArgs {
    /// Draw this window of the endless plane of tiles, noise or a model: left, top, width and height in
    /// texels. Windows agree where they overlap; --size draws from 0,0
    #[arg(
        long,
        value_name = "X,Y,W,H",
        value_parser = <PlaneWindow as FromStr>::from_str,
        allow_hyphen_values = true,
        conflicts_with = "size"
    )]
    window: Option<PlaneWindow>,
    /// Store the .exr output in tiles of this size instead of rows, so that readers can load any part alone:
    /// 256x256, or 256 for squares
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    exr_tile: Option<Size>,
    /// Side of the triangles of noise in texels [default: 0.29 of the smaller side of the exemplar]
    #[arg(long, value_name = "N")]
    triangle: Option<f64>,
}

/// The request to `relume synth`.
pub struct Request<'a> {
    /// Arguments for endless textures.
    pub args: &'a EndlessArgs,
    /// The files to make a texture from.
    pub exemplars: &'a [PathBuf],
    /// The file to write.
    pub output: &'a Path,
    /// The requested size.
    pub size: Option<Size>,
    /// The seed of the random choices.
    pub seed: u64,
    /// Whether noise is requested.
    pub noise: bool,
    /// Whether the output has to tile, which only a model supports.
    pub tile: bool,
    /// Given options without a meaning for an endless plane.
    pub other_options: Vec<String>,
}

/// The outcome of a request.
pub enum Drawn {
    /// A window of an endless plane was drawn and written.
    Window(Report),
    /// Blocks are to be placed; this one of the exemplars has been read already.
    Not(Option<Opened>),
}

/// Draws a window of an endless plane; `None` where blocks are to be placed instead.
pub fn run(request: &Request<'_>, context: &Context) -> Result<Drawn> {
    let source = source(request, context)?;
    if matches!(source, PlaneSource::Exemplars(_)) && request.args.exr_tile.is_some() {
        return Err(Error::usage(
            "--exr-tile stores endless textures, which tiles, a model or --method noise make: leave it out",
        ));
    }
    if let PlaneSource::Exemplars(opened) = source {
        return Ok(Drawn::Not(opened));
    }
    let unused = request.other_options.iter().find(|option| *option != "--tile" || !source.can_tile());
    if let Some(option) = unused {
        return Err(Error::usage(format!("{option} has no meaning for an endless plane: leave it out")));
    }
    let inputs: Vec<&Path> = request.exemplars.iter().map(PathBuf::as_path).collect();
    let mut outputs = Outputs::new(context);
    outputs.file(request.output, &inputs)?;
    let report = match source {
        PlaneSource::Tiles(tiles) => request.draw_tiles(&tiles, &mut outputs, context),
        PlaneSource::Model(model) => request.draw_model(&model, &mut outputs, context),
        PlaneSource::Noise(exemplar) => request.draw_noise(exemplar, &mut outputs, context),
        PlaneSource::Exemplars(opened) => return Ok(Drawn::Not(opened)),
    }?;
    Ok(Drawn::Window(report.with_outputs(outputs.commit()?)))
}

/// The source of a texture.
enum PlaneSource {
    Tiles(Box<TileSetFile>),
    Model(Box<FieldModel>),
    Noise(Opened),
    /// Blocks; the exemplar has been read if it is the only one.
    Exemplars(Option<Opened>),
}

impl PlaneSource {
    /// Whether a part of the plane can be made to tile.
    fn can_tile(&self) -> bool {
        matches!(self, Self::Model(_))
    }
}

/// The source for the request; `None` where blocks are to be placed.
fn source(request: &Request<'_>, context: &Context) -> Result<PlaneSource> {
    let opened = match request.exemplars {
        [path] => Some(input::open(path, &context.job)?),
        _ => None,
    };
    let content = opened.as_ref().map(Opened::content);
    match (opened, content, request.noise) {
        (_, Some(Content::Tiles | Content::Model), true) => Err(Error::usage(
            "--method noise takes an exemplar, and this is a set of tiles or a model: leave it out",
        )),
        (Some(opened), Some(Content::Tiles), _) => {
            opened.into_tiles().map(|tiles| PlaneSource::Tiles(Box::new(tiles)))
        }
        (Some(opened), Some(Content::Model), _) => Ok(PlaneSource::Model(Box::new(opened.into_model()?))),
        (Some(opened), _, true) => Ok(PlaneSource::Noise(opened)),
        (None, _, true) => Err(Error::usage("--method noise makes a texture of one exemplar: give one")),
        (_, _, false) if request.args.window.is_some() => Err(Error::usage(
            "--window draws from a set of tiles made by relume roll, from a model, or with --method noise: \
             this is none of them",
        )),
        (opened, ..) => Ok(PlaneSource::Exemplars(opened)),
    }
}

impl Request<'_> {
    /// The part of the plane to draw.
    fn window(&self) -> Result<PlaneWindow> {
        let from_origin = self.size.map(PlaneWindow::of_size);
        let window = self.args.window.or(from_origin);
        window.ok_or_else(|| Error::usage("the output has no size: give --size or --window"))
    }

    /// The file to write, in a given format.
    fn target(&self, format: FieldFormat) -> FileTarget {
        FileTarget { format, tile: self.args.exr_tile }
    }

    /// Tiles copied into place.
    fn draw_tiles(&self, tiles: &TileSetFile, outputs: &mut Outputs, context: &Context) -> Result<Report> {
        if self.args.triangle.is_some() {
            return Err(Error::usage(
                "--triangle belongs to --method noise, and this is a set of tiles: leave it out",
            ));
        }
        let (window, TileSetFile { file, count, cells, corners }) = (self.window()?, tiles);
        let plane = TilePlane { file, count: *count, cells: *cells, corners: *corners, seed: self.seed };
        let target = self.target(gathered::format_of(self.output, &file.encoding)?);
        self.write(plane.drawing(window, &target, &context.job), outputs)?;
        let Size { width, height } = cells.bounds();
        let details = json!({ "tiles": count, "tile_width": width, "tile_height": height, "cells": cells });
        Ok(self.report(window, &format!("of {}", in_words(*count, cells)), details))
    }

    /// Noise from the exemplar.
    fn draw_noise(&self, exemplar: Opened, outputs: &mut Outputs, context: &Context) -> Result<Report> {
        let (window, path) = (self.window()?, exemplar.name().to_owned());
        let file = exemplar.into_field()?;
        let options = NoiseOptions { side: self.args.triangle, seed: self.seed };
        let role = MapRole::of_name(&path);
        let plane = NoisePlane::new(&file, role, &options, &context.job).map_err(|e| e.at(path))?;
        let target = self.target(gathered::format_of(self.output, &file.encoding)?);
        self.write(plane.drawing(window, &target, &context.job), outputs)?;
        let noise = plane.noise();
        let details = json!({ "triangle": noise.side(), "measured": noise.suitability() });
        Ok(self.report(window, &format!("of noise in triangles of {:.1}", noise.side()), details))
    }

    /// A model's plane.
    fn draw_model(&self, model: &FieldModel, outputs: &mut Outputs, context: &Context) -> Result<Report> {
        let window = self.window()?;
        let plane = ModelPlane { model, seed: self.seed, period: self.tile.then_some(window.size) };
        let drawing = match model.heights {
            Some(_) => plane.height_drawing(window, self.height_format()?, &context.job),
            None => {
                let is_named = !output::is_stream(self.output);
                let named = is_named.then(|| FieldFormat::from_path(self.output)).transpose()?;
                let target = self.target(named.unwrap_or(plane.customary_format()));
                plane.drawing(window, &target, &context.job)
            }
        };
        self.write(drawing, outputs)?;
        let of = if self.tile { "of a model; tiles without a seam" } else { "of a model" };
        Ok(self.report(window, of, json!({ "tile": self.tile })))
    }

    fn height_format(&self) -> Result<HeightFormat> {
        if self.args.exr_tile.is_some() {
            return Err(Error::usage(
                "--exr-tile has no meaning for a height map, which is written at once: leave it out",
            ));
        }
        match output::is_stream(self.output) {
            true => Ok(HeightFormat::Exr),
            false => HeightFormat::from_path(self.output),
        }
    }

    /// Writes the output.
    fn write(&self, drawing: Result<Drawing<'_>>, outputs: &mut Outputs) -> Result<()> {
        let drawing = drawing.map_err(|e| e.at(self.output))?;
        if output::is_stream(self.output) {
            return outputs.write(self.output, drawing.into_bytes()?);
        }
        outputs.write_with(self.output, |out| drawing.write(out))
    }

    /// The report: the window, its source, and details.
    fn report(&self, window: PlaneWindow, of: &str, details: Value) -> Report {
        let PlaneWindow { x, y, size } = window;
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
