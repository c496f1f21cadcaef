//! Functions of light and view learned from the photographs.

use relume::field::Basis;
use relume::fit::learned::{
    self, ClusterOptions, LearnedFit, LearnedOptions, LearnedReport, MOST_FUNCTIONS, Rank,
};
use relume::format::bonn::{BtfFactors, FactorShape, encode_fmf};
use relume::format::exr::encode_clustered;
use relume::format::{FieldFormat, encode_field};
use relume::{Error, Footprint, RasterSequence, Result, Size, Space};
use serde_json::json;

use super::input::Inputs;
use super::test::{self, Test};
use super::words::{by_polar_angle, measured, predicted, relit};
use super::{Args, FittedFormat, described, quality};
use crate::context::Context;
use crate::output::Outputs;
use crate::report::{Report, counted};

/// A number of functions.
pub(super) fn rank(text: &str) -> std::result::Result<usize, String> {
    let number = text.parse().ok().filter(|n| (1..=MOST_FUNCTIONS).contains(n));
    number.ok_or_else(|| format!("expected a number of functions from 1 to {MOST_FUNCTIONS}"))
}

/// A root mean square error.
pub(super) fn error(text: &str) -> std::result::Result<f64, String> {
    let number = text.parse().ok().filter(|error| *error > 0.0 && *error < 1.0);
    number.ok_or_else(|| "expected an error of values with white at 1, between 0 and 1".to_owned())
}

/// Learns functions and writes the field.
pub(super) fn run(
    args: &Args,
    format: FittedFormat,
    mut inputs: Inputs,
    mut outputs: Outputs,
    context: &Context,
) -> Result<Report> {
    let mut options = options(args, format)?;
    options.mask = inputs.mask().map(<[bool]>::to_vec);
    if options.rounding.is_some() {
        inputs.check_grid("rounding")?;
    }
    let pairs = inputs.pairs().to_vec();
    let most = |shape: (Size, usize)| learned::most_functions(&pairs, options.hold_out, shape);
    let place = inputs.place().to_path_buf();
    let most = |shape| most(shape).map_err(|e| e.at(&place));
    let rank = |size: Size, channels: usize| match (options.rank, args.rank) {
        // A texture of one texel, or of few pairs, has no more functions.
        (Rank::Functions(usual), None) => Ok(Rank::Functions(usual.min(most((size, channels))?))),
        (rank, _) => Ok(rank),
    };
    let count = pairs.len();
    let fits = |size, channels| foresee(rank(size, channels)?, (size, channels), count, format, context);
    inputs.measure(args, &fits, &context.job)?;
    let load = |i: usize| inputs.photograph(i, &context.job);
    let photographs = RasterSequence::open(&load)?;
    let (size, channels) = (photographs.size(), photographs.channels());
    fits(size, channels)?;
    let options = LearnedOptions { rank: rank(size, channels)?, ..options };
    let load = |i: usize| photographs.read(i);
    let fit =
        learned::fit(inputs.pairs(), &load, &options, &context.job).map_err(|e| e.at(inputs.place()))?;
    let tested = test::run(args, &inputs, &fit.field, context)?;
    outputs.write(&args.output, encoded(&fit, format, context)?)?;
    let fitted = json!(fit.report);
    let quality = quality::run(args, &inputs, &fit.field, &fitted, &mut outputs, context)?;
    let written = outputs.commit()?;
    let mut json = described(&fit.field, fitted, tested.as_ref(), quality.as_ref());
    json["clusters"] = json!(options.clusters);
    json["rounding"] = json!(options.rounding);
    let mut text =
        format!("{}: {}\n{}", args.output.display(), made(&fit, &options, count), summary(&fit.report));
    text.extend(tested.as_ref().map(Test::summary));
    Ok(Report::new(text, json)
        .with_outputs(written)
        .with_warnings(&fit.report.warnings)
        .with_warnings(inputs.saturation())
        .with_warnings(inputs.warnings())
        .with_warnings(inputs.lamp_warning(fit.field.basis()))
        .with_warnings(tested.iter().flat_map(|test| &test.warnings))
        .with_warnings(quality.iter().flat_map(|quality| &quality.warnings)))
}

/// What was made of so many photographs.
fn made(fit: &LearnedFit, options: &LearnedOptions, photographs: usize) -> String {
    let clusters = options
        .clusters
        .map_or(String::new(), |of| format!(" in {} of {}", counted(of.clusters, "cluster"), axes(of.axes)));
    format!(
        "{} texels, {}{clusters}, {} values, from {}",
        fit.field.size(),
        counted(fit.report.functions, "learned function"),
        fit.report.space,
        counted(photographs, "photograph")
    )
}

