//! `relume fill`: holes of a texture filled with copies of its own texels.

use std::path::{Path, PathBuf};

use relume::field::Domain;
use relume::format::FieldFile;
use relume::synthesis::fill::{FillMethod, FillOptions, fill};
use relume::synthesis::pixel::Growth;
use relume::synthesis::{Boundary, Guidance, SourceMap};
use relume::workflow::sizes::filling_window;
use relume::workflow::tiling::MeasuredTiling;
use relume::workflow::{Btf, NamedMetric};
use relume::{Error, Named, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output::Outputs;
use crate::rearranged;
use crate::rearranged_btf::{self, AppliedBtf};
use crate::registered::{Applied, Registered, compared, read_registered};
use crate::report::Report;
use crate::tiling::with_tiling;
use crate::{args, gathered, input, opacity};

/// Arguments of `relume fill`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Example:\n  relume fill wool.ptm --mask label.png -o clean.ptm\n  \
                        relume fill meadow.png --mask car.png --guide labels.png -o clean.png")]
pub struct Args {
    /// A .ptm, an .exr field, or a picture; - is standard input
    file: PathBuf,
    /// The holes: white in a mask as large as the texture, or painted in its opacity
    #[arg(long, value_name = "MASK")]
    mask: PathBuf,
    /// The texture tiles: its opposite edges are adjacent
    #[arg(long)]
    tile: bool,
    #[command(flatten)]
    how: How,
}

/// Options shared with `relume tileable`.
#[derive(Debug, Clone, clap::Args)]
pub struct How {
    /// The texture to write; - writes it to standard output in the input's format
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// Fill patch by patch, texel by texel, or, where the texture tiles, all at once from coarse to fine, or
    /// bridge its border by large blocks [default: patches; of relume tileable bridges]
    #[arg(long, value_parser = args::named::<FillMethod>())]
    method: Option<FillMethod>,
    /// Side of the patches, or of the window of compared texels: odd [default: two features, 11 to 21]
    #[arg(long = "neighbourhood", value_name = "N")]
    window: Option<usize>,
    /// Draw from windows up to (1 + E) times the squared distance of the best one [default: 0 for patches,
    /// 0.1 for efros-leung]
    #[arg(long, value_name = "E")]
    epsilon: Option<f64>,
    /// A map of the size of the texture that steers the content of the holes: labels, or a blurred or painted
    /// copy; windows are compared by it as well, also inside the holes
    #[arg(long, value_name = "IMAGE")]
    guide: Option<PathBuf>,
    /// Weight of a difference of the map relative to one of the texture [default: 1]
    #[arg(long, value_name = "W", requires = "guide")]
    guide_weight: Option<f64>,
    /// Texels that may not be copied: white in a mask as large as the texture
    #[arg(long, value_name = "MASK")]
    exclude: Option<PathBuf>,
    /// Meaning of the distance of two texels, as in relume synth
    #[arg(long, default_value = "function", value_parser = args::named::<NamedMetric>())]
    metric: NamedMetric,
    /// The light directions over which functions are compared
    #[arg(long, default_value = "hemisphere", value_parser = args::named::<Domain>())]
    domain: Domain,
    /// Another seed gives another filling where several fit
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    pub rearranged: rearranged::Args,
}

/// Fills the holes and writes all requested outputs.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let claimed = args.how.claim(&[&args.file, &args.mask], context)?;
    let boundary = if args.tile { Boundary::Torus } else { Boundary::Open };
    let texture = args.how.read(&args.file, claimed, context)?;
    let holes = input::mask(&args.mask, texture.file[0].field.size(), &context.job)?;
    let options = args.how.options(FillMethod::Patches, boundary, &texture, &holes, context)?;
    let excluded = texture.excluded.as_deref();
    if !holes.contains(&true) {
        return Err(Error::usage("the mask has no hole: paint the texels to fill white").at(&args.mask));
    }
    let (map, growth) = fill(&texture.index, &holes, excluded, &options, &context.job)?;
    let special = json!({ "tile": args.tile });
    args.how.finish(texture, boundary, (&map, &growth), "of the holes", special, context)
}

/// The images that are filled in the same way as the texture, and all outputs.
pub type Claimed = (Vec<Applied>, Outputs);

/// A texture ready to be filled.
pub struct FilledTexture {
    /// The path of the file.
    name: PathBuf,
    /// The file, one alone.
    pub file: [FieldFile; 1],
    /// Its index planes.
    pub index: relume::Planes,
    /// Its texels that may not be copied.
    pub excluded: Option<Vec<bool>>,
    /// The guide, for known texels and holes.
    guide: Option<relume::Planes>,
    /// Where it goes.
    outputs: Outputs,
    images: Vec<Registered>,
    /// Photographs of light and view that are rearranged as well.
    sets: Vec<AppliedBtf>,
    btfs: Vec<Btf>,
}

