//! Factorisations that a `.btf` file holds beside the common one of all channels and views.

use relume::fit::learned::{LearnedOptions, Rank};
use relume::format::bonn::{BtfScalar, encode_dfmf, encode_pvf};
use relume::workflow::decorrelated::{DECORRELATED, DecorrelatedRanks, decorrelated};
use relume::workflow::per_view::per_view;
use relume::{Error, Held, Job, Named, RasterSequence, Result};
use serde_json::{Value, json};

use super::Args;
use super::input::Inputs;
use crate::context::Context;
use crate::output::Outputs;
use crate::paths;
use crate::report::{Report, counted};

/// What is factored in one piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Factorisation {
    /// Everything (FMF).
    Common,
    /// Each channel of a decorrelated colour (DFMF).
    Decorrelated,
    /// Each view (PVF).
    PerView,
}

impl Named for Factorisation {
    const ALL: &'static [Self] = &[Self::Common, Self::Decorrelated, Self::PerView];

    fn name(self) -> &'static str {
        match self {
            Self::Common => "common",
            Self::Decorrelated => "decorrelated",
            Self::PerView => "per-view",
        }
    }
}

/// Learns the functions and writes the file.
pub(super) fn run(
    args: &Args,
    factorisation: Factorisation,
    scalar: BtfScalar,
    inputs: &Inputs,
    mut outputs: Outputs,
    context: &Context,
) -> Result<Report> {
    check(args, factorisation)?;
    let job = &context.job;
    let load = |i: usize| inputs.photograph(i, job);
    let photographs = RasterSequence::open(&load)?;
    let size = photographs.size();
    let usual = match LearnedOptions::default().rank {
        Rank::Functions(rank) => rank,
        Rank::Error(_) => 1,
    };
    let most = match factorisation {
        // Each view has as many as its own lights allow.
        Factorisation::PerView => size.texels(),
        Factorisation::Common | Factorisation::Decorrelated => size.texels().min(inputs.pairs().len()),
    };
    let rank = args.rank.unwrap_or(usual.min(most));
    let load = |i: usize| photographs.read(i);
    let (functions, said, bytes) = match factorisation {
        Factorisation::PerView => {
            let _factors = hold_factors(rank, scalar, inputs, &photographs, job)?;
            let views = per_view(inputs.pairs(), &load, rank, job).map_err(|e| e.at(inputs.place()))?;
            let said = format!("{} of each of {}", counted(rank, "function"), counted(views.len(), "view"));
            (json!(rank), said, encode_pvf(&directions(inputs), &views, scalar, job))
        }
        Factorisation::Common | Factorisation::Decorrelated => {
            let ranks = DecorrelatedRanks::of_luminance(rank);
            let factors =
                decorrelated(inputs.pairs(), &load, ranks, job).map_err(|e| e.at(inputs.place()))?;
            let said = format!(
                "{} of the logarithm of the luminance and {} of each colour difference",
                counted(ranks.luminance, "function"),
                ranks.color
            );
            let bytes = encode_dfmf(&directions(inputs), &factors, DECORRELATED, scalar, job);
            (json!(ranks), said, bytes)
        }
    };
    outputs.write(&args.output, bytes.map_err(|e| e.at(&args.output))?)?;
    let written = outputs.commit()?;
    let text = format!(
        "{}: {size} texels, {said}, from {}\n`relume compare {} {}` measures the error",
        args.output.display(),
        counted(inputs.pairs().len(), "photograph"),
        paths::shell_word(&args.capture),
        paths::shell_word(&args.output)
    );
    Ok(Report::new(text, described(size, factorisation, &functions))
        .with_outputs(written)
        .with_warnings(inputs.warnings()))
}

/// Holds the memory of the factors of all views, where that of their file suffices as well.
fn hold_factors(
    rank: usize,
    scalar: BtfScalar,
    inputs: &Inputs,
    photographs: &RasterSequence<'_>,
    job: &Job,
) -> Result<Held> {
    let of_texels = inputs.views() * photographs.size().texels();
    let numbers = (rank * (of_texels + inputs.pairs().len() * photographs.channels())) as u64;
    job.check_bytes("the factors of all views and their file", numbers * (4 + scalar.bytes()))?;
    job.hold("the factors of all views", 4 * numbers)
}

/// Refuses options without a part in these factorisations.
fn check(args: &Args, factorisation: Factorisation) -> Result<()> {
    let given = [
        (args.error.is_some(), "--error"),
        (args.clusters.is_some(), "--clusters"),
        (args.hold_out.is_some(), "--hold-out"),
        (args.space.is_some(), "--space"),
        (args.report_texels.is_some(), "--report-texels"),
    ];
    match given.iter().find(|(given, _)| *given) {
        Some((_, name)) => Err(Error::usage(format!(
            "{name} has no meaning with --factors {}: leave it out",
            factorisation.name()
        ))),
        None => Ok(()),
    }
}

fn directions(inputs: &Inputs) -> Vec<relume::direction::Directions> {
    inputs.pairs().iter().map(|(_, pair)| *pair).collect()
}

fn described(size: relume::Size, factorisation: Factorisation, functions: &Value) -> Value {
    json!({
        "width": size.width,
        "height": size.height,
        "basis": "learned",
        "color": "rgb",
        "report": { "factors": factorisation.name(), "functions": functions },
    })
}
