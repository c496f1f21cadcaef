//! `relume model`: a texture as a random field of a few kilobytes; [`combine`]: with structure from tiles;
//! [`lights`]: one model per light; [`clusters`]: one for each cluster of photographs; [`describe`](mod@describe): the contents of a model.

mod clusters;
mod combine;
mod describe;
mod lights;

use std::fmt::Write;
use std::path::{Path, PathBuf};

use relume::field::Basis;
use relume::fit::learned::{self, LearnedOptions, Rank};
use relume::format::{Content, rlm};
use relume::random_field::{
    Character, FieldModel, Heights, LevelReport, ModelOptions, SelectionOrder, character, curves,
};
use relume::workflow::likeness::{LEAST_SIDE, Likeness, SURE_SIDE};
use relume::workflow::model::{Combine, FittedModel, ModelRequest, StructureSource};
use relume::workflow::{Btf, Missing};
use relume::{Error, Picture, RasterSequence, ReflectanceField, Result, Space};
use serde_json::json;

pub use describe::describe;

use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;
use crate::{args, input, output, paths};

/// Arguments of `relume model`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume model bark.png -o bark.rlm\n  \
                        relume synth bark.rlm -o large.png --size 4096\n  \
                        relume synth bark.rlm -o part.png --window 10000,-300,512,512\n  \
                        relume model wool.zip -o wool.rlm")]
pub struct Args {
    /// A .ptm, an .exr field, or a picture; or a texture of light and view (folder, .zip, .btf), whose functions are learned
    /// first; - is standard input
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
    /// The most learned functions of a texture of light and view [default: 12]
    #[arg(long, value_name = "N")]
    functions: Option<usize>,
    /// The most bytes of these functions in the model [default: 49152]
    #[arg(long, value_name = "N")]
    function_bytes: Option<usize>,
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
    output::expect(&args.output, "a model", &["rlm"])?;
    args.curve.iter().try_for_each(|path| output::expect(path, "a drawing", &["svg"]))?;
    let mut outputs = Outputs::new(context);
    for path in std::iter::once(&args.output).chain(&args.curve) {
        outputs.file(path, &[&args.texture])?;
    }
    if args.lights.are_clusters() {
        return clusters::run(args, outputs, context);
    }
    let request = request(args)?;
    let ModelledTexture { field, heights, has_photographs } = match Btf::is_at(&args.texture) {
        true => {
            let field = learned_functions(args, &request, context)?;
            ModelledTexture { field, heights: None, has_photographs: true }
        }
        false => texture(&args.texture, context)?,
    };
    args.check(&field)?;
    rlm::check_kind(field.basis(), field.layout()).map_err(|e| e.at(&args.texture))?;
    let kind = character(&field, &context.job)?;
    let fitted = request.fit(&field, &kind, &context.job).map_err(|e| e.at(&args.texture))?;
    let FittedModel { mut model, levels, structure, likeness } = fitted;
    model.heights = heights;
    if !has_photographs {
        // Unknown: the ratio is to the coefficients.
        model.source.photographs = 0;
    }
    let bytes = rlm::encode(&model)?;
    let large = larger(&model, bytes.len());
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
    let shorter = field.size().width.min(field.size().height);
    if let Some(doubt) = doubt_of_size(shorter, likeness.is_some()) {
        let _ = write!(report.text, "\n{doubt}");
    }
    report.json["likeness"] = json!(likeness);
    report.json["character"] = json!(kind);
    report.json["estimation"] = if let [joint] = &levels[..] { json!(joint) } else { json!(levels) };
    let warnings = likeness.iter().flat_map(|likeness| {
        let changing = likeness.changes().then(|| changing(likeness, args));
        changing.into_iter().chain((!likeness.alike).then(|| unlike(likeness, structure.is_some(), args)))
    });
    Ok(report.with_outputs(written).with_warnings(warnings).with_warnings(large))
}

/// What is to be said of a judgement of a texture of that shorter side.
fn doubt_of_size(shorter: usize, is_judged: bool) -> Option<String> {
    match (is_judged, shorter) {
        (false, side) if side < LEAST_SIDE => Some(format!(
            "the texture is too small to judge whether the model looks like it: {LEAST_SIDE} texels along each side are needed"
        )),
        (true, side) if side < SURE_SIDE => Some(format!(
            "the halves of so small a texture differ much, so that much passes: look at a made one as well ({SURE_SIDE} texels along \
             each side would do)"
        )),
        _ => None,
    }
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
    let lights = args.lights.chosen()?;
    let defaults = ModelRequest::default();
    let functions = args.functions.unwrap_or(defaults.functions);
    let function_bytes = args.function_bytes.unwrap_or(defaults.function_bytes);
    Ok(ModelRequest { options, combine, structure_bytes, tiles, period, lights, functions, function_bytes })
}

