//! `relume match`: gives one texture the exact distribution of another, reversibly.

use std::path::PathBuf;

use relume::format::{ExrDepth, FieldFormat, encode_field};
use relume::random_field::histogram::{Distribution, Ranks};
use relume::workflow::memory::MemoryPeak;
use relume::{Error, Footprint, Planes, ReflectanceField, Result};
use serde_json::json;

use crate::context::Context;
use crate::output::Outputs;
use crate::report::Report;
use crate::{input, output};

/// Arguments of `relume match`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  relume match made.png --to bark.png -o matched.png --ranks ranks.exr\n  \
                        relume match ranks.exr --to made.png -o made_again.png"
)]
pub struct Args {
    /// The texture whose values are replaced: a .ptm, an .exr field, or a picture; - is standard input
    file: PathBuf,
    /// The texture with the wanted distribution: each value is replaced by its sample of the same rank in
    /// each plane
    #[arg(long, value_name = "FILE")]
    to: PathBuf,
    /// The texture to write, in the bit depth of the one with the wanted distribution
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Also write the ranks, from 0, ties ordered by position: matching them to the first texture restores it
    #[arg(long, value_name = "FILE.exr")]
    ranks: Option<PathBuf>,
}

/// Floats represent integers exactly up to this.
const MOST_RANKS: usize = 1 << 24;

/// Matches and writes.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    args.ranks.iter().try_for_each(|path| output::expect(path, "ranks as an EXR file", &["exr"]))?;
    let mut outputs = Outputs::new(context);
    for path in std::iter::once(&args.output).chain(&args.ranks) {
        outputs.file(path, &[&args.file, &args.to])?;
    }
    let format = match output::is_stream(&args.output) {
        true => FieldFormat::Exr(ExrDepth::Float),
        false => FieldFormat::from_path(&args.output)?,
    };
    let file = input::field(&args.file, &context.job)?;
    let to = input::field(&args.to, &context.job)?;
    let texels = file.field.size().texels();
    if args.ranks.is_some() && texels > MOST_RANKS {
        return Err(Error::usage(format!("--ranks holds at most {MOST_RANKS} ranks, found {texels} texels")));
    }
    foresee(&file.field, format, args.ranks.is_some(), context)?;
    let (matched, ranks) = matched(&file.field, &to.field).map_err(|e| e.at(&args.file))?;
    let format = if output::is_stream(&args.output) { format } else { format.in_depth_of(&to.encoding) };
    let bytes = encode_field(&matched, format, Some(&to.encoding), &context.job);
    outputs.write(&args.output, bytes.map_err(|e| e.at(&args.output))?)?;
    if let Some(path) = &args.ranks {
        let format = FieldFormat::Exr(ExrDepth::Float);
        let bytes = encode_field(&ranks, format, None, &context.job).map_err(|e| e.at(path))?;
        outputs.write(path, bytes)?;
    }
    let written = outputs.commit()?;
    let text = format!(
        "{}: {} texels with the values of {}",
        args.output.display(),
        matched.size(),
        args.to.display()
    );
    let json = json!({ "width": matched.size().width, "height": matched.size().height });
    Ok(Report::new(text, json).with_outputs(written))
}

/// Refuses textures that cannot be matched and written within the memory.
fn foresee(field: &ReflectanceField, format: FieldFormat, ranks: bool, context: &Context) -> Result<()> {
    let (size, planes) = (field.size(), field.coefficients().count());
    // Both results, and of one plane its ranks, sorted values, and numbers.
    let both = 8 * planes as u64;
    let matched = Footprint::of_texels(size, both + 28, both);
    let mut stages = vec![matched, format.footprint(size, planes)];
    if ranks {
        stages.push(FieldFormat::Exr(ExrDepth::Float).footprint(size, planes));
    }
    MemoryPeak::of_stages("the matched texture and its file", stages).check(&context.job)
}

/// The field with the values of the other, plane by plane, and its ranks.
fn matched(field: &ReflectanceField, to: &ReflectanceField) -> Result<(ReflectanceField, ReflectanceField)> {
    // Values may be of the other space: only their order counts.
    if (field.basis(), field.layout()) != (to.basis(), to.layout()) {
        to.check_kind(field, "the texture that gives the values")?;
    }
    let length = field.coefficients().as_slice().len();
    let (mut values, mut order) = (Vec::with_capacity(length), Vec::with_capacity(length));
    let numbers: Vec<f32> = (0..field.size().texels()).map(|rank| rank as f32).collect();
    let numbers = Distribution::of(&numbers)?;
    for (plane, source) in field.coefficients().iter().zip(to.coefficients().iter()) {
        let ranks = Ranks::of(plane);
        values.extend(ranks.filled(&Distribution::of(source)?));
        order.extend(ranks.filled(&numbers));
    }
    let count = field.coefficients().count();
    let made = |data: Vec<f32>| {
        let planes = Planes::from_vec(field.size(), count, data)?;
        ReflectanceField::new(to.basis().clone(), to.layout().clone(), to.space(), planes)
    };
    Ok((made(values)?, made(order)?))
}
