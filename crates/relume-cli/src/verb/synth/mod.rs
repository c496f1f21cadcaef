//! `relume synth`: a new texture of any size from blocks or texels of exemplars, or any part of the
//! endless plane that tiles, noise or a model make.
//!
//! [`method`] holds what differs between the methods; [`auto`] chooses among them by measuring.

mod auto;
mod method;
mod roller;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::{Domain, Metric};
use relume::format::{FieldFile, FieldFormat};
use relume::synthesis::search::{KernelBasis, SearchMethod, SearchOptions};
use relume::synthesis::{Blend, BlockOptions, Boundary, Exemplar, SourceMap, Synthesis, Tolerance};
use relume::{Error, ReflectanceField, Result, Size};
use serde_json::json;

use super::endless;
use crate::context::Context;
use crate::output;
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
    /// Draw among blocks up to (1 + T) times the distance of the best one
    #[arg(long, value_name = "T", default_value_t = 0.1, conflicts_with = "delta")]
    tolerance: f64,
    /// Draw among blocks up to this distance instead: root mean square over the overlap's texels, in
    /// the units of the metric
    #[arg(long, value_name = "D")]
    delta: Option<f64>,
    /// Join blocks along cuts, one for each overlap or one seam through all of them at once, which
    /// copies every texel, or by ramps
    #[arg(long, default_value = "cut", value_parser = blend())]
    blend: Blend,
    /// Blend the functions within N texels of a cut on either side, at most the overlap; 0 copies
    /// every texel
    #[arg(long, value_name = "N", default_value_t = 0)]
    feather: usize,
    /// Make the output tile without a seam
    #[arg(long)]
    tile: bool,
    /// What the distance of two texels means: that of their functions, or the documents' nine or
    /// six numbers for luminance polynomials
    #[arg(long, default_value = "function", value_parser = args::metric())]
    metric: Metric,
    /// The light directions over which functions are compared
    #[arg(long, default_value = "hemisphere", value_parser = args::domain())]
    domain: Domain,
    /// How blocks are searched for; all ways give the same texture
    #[arg(long, default_value = "auto", value_parser = search())]
    search: SearchMethod,
    /// The basis of --search projection
    #[arg(long, value_name = "BASIS", default_value = "svd", value_parser = kernels())]
    kernels: KernelBasis,
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
    /// Also write where each texel comes from, as x, y and exemplar: .npy or .exr
    #[arg(long, value_name = "FILE")]
    source_map: Option<PathBuf>,
    /// Also rearrange these registered images in the same way; with several exemplars, one image for
    /// each in turn. OUTPUT_IMAGE beside the output, or IMAGE in --apply-dir
    #[arg(long, value_name = "IMAGE", num_args = 1..)]
    apply: Vec<PathBuf>,
    /// The folder for the images of --apply
    #[arg(long, value_name = "DIR", requires = "apply")]
    apply_dir: Option<PathBuf>,
}

/// Synthesises a texture and writes all that was asked for.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    if let Some(report) = endless::run(&endless_job(args), context)? {
        return Ok(report);
    }
    let applied = check_outputs(args, context)?;
    let plan = Plan::new(&args.method, options(args))?;
    let files = read_all(&args.exemplars, context)?;
    let images =
        applied.iter().map(|job| read_registered(job.images, &files, context)).collect::<Result<Vec<_>>>()?;
    let (map, report) = synthesise(args, &files, &plan, context)?;
    let output = gathered::apply(&map, &files, &args.output, context)?;
    let mut bytes = vec![(args.output.clone(), output)];
    for (job, images) in applied.into_iter().zip(&images) {
        let image = gathered::apply(&map, images, &job.output, context)?;
        bytes.push((job.output, image));
    }
    if let Some(path) = &args.source_map {
        bytes.push((path.clone(), gathered::source_map(&map, path, context)?));
    }
    if let Some(path) = &args.report {
        bytes.push((path.clone(), format!("{:#}\n", report.json).into_bytes()));
    }
    for (path, bytes) in &bytes {
        output::write(path, bytes, context)?;
    }
    let outputs: Vec<&Path> = bytes.iter().map(|(path, _)| path.as_path()).collect();
    let mut report = report.with_stdout_taken(output::is_stream(&args.output));
    report.json["outputs"] = json!(outputs);
    Ok(report)
}

/// What matters where the output is a window of an endless plane.
fn endless_job(args: &Args) -> endless::Job<'_> {
    let given = [
        ("--tile", args.tile),
        ("--overlap", args.overlap.is_some()),
        ("--delta", args.delta.is_some()),
        ("--exclude", !args.exclude.is_empty()),
        ("--report", args.report.is_some()),
        ("--source-map", args.source_map.is_some()),
        ("--apply", !args.apply.is_empty()),
    ];
    endless::Job {
        args: &args.endless,
        exemplars: &args.exemplars,
        output: &args.output,
        size: args.size,
        seed: args.seed,
        tile: args.tile,
        noise: args.method.is_noise(),
        other_options: given.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect(),
    }
}

