//! `relume model`: a texture as a random field in a few kilobytes; [`combine`]: with structure from tiles.

mod combine;

use std::fmt::Write;
use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::format::rlm;
use relume::random_field::level::Level;
use relume::random_field::{
    Character, FieldModel, LevelReport, ModelOptions, Search, Source, Structure, character, curves,
    model_field,
};
use relume::{Error, ReflectanceField, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::report::Report;
use crate::{input, output};

/// Arguments of `relume model`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume model bark.png -o bark.rlm\n  \
                        relume synth bark.rlm -o large.png --size 4096 --window 10000,-300")]
pub struct Args {
    /// A .ptm, an .exr field, or a picture; - is standard input
    texture: PathBuf,
    /// The model to write; - writes it to standard output
    #[arg(short, long, value_name = "FILE.rlm")]
    output: PathBuf,
    /// Levels of the pyramid at most
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().levels)]
    levels: usize,
    /// By how much each level is coarser than the one before
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().factor)]
    factor: usize,
    /// The nearest so many causal neighbours may be chosen
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().candidates)]
    candidates: usize,
    /// The nearest so many neighbours in the coarser level may be chosen; 0 leaves levels independent
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().coarse)]
    coarse: usize,
    /// Neighbours that a level may have
    #[arg(long, value_name = "N", default_value_t = ModelOptions::default().most)]
    most: usize,
    /// How neighbours are chosen: those nearest, or freely by adding or by taking away
    #[arg(long, default_value = "forward", value_parser = search())]
    search: Search,
    /// Take values to be normally distributed instead of keeping their distribution
    #[arg(long)]
    normal: bool,
    #[command(flatten)]
    combine: combine::CombineArgs,
    /// Also draw the log evidence of the neighbourhoods met, a panel a level
    #[arg(long, value_name = "FILE.svg")]
    curve: Option<PathBuf>,
}

fn search() -> impl TypedValueParser<Value = Search> {
    PossibleValuesParser::new(["nested", "forward", "backward"]).map(|name| match name.as_str() {
        "nested" => Search::Nested,
        "backward" => Search::Backward,
        _ => Search::Forward,
    })
}

/// Fits the model, writes it, and says what kind of material it is for.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    for path in std::iter::once(&args.output).chain(&args.curve) {
        output::check(path, &[&args.texture], context)?;
    }
    if args.curve.as_ref() == Some(&args.output) {
        return Err(Error::usage("is named for two outputs of this command: choose another").at(&args.output));
    }
    let options = ModelOptions {
        levels: args.levels,
        factor: args.factor,
        candidates: args.candidates,
        coarse: args.coarse,
        most: args.most,
        search: args.search,
        marginals: !args.normal,
        ..ModelOptions::default()
    };
    options.validate()?;
    let file = input::field(&args.texture, &context.limits)?;
    let kind = character(&file.field, &context.limits)?;
    let made = fit(args, &file.field, &kind, &options, context).map_err(|e| e.at(&args.texture))?;
    let Made { model, levels, structure } = made;
    let bytes = rlm::encode(&model)?;
    output::write(&args.output, &bytes, context)?;
    if let Some(path) = &args.curve {
        output::write(path, curves::svg(&levels).as_bytes(), context)?;
    }
    let mut report = describe(&model)?;
    let _ = write!(report.text, "\n{}", advice(&kind, &levels, structure.as_deref()));
    report.json["character"] = json!(kind);
    report.json["estimation"] = json!(levels);
    report.json["output"] = json!(args.output);
    Ok(report.with_stdout_taken(output::is_stream(&args.output)))
}

/// A model and how it came about.
struct Made {
    model: FieldModel,
    levels: Vec<LevelReport>,
    /// Where the structure comes from.
    structure: Option<String>,
}

