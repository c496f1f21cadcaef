//! `relume convert`: a texture in another format, in other functions, space or colours, and what that loses.

mod nonlinear;
mod recorded;

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::field::{Basis, ClusterSpaces, NonlinearField, PlaneLayout};
use relume::format::web::{WebLayout, WebOptions, encode_web};
use relume::format::{
    Encoding, ExrDepth, FieldFile, FieldFormat, decode_field, encode_field, encode_npy, encode_npz,
    read_field,
};
use relume::workflow::convert::{ConvertOptions, RefitLoss, convert, refit_loss};
use relume::{Error, Footprint, ReflectanceField, Result, Space};
use serde_json::{Value, json};

use recorded::RecordedMap;

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
        if target == Self::File(FieldFormat::Hsh)
            && args.color.as_ref().is_some_and(|color| *color != PlaneLayout::RGB)
        {
            return Err(Error::usage(
                "a .hsh file has functions for each channel: give --color rgb, or name a .rti file",
            ));
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

    /// The functions of the light that the target needs, given a texture of none; any for files of arrays and EXR.
    fn default_basis(self) -> Option<Basis> {
        match self {
            Self::File(FieldFormat::Ptm | FieldFormat::PtmJpeg { .. }) => Some(Basis::Ptm),
            Self::File(FieldFormat::Rti | FieldFormat::Hsh) | Self::Web(_) => Basis::from_name("hsh9"),
            Self::File(FieldFormat::Exr(_) | FieldFormat::Picture(_)) | Self::Npz | Self::Npy => None,
        }
    }

    /// The arrangement of colours that the target needs, given that of the texture.
    fn layout(self, from: Option<&PlaneLayout>) -> Option<PlaneLayout> {
        let needs_channels = self == Self::File(FieldFormat::Hsh);
        from.filter(|layout| needs_channels && layout.is_product()).map(|_| PlaneLayout::RGB)
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
    let opened = input::open(&args.file, &context.job)?;
    let place = ConvertedPlace { args, target, outputs, folder, context };
    match opened.nonlinear()? {
        Some((own, depth)) if place.keeps_form() => nonlinear::keep(&own, depth, place),
        Some((NonlinearField::Models(models), _)) => nonlinear::convert(&models, place),
        Some((NonlinearField::Clusters(clusters), _)) => {
            let clusters = clusters.spaces().clone();
            of_field(opened.into_field()?, Some(&clusters), place)
        }
        None => match RecordedMap::of(&opened, args)? {
            Some(map) => map.copied(place),
            None => of_field(opened.into_field()?, None, place),
        },
    }
}

/// Where a texture goes.
struct ConvertedPlace<'a> {
    args: &'a Args,
    target: Target,
    outputs: Outputs,
    folder: Option<Folder>,
    context: &'a Context,
}

impl ConvertedPlace<'_> {
    /// Whether a form that only EXR files hold stays as it is.
    fn keeps_form(&self) -> bool {
        let same = self.args.basis.is_none() && self.args.space.is_none() && self.args.color.is_none();
        same && matches!(self.target, Target::File(FieldFormat::Exr(_)))
    }

    /// What is asked for of a texture of functions; `None` of those that no format but EXR holds.
    fn options(&self, from: Option<&ReflectanceField>) -> ConvertOptions {
        let needed = || match from {
            Some(from) => self.target.basis(from.basis()),
            None => self.target.default_basis(),
        };
        ConvertOptions {
            basis: self.args.basis.clone().or_else(needed),
            space: self.args.space.or(self.target.space()),
            layout: self
                .args
                .color
                .clone()
                .or_else(|| self.target.layout(from.map(ReflectanceField::layout))),
        }
    }

    /// Refuses, before the work, a texture that could not be held and written within the memory.
    fn foresee(&self, from: &ReflectanceField, options: &ConvertOptions) -> Result<()> {
        let Target::File(format) = self.target else { return Ok(()) };
        let basis = options.basis.as_ref().unwrap_or(from.basis());
        // A product of encoded values is none of linear ones.
        let is_recoded = options.space.is_some_and(|space| space != from.space());
        let layout = match options.layout.as_ref().unwrap_or(from.layout()) {
            layout if layout.is_product() && is_recoded => &PlaneLayout::RGB,
            layout => layout,
        };
        let planes = layout.planes(basis.len());
        let made = Footprint::of_texels(from.size(), 4 * planes as u64, 4 * planes as u64);
        let peak = made.then(format.footprint(from.size(), planes)).peak;
        self.context.job.check_bytes("the texture and its file", peak).map_err(|e| e.at(&self.args.file))
    }

    /// Writes a texture of functions, and measures by `loss` what the file or folder holds.
    fn write(
        self,
        made: &ReflectanceField,
        copied: Option<&FieldFile>,
        loss: impl Fn(&ReflectanceField) -> Result<RefitLoss>,
    ) -> Result<(Option<RefitLoss>, Vec<PathBuf>)> {
        let (job, output) = (&self.context.job, &self.args.output);
        if let (Target::Web(options), Some(folder)) = (self.target, self.folder) {
            let mut store = |name: &str, bytes: &[u8]| folder.add(name, bytes);
            encode_web(made, &options, job, &mut store).map_err(|e| e.at(output))?;
            // Read before it is in its place: what does not fit the memory leaves nothing.
            let loss = loss(
                &read_field(folder.path(), job)
                    .map_err(|e| Error::new(e.kind(), e.message()).at(output))?
                    .field,
            )?;
            return Ok((Some(loss), folder.commit()?));
        }
        let bytes = encoded(made, self.target, copied, self.context).map_err(|e| e.at(output))?;
        let _file = job.hold("the new file", bytes.len() as u64).map_err(|e| e.at(output))?;
        let loss = match self.target {
            Target::File(format) if !format.is_exact() => Some(loss(&decode_field(&bytes, job)?.field)?),
            _ if copied.is_some() => None,
            _ => Some(loss(made)?),
        };
        let mut outputs = self.outputs;
        outputs.write(output, bytes)?;
        Ok((loss, outputs.commit()?))
    }
}