impl Args {
    /// Refuses options without a part in the model.
    fn check(&self, field: &ReflectanceField) -> Result<()> {
        let given =
            [("--functions", self.functions.is_some()), ("--function-bytes", self.function_bytes.is_some())];
        match given.into_iter().find(|(_, given)| *given) {
            Some((name, _)) if !matches!(field.basis(), Basis::Learned(_)) => Err(Error::usage(format!(
                "{name} is of learned functions, and this is a texture of the basis {}",
                field.basis().name()
            ))
            .at(&self.texture)),
            _ => Ok(()),
        }
    }
}

/// The functions learned from the photographs of a texture of light and view, as many as the model is to have.
fn learned_functions(args: &Args, request: &ModelRequest, context: &Context) -> Result<ReflectanceField> {
    let btf = Btf::open(&args.texture, Missing::Refuse, &context.job)?;
    btf.list().check_grid("a model").map_err(|e| e.at(&args.texture))?;
    let load = |i: usize| btf.photograph(i, &context.job);
    let photographs = RasterSequence::open(&load)?;
    let pairs = btf.pairs();
    let shape = (photographs.size(), photographs.channels());
    let functions = request.functions.min(learned::most_functions(&pairs, None, shape)?);
    request
        .foresee(photographs.size(), functions, functions, &context.job)
        .map_err(|e| e.at(&args.texture))?;
    let options = LearnedOptions { rank: Rank::Functions(functions), ..LearnedOptions::default() };
    let load = |i: usize| photographs.read(i);
    let fit = learned::fit(&pairs, &load, &options, &context.job).map_err(|e| e.at(&args.texture))?;
    Ok(fit.field)
}

/// The input: a field, or heights in texels where the file records them.
fn texture(path: &Path, context: &Context) -> Result<ModelledTexture> {
    let opened = input::open(path, &context.job)?;
    if opened.content() != Content::Heights {
        let file = opened.into_field()?;
        return Ok(ModelledTexture {
            has_photographs: file.models.is_none(),
            field: file.field,
            heights: None,
        });
    }
    let map = opened.into_height()?;
    let mm_per_texel = map.scale.and_then(|scale| scale.mm_per_texel);
    let picture = Picture { planes: input::texels(&map), space: Space::Linear };
    let field = ReflectanceField::from_picture(picture);
    Ok(ModelledTexture { field, heights: Some(Heights { mm_per_texel }), has_photographs: true })
}

/// What is modelled.
struct ModelledTexture {
    field: ReflectanceField,
    heights: Option<Heights>,
    /// Whether the directions of its functions are those of photographs; those of the linear form of reflectance models are not.
    has_photographs: bool,
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
fn unlike(likeness: &Likeness, has_structure: bool, args: &Args) -> String {
    let more = match has_structure || args.combine.combine == Combine::Always {
        true => "try more --structure-bytes, which need not help",
        false => "try a structure with --combine always",
    };
    let copy = match Btf::is_at(&args.texture) {
        true => format!("{}, then relume synth FILE.exr --method auto", fitted_first(args)),
        false => format!("relume synth {} --method auto", args.texture.display()),
    };
    format!(
        "this model does not look like the material: its textures are {:.1} times as far from it as may pass; {more}, or \
         copy the texture instead ({copy})",
        likeness.excess
    )
}

/// What to do about a material that changes across the sample.
fn changing(likeness: &Likeness, args: &Args) -> String {
    let stretch = match Btf::is_at(&args.texture) {
        true => format!("{}, then relume synth FILE.exr --follow-trend,", fitted_first(args)),
        false => format!("relume synth {} --follow-trend", args.texture.display()),
    };
    format!(
        "the material changes from side to side of the sample ({:.0} % of the variance is a slow change), and a model is \
         the same everywhere or repeats the sample: {stretch} stretches the change",
        100.0 * likeness.trend
    )
}

/// The command that makes a texture of photographs under light and view, which other verbs take.
fn fitted_first(args: &Args) -> String {
    format!("relume fit {} -o FILE.exr", paths::shell_word(&args.texture))
}

/// What is to be said of a model that is no smaller than what it was made of.
fn larger(model: &FieldModel, bytes: usize) -> Option<String> {
    let source = model.source_bytes();
    let advice = match model.basis {
        Basis::Learned(_) => "; fewer --function-bytes or --functions make it smaller",
        _ => "",
    };
    (bytes as u64 >= source).then(|| {
        format!("the model has {bytes} bytes, and what it was made of {source}: it saves nothing but an endless plane{advice}")
    })
}
