//! `relume model`: a texture as a random field of a few kilobytes; [`combine`]: with structure from tiles;
//! [`lights`]: one model per light; [`describe`](mod@describe): the contents of a model.

mod combine;
mod describe;
mod lights;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use relume::format::{Content, rlm};
use relume::random_field::{
    Character, Heights, LevelReport, ModelOptions, SelectionOrder, character, curves,
};
use relume::workflow::likeness::Likeness;
use relume::workflow::model::{Combine, FittedModel, ModelRequest, StructureSource};
use relume::{Picture, ReflectanceField, Result, Space};
use serde_json::json;

pub use describe::describe;

use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;
use crate::{args, input};

/// Arguments of `relume model`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume model bark.png -o bark.rlm\n  \
                        relume synth bark.rlm -o large.png --size 4096\n  \
                        relume synth bark.rlm -o part.png --window 10000,-300,512,512")]
pub struct Args {
    /// A .ptm, an .exr field, or a picture; - is standard input
    texture: PathBuf,
    /// The model to write; - writes it to standard output
    #[arg(short, long, value_name = "FILE.rlm")]
    output: PathBuf,
    /// The most levels of the pyramid; auto tries 1 to 4 and uses the number whose field has the
    /// autocorrelation nearest to that of the texture; 4 takes a third of the time of auto
    #[arg(long, value_name = "N", default_value = "auto", value_parser = levels)]
    levels: LevelChoice,
    /// Factor by which each level is coarser than the one before
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().factor)]
    factor: usize,
    /// Number of nearest causal neighbours that may be chosen
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().candidates)]
    candidates: usize,
    /// Number of nearest neighbours in the coarser level that may be chosen; 0 makes levels independent
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().coarse)]
    coarse: usize,
    /// The most neighbours of a level
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().most)]
    most: usize,
    /// Selection of neighbours: the nearest, or freely by adding or removing
    #[arg(long, default_value = "forward", value_parser = args::named::<SelectionOrder>())]
    search: SelectionOrder,
    /// Assume normally distributed values instead of preserving their distribution
    #[arg(long)]
    normal: bool,
    #[command(flatten)]
    combine: combine::CombineArgs,
    #[command(flatten)]
    lights: lights::LightArgs,
    /// Also draw the log evidence of the neighbourhoods examined, one panel per level
    #[arg(long, value_name = "FILE.svg")]
    curve: Option<PathBuf>,
}

/// The number of levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LevelChoice {
    Auto,
    Most(usize),
}

fn levels(text: &str) -> Result<LevelChoice, String> {
    let number = || text.parse().map_err(|_| "expected a number such as 4, or auto".to_owned());
    if text == "auto" { Ok(LevelChoice::Auto) } else { number().map(LevelChoice::Most) }
}

/// Fits the model, writes it, and reports the kind of material it suits.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let mut outputs = Outputs::new(context);
    for path in std::iter::once(&args.output).chain(&args.curve) {
        outputs.file(path, &[&args.texture])?;
    }
    let request = request(args)?;
    let (field, heights) = texture(&args.texture, context)?;
    rlm::check_kind(field.basis(), field.layout()).map_err(|e| e.at(&args.texture))?;
    let kind = character(&field, &context.job)?;
    let fitted = request.fit(&field, &kind, &context.job).map_err(|e| e.at(&args.texture))?;
    let FittedModel { mut model, levels, structure, likeness } = fitted;
    model.heights = heights;
    let bytes = rlm::encode(&model)?;
    outputs.write(&args.output, bytes)?;
    if let Some(path) = &args.curve {
        outputs.write(path, curves::svg(&levels.concat()).into_bytes())?;
    }
    let written = outputs.commit()?;
    let mut report = describe(&model)?;
    let _ = write!(report.text, "\n{}", advice(&kind, &levels, structure));
    if let Some(likeness) = &likeness {
        let _ = write!(report.text, "\n{likeness}");
    }
    report.json["likeness"] = json!(likeness);
    report.json["character"] = json!(kind);
    report.json["estimation"] = if let [joint] = &levels[..] { json!(joint) } else { json!(levels) };
    let warning = likeness.filter(|likeness| !likeness.alike).map(|likeness| unlike(&likeness, args));
    Ok(report.with_outputs(written).with_warnings(warning))
}

/// The checked request.
fn request(args: &Args) -> Result<ModelRequest> {
    let options = ModelOptions {
        levels: match args.levels {
            LevelChoice::Auto => ModelOptions::default().levels,
            LevelChoice::Most(levels) => levels,
        },
        fewer: args.levels == LevelChoice::Auto,
        factor: args.factor,
        candidates: args.candidates,
        coarse: args.coarse,
        most: args.most,
        search: args.search,
        marginals: !args.normal,
        ..ModelOptions::default()
    };
    options.validate()?;
    let combine::CombineArgs { combine, structure_bytes, tiles, period } = args.combine;
    Ok(ModelRequest { options, combine, structure_bytes, tiles, period, lights: args.lights.chosen()? })
}

/// The input: a field, or heights in texels where the file records them.
fn texture(path: &Path, context: &Context) -> Result<(ReflectanceField, Option<Heights>)> {
    let opened = input::open(path, &context.job)?;
    if opened.content() != Content::Heights {
        return Ok((opened.into_field()?.field, None));
    }
    let map = opened.into_height()?;
    let mm_per_texel = map.scale.and_then(|scale| scale.mm_per_texel);
    let picture = Picture { planes: input::texels(&map), space: Space::Linear };
    Ok((ReflectanceField::from_picture(picture), Some(Heights { mm_per_texel })))
}

/// Expectations of the model, in words.
fn advice(kind: &Character, models: &[Vec<LevelReport>], structure: Option<StructureSource>) -> String {
    let mut text = String::new();
    for (number, levels) in models.iter().enumerate() {
        let light = if models.len() > 1 { format!("light {}, ", number + 1) } else { String::new() };
        let least = ModelOptions::default().prior;
        for (k, level) in levels.iter().enumerate().filter(|(_, level)| level.prior > least) {
            let _ = writeln!(
                text,
                "{light}level {k}: weights shrunk until stable, by a prior worth {} of its {} texels",
                level.prior,
                level.width * level.height
            );
        }
    }
    let structure = structure.map(|how| format!("structure: {how}\n"));
    text + &structure.unwrap_or_default() + &kind.to_string()
}

/// What to do about a model whose textures do not look like the material.
fn unlike(likeness: &Likeness, args: &Args) -> String {
    let more = match args.combine.combine {
        Combine::Always => "give --structure-bytes more bytes",
        _ => "give it more bytes with --combine always",
    };
    format!(
        "this model does not look like the material: its textures are {:.1} times as far from it as may pass; {more}, or \
         copy the texture instead (relume synth {} --method auto)",
        likeness.excess,
        args.texture.display()
    )
}
