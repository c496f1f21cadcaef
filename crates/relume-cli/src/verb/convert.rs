//! `relume convert`: a texture in another format, in other functions, space or colours, and what that loses.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::{Basis, PlaneLayout};
use relume::format::web::{WebLayout, WebOptions, encode_web};
use relume::format::{
    Encoding, ExrDepth, FieldFile, FieldFormat, decode_field, encode_field, encode_npy, encode_npz,
    read_field,
};
use relume::workflow::convert::{ConvertOptions, RefitLoss, convert, refit_loss};
use relume::{Error, ReflectanceField, Result, Space};
use serde_json::json;

use crate::context::Context;
use crate::output::{Folder, Outputs};
use crate::report::Report;
use crate::{args, input};

/// Arguments of `relume convert`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume convert coin.ptm -o coin.rti\n  \
                        relume convert coin.exr -o web --web deepzoom\n  \
                        relume convert coin.rti -o coin.ptm --jpeg 95")]
pub struct Args {
    /// A .ptm, .rti, .hsh, an .exr field, a web folder (info.json or info.xml), or a picture; - is standard input
    file: PathBuf,
    /// The file to write (.ptm, .rti, .hsh, .exr, .npz, .npy, or a picture of constants), or with --web a folder
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// The functions [default: those of the texture where the format holds them, else ptm for .ptm and hsh9 for .rti,
    /// .hsh and --web]
    #[arg(long, value_name = "NAME", value_parser = basis_parser())]
    basis: Option<Basis>,
    /// Linear or sRGB-encoded values [default: as they are where the format holds them, else encoded]
    #[arg(long, value_parser = args::named::<Space>())]
    space: Option<Space>,
    /// The arrangement of colours: a function for each channel, or one times a colour [default: as it is]
    #[arg(long, value_parser = args::color())]
    color: Option<PlaneLayout>,
    /// Write a web folder of this layout, as OpenLIME shows them; multires: as the older web RTI viewer does (info.xml)
    #[arg(long, value_name = "LAYOUT", num_args = 0..=1, default_missing_value = "plain",
          value_parser = args::named::<WebLayout>())]
    web: Option<WebLayout>,
    /// Compress the planes of a .ptm as JPEG of this quality, 1 to 100; also of the pictures of --web [default: 95]
    #[arg(long, value_name = "QUALITY", value_parser = clap::value_parser!(u8).range(1..=100))]
    jpeg: Option<u8>,
    /// 16-bit floats in .exr
    #[arg(long)]
    half: bool,
}

fn basis_parser() -> impl TypedValueParser<Value = Basis> {
    let names = PossibleValuesParser::new(Basis::NAMED.iter().map(Basis::name));
    names.map(|name| Basis::from_name(&name).expect("one of the names"))
}

/// The kind of file that is written.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Target {
    File(FieldFormat),
    Npz,
    Npy,
    Web(WebOptions),
}

impl Target {
    fn of(args: &Args) -> Result<Self> {
        if let Some(layout) = args.web {
            if FieldFormat::from_path(&args.output).is_ok() {
                return Err(Error::usage("is the name of a file, and --web writes a folder: name a folder")
                    .at(&args.output));
            }
            let quality = args.jpeg.unwrap_or(WebOptions::default().quality);
            return Ok(Self::Web(WebOptions { layout, quality }));
        }
        let extension = args.output.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let target = match extension.as_deref() {
            Some("npz") => Self::Npz,
            Some("npy") => Self::Npy,
            None => {
                return Err(Error::usage(
                    "has no extension: name a file such as x.ptm or x.exr, or give --web for a folder",
                )
                .at(&args.output));
            }
            _ => Self::File(match (FieldFormat::from_path(&args.output)?, args.jpeg, args.half) {
                (FieldFormat::Ptm, Some(quality), _) => FieldFormat::PtmJpeg { quality },
                (FieldFormat::Exr(_), _, true) => FieldFormat::Exr(ExrDepth::Half),
                (format, ..) => format,
            }),
        };
        if args.jpeg.is_some() && !matches!(target, Self::File(FieldFormat::PtmJpeg { .. })) {
            return Err(Error::usage("--jpeg is for .ptm files and --web"));
        }
        if args.half && target != Self::File(FieldFormat::Exr(ExrDepth::Half)) {
            return Err(Error::usage("--half is for .exr files"));
        }
        Ok(target)
    }