fn fit(
    args: &Args,
    field: &ReflectanceField,
    kind: &Character,
    options: &ModelOptions,
    context: &Context,
) -> Result<Made> {
    if args.combine.applies(kind, field.size()) {
        let (model, levels, how) = args.combine.model(field, options, context)?;
        return Ok(Made { model, levels, structure: Some(how) });
    }
    let (model, levels) = model_field(field, options, &context.limits, &context.progress)?;
    Ok(Made { model, levels, structure: None })
}

/// What a model holds, for `relume info` as well.
pub fn describe(field: &FieldModel) -> Result<Report> {
    let bytes = rlm::encode(field)?.len() as u64;
    let model = &field.model;
    let mut text = format!(
        "random field, basis {}, colour {}, {} values: {} planes of {} components, {} levels of factor {}\n\
         {bytes} bytes; {} are {} bytes: 1 to {:.0}",
        field.basis.name(),
        field.color.name(),
        field.space,
        model.planes(),
        model.mixing.components(),
        model.levels.len(),
        model.kernel.factor(),
        base(&field.source),
        field.source_bytes(),
        field.source_bytes() as f64 / bytes as f64,
    );
    if let Some(structure) = &model.structure {
        let _ = write!(
            text,
            "\n  structure: {} of {} texels, {} bytes",
            match structure.tiles {
                1 => "one tile".to_owned(),
                tiles => format!("{tiles} tiles"),
            },
            structure.tile,
            rlm::structure_bytes(structure)
        );
    }
    for (k, level) in model.levels.iter().enumerate() {
        let _ = write!(
            text,
            "\n  level {k}: {} neighbours, {} in the coarser level, margin {}, log evidence {:.0} over {} texels",
            level.neighbours.len(),
            level.coarse.len(),
            level.burn_in,
            level.log_evidence,
            level.texels
        );
    }
    let levels: Vec<Value> = model.levels.iter().map(level_value).collect();
    let json = json!({
        "basis": field.basis.name(),
        "color": field.color.name(),
        "space": field.space,
        "planes": model.planes(),
        "components": model.mixing.components(),
        "factor": model.kernel.factor(),
        "bytes": bytes,
        "source": field.source,
        "source_bytes": field.source_bytes(),
        "ratio": field.source_bytes() as f64 / bytes as f64,
        "structure": model.structure.as_ref().map(structure_value),
        "levels": levels,
    });
    Ok(Report::new(text, json))
}

/// What the model was made of: the base of its ratio.
fn base(source: &Source) -> String {
    let Source { width, height, photographs, channels } = source;
    match photographs {
        0 => format!("the coefficients of the {width} x {height} texels it is made of, a byte each,"),
        1 => format!("the samples of the picture of {width} x {height} texels it is made of"),
        _ => format!(
            "the samples of the {photographs} photographs of {width} x {height} texels and {channels} channels it is \
             made of"
        ),
    }
}

fn structure_value(structure: &Structure) -> Value {
    json!({
        "tiles": structure.tiles,
        "tile_width": structure.tile.width,
        "tile_height": structure.tile.height,
        "bytes": rlm::structure_bytes(structure),
    })
}

fn level_value(level: &Level) -> Value {
    let places = |offsets: &[relume::random_field::neighbourhood::Offset]| -> Vec<[i32; 2]> {
        offsets.iter().map(|o| [o.dx, o.dy]).collect()
    };
    json!({
        "neighbours": places(&level.neighbours),
        "coarse": places(&level.coarse),
        "margin": level.burn_in,
        "log_evidence": level.log_evidence,
        "texels": level.texels,
    })
}

/// What to expect of the model.
fn advice(kind: &Character, levels: &[LevelReport], structure: Option<&str>) -> String {
    let unstable = levels.iter().enumerate().filter(|(_, level)| level.unstable > 0).map(|(k, level)| {
        format!(
            "level {k}: {} more probable models were unstable or remembered too long; the best stable one is taken\n",
            level.unstable
        )
    });
    let structure = structure.map(|how| format!("structure: {how}\n"));
    unstable.collect::<String>() + &structure.unwrap_or_default() + &kind.to_string()
}
