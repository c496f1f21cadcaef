//! `relume compare`: the distance between two textures, texel by texel or statistically.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use relume::direction::Directions;
use relume::format::Content;
use relume::format::npy::Array;
use relume::metric::texture::{Appearance, Distances, Source, Sources};
use relume::workflow::btf_comparison::{self, PairErrors};
use relume::workflow::comparison::{Comparison, TexelErrors, TextureMeasures};
use relume::workflow::{Btf, Missing};
use relume::{Direction, Error, Planes, Result, Size};
use serde_json::json;

use crate::context::Context;
use crate::decibels::{self, decibels};
use crate::report::{Report, counted};
use crate::{evaluated, input, output};

/// Arguments of `relume compare`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  relume compare photograph.png relit.png\n  relume synth wool.ptm -o cloth.ptm --size 512 \
                  --source-map map.npy\n  relume compare --texture wool.ptm cloth.ptm --source-map map.npy\n  \
                  relume compare wool.zip wool.exr\n\n\
                  All values are compared sRGB-encoded. Textures of functions are compared as pictures under \
                  several lights: the mean and the worst of them are given. docs/measures.md says what each measure \
                  can and cannot see."
)]
pub struct Args {
    /// The reference: a .ptm, an .exr field, a picture or a .rlm model; or a folder or .zip of photographs under light and
    /// view, all of which are compared (thousands of large ones take minutes, with a bar on a terminal); - is standard input
    reference: PathBuf,
    /// The texture to compare with it; of the same size unless --texture is given. With photographs under light and view
    /// also another such set, or a .btf
    other: PathBuf,
    /// Compare the statistics of the textures, of any sizes, instead of texel by texel
    #[arg(long)]
    texture: bool,
    /// Number of lights under which functions are compared: one at the zenith, the others in a circle 45
    /// degrees from it
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    lights: u16,
    /// The source map of the second texture in the first (.npy or .exr of `relume synth --source-map`):
    /// measures cuts and copying
    #[arg(long, value_name = "FILE", requires = "texture")]
    source_map: Option<PathBuf>,
    /// Seed of the patches drawn for the patch distance
    #[arg(long, value_name = "N", default_value_t = 0, requires = "texture")]
    seed: u64,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

/// Compares and reports.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    if Btf::is_at(&args.reference) {
        return with_photographs(args, context);
    }
    let inputs = [Some(&args.reference), Some(&args.other), args.source_map.as_ref()];
    if inputs.into_iter().flatten().filter(|path| output::is_stream(path)).count() > 1 {
        return Err(Error::usage("standard input can be read only once: give - for one input at most"));
    }
    if Btf::is_at(&args.other) {
        return Err(Error::usage(format!(
            "photographs under light and view are the reference: write them first, `relume compare {} {}`",
            args.other.display(),
            args.reference.display()
        ))
        .at(&args.other));
    }
    let read = |path: &Path| args.evaluated.compared(path, &context.job);
    let (reference, other) = (read(&args.reference)?, read(&args.other)?);
    args.evaluated.check(reference.is_made() || other.is_made())?;
    let sizes = [reference.shown().size(), other.shown().size()];
    let comparison = Comparison::new(reference.shown(), other.shown(), args.lights.into());
    if !args.texture {
        return texel_by_texel(&comparison, sizes, args, context);
    }
    let map = args.source_map.as_deref().map(|path| SourceFile::read(path, context)).transpose()?;
    let exemplars = [sizes[0]];
    let sources = map.as_ref().map(|map| Sources::new(map.size, &map.texels, &exemplars)).transpose();
    let sources = sources.map_err(|e| e.at(args.source_map.as_deref().unwrap_or(Path::new("-"))))?;
    let measures = comparison.texture_measures(sources.as_ref(), args.seed, &context.job)?;
    Ok(Report::new(
        texture_text(&measures, comparison.directions(), args),
        texture_json(&measures, comparison.directions()),
    ))
}

