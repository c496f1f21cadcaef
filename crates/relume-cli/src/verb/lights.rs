//! `relume lights`: the lamps of photographs from the highlights on mirror balls.

use std::path::{Path, PathBuf};

use relume::capture::balls::{BallLights, MirrorBall, drawn, find_lights, lights_of};
use relume::capture::{lp, pictures_in};
use relume::format::{PictureFormat, encode_picture_with};
use relume::{Error, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output::Outputs;
use crate::report::{Report, counted};
use crate::{args, input, output, paths};

/// Arguments of `relume lights`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume lights photographs -o photographs/lights.lp\n  \
    relume lights photographs --ball 385,346,260 --ball 2210,350,258 -o lights.lp --picture found.png\n  \
    relume lights IMG_*.JPG -o lights.lp --ball-mm 30 --positions")]
pub struct Args {
    /// A folder of photographs, one for each lamp, or the photographs
    #[arg(required = true)]
    photographs: Vec<PathBuf>,
    /// The light-position file to write (.lp)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The outline of a mirror ball in pixels: column and row of its centre, counted from the upper left corner, and
    /// radius; may be given several times [default: balls are looked for]
    #[arg(long, value_name = "X,Y,R", value_parser = ball)]
    ball: Vec<MirrorBall>,
    /// The diameter of the balls in millimetres: positions are then in millimetres
    #[arg(long, value_name = "MM", value_parser = args::within(0.1, 10_000.0, "millimetres"))]
    ball_mm: Option<f64>,
    /// Write positions instead of unit vectors: in millimetres (with --ball-mm) or pixels from the middle of the
    /// photographs; needs two balls
    #[arg(long)]
    positions: bool,
    /// Leave out photographs without a usable highlight instead of refusing them
    #[arg(long)]
    skip: bool,
    /// Also write a picture of what was found: the balls and all highlights
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
}

/// Finds the lamps and writes their directions.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let photographs = photographs(args)?;
    let inputs: Vec<&Path> = photographs.iter().map(PathBuf::as_path).collect();
    let mut outputs = Outputs::new(context);
    output::expect(&args.output, "a light-position file", &["lp"])?;
    outputs.file(&args.output, &inputs)?;
    let picture =
        args.picture.as_ref().map(|path| PictureFormat::from_path(path).map(|format| (path, format)));
    let picture = picture.transpose()?;
    if let Some((path, _)) = picture {
        outputs.file(path, &inputs)?;
    }
    let names: Vec<String> = photographs.iter().map(|path| name(path)).collect();
    let load = |i: usize| input::raster(&photographs[i], &context.job);
    let found = match args.ball.as_slice() {
        [] => find_lights(&names, &load, &context.job)?,
        balls => lights_of(&names, &load, balls, &context.job)?,
    };
    if !args.skip || found.lights().is_empty() {
        let advice =
            if found.lights().is_empty() { "" } else { "; take them out, or have them left out with --skip" };
        found.refuse_problems().map_err(|e| Error::new(e.kind(), format!("{}{advice}", e.message())))?;
    }
    outputs.write(&args.output, light_file(args, &found)?.into_bytes())?;
    if let Some((path, format)) = picture {
        let picture = drawn(&found, &load, &context.job)?;
        outputs.write(path, encode_picture_with(&picture, format, &context.job)?)?;
    }
    let written = outputs.commit()?;
    let skipped = found.frames.iter().filter_map(|frame| frame.trouble()).map(|t| format!("left out: {t}"));
    Ok(Report::new(summary(args, &found), described(args, &found))
        .with_outputs(written)
        .with_warnings(skipped)
        .with_warnings(disagreeing(&found)))
}

/// Directions of one lamp in two balls farther apart than near lamps leave them.
const DISAGREEING_DEG: f64 = 25.0;

/// What is said of balls of which one seems to be none.
fn disagreeing(found: &BallLights) -> Option<String> {
    found.disagreement_deg.filter(|deg| *deg > DISAGREEING_DEG).map(|deg| {
        format!("the balls show one lamp in directions up to {deg:.0} degrees apart: one of them may be no mirror ball, or not outlined as it is (--picture shows them)")
    })
}

