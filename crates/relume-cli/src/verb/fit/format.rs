//! The file that a fit is asked to write.

use std::path::Path;

use relume::format::bonn::{BtfScalar, check_grid, check_square};
use relume::format::{ExrDepth, FieldFormat};
use relume::{Error, Result};

use super::choice::BasisChoice;
use super::factors::Factorisation;
use super::input::Inputs;
use super::{Args, parametric};
use crate::output;

/// The format of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FittedFormat {
    Field(FieldFormat),
    /// Factors, as the database UBO2014 stores them.
    Btf(BtfScalar),
}

/// The format of the file named, where it holds what is asked for.
pub(super) fn output_format(args: &Args, basis: &BasisChoice) -> Result<FittedFormat> {
    if args.model.is_some() {
        return parametric::output_format(args);
    }
    if is_btf(&args.output) {
        if args.rounding.is_some() {
            return Err(Error::usage(
                "a .btf file holds plain numbers: give --rounding with an .exr to write",
            )
            .at(&args.output));
        }
        return Ok(FittedFormat::Btf(if args.half { BtfScalar::Half } else { BtfScalar::Float }));
    }
    let format = named_format(args)?;
    format.check_basis(basis.name()).map_err(|e| e.at(&args.output))?;
    Ok(FittedFormat::Field(format))
}

/// Whether a file is to hold factors for readers of `.btf`.
pub(super) fn is_btf(output: &Path) -> bool {
    output.extension().is_some_and(|e| e.eq_ignore_ascii_case("btf"))
}

fn named_format(args: &Args) -> Result<FieldFormat> {
    if output::is_stream(&args.output) && !args.half && args.rounding.is_none() {
        return Ok(FieldFormat::Ptm);
    }
    let format = FieldFormat::from_path(&args.output).map_err(|_| {
        Error::usage("no texture is written under this name: name a .ptm, .rti or .exr, or a .btf for learned functions")
            .at(&args.output)
    })?;
    match (format, args.half || args.rounding.is_some()) {
        (FieldFormat::Exr(_), true) => Ok(FieldFormat::Exr(ExrDepth::Half)),
        (FieldFormat::Picture(_), false) => {
            Err(Error::usage("a picture cannot hold functions: name a .ptm or .exr to write")
                .at(&args.output))
        }
        (format, false) => Ok(format),
        (_, true) if args.half => Err(Error::usage("--half needs an .exr or .btf to write").at(&args.output)),
        (_, true) => Err(Error::usage("--rounding needs an .exr to write").at(&args.output)),
    }
}

/// Refuses, before any work, pairs that the file named cannot hold.
pub(super) fn check_pairs(args: &Args, format: FittedFormat, inputs: &Inputs) -> Result<()> {
    let FittedFormat::Btf(_) = format else { return Ok(()) };
    let pairs: Vec<_> = inputs.pairs().iter().map(|(_, pair)| *pair).collect();
    let of_views = args.factors == Some(Factorisation::PerView);
    let checked = if of_views { check_grid(&pairs) } else { check_square(&pairs) };
    let other = if !of_views && check_grid(&pairs).is_ok() { "give --factors per-view, or " } else { "" };
    checked.map_err(|e| Error::usage(format!("{e}; {other}name an .exr to write")).at(&args.output))
}
