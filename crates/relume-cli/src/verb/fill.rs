//! `relume fill`: holes of a texture filled with copies of its own texels.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::{Domain, Metric};
use relume::format::{FieldFile, FieldFormat};
use relume::synthesis::fill::{FillMethod, FillOptions, fill};
use relume::synthesis::pixel::Growth;
use relume::synthesis::{Boundary, SourceMap};
use relume::{Error, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output;
use crate::report::Report;
use crate::{args, gathered, input};

/// Arguments of `relume fill`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume fill wool.ptm --mask label.png -o clean.ptm")]
pub struct Args {
    /// A .ptm, an .exr field, or a picture; - is standard input
    file: PathBuf,
    /// The holes: white in a mask as large as the texture
    #[arg(long, value_name = "MASK")]
    mask: PathBuf,
    /// The texture tiles: beyond an edge lies the opposite one
    #[arg(long)]
    tile: bool,
    #[command(flatten)]
    how: How,
}

/// Options shared with `relume tileable`.
#[derive(Debug, clap::Args)]
pub struct How {
    /// The texture to write; - writes it to standard output in the input's format
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Fill patch after patch, or texel after texel
    #[arg(long, default_value = "patches", value_parser = method())]
    method: FillMethod,
    /// Side of the patches, or of the window of texels that is compared: odd
    #[arg(long = "neighbourhood", value_name = "N", default_value_t = 11)]
    window: usize,
    /// Draw among windows up to (1 + E) times the squared distance of the best one [default: 0 for
    /// patches, 0.1 for efros-leung]
    #[arg(long, value_name = "E")]
    epsilon: Option<f64>,
    /// Texels that may not be copied: white in a mask as large as the texture
    #[arg(long, value_name = "MASK")]
    exclude: Option<PathBuf>,
    /// What the distance of two texels means, as in relume synth
    #[arg(long, default_value = "function", value_parser = args::metric())]
    metric: Metric,
    /// The light directions over which functions are compared
    #[arg(long, default_value = "hemisphere", value_parser = args::domain())]
    domain: Domain,
    /// Another seed gives another filling, where several fit
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Also write where each texel comes from, as x, y and exemplar: .npy or .exr
    #[arg(long, value_name = "FILE")]
    source_map: Option<PathBuf>,
}

/// Fills the holes and writes all that was asked for.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    args.how.check(&[&args.file, &args.mask], context)?;
    let boundary = if args.tile { Boundary::Torus } else { Boundary::Open };
    let texture = args.how.read(&args.file, context)?;
    let holes = input::mask(&args.mask, texture.file[0].field.size(), &context.limits)?;
    let options = args.how.options(boundary);
    let excluded = texture.excluded.as_deref();
    let (map, growth) = fill(&texture.index, &holes, excluded, &options, &context.limits, &context.progress)?;
    args.how.finish(&texture, &map, &growth, "of the holes", json!({ "tile": args.tile }), context)
}

/// A texture ready to be filled.
pub struct Texture {
    /// The file, one alone.
    pub file: [FieldFile; 1],
    /// Its index planes.
    pub index: relume::Planes,
    /// Its texels that may not be copied.
    pub excluded: Option<Vec<bool>>,
}

impl How {
    /// Refuses outputs before any work is done.
    pub fn check(&self, inputs: &[&Path], context: &Context) -> Result<()> {
        let mut inputs = inputs.to_vec();
        inputs.extend(self.exclude.as_deref());
        if inputs.iter().filter(|path| output::is_stream(path)).count() > 1 {
            return Err(Error::usage("standard input can be read only once: give - for one input at most"));
        }
        output::check(&self.output, &inputs, context)?;
        if !output::is_stream(&self.output) {
            FieldFormat::from_path(&self.output)?;
        }
        if let Some(path) = &self.source_map {
            output::check(path, &inputs, context)?;
            gathered::check_map(path)?;
            if *path == self.output {
                return Err(Error::usage("is named for two outputs of this command: choose another").at(path));
            }
        }
        Ok(())
    }

    /// Reads a texture, its index planes, and the texels that may not be copied.
    pub fn read(&self, path: &Path, context: &Context) -> Result<Texture> {
        let file = [input::field(path, &context.limits)?];
        let index = gathered::index(&file, self.metric, self.domain, context)?.swap_remove(0);
        let mask = |path: &PathBuf| input::mask(path, index.size(), &context.limits);
        let excluded = self.exclude.as_ref().map(mask).transpose()?;
        Ok(Texture { file, index, excluded })
    }

    /// The library's options.
    pub fn options(&self, boundary: Boundary) -> FillOptions {
        let customary = if self.method == FillMethod::Texels { 0.1 } else { 0.0 };
        FillOptions {
            method: self.method,
            window: self.window,
            epsilon: self.epsilon.unwrap_or(customary),
            boundary,
            seed: self.seed,
        }
    }

    /// Writes what a map makes of the texture, and says how; `special` is what one verb alone knows.
    pub fn finish(
        &self,
        texture: &Texture,
        map: &SourceMap,
        growth: &Growth,
        what: &str,
        special: Value,
        context: &Context,
    ) -> Result<Report> {
        let bytes = gathered::apply(map, &texture.file, &self.output, context)?;
        let source_map =
            self.source_map.as_ref().map(|path| gathered::source_map(map, path, context)).transpose()?;
        output::write(&self.output, &bytes, context)?;
        for (path, bytes) in self.source_map.iter().zip(source_map) {
            output::write(path, &bytes, context)?;
        }
        let text = format!(
            "{}: {} texels {what} filled from windows of {}, drawn from {} positions",
            self.output.display(),
            growth.texels,
            self.window,
            growth.positions
        );
        let outputs: Vec<&Path> = [&self.output].into_iter().chain(&self.source_map).map(|p| &**p).collect();
        let mut json = json!({
            "width": map.size().width,
            "height": map.size().height,
            "window": self.window,
            "seed": self.seed,
            "filling": growth,
            "outputs": outputs,
        });
        special.as_object().into_iter().flatten().for_each(|(name, value)| json[name] = value.clone());
        Ok(Report::new(text, json).with_stdout_taken(output::is_stream(&self.output)))
    }
}

fn method() -> impl TypedValueParser<Value = FillMethod> {
    PossibleValuesParser::new(["patches", "efros-leung"])
        .map(|name| if name == "patches" { FillMethod::Patches } else { FillMethod::Texels })
}