fn photographs(args: &Args) -> Result<Vec<PathBuf>> {
    match args.photographs.as_slice() {
        [folder] if folder.is_dir() => pictures_in(folder),
        files => match files.iter().find(|path| path.is_dir()) {
            Some(folder) => {
                Err(Error::usage("is a folder among files: name one folder, or photographs alone").at(folder))
            }
            None => Ok(files.to_vec()),
        },
    }
}

fn name(path: &Path) -> String {
    paths::text(path.file_name().map_or(path, Path::new))
}

/// The text of the light file.
fn light_file(args: &Args, found: &BallLights) -> Result<String> {
    if !args.positions {
        return lp::format(&found.lights());
    }
    let scale = scale(args, found);
    let placed: Vec<(String, [f64; 3])> = found
        .frames
        .iter()
        .filter_map(|frame| Some((frame.name.clone(), frame.position?.map(|v| v * scale))))
        .collect();
    if placed.len() < found.lights().len() {
        return Err(Error::usage(
            "--positions: the lamps are too far away, or the balls too few or too near to each other, to tell how far; \
             leave it out to write directions",
        ));
    }
    lp::format_positions(&placed)
}

/// Millimetres in a pixel, or 1 for pixels.
fn scale(args: &Args, found: &BallLights) -> f64 {
    let radius = found.balls.iter().map(|ball| ball.radius).sum::<f64>() / found.balls.len() as f64;
    args.ball_mm.map_or(1.0, |mm| mm / (2.0 * radius))
}

fn described(args: &Args, found: &BallLights) -> Value {
    let scale = scale(args, found);
    let light = |frame: &relume::capture::balls::BallFrame| {
        json!({
            "name": frame.name,
            "direction": frame.direction,
            "position": frame.position.map(|p| p.map(|v| v * scale)),
            "highlights": frame.highlights,
            "problem": frame.problem,
        })
    };
    json!({
        "width": found.size.width,
        "height": found.size.height,
        "balls": found.balls,
        "found_balls": args.ball.is_empty(),
        "unit": if args.ball_mm.is_some() { "mm" } else { "pixels" },
        "mm_per_pixel": args.ball_mm.map(|_| scale),
        "disagreement_deg": found.disagreement_deg,
        "lights": found.frames.iter().map(light).collect::<Vec<_>>(),
    })
}

fn summary(args: &Args, found: &BallLights) -> String {
    let lights = found.lights();
    let outline = |ball: &MirrorBall| format!("--ball {:.1},{:.1},{:.1}", ball.x, ball.y, ball.radius);
    let mut lines = vec![
        format!(
            "{}: {} from {}",
            args.output.display(),
            counted(lights.len(), "light"),
            counted(found.frames.len(), "photograph")
        ),
        format!(
            "{}: {}",
            counted(found.balls.len(), "mirror ball"),
            found.balls.iter().map(outline).collect::<Vec<_>>().join(" ")
        ),
    ];
    let lowest = lights.iter().map(|(_, light)| light.polar_rad().to_degrees()).fold(0.0, f64::max);
    lines.push(format!("the lowest light is {lowest:.1} degrees from the zenith"));
    lines.extend(
        found
            .disagreement_deg
            .map(|deg| format!("the balls' directions for one lamp differ by up to {deg:.2} degrees")),
    );
    let distances: Vec<f64> = found
        .frames
        .iter()
        .filter_map(|frame| {
            Some(frame.position?.iter().map(|v| v * v).sum::<f64>().sqrt() * scale(args, found))
        })
        .collect();
    if let (Some(near), Some(far)) =
        (distances.iter().copied().reduce(f64::min), distances.iter().copied().reduce(f64::max))
    {
        let unit = if args.ball_mm.is_some() { "mm" } else { "pixels" };
        lines.push(format!("lamps are {near:.0} to {far:.0} {unit} from the middle of the photographs"));
    }
    lines.join("\n")
}

/// The outline of a ball on the command line.
pub fn ball(text: &str) -> std::result::Result<MirrorBall, String> {
    match args::numbers::<3>(text) {
        Some([x, y, radius]) if radius > 0.0 => Ok(MirrorBall { x, y, radius }),
        _ => Err("expected three numbers such as 385.5,346,260: column, row and radius in pixels".to_owned()),
    }
}