impl How {
    /// Claims the outputs before any work is done.
    pub fn claim(&self, inputs: &[&Path], context: &Context) -> Result<Claimed> {
        let masks = self.exclude.as_deref().into_iter().chain(self.guide.as_deref());
        let inputs: Vec<&Path> = inputs.iter().copied().chain(masks).collect();
        let mut outputs = Outputs::new(context);
        let applied = self.rearranged.claim(&inputs, &[&self.output], 1, &mut outputs)?;
        Ok((applied, outputs))
    }

    /// Reads a texture, its index planes, the texels that may not be copied, its guide, and the images
    /// that are filled in the same way.
    pub fn read(&self, path: &Path, (applied, outputs): Claimed, context: &Context) -> Result<FilledTexture> {
        let file = [input::exemplar(path, &context.job)?];
        let images = read_registered(applied, &file, context)?;
        let sets = self.rearranged.btfs(&self.output)?;
        let btfs = rearranged_btf::open_all(&sets, file[0].field.size(), context)?;
        let space = self.metric.space(&file[0].field, self.domain)?;
        let index = gathered::index(&file, &compared(&images), &space, context)?.swap_remove(0);
        let mask = |path: &PathBuf| input::mask(path, index.size(), &context.job);
        let excluded = self.exclude.as_ref().map(mask).transpose()?;
        let excluded = opacity::excluded(&file[0], path, excluded, context);
        let guide = |path: &PathBuf| input::guide(path, index.size(), &context.job);
        let guide = self.guide.as_ref().map(guide).transpose()?;
        let rearranged = images.iter().map(|one| (&*one.applied.output, &one.files[0]));
        let outputs_of = std::iter::once((&*self.output, &file[0])).chain(rearranged);
        gathered::check_memory(index.size(), outputs_of, context)?;
        let name = path.to_owned();
        Ok(FilledTexture { name, file, index, excluded, guide, outputs, images, sets, btfs })
    }

    /// The options for the library, by the given method unless another is asked for. The guide of a texture
    /// also serves for the filled texture. A window that is not given is fitted to what lies outside the `holes`.
    pub fn options(
        &self,
        method: FillMethod,
        boundary: Boundary,
        texture: &FilledTexture,
        holes: &[bool],
        context: &Context,
    ) -> Result<FillOptions> {
        let method = self.method.unwrap_or(method);
        if matches!(method, FillMethod::Optimised | FillMethod::Bridges) && self.epsilon.is_some() {
            return Err(Error::usage(format!(
                "--epsilon does not apply to --method {}: it is an option of patches and efros-leung",
                method.name()
            )));
        }
        let customary = if method == FillMethod::Texels { 0.1 } else { 0.0 };
        let guidance = |guide: &relume::Planes| Guidance {
            sources: vec![guide.clone()],
            target: guide.clone(),
            weight: self.guide_weight.unwrap_or(1.0),
        };
        let excluded = texture.excluded.as_deref();
        let fitted = || filling_window(&texture.index, holes, excluded, &context.job);
        Ok(FillOptions {
            method,
            window: self.window.map_or_else(fitted, Ok)?,
            epsilon: self.epsilon.unwrap_or(customary),
            boundary,
            guidance: texture.guide.as_ref().map(guidance),
            seed: self.seed,
        })
    }

    /// Writes the texture made by a map, and reports; `special` is the part of the report specific to one
    /// verb, with the `window`.
    pub fn finish(
        &self,
        texture: FilledTexture,
        boundary: Boundary,
        (map, growth): (&SourceMap, &Growth),
        what: &str,
        special: Value,
        context: &Context,
    ) -> Result<Report> {
        let tiles = boundary == Boundary::Torus;
        let tiling =
            tiles.then(|| MeasuredTiling::measure(map, &[&texture.index], &context.job)).transpose()?;
        let named = (&texture.file[..], &*texture.name);
        let mut made = vec![self.rearranged.texture(map, named, &self.output, boundary, context)?];
        made.extend(self.rearranged.rearranged(map, &texture.images, boundary, context)?);
        let mut outputs = texture.outputs;
        if let Some((path, bytes)) = self.rearranged.source_map(map, context)? {
            outputs.write(&path, bytes)?;
        }
        let sets = rearranged_btf::write_all(&texture.sets, &texture.btfs, map, &mut outputs, context)?;
        let text = format!(
            "{}: {} texels {what} filled from windows of {} at {} positions",
            self.output.display(),
            growth.texels,
            growth.window,
            growth.positions
        );
        let mut json = json!({
            "width": map.size().width,
            "height": map.size().height,
            "window": growth.window,
            "seed": self.seed,
            "filling": growth,
        });
        special.as_object().into_iter().flatten().for_each(|(name, value)| json[name] = value.clone());
        let remedy = "try another --seed or --neighbourhood, or a wider band by relume tileable --band";
        let report = with_tiling(Report::new(text, json), tiling.as_ref(), remedy);
        let report = rearranged::with_tilings(self.rearranged.describe(&texture.images, report), &made);
        for one in made {
            outputs.write(&one.output, one.bytes)?;
        }
        let written = outputs.commit()?;
        Ok(report.with_lines(&sets).with_outputs(written))
    }
}