    /// The functions that the target needs, given those of the texture.
    fn basis(self, from: &Basis) -> Option<Basis> {
        let harmonics = || Basis::from_name("hsh9");
        match self {
            Self::File(format) if format.check_basis(from.name()).is_ok() => None,
            Self::File(FieldFormat::Ptm | FieldFormat::PtmJpeg { .. }) => Some(Basis::Ptm),
            Self::File(FieldFormat::Rti | FieldFormat::Hsh) => harmonics(),
            Self::Web(options) if !options.layout.shows(from.name()) => harmonics(),
            _ => None,
        }
    }

    fn space(self) -> Option<Space> {
        match self {
            Self::File(format) if format.is_encoded() => Some(Space::Srgb),
            Self::Web(_) => Some(Space::Srgb),
            _ => None,
        }
    }
}

/// Reads, converts, writes, and measures what the file written holds.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let target = Target::of(args)?;
    let mut outputs = Outputs::new(context);
    let folder = match target {
        Target::Web(_) => Some(Folder::stage(&args.output, &[&args.file], context)?),
        _ => {
            outputs.file(&args.output, &[&args.file])?;
            None
        }
    };
    let file = input::field(&args.file, &context.job)?;
    let options = ConvertOptions {
        basis: args.basis.clone().or_else(|| target.basis(file.field.basis())),
        space: args.space.or(target.space()),
        layout: args.color.clone(),
    };
    let made = convert(&file.field, &options, &context.job)?;
    let is_same = matches!(made, Cow::Borrowed(_));
    let loss_of = |made: &ReflectanceField| refit_loss(&file.field, made, &context.job);
    let (loss, written) = match (target, folder) {
        (Target::Web(options), Some(folder)) => {
            let mut store = |name: &str, bytes: &[u8]| folder.add(name, bytes);
            encode_web(&made, &options, &context.job, &mut store).map_err(|e| e.at(&args.output))?;
            let written = folder.commit()?;
            (Some(loss_of(&read_field(&args.output, &context.job)?.field)?), written)
        }
        _ => {
            let bytes = encoded(&made, target, is_same, &file, context).map_err(|e| e.at(&args.output))?;
            let loss = match target {
                Target::File(format) if !format.is_exact() => {
                    Some(loss_of(&decode_field(&bytes, &context.job)?.field)?)
                }
                _ if is_same => None,
                _ => Some(loss_of(&made)?),
            };
            outputs.write(&args.output, bytes)?;
            (loss, outputs.commit()?)
        }
    };
    let loss = loss.filter(|loss| !is_same || loss.largest > 0.0);
    Ok(report(&args.output, &file.field, &made, loss).with_outputs(written))
}

/// The bytes of a file; values that are copies are stored as they were.
fn encoded(
    made: &ReflectanceField,
    target: Target,
    is_same: bool,
    file: &FieldFile,
    context: &Context,
) -> Result<Vec<u8>> {
    let stored: Option<&Encoding> = is_same.then_some(&file.encoding);
    match target {
        Target::File(format) => {
            let keeps_depth = is_same && format != FieldFormat::Exr(ExrDepth::Half);
            let format = if keeps_depth { format.in_depth_of(&file.encoding) } else { format };
            encode_field(made, format, stored, &context.job)
        }
        Target::Npz => encode_npz(made, &context.job),
        Target::Npy | Target::Web(_) => encode_npy(made, &context.job),
    }
}

fn report(
    output: &Path,
    from: &ReflectanceField,
    made: &ReflectanceField,
    loss: Option<RefitLoss>,
) -> Report {
    let described = |field: &ReflectanceField| {
        format!("{} {}, {}", field.layout().name(), field.basis().name(), field.space())
    };
    let lost = match loss {
        None => "the same functions".to_owned(),
        Some(loss) => format!(
            "from {}; relit values change by {:.4} of white (root mean square) and {:.3} at most",
            described(from),
            loss.rms,
            loss.largest
        ),
    };
    let text = format!("{}: {}, {}; {lost}", output.display(), made.size(), described(made));
    let json = json!({
        "width": made.size().width,
        "height": made.size().height,
        "basis": made.basis(),
        "color": made.layout(),
        "space": made.space(),
        "from": { "basis": from.basis(), "color": from.layout(), "space": from.space() },
        "loss": loss,
    });
    Report::new(text, json)
}
