//! Functions of light: polynomials or harmonics.

use std::path::Path;

use relume::direction::Direction;
use relume::field::{Basis, Interpolation, PlaneLayout};
use relume::fit::{self, FitOptions, FitReport, Ridge, Robust};
use relume::format::{FieldFormat, encode_field};
use relume::{Error, Footprint, RasterSequence, ReflectanceField, Result, Size, Space};
use serde_json::json;

use super::input::Inputs;
use super::test::{self, Test};
use super::words::measured;
use super::{Args, described, quality};
use crate::context::Context;
use crate::output::Outputs;
use crate::report::{Report, counted};

/// Fits the functions of a basis and writes the field.
pub(super) fn run(
    args: &Args,
    basis: Basis,
    format: FieldFormat,
    mut inputs: Inputs,
    mut outputs: Outputs,
    context: &Context,
) -> Result<Report> {
    let has_shapes = basis.name() == Interpolation::Shapes.name();
    if has_shapes && args.color == Some(PlaneLayout::LRGB) {
        return Err(Error::usage("shapes of shadows are those of each channel: leave out --color lrgb"));
    }
    let far = inputs.lamp_warning(&basis);
    let options = options(args, basis, format.is_encoded() || has_shapes, &inputs);
    let count = inputs.pairs().len();
    let fits = |size: Size, channels: usize| {
        foresee(&options, (size, channels), format, context)?;
        fit::check_memory((size, channels), count, &options, &context.job)
    };
    inputs.measure(args, &fits, &context.job)?;
    let load = |i: usize| inputs.photograph(i, &context.job);
    let photographs = RasterSequence::open(&load)?;
    foresee(&options, (photographs.size(), photographs.channels()), format, context)?;
    let load = |i: usize| photographs.read(i);
    let lights: Vec<(String, Direction)> =
        inputs.pairs().iter().map(|(name, pair)| (name.clone(), pair.light)).collect();
    let mut fit = fit::fit(&lights, &load, &options, &context.job).map_err(|e| e.at(inputs.place()))?;
    fit.report.warnings.extend(inputs.warnings().iter().cloned());
    fit.report.warnings.extend(inputs.saturation());
    fit.report.warnings.extend(far);
    fit.report.warnings.extend(unmet(args, &fit.report, has_shapes));
    let tested = test::run(args, &inputs, &fit.field, context)?;
    outputs.write(&args.output, encode_field(&fit.field, format, None, &context.job)?)?;
    let fitted = json!(fit.report);
    let quality = quality::run(args, &inputs, &fit.field, &fitted, &mut outputs, context)?;
    let written = outputs.commit()?;
    let mut json = described(&fit.field, fitted, tested.as_ref(), quality.as_ref());
    json["development"] = inputs.facts();
    let mut text = summary(&args.output, &fit.field, &fit.report);
    text.extend(tested.as_ref().map(Test::summary));
    Ok(Report::new(text, json)
        .with_outputs(written)
        .with_warnings(&fit.report.warnings)
        .with_warnings(tested.iter().flat_map(|test| &test.warnings))
        .with_warnings(quality.iter().flat_map(|quality| &quality.warnings)))
}

/// The options of the fit; `is_encoded` says which values are usual for the file and the functions.
fn options(args: &Args, basis: Basis, is_encoded: bool, inputs: &Inputs) -> FitOptions {
    let is_compact = basis == Basis::Ptm || basis == Basis::HSH9;
    let layout = if is_compact { PlaneLayout::LRGB } else { PlaneLayout::RGB };
    let robust = args.robust.unwrap_or_default();
    let lamps = inputs.lamps(&basis);
    FitOptions {
        basis,
        layout: args.color.clone().unwrap_or(layout),
        space: args.space.unwrap_or(if is_encoded { Space::Srgb } else { Space::Linear }),
        report_texels: args.report_texels.unwrap_or(FitOptions::default().report_texels),
        leave_one_out: args.leave_one_out
            || (args.report.is_some() && robust == Robust::None && lamps.is_none()),
        ridge: args.ridge.unwrap_or_default(),
        robust,
        lamps,
        mask: inputs.mask().map(<[bool]>::to_vec),
    }
}