/// Compares a texture with all photographs under light and view.
fn with_photographs(args: &Args, context: &Context) -> Result<Report> {
    if args.texture {
        return Err(Error::usage(
            "--texture compares two textures: relight both for the statistics of single pairs of light and view",
        )
        .at(&args.reference));
    }
    let btf = Btf::open(&args.reference, Missing::Fill, &context.job)?;
    let absent = btf.list().absent().map(|absent| format!("{absent}: they are not compared"));
    let mut warnings: Vec<String> = absent.into_iter().collect();
    let errors = match Btf::is_at(&args.other) {
        true => {
            let other = Btf::open(&args.other, Missing::Fill, &context.job)?;
            warnings.extend(other.list().absent().map(|absent| {
                format!("{}: {absent}: their values are interpolated from the others", args.other.display())
            }));
            btf_comparison::compare_sets(&btf, &other, &context.job)?
        }
        false => {
            let other = args.evaluated.compared(&args.other, &context.job)?;
            args.evaluated.check(other.is_made())?;
            btf_comparison::compare(&btf, other.shown(), &context.job)?
        }
    };
    let (mean, worst) = (&errors.mean, &errors.worst);
    let mut text = format!(
        "{}, means and (worst, {}):\n",
        counted(btf.list().entries.len(), "photograph"),
        errors.worst_name
    );
    let (all, least) = (decibels(mean.psnr_db), decibels(worst.psnr_db));
    let exact = match errors.exact {
        0 => String::new(),
        exact => format!("; equal, and not in this mean: {exact} of {}", btf.list().entries.len()),
    };
    let _ = writeln!(text, "{:<28} {all:>9} ({least}){exact}", "PSNR");
    for (name, mean, worst, digits) in [
        ("RMSE, of white", mean.rmse, worst.rmse, 5),
        ("mean difference in CIE Lab", mean.mae_lab, worst.mae_lab, 3),
        ("CIEDE2000", mean.ciede2000, worst.ciede2000, 3),
        ("structural similarity", mean.ssim, worst.ssim, 4),
    ] {
        let _ = writeln!(text, "{name:<28} {mean:>9.digits$} ({worst:.digits$})");
    }
    text.push_str(&by_view(&btf, &errors));
    let pairs: Vec<Directions> = btf.list().entries.iter().map(|entry| entry.directions).collect();
    let json = json!({
        "psnr_db": mean.psnr_db.is_finite().then_some(mean.psnr_db),
        "rmse": mean.rmse,
        "mean": mean,
        "exact": errors.exact,
        "worst": worst,
        "worst_name": errors.worst_name,
        "by_view": errors.by_view,
        "lights": arrays(&pairs, |pair| pair.light),
        "views": arrays(&pairs, |pair| pair.view),
    });
    Ok(Report::new(text, json).with_warnings(warnings))
}

/// The mean ratios by the polar angle of the view.
fn by_view(btf: &Btf, errors: &PairErrors) -> String {
    let tenths = |degrees: f64| (10.0 * degrees).round();
    let count = |polar: f64| {
        let angles = btf.list().entries.iter().map(|entry| entry.directions.view.polar_rad().to_degrees());
        angles.filter(|degrees| tenths(*degrees) == tenths(polar)).count()
    };
    let sums = errors.by_view.iter().map(|&(polar, db)| {
        let count = count(polar);
        (polar, count, count as f64 * db)
    });
    decibels::by_polar_angle("view", &sums.collect::<Vec<_>>(), decibels)
}

fn texel_by_texel(
    comparison: &Comparison<'_>,
    sizes: [Size; 2],
    args: &Args,
    context: &Context,
) -> Result<Report> {
    if sizes[0] != sizes[1] {
        return Err(Error::usage(format!(
            "is {} texels and the reference {}: give --texture to compare textures of different sizes",
            sizes[1], sizes[0]
        ))
        .at(&args.other));
    }
    let TexelErrors { psnr_db, rmse, worst_psnr_db, worst_rmse } = comparison.texel_errors(&context.job)?;
    let lights = comparison.directions();
    let mut text = format!("PSNR {}, RMSE {rmse:.5} of white", decibels(psnr_db));
    if lights.len() > 1 {
        let worst = format!("worst {}, {worst_rmse:.5}", decibels(worst_psnr_db));
        let _ = write!(text, " (means over {}; {worst})", pairs_in_words(lights));
    }
    // JSON has no infinity: equal textures have no PSNR.
    let finite = |db: f64| db.is_finite().then_some(db);
    let json = json!({
        "psnr_db": finite(psnr_db),
        "rmse": rmse,
        "worst": { "psnr_db": finite(worst_psnr_db), "rmse": worst_rmse },
        "lights": arrays(lights, |pair| pair.light),
        "views": arrays(lights, |pair| pair.view),
    });
    Ok(Report::new(text, json))
}

/// The lights, and the views if they differ.
fn pairs_in_words(pairs: &[Directions]) -> String {
    let beside = pairs.iter().filter(|pair| pair.view != Direction::ZENITH).count();
    let lights = counted(pairs.len(), "light");
    match beside {
        0 => format!("{lights}, seen from straight above"),
        _ => format!("{lights}, {beside} of them seen from the side, others from straight above"),
    }
}

/// The lights or the views of pairs, for JSON.
fn arrays(pairs: &[Directions], of: fn(&Directions) -> Direction) -> Vec<[f64; 3]> {
    pairs.iter().map(|pair| of(pair).to_array()).collect()
}

fn texture_json(measures: &TextureMeasures, lights: &[Directions]) -> serde_json::Value {
    json!({
        "mean": Distances::mean(&measures.distances),
        "worst": Distances::worst(&measures.distances),
        "by_light": measures.distances,
        "wrap": { "right_to_left": measures.wraps[0], "bottom_to_top": measures.wraps[1] },
        "seams": measures.seams,
        "copying": measures.copying,
        "lights": arrays(lights, |pair| pair.light),
        "views": arrays(lights, |pair| pair.view),
    })
}

