//! Reflectance models fitted to each texel.

use std::path::Path;

use relume::Named;
use relume::field::{Basis, MOST_PRODUCTS, ViewFunction};
use relume::fit::parametric::{self, ParametricForm, ParametricOptions, ParametricReport};
use relume::format::exr::encode_parametric;
use relume::format::{ExrDepth, FieldFormat};
use relume::{Error, Footprint, RasterSequence, Result, Space};
use serde_json::json;

use super::input::Inputs;
use super::words::{by_polar_angle, predicted, relit};
use super::{Args, FittedFormat};
use crate::context::Context;
use crate::output::Outputs;
use crate::report::{Report, counted};

/// The name of a model, checked.
pub(super) fn named(text: &str) -> std::result::Result<String, String> {
    let views = Basis::NAMED.iter().map(|basis| format!("views-{}", basis.name()));
    let products = (1..=MOST_PRODUCTS).map(|products| format!("separable{products}"));
    let mut names = ParametricForm::NAMES.into_iter().map(str::to_owned).chain(views).chain(products);
    match names.any(|name| name == text) {
        true => Ok(text.to_owned()),
        false => Err(format!(
            "expected {}, views- and the name of a basis of light, or separable and 1 to {MOST_PRODUCTS} products",
            ParametricForm::NAMES.join(", ")
        )),
    }
}

/// The file that holds the numbers.
pub(super) fn output_format(args: &Args) -> Result<FittedFormat> {
    match FieldFormat::from_path(&args.output) {
        Ok(FieldFormat::Exr(_)) => {
            let depth = if args.half { ExrDepth::Half } else { ExrDepth::Float };
            Ok(FittedFormat::Field(FieldFormat::Exr(depth)))
        }
        _ => Err(needs_exr(&args.output)),
    }
}

fn needs_exr(output: &Path) -> Error {
    Error::usage("the numbers of reflectance models are written as .exr: name an .exr").at(output)
}

/// Fits the model named and writes its numbers.
pub(super) fn run(
    args: &Args,
    model: &str,
    format: FittedFormat,
    inputs: &Inputs,
    mut outputs: Outputs,
    context: &Context,
) -> Result<Report> {
    let job = &context.job;
    let FittedFormat::Field(FieldFormat::Exr(depth)) = format else { return Err(needs_exr(&args.output)) };
    let mut options = options(args, model)?;
    options.validate()?;
    let load = |i: usize| inputs.photograph(i, job);
    let photographs = RasterSequence::open(&load)?;
    options.report_texels = args.report_texels.unwrap_or(options.report_texels);
    foresee(&options, &photographs, inputs, context)?;
    let load = |i: usize| photographs.read(i);
    let fit = parametric::fit(inputs.pairs(), &load, &options, job).map_err(|e| e.at(inputs.place()))?;
    outputs.write(&args.output, encode_parametric(&fit.field, depth, job)?)?;
    let written = outputs.commit()?;
    let size = fit.field.size();
    let what = format!(
        "{}: {size} texels, reflectance model {}, {} numbers a texel, from {}",
        args.output.display(),
        fit.report.model,
        fit.report.numbers,
        counted(inputs.pairs().len(), "photograph")
    );
    let json = json!({
        "width": size.width,
        "height": size.height,
        "model": fit.report.model,
        "color": if fit.field.channels() == 1 { "luminance" } else { "rgb" },
        "numbers": fit.field.plane_names(),
        "report": fit.report,
    });
    let text = format!("{what}\n{}", summary(&fit.report));
    Ok(Report::new(text, json).with_outputs(written).with_warnings(inputs.warnings()))
}

fn options(args: &Args, model: &str) -> Result<ParametricOptions> {
    let form = ParametricForm::from_name(model, args.space.unwrap_or(Space::Srgb));
    let form = form.ok_or_else(|| Error::usage(format!("there is no reflectance model {model}")))?;
    let has_space =
        matches!(&form, ParametricForm::PerView(ViewFunction::Basis(..)) | ParametricForm::Separable(..));
    if let Some(space) = args.space.filter(|_| !has_space) {
        return Err(Error::usage(format!(
            "--space {} has no meaning for {model}, which is of light: leave it out",
            space.name()
        )));
    }
    let usual = ParametricOptions::of(form);
    let pairs = args.fit_pairs.unwrap_or(usual.pairs);
    Ok(ParametricOptions { pairs, hold_out: args.hold_out, ..usual })
}

/// Refuses numbers that could be fitted, but not written within the memory.
fn foresee(
    options: &ParametricOptions,
    photographs: &RasterSequence<'_>,
    inputs: &Inputs,
    context: &Context,
) -> Result<()> {
    let (views, lights) = (inputs.views(), inputs.lights());
    let numbers = options.form.numbers(photographs.channels(), views, lights) as u64;
    let size = photographs.size();
    let fitted = Footprint::of_texels(size, 4 * numbers, 4 * numbers);
    let file = Footprint::of_texels(size, 8 * numbers, 4 * numbers);
    context.job.check_bytes("the numbers and their file", fitted.then(file).peak)
}

fn summary(report: &ParametricReport) -> String {
    let mut lines = vec![relit(&report.fitted, report.space)];
    lines.extend(report.held_out.as_ref().map(|left_out| predicted(left_out, &report.fitted)));
    lines.push(by_polar_angle(&report.by_view, &report.by_light));
    lines.push(format!("worst: {}", report.worst));
    lines.push(format!(
        "fitted to {} pairs, measured on {} of {} texels under all, before rounding to the file's depth",
        report.pairs_fitted, report.texels_measured, report.texels
    ));
    lines.join("\n")
}
