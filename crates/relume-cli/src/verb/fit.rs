//! `relume fit`: from photographs under known lights to a texture of functions.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::capture::{Capture, Pairing};
use relume::field::{Basis, PlaneLayout};
use relume::fit::{self, FitOptions, FitReport};
use relume::format::{ExrDepth, FieldFormat, encode_field};
use relume::{Error, Footprint, RasterSequence, ReflectanceField, Result, Size, Space};
use serde_json::json;

use crate::args;
use crate::context::Context;
use crate::output::{self, CaptureFiles, Outputs};
use crate::report::Report;

/// Arguments of `relume fit`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume fit photographs/lights.lp -o wool.ptm --leave-one-out")]
pub struct Args {
    /// A light-position file (.lp), or a folder that holds exactly one
    capture: PathBuf,
    /// The texture to write: .ptm or .exr; `-` writes a .ptm to standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The basis functions: six polynomials (ptm), or nine hemispherical harmonics (hsh9)
    #[arg(long, default_value = "ptm", value_parser = basis())]
    basis: Basis,
    /// One luminance function times a colour (lrgb), or one function per channel (rgb); not needed for grey
    /// photographs
    #[arg(long, default_value = "lrgb", value_parser = color())]
    color: PlaneLayout,
    /// Fit sRGB-encoded values (srgb) or values proportional to light (linear) [default: srgb for .ptm,
    /// linear for .exr]
    #[arg(long, value_parser = args::named::<Space>())]
    space: Option<Space>,
    /// Store an .exr in 16-bit floats
    #[arg(long)]
    half: bool,
    /// Pair lights and photographs by name, or in order of sorted names
    #[arg(long, default_value = "name", value_parser = args::named::<Pairing>())]
    pair: Pairing,
    /// Also measure how well each photograph is predicted from all others
    #[arg(long)]
    leave_one_out: bool,
    /// Number of texels of each photograph to compare with the result, or `all`
    #[arg(long, value_name = "N", default_value = "65536", value_parser = texels)]
    report_texels: usize,
    /// Fit only this rectangle of the photographs: left, top, width and height in texels
    #[arg(long, value_name = "X,Y,W,H", value_parser = rectangle)]
    crop: Option<Rectangle>,
}

/// A rectangle of texels.
#[derive(Debug, Clone, Copy)]
struct Rectangle {
    x: usize,
    y: usize,
    size: Size,
}

/// Fits a capture and writes the field.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let mut outputs = Outputs::new(context);
    outputs.file(&args.output, &[&args.capture])?;
    let format = output_format(args)?;
    if format == FieldFormat::Ptm && args.basis != Basis::Ptm {
        return Err(Error::usage(format!(
            "a .ptm file holds functions of the basis ptm, not {}: name an .exr to write",
            args.basis.name()
        ))
        .at(&args.output));
    }
    let options = FitOptions {
        basis: args.basis.clone(),
        layout: args.color.clone(),
        space: args.space.unwrap_or(if format == FieldFormat::Ptm { Space::Srgb } else { Space::Linear }),
        report_texels: args.report_texels,
        leave_one_out: args.leave_one_out,
    };
    let capture = Capture::open_paired(&args.capture, args.pair)?;
    let paths: Vec<&Path> = capture.photographs.iter().map(|p| p.path.as_path()).collect();
    output::refuse_input(&args.output, &paths)?;
    let files = CaptureFiles::of(&capture)?;
    let load = |i: usize| {
        let photograph = files.raster(paths[i], &context.job)?;
        let cropped = args.crop.map(|r| photograph.crop(r.x, r.y, r.size));
        cropped.unwrap_or(Ok(photograph)).map_err(|e| e.at(paths[i]))
    };
    let photographs = RasterSequence::open(&load)?;
    foresee(&options, &photographs, format, context)?;
    let load = |i: usize| photographs.read(i);
    let mut fit =
        fit::fit(&capture.lights(), &load, &options, &context.job).map_err(|e| e.at(&capture.light_file))?;
    fit.report.warnings.extend(capture.warnings.iter().cloned());
    outputs.write(&args.output, encode_field(&fit.field, format, None, &context.job)?)?;
    let written = outputs.commit()?;
    let json = json!({
        "width": fit.field.size().width,
        "height": fit.field.size().height,
        "basis": fit.field.basis(),
        "color": fit.field.layout(),
        "report": fit.report,
    });
    let text = summary(&args.output, &fit.field, &fit.report);
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

fn output_format(args: &Args) -> Result<FieldFormat> {
    if output::is_stream(&args.output) && !args.half {
        return Ok(FieldFormat::Ptm);
    }
    match (FieldFormat::from_path(&args.output)?, args.half) {
        (FieldFormat::Exr(_), true) => Ok(FieldFormat::Exr(ExrDepth::Half)),
        (format @ (FieldFormat::Exr(_) | FieldFormat::Ptm), false) => Ok(format),
        (_, true) => Err(Error::usage("--half needs an .exr to write").at(&args.output)),
        (FieldFormat::Picture(_), false) => {
            Err(Error::usage("a picture cannot hold functions: name a .ptm or .exr to write")
                .at(&args.output))
        }
    }
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
    if let Some(error) = report.leave_one_out {
        lines.push(format!("each predicted from the others: {:.2} dB", error.psnr_db));
    }
    lines.push(format!(
        "measured on {} of {} texels, before rounding to the file's depth",
        report.texels_measured, report.texels
    ));
    lines.join("\n")
}

fn basis() -> impl TypedValueParser<Value = Basis> {
    PossibleValuesParser::new([Basis::Ptm.name(), Basis::Harmonics.name()])
        .map(|name| Basis::from_name(&name).expect("a possible value is a basis"))
}

fn color() -> impl TypedValueParser<Value = PlaneLayout> {
    PossibleValuesParser::new([PlaneLayout::LRGB.name(), PlaneLayout::RGB.name()])
        .map(|name| PlaneLayout::from_name(&name).expect("a possible value is a layout"))
}

fn texels(text: &str) -> std::result::Result<usize, String> {
    let number = if text == "all" { Some(usize::MAX) } else { text.parse().ok().filter(|n| *n > 0) };
    number.ok_or_else(|| "expected a number of at least 1, or all".to_owned())
}

fn rectangle(text: &str) -> std::result::Result<Rectangle, String> {
    let numbers: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, width, height]) if width > 0 && height > 0 => {
            Ok(Rectangle { x, y, size: Size::new(width, height) })
        }
        _ => Err("expected four whole numbers such as 100,80,512,512, the last two at least 1".to_owned()),
    }
}
