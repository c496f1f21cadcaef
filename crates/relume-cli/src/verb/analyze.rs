//! `relume analyze`: the properties of a texture, and possible causes of failure of a synthesis from it.

use std::fmt::Write;
use std::path::PathBuf;

use relume::analysis::advice::Way;
use relume::analysis::{Analysis, advise, analyze, blocks::Drift, draw};
use relume::field::{Domain, IndexSpace, Metric};
use relume::format::{Depth, PictureFormat, encode_picture_with};
use relume::numeric::periods::{Pattern, UncertainLattice};
use relume::render::relight;
use relume::{Direction, Result};
use serde_json::json;

use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;
use crate::{evaluated, output};

/// Arguments of `relume analyze`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume analyze wool.ptm -o wool_analysis.png\n\n\
                        docs/measures.md says how to read it.")]
pub struct Args {
    /// A .ptm, an .exr field, a picture or a .rlm model; - is standard input
    file: PathBuf,
    /// A picture of the texture with its period lattice, the autocorrelation and the spectrum (.png,
    /// .jpg, .tif, .exr, .pfm, .hdr); - is standard output, as PNG
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

/// Analyses the texture and reports.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let mut outputs = Outputs::new(context);
    let target = args.output.as_deref().map(|path| {
        outputs.file(path, &[&args.file])?;
        let stream = output::is_stream(path);
        let format =
            if stream { Ok(PictureFormat::Png(Depth::Eight)) } else { PictureFormat::from_path(path) };
        Ok((path, format?))
    });
    let target = target.transpose()?;
    let field = args.evaluated.texture(&args.file, &context.job)?;
    let space = IndexSpace::new(&field, Metric::Function, Domain::Hemisphere)?;
    let planes = space.index_planes_within(&field, &context.job, "the index of the texture")?;
    let found = analyze(&planes, &context.job).map_err(|e| e.at(&args.file))?;
    if let Some((path, format)) = target {
        let picture = draw(&relight(&field, Direction::ZENITH), &planes, &found, &context.job)?;
        outputs.write(path, encode_picture_with(&picture, format, &context.job)?)?;
    }
    let written = outputs.commit()?;
    let mut json = json!(found);
    let advice = advise(&[(&found, planes.size())]);
    json["advice"] = json!(advice);
    let ways: Vec<String> = advice.ways.iter().map(|way| way_in_words(*way)).collect();
    let text = format!(
        "{}: {}\n{}\n  to try       {} (--method auto does)",
        args.file.display(),
        advice.reason,
        describe(&found),
        ways.join(", ")
    );
    if let Some(codes) = json.as_object_mut().and_then(|json| json.shift_remove("warnings")) {
        json["warning_codes"] = codes;
    }
    Ok(Report::new(text, json).with_outputs(written).with_warnings(warnings(&found)))
}

/// A method of synthesis as options of `relume synth`.
fn way_in_words(way: Way) -> String {
    match way {
        Way::Quilting { block, overlap } => format!("--block {block} --overlap {overlap}"),
        Way::PatchMatch => "--method patchmatch".to_owned(),
        Way::Scanlines => "--method wei-levoy --coherence 1".to_owned(),
        Way::Roller { tiles } => format!("--method roller --tiles {tiles}"),
        Way::Elements => "--method elements".to_owned(),
    }
}

/// Possible causes of failure of a synthesis, a sentence each.
pub fn warnings(found: &Analysis) -> Vec<String> {
    found.warnings.iter().map(|warning| warning.sentence().to_string()).collect()
}

/// A lattice that the texture suggests and does not prove, in words.
fn doubtful(found: &UncertainLattice) -> String {
    let [a, b] = found.lattice.basis();
    format!(
        "uncertain: perhaps ({:.2}, {:.2}) and ({:.2}, {:.2}) texels, at most {:.1} repeats; {:.0} % repeats",
        a[0],
        a[1],
        b[0],
        b[1],
        found.repeats,
        100.0 * found.share
    )
}

/// The measurements, in lines without a final break.
pub fn describe(found: &Analysis) -> String {
    let mut text = String::new();
    let share = 100.0 * found.periods.share;
    let _ = match found.periods.pattern {
        Pattern::None => match found.periods.uncertain {
            None => writeln!(text, "  periods      none"),
            Some(uncertain) => writeln!(text, "  periods      {}", doubtful(&uncertain)),
        },
        Pattern::Stripes([x, y]) => {
            writeln!(
                text,
                "  periods      stripes every ({x:.2}, {y:.2}) texels (x right, y down); {share:.0} % repeats"
            )
        }
        Pattern::Lattice(lattice) => {
            let [a, b] = lattice.basis();
            writeln!(
                text,
                "  periods      ({:.2}, {:.2}) and ({:.2}, {:.2}) texels (x right, y down); {share:.0} % repeats",
                a[0], a[1], b[0], b[1]
            )
        }
    };
    let orientation = found.orientation;
    let _ = writeln!(
        text,
        "  direction    {:.0} degrees from x to y (up), coherence {:.2}",
        orientation.angle_deg, orientation.coherence
    );
    let _ = match found.feature {
        Some(size) => writeln!(text, "  features     {size:.1} texels"),
        None => writeln!(text, "  features     as large as half the picture"),
    };
    let _ = writeln!(text, "  steps        kurtosis {:.1} (3 for random phases)", found.kurtosis);
    let _ = writeln!(text, "  light        {:.1} % of the variance is a slow change", 100.0 * found.trend);
    let drift =
        |[x, y]: [Drift; 2]| format!("x {:.2} times, y {:.2} times from side to side", x.factor, y.factor);
    let _ = writeln!(text, "  scale        {}", drift(found.scale));
    let _ = write!(text, "  contrast     {}", drift(found.contrast));
    text
}