/// Converts a texture of functions, which may be the linear form of clusters.
fn of_field(file: FieldFile, clusters: Option<&ClusterSpaces>, place: ConvertedPlace<'_>) -> Result<Report> {
    let context = place.context;
    let options = place.options(Some(&file.field));
    place.foresee(&file.field, &options)?;
    let made = convert(&file.field, &options, &context.job)?;
    let is_same = matches!(made, Cow::Borrowed(_));
    let loss = |made: &ReflectanceField| refit_loss(&file.field, made, &context.job);
    let output = &place.args.output;
    let (loss, written) = place.write(&made, is_same.then_some(&file), loss)?;
    let loss = loss.filter(|loss| !is_same || loss.largest > 0.0);
    let clusters = clusters.map(|of| format!(" in {} clusters of {} axes", of.clusters(), of.axes()));
    let from = format!("{}{}", described(&file.field), clusters.clone().unwrap_or_default());
    let lost = match (loss, clusters) {
        (None, None) => "the same functions".to_owned(),
        (None, Some(_)) => format!("from {from}: the same functions, without the clusters"),
        (Some(loss), _) => changed(&from, loss),
    };
    let from =
        json!({ "basis": file.field.basis(), "color": file.field.layout(), "space": file.field.space() });
    Ok(report(output, &made, &lost, from, loss).with_outputs(written))
}

/// The bytes of a file; values that are copies are stored as they were.
fn encoded(
    made: &ReflectanceField,
    target: Target,
    copied: Option<&FieldFile>,
    context: &Context,
) -> Result<Vec<u8>> {
    let stored: Option<&Encoding> = copied.map(|file| &file.encoding);
    match target {
        Target::File(format) => {
            let format = match stored.filter(|_| format != FieldFormat::Exr(ExrDepth::Half)) {
                Some(stored) => format.in_depth_of(stored),
                None => format,
            };
            encode_field(made, format, stored, &context.job)
        }
        Target::Npz => encode_npz(made, &context.job),
        Target::Npy | Target::Web(_) => encode_npy(made, &context.job),
    }
}

fn described(field: &ReflectanceField) -> String {
    format!("{} {}, {}", field.layout().name(), field.basis().name(), field.space())
}

fn changed(from: &str, loss: RefitLoss) -> String {
    format!(
        "from {from}; under {} lights relit values change by {:.4} of white (root mean square) and {:.3} at most",
        loss.lights, loss.rms, loss.largest
    )
}

fn report(
    output: &Path,
    made: &ReflectanceField,
    lost: &str,
    from: Value,
    loss: Option<RefitLoss>,
) -> Report {
    let text = format!("{}: {}, {}; {lost}", output.display(), made.size(), described(made));
    let json = json!({
        "width": made.size().width,
        "height": made.size().height,
        "basis": made.basis(),
        "color": made.layout(),
        "space": made.space(),
        "from": from,
        "loss": loss,
    });
    Report::new(text, json)
}