fn options(args: &Args) -> BlockOptions {
    let default = BlockOptions::default();
    let block = args.block.unwrap_or(default.block);
    BlockOptions {
        size: args.size.unwrap_or(default.size),
        block,
        overlap: args.overlap.unwrap_or_else(|| BlockOptions::customary_overlap(block)),
        tolerance: args.delta.map_or(Tolerance::Relative(args.tolerance), Tolerance::Absolute),
        blend: args.blend,
        feather: args.feather,
        boundary: if args.tile { Boundary::Torus } else { Boundary::Open },
        seed: args.seed,
        search: SearchOptions {
            method: args.search,
            basis: args.kernels,
            curve: args.report.is_some(),
            ..SearchOptions::default()
        },
    }
}

/// Images to rearrange into one output, one for each exemplar.
struct Applied<'a> {
    images: &'a [PathBuf],
    output: PathBuf,
}

/// Names all outputs and refuses them before any work is done.
fn check_outputs<'a>(args: &'a Args, context: &Context) -> Result<Vec<Applied<'a>>> {
    let count = args.exemplars.len();
    if !args.apply.len().is_multiple_of(count) {
        return Err(Error::usage(format!(
            "--apply has {} images for {count} exemplars: give one for each exemplar in turn",
            args.apply.len()
        )));
    }
    let inputs: Vec<&Path> =
        [&args.exemplars, &args.apply, &args.exclude].into_iter().flatten().map(PathBuf::as_path).collect();
    if inputs.iter().filter(|path| output::is_stream(path)).count() > 1 {
        return Err(Error::usage("standard input can be read only once: give - for one input at most"));
    }
    let jobs = args
        .apply
        .chunks(count)
        .map(|images| applied_output(args, &images[0]).map(|output| Applied { images, output }));
    let jobs = jobs.collect::<Result<Vec<_>>>()?;
    let mut outputs: Vec<&Path> = vec![&args.output];
    outputs.extend(args.source_map.as_deref());
    outputs.extend(args.report.as_deref());
    outputs.extend(jobs.iter().map(|job| job.output.as_path()));
    for (i, path) in outputs.iter().enumerate() {
        output::check(path, &inputs, context)?;
        if outputs[..i].contains(path) {
            return Err(Error::usage("is named for two outputs of this command: choose another").at(path));
        }
    }
    if let Some(path) = &args.source_map {
        gathered::check_map(path)?;
    }
    let textures = jobs.iter().map(|job| job.output.as_path()).chain([args.output.as_path()]);
    for path in textures.filter(|path| !output::is_stream(path)) {
        FieldFormat::from_path(path)?;
    }
    Ok(jobs)
}

/// Where a rearranged image goes.
fn applied_output(args: &Args, image: &Path) -> Result<PathBuf> {
    let name = image.file_name().filter(|_| !output::is_stream(image));
    let name = name.ok_or_else(|| Error::usage("has no file name to call its output by").at(image))?;
    if let Some(folder) = &args.apply_dir {
        return Ok(folder.join(name));
    }
    let stem = args.output.file_stem().filter(|_| !output::is_stream(&args.output)).ok_or_else(|| {
        Error::usage("--apply names its outputs after the output file: give a file or --apply-dir")
    })?;
    let mut joined = OsString::from(stem);
    joined.push("_");
    joined.push(name);
    Ok(args.output.with_file_name(joined))
}

/// Reads fields that must be of one kind.
fn read_all(paths: &[PathBuf], context: &Context) -> Result<Vec<FieldFile>> {
    let kind = |field: &ReflectanceField| {
        format!("{} {} in {} values", field.color().name(), field.basis().name(), field.space())
    };
    let files = paths.iter().map(|path| input::field(path, &context.limits)).collect::<Result<Vec<_>>>()?;
    for (file, path) in files.iter().zip(paths) {
        let (found, expected) = (kind(&file.field), kind(&files[0].field));
        if found != expected {
            return Err(Error::usage(format!(
                "holds {found} and {} {expected}: they must be of one kind",
                paths[0].display()
            ))
            .at(path));
        }
    }
    Ok(files)
}

/// Reads images that must be as large as the exemplars, one for each.
fn read_registered(paths: &[PathBuf], exemplars: &[FieldFile], context: &Context) -> Result<Vec<FieldFile>> {
    let images = read_all(paths, context)?;
    for ((image, exemplar), path) in images.iter().zip(exemplars).zip(paths) {
        let (found, expected) = (image.field.size(), exemplar.field.size());
        if found != expected {
            return Err(Error::usage(format!(
                "is {found} texels and its exemplar {expected}: --apply takes images registered with the \
                 exemplar, texel by texel"
            ))
            .at(path));
        }
    }
    Ok(images)
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
    masks.map(|(path, file)| input::mask(path, file.field.size(), &context.limits)).collect()
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
