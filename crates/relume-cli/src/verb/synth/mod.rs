//! `relume synth`: a new texture of any size from blocks or texels of exemplars, or any part of the
//! endless plane that tiles, noise or a model make.
//!
//! [`method`] holds what differs between the methods; [`auto`] chooses among them by measuring.

mod auto;
mod guide;
mod method;
mod roller;

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::Domain;
use relume::format::FieldFile;
use relume::synthesis::search::{KernelBasis, SearchMethod, SearchOptions};
use relume::synthesis::{Blend, BlockOptions, Boundary, Exemplar, SourceMap, Synthesis, Tolerance};
use relume::{Error, ReflectanceField, Result, Size};
use serde_json::json;

use super::endless;
use crate::context::Context;
use crate::output::Outputs;
use crate::rearranged::{self, Applied, read_all, read_registered};
use crate::report::Report;
use crate::{args, gathered, input};
use method::Plan;

/// Arguments of `relume synth`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume synth wool.ptm -o cloth.ptm --size 1024x1024 --tile\n  \
                        relume synth bricks.png -o wall.png --size 800 --block 64 --apply bricks_normals.png")]
pub struct Args {
    /// Exemplars: .ptm, .exr or pictures, all of one kind; - is standard input. Or one set of tiles
    /// made by relume roll, or one .rlm model
    #[arg(required = true, value_name = "FILE")]
    exemplars: Vec<PathBuf>,
    /// The texture to write; - writes it to standard output in the first exemplar's format
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height in texels: 512x512, or 512 for a square
    #[arg(long, value_name = "WxH", value_parser = args::size, required_unless_present = "window")]
    size: Option<Size>,
    #[command(flatten)]
    endless: endless::EndlessArgs,
    #[command(flatten)]
    method: method::Args,
    /// Side of the blocks in texels [default: 32, or as auto chooses]
    #[arg(long, value_name = "N")]
    block: Option<usize>,
    /// Texels by which blocks overlap [default: a sixth of the block]
    #[arg(long, value_name = "N")]
    overlap: Option<usize>,
    /// Draw among blocks up to (1 + T) times the distance of the best one [default: 0.1]
    #[arg(long, value_name = "T", conflicts_with = "delta")]
    tolerance: Option<f64>,
    /// Draw among blocks up to this distance instead: root mean square over the overlap's texels, in
    /// the units of the metric
    #[arg(long, value_name = "D")]
    delta: Option<f64>,
    /// Join blocks along cuts, one for each overlap or one seam through all of them at once, which
    /// copies every texel, or by ramps [default: cut]
    #[arg(long, value_parser = blend())]
    blend: Option<Blend>,
    /// Blend the functions within N texels of a cut on either side, at most the overlap; 0 copies
    /// every texel [default: 0]
    #[arg(long, value_name = "N")]
    feather: Option<usize>,
    /// Make the output tile without a seam
    #[arg(long)]
    tile: bool,
    /// What the distance of two texels means: that of their functions, of luminance and colour, or of
    /// luminance alone; legendre9 and legendre6 are the last two over the square, as in the documents
    #[arg(long, default_value = "function", value_parser = args::metric())]
    metric: args::NamedMetric,
    /// The light directions over which functions are compared
    #[arg(long, default_value = "hemisphere", value_parser = args::domain())]
    domain: Domain,
    /// How blocks are searched for; all ways give the same texture [default: auto]
    #[arg(long, value_parser = search())]
    search: Option<SearchMethod>,
    /// The basis of --search projection [default: svd]
    #[arg(long, value_name = "BASIS", value_parser = kernels())]
    kernels: Option<KernelBasis>,
    /// Exemplar texels that may not be used: white in a mask as large as the exemplar; with several
    /// exemplars, one mask for each in turn
    #[arg(long, value_name = "MASK", num_args = 1..)]
    exclude: Vec<PathBuf>,
    /// Also write what was searched and what it took, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// Another seed gives another texture
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    #[command(flatten)]
    guide: guide::Args,
    #[command(flatten)]
    rearranged: rearranged::Args,
}

impl Args {
    /// Options of blocks, and whether they are given.
    fn of_blocks(&self) -> [(&'static str, bool); 8] {
        [
            ("--block", self.block.is_some()),
            ("--overlap", self.overlap.is_some()),
            ("--tolerance", self.tolerance.is_some()),
            ("--delta", self.delta.is_some()),
            ("--blend", self.blend.is_some()),
            ("--feather", self.feather.is_some()),
            ("--search", self.search.is_some()),
            ("--kernels", self.kernels.is_some()),
        ]
    }
}

/// Synthesises a texture and writes all that was asked for.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    if let Some(report) = endless::run(&endless_job(args), context)? {
        return Ok(report);
    }
    let mut outputs = Outputs::new(context);
    let applied = claim_outputs(args, &mut outputs)?;
    let guidance = args.guide.read(args.exemplars.len(), context)?;
    let plan = Plan::new(args, BlockOptions { guidance, ..options(args) })?;
    let files = read_all(&args.exemplars, context)?;
    let images = read_registered(&applied, &files, context)?;
    let (map, report) = synthesise(args, &files, &plan, context)?;
    let output = gathered::apply(&map, &files, &args.output, context)?;
    let mut bytes = vec![(args.output.clone(), output)];
    for (job, images) in applied.into_iter().zip(&images) {
        let image = gathered::apply(&map, images, &job.output, context)?;
        bytes.push((job.output, image));
    }
    bytes.extend(args.rearranged.source_map(&map, context)?);
    if let Some(path) = &args.report {
        bytes.push((path.clone(), format!("{:#}\n", report.json).into_bytes()));
    }
    for (path, bytes) in bytes {
        outputs.write(&path, bytes)?;
    }
    Ok(report.with_outputs(outputs.commit()?))
}

