//! `relume synth`: a new texture of any size from blocks of exemplars, or from a model.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::{Domain, IndexSpace, Metric};
use relume::format::{Encoding, ExrDepth, FieldFile, FieldFormat, PictureFormat, encode_field, exr, npy};
use relume::synthesis::search::{KernelBasis, SearchMethod, SearchOptions};
use relume::synthesis::{
    Blend, BlockOptions, Boundary, Exemplar, SourceMap, Synthesis, Tolerance, gather, synthesize,
};
use relume::{Error, Planes, ReflectanceField, Result, Size};
use serde_json::json;

use super::endless;
use crate::context::Context;
use crate::output;
use crate::report::Report;
use crate::{args, input};

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
    /// Side of the blocks in texels
    #[arg(long, value_name = "N", default_value_t = 32)]
    block: usize,
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
    /// Join blocks along cuts, which copies every texel, or by ramps
    #[arg(long, default_value = "cut", value_parser = blend())]
    blend: Blend,
    /// Make the output tile without a seam
    #[arg(long)]
    tile: bool,
    /// What the distance of two texels means: that of their functions, or the documents' nine or
    /// six numbers for luminance polynomials
    #[arg(long, default_value = "function", value_parser = metric())]
    metric: Metric,
    /// The light directions over which functions are compared
    #[arg(long, default_value = "hemisphere", value_parser = domain())]
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
    let options = options(args);
    options.validate()?;
    let files = read_all(&args.exemplars, context)?;
    let images =
        applied.iter().map(|job| read_registered(job.images, &files, context)).collect::<Result<Vec<_>>>()?;
    let made = synthesise(args, &files, &options, context)?;
    let output = apply(&made.map, &files, &args.output, context)?;
    let mut bytes = vec![(args.output.clone(), output)];
    for (job, images) in applied.into_iter().zip(&images) {
        let image = apply(&made.map, images, &job.output, context)?;
        bytes.push((job.output, image));
    }
    if let Some(path) = &args.source_map {
        bytes.push((path.clone(), source_map(&made.map, path, context)?));
    }
    let report = report(args, &options, &made);
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
        other_options: given.into_iter().filter(|(_, given)| *given).map(|(name, _)| name).collect(),
    }
}

fn options(args: &Args) -> BlockOptions {
    BlockOptions {
        size: args.size.unwrap_or(BlockOptions::default().size),
        block: args.block,
        overlap: args.overlap.unwrap_or_else(|| BlockOptions::customary_overlap(args.block)),
        tolerance: args.delta.map_or(Tolerance::Relative(args.tolerance), Tolerance::Absolute),
        blend: args.blend,
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
        MapFormat::from_path(path)?;
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
    options: &BlockOptions,
    context: &Context,
) -> Result<Synthesis> {
    let space = IndexSpace::new(&files[0].field, args.metric, args.domain)?;
    let index: Vec<Planes> = files
        .iter()
        .map(|file| {
            context.limits.check(
                "the index of the exemplar",
                file.field.size(),
                4 * space.planes() as u64,
            )?;
            Ok(space.index_planes(&file.field))
        })
        .collect::<Result<_>>()?;
    let masks = masks(args, files, context)?;
    let excluded = (0..index.len()).map(|i| masks.get(i).map(Vec::as_slice));
    let exemplars: Vec<Exemplar<'_>> =
        index.iter().zip(excluded).map(|(index, excluded)| Exemplar { index, excluded }).collect();
    synthesize(&exemplars, options, &context.limits, &context.progress)
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
    let read = |(path, file): (&PathBuf, &FieldFile)| {
        let mask = input::raster(path, &context.limits)?;
        if mask.size() != file.field.size() {
            return Err(Error::usage(format!(
                "the mask is {} texels, its exemplar {}: they must be equally large",
                mask.size(),
                file.field.size()
            ))
            .at(path));
        }
        let bright = |texel: usize| mask.samples().value(texel * mask.channels()) > 0.5;
        Ok((0..mask.size().texels()).map(bright).collect())
    };
    args.exclude.iter().zip(files).map(read).collect()
}

/// The file that a map makes of registered fields, stored as the first one was.
fn apply(map: &SourceMap, files: &[FieldFile], output: &Path, context: &Context) -> Result<Vec<u8>> {
    let fields: Vec<&ReflectanceField> = files.iter().map(|file| &file.field).collect();
    let field = gather(map, &fields, &context.limits).map_err(|e| e.at(output))?;
    let encoding = &files[0].encoding;
    let format = if output::is_stream(output) {
        match *encoding {
            Encoding::Ptm(_) => FieldFormat::Ptm,
            Encoding::Picture(depth) => FieldFormat::Picture(PictureFormat::Png(depth)),
            Encoding::Exr(depth) => FieldFormat::Exr(depth),
        }
    } else {
        FieldFormat::from_path(output)?.in_depth_of(encoding)
    };
    let shared = files.iter().all(|file| file.encoding == *encoding).then_some(encoding);
    encode_field(&field, format, shared, &context.limits).map_err(|e| e.at(output))
}

/// A file format of source maps.
enum MapFormat {
    Npy,
    Exr,
}

impl MapFormat {
    fn from_path(path: &Path) -> Result<Self> {
        match path.extension().and_then(|e| e.to_str()) {
            Some("npy") => Ok(Self::Npy),
            Some("exr") => Ok(Self::Exr),
            _ => Err(Error::usage("a source map is written as .npy or .exr: name the file so").at(path)),
        }
    }
}

/// x, y and exemplar of each texel's source; of blended texels the dominant one.
fn source_map(map: &SourceMap, path: &Path, context: &Context) -> Result<Vec<u8>> {
    context.limits.check("the source map", map.size(), 24)?;
    let values = map.copies().iter().flat_map(|from| [from.x, from.y, from.exemplar]);
    match MapFormat::from_path(path)? {
        MapFormat::Npy => {
            let values: Vec<i32> = values.map(u32::cast_signed).collect();
            npy::encode_i32(map.size(), 3, &values)
        }
        MapFormat::Exr => {
            let mut planes = Planes::zeros(map.size(), 3);
            for (k, plane) in planes.iter_mut().enumerate() {
                plane.iter_mut().zip(values.clone().skip(k).step_by(3)).for_each(|(out, v)| *out = v as f32);
            }
            exr::encode_labelled(&["x", "y", "exemplar"], &planes, ExrDepth::Float)
        }
    }
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
    PossibleValuesParser::new(["cut", "alpha"])
        .map(|name| if name == "cut" { Blend::Cut } else { Blend::Alpha })
}

fn metric() -> impl TypedValueParser<Value = Metric> {
    PossibleValuesParser::new(["function", "legendre9", "legendre6"]).map(|name| match name.as_str() {
        "legendre9" => Metric::Legendre9,
        "legendre6" => Metric::Legendre6,
        _ => Metric::Function,
    })
}

fn domain() -> impl TypedValueParser<Value = Domain> {
    PossibleValuesParser::new(["hemisphere", "cosine", "square"]).map(|name| match name.as_str() {
        "cosine" => Domain::Cosine,
        "square" => Domain::Square,
        _ => Domain::Hemisphere,
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
