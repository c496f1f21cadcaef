//! `relume synth`: a new texture of any size from blocks or texels of exemplars, or any window of the endless
//! plane of tiles, noise or a model.
//!
//! [`method`] holds the options of the methods; [`describe`](mod@describe) reports what they did.

mod describe;
mod guide;
mod method;

use std::path::{Path, PathBuf};

use relume::field::Domain;
use relume::format::{Content, FieldFile};
use relume::synthesis::search::{KernelBasis, SearchMethod};
use relume::synthesis::{Blend, Boundary, Exemplar, Guidance, Tolerance};
use relume::workflow::tiling::MeasuredTiling;
use relume::workflow::{Approach, Exemplars, NamedMetric, Outcome, SynthOptions};
use relume::{Error, Job, Planes, Result, Size};

use super::endless::{self, Drawn};
use crate::context::Context;
use crate::map_folder::MapFolder;
use crate::output::Outputs;
use crate::rearranged;
use crate::registered::{Applied, Registered, compared, read_all, read_registered};
use crate::report::Report;
use crate::{args, gathered, input, opacity, rearranged_btf};
use describe::describe;

/// Arguments of `relume synth`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "Example:\n  relume synth wool.ptm -o cloth.ptm --size 1024x1024 --tile\n  \
                        relume synth bricks.png -o wall.png --size 800 --block 64 --apply bricks_normals.png")]
pub struct Args {
    /// Exemplars: .ptm, .exr or pictures, all of one kind; - is standard input. Or one tile set made by
    /// relume roll, one .rlm model, or one folder of maps known by the words in their names, all of which are compared
    #[arg(required = true, value_name = "FILE")]
    exemplars: Vec<PathBuf>,
    /// The texture to write; - writes it to standard output in the format of the first exemplar. Of a folder of
    /// maps: the folder to write them into, under their own names
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Width and height in texels: 512x512, or 512 for a square
    #[arg(long, value_name = "WxH", value_parser = args::size, required_unless_present = "window")]
    size: Option<Size>,
    #[command(flatten)]
    endless: endless::EndlessArgs,
    #[command(flatten)]
    method: method::Args,
    /// Side of the blocks in texels [default: as relume analyze suggests: a quarter of the
    /// exemplar, or more where features or periods are large]
    #[arg(long, value_name = "N")]
    block: Option<usize>,
    /// Texels by which blocks overlap [default: a sixth of the block]
    #[arg(long, value_name = "N")]
    overlap: Option<usize>,
    /// Draw from blocks up to (1 + T) times the distance of the best one [default: 0.1]
    #[arg(long, value_name = "T", conflicts_with = "delta", value_parser = args::within(0.0, 1e6, "a number"))]
    tolerance: Option<f64>,
    /// Draw from blocks up to this distance instead: root mean square over the texels of the overlap, in the
    /// units of the metric
    #[arg(long, value_name = "D", value_parser = args::within(0.0, 1e6, "a distance"))]
    delta: Option<f64>,
    /// Join blocks along cuts, one per overlap (cut) or one seam through all of them at once (graphcut), by
    /// exact copies, or by ramps (alpha) [default: cut]
    #[arg(long, value_parser = args::named::<Blend>())]
    blend: Option<Blend>,
    /// Blend the functions within N texels on either side of a cut, at most the overlap; with 0 every texel
    /// is a copy [default: 0]
    #[arg(long, value_name = "N")]
    feather: Option<usize>,
    /// Make the output tile without a seam
    #[arg(long)]
    tile: bool,
    /// Meaning of the distance of two texels: that of their functions, of luminance and colour, or of
    /// luminance alone; legendre9 and legendre6 are the last two over the square, as in HPL-2003-16
    /// [default: function]
    #[arg(long, value_parser = args::named::<NamedMetric>())]
    metric: Option<NamedMetric>,
    /// The light directions over which functions are compared [default: hemisphere]
    #[arg(long, value_parser = args::named::<Domain>())]
    domain: Option<Domain>,
    /// The search for blocks; all give the same texture [default: auto]
    #[arg(long, value_parser = args::named::<SearchMethod>())]
    search: Option<SearchMethod>,
    /// The basis of --search projection [default: svd]
    #[arg(long, value_name = "BASIS", value_parser = args::named::<KernelBasis>())]
    kernels: Option<KernelBasis>,
    /// Search large exemplars (from 1,024 texels on) at a reduced resolution first, and refine the best blocks found there: many
    /// times faster, and nearly as good; folders of maps are searched so unless --search is given
    #[arg(long)]
    coarse: bool,
    /// Exemplar texels that may not be used: white in a mask of the size of the exemplar; with several
    /// exemplars, one mask for each in turn
    #[arg(long, value_name = "MASK", num_args = 1..)]
    exclude: Vec<PathBuf>,
    /// Also write statistics of the search, as JSON
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
    /// The requested options, checked, with their derived values.
    fn options(&self, guidance: Option<Guidance>) -> Result<(SynthOptions, Approach)> {
        let options = SynthOptions { guidance, ..self.unguided() };
        method::refuse_strangers(&options)?;
        let approach = options.approach()?;
        Ok((options, approach))
    }