/// What matters where the output is a window of an endless plane.
fn endless_job(args: &Args) -> endless::Drawing<'_> {
    let more = [
        ("--tile", args.tile),
        ("--exclude", !args.exclude.is_empty()),
        ("--report", args.report.is_some()),
        args.guide.given(),
    ];
    let given =
        more.into_iter().chain(args.of_blocks()).chain(args.method.given()).chain(args.rearranged.given());
    endless::Drawing {
        args: &args.endless,
        exemplars: &args.exemplars,
        output: &args.output,
        size: args.size,
        seed: args.seed,
        tile: args.tile,
        noise: args.method.is_noise(),
        other_options: given.filter(|(_, given)| *given).map(|(name, _)| name).collect(),
    }
}

fn options(args: &Args) -> BlockOptions {
    let default = BlockOptions::default();
    let block = args.block.unwrap_or(default.block);
    let relative = args.tolerance.map_or(default.tolerance, Tolerance::Relative);
    BlockOptions {
        size: args.size.unwrap_or(default.size),
        block,
        overlap: args.overlap.unwrap_or_else(|| BlockOptions::customary_overlap(block)),
        tolerance: args.delta.map_or(relative, Tolerance::Absolute),
        blend: args.blend.unwrap_or(default.blend),
        feather: args.feather.unwrap_or(default.feather),
        boundary: if args.tile { Boundary::Torus } else { Boundary::Open },
        guidance: None,
        seed: args.seed,
        search: SearchOptions {
            method: args.search.unwrap_or_default(),
            basis: args.kernels.unwrap_or_default(),
            curve: args.report.is_some(),
            ..SearchOptions::default()
        },
    }
}

/// Claims all outputs before any work is done.
fn claim_outputs<'a>(args: &'a Args, outputs: &mut Outputs) -> Result<Vec<Applied<'a>>> {
    let inputs = [&args.exemplars, &args.exclude].into_iter().flatten().map(PathBuf::as_path);
    let inputs: Vec<&Path> = inputs.chain(args.guide.inputs()).collect();
    let named: Vec<&Path> = std::iter::once(&*args.output).chain(args.report.as_deref()).collect();
    args.rearranged.claim(&inputs, &named, args.exemplars.len(), outputs)
}

fn synthesise(
    args: &Args,
    files: &[FieldFile],
    plan: &Plan,
    context: &Context,
) -> Result<(SourceMap, Report)> {
    let index = gathered::index(files, args.metric, args.domain, context)?;
    let masks = masks(args, files, context)?;
    let excluded = (0..index.len()).map(|i| masks.get(i).map(Vec::as_slice));
    let exemplars: Vec<Exemplar<'_>> =
        index.iter().zip(excluded).map(|(index, excluded)| Exemplar { index, excluded }).collect();
    let fields: Vec<&ReflectanceField> = files.iter().map(|file| &file.field).collect();
    plan.run(args, &fields, &exemplars, context)
}

/// The excluded texels of each exemplar: those whose mask is brighter than half.
fn masks(args: &Args, files: &[FieldFile], context: &Context) -> Result<Vec<Vec<bool>>> {
    if !args.exclude.is_empty() && args.exclude.len() != files.len() {
        return Err(Error::usage(format!(
            "--exclude has {} masks for {} exemplars: give one for each in turn",
            args.exclude.len(),
            files.len()
        )));
    }
    let masks = args.exclude.iter().zip(files);
    masks.map(|(path, file)| input::mask(path, file.field.size(), &context.job)).collect()
}

fn report(args: &Args, options: &BlockOptions, made: &Synthesis) -> Report {
    let (map, how) = (&made.map, &made.report);
    let drawn = how.placements.len().saturating_sub(1).max(1);
    let candidates = how.candidates as f64 / drawn as f64;
    let text = format!(
        "{}: {} texels from {} x {} blocks of {}, drawn from {} positions, {candidates:.1} candidates a \
         block{}",
        args.output.display(),
        map.size(),
        how.columns,
        how.rows,
        options.block,
        how.positions,
        if args.tile { "; tiles without a seam" } else { "" }
    );
    let json = json!({
        "width": map.size().width,
        "height": map.size().height,
        "block": options.block,
        "overlap": options.overlap,
        "blend": options.blend,
        "feather": options.feather,
        "tile": args.tile,
        "seed": options.seed,
        "blended_texels": map.mix_count(),
        "search": options.search,
        "times": made.times,
        "synthesis": how,
    });
    Report::new(text, json)
}

fn blend() -> impl TypedValueParser<Value = Blend> {
    PossibleValuesParser::new(["cut", "graphcut", "alpha"]).map(|name| match name.as_str() {
        "graphcut" => Blend::GraphCut,
        "alpha" => Blend::Alpha,
        _ => Blend::Cut,
    })
}

fn search() -> impl TypedValueParser<Value = SearchMethod> {
    PossibleValuesParser::new(["auto", "projection", "fft", "brute"]).map(|name| match name.as_str() {
        "projection" => SearchMethod::Projection,
        "fft" => SearchMethod::Fft,
        "brute" => SearchMethod::Brute,
        _ => SearchMethod::Auto,
    })
}

fn kernels() -> impl TypedValueParser<Value = KernelBasis> {
    PossibleValuesParser::new(["svd", "dct", "walsh-hadamard"]).map(|name| match name.as_str() {
        "dct" => KernelBasis::Dct,
        "walsh-hadamard" => KernelBasis::WalshHadamard,
        _ => KernelBasis::Svd,
    })
}