fn texture_text(measures: &TextureMeasures, pairs: &[Directions], args: &Args) -> String {
    let (Some(mean), Some(worst)) =
        (Distances::mean(&measures.distances), Distances::worst(&measures.distances))
    else {
        return String::new();
    };
    let mut text = format!(
        "{} against {}, over {}\n{:<34} {:>8} {:>8}\n",
        args.other.display(),
        args.reference.display(),
        pairs_in_words(pairs),
        "",
        "mean",
        "worst"
    );
    append_appearance(&mean.appearance, &worst.appearance, &mut text);
    append_unit(&mean.appearance, &mut text);
    let rows = [
        ("patches at several scales", mean.sliced, worst.sliced),
        ("histogram", mean.histogram, worst.histogram),
        ("autocorrelation", mean.autocorrelation, worst.autocorrelation),
        ("spectrum, dB", mean.spectrum_db, worst.spectrum_db),
        ("steerable pyramid, 1 - STSIM-2", mean.steerable, worst.steerable),
    ];
    for (name, mean, worst) in rows {
        let _ = writeln!(text, "{name:<34} {mean:>8.4} {worst:>8.4}");
    }
    let [x, y] = measures.wraps;
    let _ = write!(
        text,
        "wrap: step over the border {:.2} (right to left) and {:.2} (bottom to top) times that inside",
        x.ratio, y.ratio
    );
    append_sources(measures, &mut text);
    text
}

/// The names of [`Appearance::parts`].
const PARTS: [&str; 6] = ["patches", "colours", "detail", "direction", "order", "repetition"];

fn append_appearance(mean: &Appearance, worst: &Appearance, text: &mut String) {
    let rows = [("appearance", mean.distance, worst.distance)].into_iter();
    let rows =
        rows.chain(PARTS.iter().zip(mean.parts()).zip(worst.parts()).map(|((name, a), b)| (*name, a, b)));
    for (number, (name, mean, worst)) in rows.enumerate() {
        let name = if number > 0 { format!("  {name}") } else { name.to_owned() };
        let _ = writeln!(text, "{name:<34} {mean:>8.2} {worst:>8.2}");
    }
}

/// What the numbers of the appearance mean, and which part decides.
fn append_unit(mean: &Appearance, text: &mut String) {
    text.push_str("  1 is as far as the halves of the reference are from each other, less is nearer");
    let named = PARTS.iter().zip(mean.parts());
    if let Some((name, _)) = named.filter(|(_, part)| *part > 0.0).max_by(|a, b| a.1.total_cmp(&b.1)) {
        let _ = write!(text, "; farthest in {name}");
    }
    text.push('\n');
}

fn append_sources(measures: &TextureMeasures, text: &mut String) {
    if let Some(seams) = measures.seams {
        let _ = write!(
            text,
            "\ncuts: {:.1} % of neighbours, step {:.2} times that inside",
            100.0 * seams.share,
            seams.ratio
        );
    }
    if let Some(copying) = measures.copying {
        let _ = write!(
            text,
            "\ncopying: {:.1} % of the exemplar used, evenness {:.3}, a texel at most {} times; pieces of {:.1} \
             texels, the largest {}, the longest run {}",
            100.0 * copying.coverage,
            copying.evenness,
            copying.most_used,
            copying.mean_piece,
            copying.largest_piece,
            copying.longest_run
        );
    }
}

/// A source map as `relume synth` writes it.
struct SourceFile {
    size: Size,
    texels: Vec<Source>,
}

impl SourceFile {
    fn read(path: &Path, context: &Context) -> Result<Self> {
        let opened = input::open(path, &context.job)?;
        let read = match opened.content() {
            Content::Array => Self::of_array(&opened.into_array()?),
            _ => opened.into_labelled().and_then(|(names, planes)| Self::of_planes(&names, &planes)),
        };
        read.map_err(|e| e.at(path))
    }

    fn of_array(array: &Array) -> Result<Self> {
        if array.components != 3 {
            return Err(Error::invalid(format!(
                "the array has {} numbers a texel: expected x, y and exemplar",
                array.components
            )));
        }
        let (values, _) = array.values.as_chunks::<3>();
        let texels = values.iter().map(|v| source(v.map(f64::from))).collect::<Result<_>>()?;
        Ok(Self { size: array.size, texels })
    }

    fn of_planes(names: &[String], planes: &Planes) -> Result<Self> {
        let place = |name: &str| {
            let missing =
                || Error::invalid(format!("the picture has no channel '{name}': expected x, y and exemplar"));
            names.iter().position(|n| n == name).ok_or_else(missing)
        };
        let channels = [place("x")?, place("y")?, place("exemplar")?];
        let texel = |i: usize| source(channels.map(|k| f64::from(planes.plane(k)[i])));
        let texels = (0..planes.size().texels()).map(texel).collect::<Result<_>>()?;
        Ok(Self { size: planes.size(), texels })
    }
}

fn source(numbers: [f64; 3]) -> Result<Source> {
    if numbers.iter().any(|v| v.fract() != 0.0 || !(0.0..f64::from(u32::MAX)).contains(v)) {
        return Err(Error::invalid(format!(
            "{numbers:?} is not a position in an exemplar: expected whole numbers from 0"
        )));
    }
    let [x, y, exemplar] = numbers.map(|v| v as u32);
    Ok(Source { exemplar, x, y })
}
