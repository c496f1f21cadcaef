//! Functions of light: polynomials or harmonics.

use std::path::Path;

use relume::direction::Direction;
use relume::field::{Basis, Interpolation, PlaneLayout};
use relume::fit::{self, FitOptions, FitReport, Robust};
use relume::format::{FieldFormat, encode_field};
use relume::{Error, Footprint, RasterSequence, ReflectanceField, Result, Space};
use serde_json::json;

use super::input::Inputs;
use super::{Args, described, quality, test};
use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;

/// Fits the functions of a basis and writes the field.
pub(super) fn run(
    args: &Args,
    basis: Basis,
    format: FieldFormat,
    inputs: &Inputs,
    mut outputs: Outputs,
    context: &Context,
) -> Result<Report> {
    let has_shapes = basis.name() == Interpolation::Shapes.name();
    if has_shapes && args.color == Some(PlaneLayout::LRGB) {
        return Err(Error::usage("shapes of shadows are those of each channel: leave out --color lrgb"));
    }
    let is_compact = basis == Basis::Ptm || basis == Basis::HSH9;
    let layout = if is_compact { PlaneLayout::LRGB } else { PlaneLayout::RGB };
    let robust = args.robust.unwrap_or_default();
    let is_interpolated = matches!(basis, Basis::Interpolated(_));
    let lamps = inputs.lamps().filter(|_| !is_interpolated);
    let is_far = inputs.lamps().is_some() && is_interpolated;
    let options = FitOptions {
        basis,
        layout: args.color.clone().unwrap_or(layout),
        space: args.space.unwrap_or(if format.is_encoded() || has_shapes {
            Space::Srgb
        } else {
            Space::Linear
        }),
        report_texels: args.report_texels,
        leave_one_out: args.leave_one_out
            || (args.report.is_some() && robust == Robust::None && lamps.is_none()),
        ridge: args.ridge.unwrap_or_default(),
        robust,
        lamps,
    };
    let load = |i: usize| inputs.photograph(i, &context.job);
    let photographs = RasterSequence::open(&load)?;
    foresee(&options, &photographs, format, context)?;
    let load = |i: usize| photographs.read(i);
    let lights: Vec<(String, Direction)> =
        inputs.pairs().iter().map(|(name, pair)| (name.clone(), pair.light)).collect();
    let mut fit = fit::fit(&lights, &load, &options, &context.job).map_err(|e| e.at(inputs.place()))?;
    fit.report.warnings.extend(inputs.warnings().iter().cloned());
    fit.report.warnings.extend(is_far.then(|| {
        "photographs that are interpolated have one light each: that of near lamps is taken from the middle of the surface"
            .to_owned()
    }));
    let tested = test::run(args, &fit.field, context)?;
    outputs.write(&args.output, encode_field(&fit.field, format, None, &context.job)?)?;
    let fitted = json!(fit.report);
    let quality = quality::run(args, inputs, &fit.field, &fitted, &mut outputs, context)?;
    let written = outputs.commit()?;
    let mut json = described(&fit.field, fitted, tested.as_ref(), quality);
    json["development"] = inputs.facts();
    let mut text = summary(&args.output, &fit.field, &fit.report);
    text.extend(tested.as_ref().map(test::summary));
    Ok(Report::new(text, json).with_outputs(written).with_warnings(&fit.report.warnings))
}

/// Refuses a texture that could be fitted, but not written within the memory.
fn foresee(
    options: &FitOptions,
    photographs: &RasterSequence<'_>,
    format: FieldFormat,
    context: &Context,
) -> Result<()> {
    let planes = match photographs.channels() {
        1 => options.basis.len(),
        _ => options.layout.planes(options.basis.len()),
    };
    let size = photographs.size();
    let fitted = Footprint::of_texels(size, 4 * planes as u64, 4 * planes as u64);
    context.job.check_bytes("the texture and its file", fitted.then(format.footprint(size, planes)).peak)
}

fn summary(output: &Path, field: &ReflectanceField, report: &FitReport) -> String {
    let worst = report.worst_light();
    let [x, y, z] = worst.direction;
    let mut lines = vec![
        format!(
            "{}: {} texels, {} {}, {} values, from {} photographs",
            output.display(),
            field.size(),
            field.layout().name(),
            field.basis().name(),
            report.space,
            report.lights.len()
        ),
        format!("relit photographs: {:.2} dB PSNR, RMSE {:.4}", report.error.psnr_db, report.error.rmse),
        format!("worst: {} at ({x:.3}, {y:.3}, {z:.3}), {:.2} dB", worst.name, worst.error.psnr_db),
    ];
    if let Some(weight) = report.ridge {
        lines.push(format!("ridge: rough functions penalised with the weight {weight}"));
    }
    match report.robust {
        Robust::None => {}
        Robust::Trimmed => lines.push(
            "robust: the darkest quarter and the brightest tenth of the photographs of each texel left out"
                .into(),
        ),
        Robust::Reweighted => {
            lines.push("robust: photographs that differ much from the function of a texel count less".into());
        }
    }
    if let Some(error) = report.leave_one_out {
        lines.push(format!("each predicted from the others: {:.2} dB", error.psnr_db));
    }
    lines.push(format!(
        "measured on {} of {} texels, before rounding to the file's depth",
        report.texels_measured, report.texels
    ));
    lines.join("\n")
}