    fn unguided(&self) -> SynthOptions {
        let options = self.method.options();
        SynthOptions {
            size: self.size.unwrap_or(options.size),
            boundary: if self.tile { Boundary::Torus } else { Boundary::Open },
            metric: self.metric.unwrap_or(options.metric),
            domain: self.domain.unwrap_or(options.domain),
            seed: self.seed,
            block: self.block,
            overlap: self.overlap,
            tolerance: self.delta.map(Tolerance::Absolute).or(self.tolerance.map(Tolerance::Relative)),
            blend: self.blend,
            feather: self.feather,
            search: self.search,
            kernels: self.kernels,
            curve: self.report.is_some(),
            coarse: self.coarse,
            follow_trend: self.guide.follow_trend,
            ..options
        }
    }
}

/// Synthesises a texture, or a whole folder of maps, and writes all requested outputs.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let Some(set) = MapFolder::of(&args.exemplars)? else { return synthesised(args, context) };
    let mut args = args.clone();
    if args.method.is_noise() {
        return Err(Error::usage(
            "noise makes an endless plane of one texture: name a map of the folder, or another --method",
        ));
    }
    args.coarse |= args.search.is_none() && args.method.is_of_blocks();
    args.output = args.rearranged.take_set(&set, &args.output)?;
    args.exemplars = vec![set.color.clone()];
    Ok(set.describe(synthesised(&args, context)?))
}

fn synthesised(args: &Args, context: &Context) -> Result<Report> {
    let opened = match endless::run(&endless_job(args), context)? {
        Drawn::Window(report) => return Ok(report),
        Drawn::Not(opened) => opened,
    };
    let mut outputs = Outputs::new(context);
    let applied = claim_outputs(args, &mut outputs)?;
    let guidance = args.guide.read(args.exemplars.len(), context)?;
    let (options, approach) = args.options(guidance)?;
    let files = read_all(&args.exemplars, opened, context, exemplar)?;
    let images = read_registered(applied, &files, context)?;
    let sets = args.rearranged.btfs(&args.output)?;
    let btfs = rearranged_btf::open_all(&sets, files[0].field.size(), context)?;
    let rearranged = images.iter().map(|one| (&*one.applied.output, &one.files[0]));
    let written = std::iter::once((&*args.output, &files[0])).chain(rearranged);
    gathered::check_memory(options.size, written, context)?;
    let made = synthesise(args, &files, &images, (&options, &approach), context)?;
    let (map, report) = (&made.0.made.map, describe(&args.output, &options, &made, &args.exemplars));
    let boundary = if made.0.plan.tiles() { Boundary::Torus } else { Boundary::Open };
    let named = (&files[..], &*args.exemplars[0]);
    let mut textures = vec![args.rearranged.texture(map, named, &args.output, boundary, context)?];
    textures.extend(args.rearranged.rearranged(map, &images, boundary, context)?);
    let mut bytes: Vec<(PathBuf, Vec<u8>)> = args.rearranged.source_map(map, context)?.into_iter().collect();
    if let Some(path) = &args.report {
        bytes.push((path.clone(), format!("{:#}\n", report.json).into_bytes()));
    }
    for (path, bytes) in bytes {
        outputs.write(&path, bytes)?;
    }
    let report = rearranged::with_tilings(args.rearranged.describe(&images, report), &textures);
    for one in textures {
        outputs.write(&one.output, one.bytes)?;
    }
    let sets = rearranged_btf::write_all(&sets, &btfs, map, &mut outputs, context)?;
    Ok(report.with_lines(&sets).with_outputs(outputs.commit()?))
}