/// Some axes of clusters, in words.
fn axes(count: usize) -> String {
    if count == 1 { "1 axis".to_owned() } else { format!("{count} axes") }
}

/// What is asked for, where the file named can hold it.
fn options(args: &Args, format: FittedFormat) -> Result<LearnedOptions> {
    let defaults = LearnedOptions::default();
    let is_btf = matches!(format, FittedFormat::Btf(_));
    let space = args.space.unwrap_or(if is_btf { Space::Linear } else { Space::Srgb });
    let options = LearnedOptions {
        rank: args.error.map_or(args.rank.map_or(defaults.rank, Rank::Functions), Rank::Error),
        space,
        hold_out: args.hold_out,
        report_texels: args.report_texels.unwrap_or(defaults.report_texels),
        clusters: clusters(args, &defaults)?,
        rounding: args.rounding,
        ..defaults
    };
    options.validate()?;
    if is_btf && space != Space::Linear {
        return Err(Error::usage("a .btf file holds values proportional to light: leave out --space srgb")
            .at(&args.output));
    }
    if is_btf && options.clusters.is_some() {
        return Err(Error::usage("a .btf file holds no clusters: name an .exr to write").at(&args.output));
    }
    Ok(options)
}

/// The clusters asked for.
fn clusters(args: &Args, defaults: &LearnedOptions) -> Result<Option<ClusterOptions>> {
    let Some(clusters) = args.clusters else { return Ok(None) };
    let functions = match (args.rank, defaults.rank) {
        (Some(rank), _) | (None, Rank::Functions(rank)) => rank,
        (None, Rank::Error(_)) => MOST_FUNCTIONS,
    };
    if args.error.is_some() {
        return Err(Error::usage(
            "--error finds a number of functions, and --clusters needs it: give --rank",
        ));
    }
    let axes = args.cluster_axes.unwrap_or(functions.div_ceil(3));
    Ok(Some(ClusterOptions { clusters: clusters.into(), axes }))
}

fn encoded(fit: &LearnedFit, format: FittedFormat, context: &Context) -> Result<Vec<u8>> {
    let field = &fit.field;
    let scalar = match (format, &fit.clustered) {
        (FittedFormat::Field(FieldFormat::Exr(depth)), Some(clustered)) => {
            return encode_clustered(clustered, depth, &context.job);
        }
        (FittedFormat::Field(format), _) => return encode_field(field, format, None, &context.job),
        (FittedFormat::Btf(scalar), _) => scalar,
    };
    let Basis::Learned(learned) = field.basis() else {
        return Err(Error::usage("a .btf file holds learned functions"));
    };
    let norm = |plane: &[f32]| plane.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>().sqrt() as f32;
    let factors = BtfFactors {
        shape: FactorShape::Functions,
        functions: learned.values().to_vec(),
        coefficients: field.coefficients().clone(),
        singular: field.coefficients().iter().map(norm).collect(),
    };
    encode_fmf(learned.pairs(), &factors.without_cosine(learned.pairs())?, scalar, &context.job)
}

/// Refuses a texture that could be fitted, but not written within the memory: with the table of its functions as
/// numbers and as text.
fn foresee(
    rank: Rank,
    (size, channels): (Size, usize),
    pairs: usize,
    format: FittedFormat,
    context: &Context,
) -> Result<()> {
    // Base64 of four bytes, twice while it is made.
    const TEXT_BYTES: usize = 6;
    let functions = if let Rank::Functions(n) = rank { n } else { MOST_FUNCTIONS };
    let table = (channels * functions).saturating_mul(pairs);
    let table = Footprint { peak: (4 + 2 * TEXT_BYTES) as u64 * table as u64, kept: 4 * table as u64 };
    let fitted = Footprint::of_texels(size, 4 * functions as u64, 4 * functions as u64);
    let file = match format {
        FittedFormat::Field(format) => format.footprint(size, functions),
        FittedFormat::Btf(_) => Footprint::of_texels(size, 8 * functions as u64, 4 * functions as u64),
    };
    let peak = fitted.then(file).then(table).peak;
    context.job.check_bytes("the texture and its file", peak)
}

fn summary(report: &LearnedReport) -> String {
    let mut lines = vec![relit(&report.fitted, report.space)];
    lines.extend(report.held_out.as_ref().map(|left_out| predicted(left_out, &report.fitted)));
    lines.push(by_polar_angle(&report.by_view, &report.by_light));
    lines.push(format!("worst: {}", report.worst));
    lines.push(measured(report.texels_measured, report.texels_inside, report.texels));
    lines.join("\n")
}