/// What was asked for and was not done, or not of all that was fitted.
fn unmet(args: &Args, report: &FitReport, has_shapes: bool) -> Vec<String> {
    let ridge = (args.ridge == Some(Ridge::LeaveOneOut) && report.ridge.is_none()).then_some(
        "no ridge was chosen: where one photograph is left out, the others are fewer than the functions; give a weight, such \
         as --ridge 0.01",
    );
    let is_missing = args.leave_one_out && report.leave_one_out.is_none();
    let left_out = is_missing.then_some(
        "the photographs were not predicted from the others (--leave-one-out), which are fewer than the functions",
    );
    let shapes = (has_shapes && args.leave_one_out).then_some(
        "each photograph is predicted by the sum of radial basis functions alone: the boundaries of shadows that move between \
         lights are not fitted anew without it (--test measures photographs that were not fitted)",
    );
    [ridge, left_out, shapes].into_iter().flatten().map(str::to_owned).collect()
}

/// Refuses a texture that could be fitted, but not written within the memory.
fn foresee(
    options: &FitOptions,
    (size, channels): (Size, usize),
    format: FieldFormat,
    context: &Context,
) -> Result<()> {
    let planes = match channels {
        1 => options.basis.len(),
        _ => options.layout.planes(options.basis.len()),
    };
    let fitted = Footprint::of_texels(size, 4 * planes as u64, 4 * planes as u64);
    context.job.check_bytes("the texture and its file", fitted.then(format.footprint(size, planes)).peak)
}

fn summary(output: &Path, field: &ReflectanceField, report: &FitReport) -> String {
    let worst = report.worst_light();
    let [x, y, z] = to_thousandths(worst.direction);
    let mut lines = vec![
        format!(
            "{}: {} texels, {} {}, {} values, from {}",
            output.display(),
            field.size(),
            field.layout().name(),
            field.basis().name(),
            report.space,
            counted(report.lights.len(), "photograph")
        ),
        format!("relit photographs: {:.2} dB PSNR, RMSE {:.4}", report.error.psnr_db, report.error.rmse),
        format!("worst: {} at ({x:.3}, {y:.3}, {z:.3}), {:.2} dB", worst.name, worst.error.psnr_db),
    ];
    if let Some(weight) = report.ridge {
        lines.push(format!("ridge: rough functions penalised with the weight {weight}"));
    }
    lines.extend(robustly(report));
    if let Some(error) = report.leave_one_out {
        lines.push(format!("each predicted from the others: {:.2} dB", error.psnr_db));
    }
    lines.push(measured(report.texels_measured, report.texels_inside, report.texels));
    lines.join("\n")
}

/// Numbers as they are printed with three decimals, of which one that rounds to nothing has no sign.
fn to_thousandths(numbers: [f64; 3]) -> [f64; 3] {
    numbers.map(|v| (1e3 * v).round() / 1e3 + 0.0)
}

/// What a robust fit did.
fn robustly(report: &FitReport) -> Option<String> {
    let fit = report.texel_fit?;
    let how = match report.robust {
        Robust::None => return None,
        Robust::Trimmed => format!(
            "the {} darkest and the {} brightest of {} photographs left out",
            fit.darkest_left_out,
            fit.brightest_left_out,
            report.lights.len()
        ),
        Robust::Reweighted => {
            "photographs that differ much from the function of a texel count less".to_owned()
        }
    };
    Some(format!("robust: at {} of {} texels {how}", fit.refitted, fit.refitted + fit.kept))
}

#[cfg(test)]
mod tests {
    use super::to_thousandths;

    #[test]
    fn nothing_has_no_sign() {
        let [x, y, z] = to_thousandths([-0.0004, -0.0006, 0.99949]);
        assert_eq!(format!("({x:.3}, {y:.3}, {z:.3})"), "(0.000, -0.001, 0.999)");
    }
}