/// Reads one of several exemplars.
fn exemplar(path: &Path, job: &Job) -> Result<FieldFile> {
    let opened = input::open(path, job)?;
    if opened.content() == Content::Tiles {
        return Err(Error::usage("is a set of tiles, which is laid alone: name no other file").at(path));
    }
    opened.into_exemplar()
}

/// The request for a window of an endless plane.
fn endless_job(args: &Args) -> endless::Request<'_> {
    let more = [
        ("--tile", args.tile),
        ("--method", args.method.is_given()),
        ("--metric", args.metric.is_some()),
        ("--domain", args.domain.is_some()),
        ("--exclude", !args.exclude.is_empty()),
        ("--report", args.report.is_some()),
        args.guide.given(),
    ];
    let special = args.unguided().special().into_iter().filter(|one| one.is_given);
    let given = more.into_iter().chain(args.rearranged.given()).filter(|(_, given)| *given);
    endless::Request {
        args: &args.endless,
        exemplars: &args.exemplars,
        output: &args.output,
        size: args.size,
        seed: args.seed,
        tile: args.tile,
        noise: args.method.is_noise(),
        other_options: special
            .map(|one| format!("--{}", one.name))
            .chain(given.map(|(name, _)| name.to_owned()))
            .collect(),
    }
}

/// Claims all outputs before any work is done.
fn claim_outputs(args: &Args, outputs: &mut Outputs) -> Result<Vec<Applied>> {
    let inputs = [&args.exemplars, &args.exclude].into_iter().flatten().map(PathBuf::as_path);
    let inputs: Vec<&Path> = inputs.chain(args.guide.inputs()).collect();
    let named: Vec<&Path> = std::iter::once(&*args.output).chain(args.report.as_deref()).collect();
    args.rearranged.claim(&inputs, &named, args.exemplars.len(), outputs)
}

/// Makes the texture, and measures how well it tiles if it is to.
fn synthesise(
    args: &Args,
    files: &[FieldFile],
    images: &[Registered],
    (options, approach): (&SynthOptions, &Approach),
    context: &Context,
) -> Result<(Outcome, Option<MeasuredTiling>)> {
    let space = options.metric.space(&files[0].field, options.domain)?;
    let index = gathered::index(files, &compared(images), &space, context)?;
    let masks = masks(args, files, context)?;
    let excluded = masks.iter().map(Option::as_deref);
    let planes: Vec<Exemplar<'_>> =
        index.iter().zip(excluded).map(|(index, excluded)| Exemplar { index, excluded }).collect();
    let exemplars = Exemplars { planes: &planes, files: &args.exemplars };
    let outcome = approach.run(&exemplars, &context.job).map_err(|e| match &args.exemplars[..] {
        [only] => e.at(only),
        _ => e,
    })?;
    let index: Vec<&Planes> = index.iter().collect();
    let measure = || MeasuredTiling::measure(&outcome.made.map, &index, &context.job);
    let tiling = outcome.plan.tiles().then(measure).transpose()?;
    Ok((outcome, tiling))
}

/// The excluded texels of each exemplar: those that its mask paints, and transparent ones.
fn masks(args: &Args, files: &[FieldFile], context: &Context) -> Result<Vec<Option<Vec<bool>>>> {
    if !args.exclude.is_empty() && args.exclude.len() != files.len() {
        return Err(Error::usage(format!(
            "--exclude has {} masks for {} exemplars: give one for each in turn",
            args.exclude.len(),
            files.len()
        )));
    }
    let one = |(number, file): (usize, &FieldFile)| {
        let mask = args.exclude.get(number);
        let mask = mask.map(|path| input::mask(path, file.field.size(), &context.job)).transpose()?;
        Ok(opacity::excluded(file, &args.exemplars[number], mask, context))
    };
    files.iter().enumerate().map(one).collect()
}
