//! `relume fit`: from photographs under known lights, or lights and views, to a texture of functions.

mod choice;
mod factors;
mod format;
mod input;
mod learned;
mod light;
mod parametric;
mod quality;
mod test;
mod words;

use std::path::PathBuf;

use relume::field::{Basis, Interpolated, PlaneLayout};
use relume::fit::{Ridge, Robust};
use relume::workflow::quality::QualityReport;
use relume::workflow::{Btf, Missing};
use relume::{Error, ReflectanceField, Result, Space};
use serde_json::{Value, json};

use crate::args;
use crate::context::Context;
use crate::output::{self, Outputs};
use crate::photographs::PhotographArgs;
use crate::report::Report;
use choice::{BasisChoice, basis};
use factors::Factorisation;
use format::{FittedFormat, check_pairs, is_btf, output_format};
use input::Inputs;
use test::Test;

/// Arguments of `relume fit`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume fit photographs/lights.lp -o wool.ptm --leave-one-out\n  \
                        relume fit wool.zip -o wool.exr --rank 32 --half")]
pub struct Args {
    /// A light-position file (.lp), or a folder that holds exactly one; or a texture of light and view: a folder or .zip
    /// of photographs with names such as `00008 tl015 pl060 tv030 pv000.jpg`
    capture: PathBuf,
    /// The texture to write: .ptm or .exr, or .btf for learned functions of as many views as lights; `-` writes a .ptm to
    /// standard output
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// The basis functions. Polynomials of the light: linear, ptm (six terms), cubic, quartic, zernike (degree 5);
    /// hemispherical harmonics (hsh, as in RTI files) and spherical harmonics (sh) with so many functions; the photographs
    /// themselves, interpolated between their lights by radial basis functions (rbf), in triangles (tabulated), or by radial basis functions
    /// with boundaries of shadows and highlights that move between the lights (shapes); or functions learned from the
    /// photographs (learned) [default: ptm; learned for textures of light and view]
    #[arg(long, value_parser = basis())]
    basis: Option<BasisChoice>,
    /// The number of learned functions, which is that of the numbers of a texel [default: 32]
    #[arg(long, value_name = "N", conflicts_with = "error", value_parser = learned::rank)]
    rank: Option<usize>,
    /// Learn as few functions as give this root mean square error, of values with white at 1
    #[arg(long, value_name = "E", value_parser = learned::error)]
    error: Option<f64>,
    /// Put the texels into N clusters with axes of their own: a texel then has fewer numbers than there are common
    /// functions (--rank)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    clusters: Option<u16>,
    /// The numbers of a texel of a cluster [default: a third of the functions]
    #[arg(long, value_name = "N", requires = "clusters")]
    cluster_axes: Option<usize>,
    /// Round numbers and functions such that they add this root mean square error at most, of values with white at 1, for a
    /// file several times smaller (an .exr in 16-bit floats): 0.004 is one step of 8 bits
    #[arg(long, value_name = "E")]
    rounding: Option<f64>,
    /// In a .btf: common functions of all views and channels (common); of the logarithm of the luminance, and a quarter as
    /// many of two colour differences over it (decorrelated); or functions of the light for each view (per-view)
    /// [default: common]
    #[arg(long, value_name = "OF", value_parser = args::named::<Factorisation>())]
    factors: Option<Factorisation>,
    /// Fit a reflectance model to each texel of a texture of light and view: one or two lobes of light and view (lafortune1,
    /// lafortune2); base colour, normal, roughness and specular reflectance as in artists' programs (ggx); a function of
    /// the light for each view: lobes (views-lafortune1, views-lafortune2), or any basis of light (views-ptm, views-hsh9); or
    /// a sum of products of a function of the view and one of the light (separable1 to separable16)
    #[arg(long, value_name = "NAME", value_parser = parametric::named,
          conflicts_with_all = ["basis", "rank", "error", "clusters", "rounding", "factors"])]
    model: Option<String>,
    /// The most pairs of light and view to which the lobes or facets of a texel are fitted [default: 1024]
    #[arg(long, value_name = "N", requires = "model")]
    fit_pairs: Option<usize>,
    /// Leave every N-th light and view out of the fit of learned functions or models, and measure how well they are
    /// predicted
    #[arg(long, value_name = "N")]
    hold_out: Option<usize>,
    /// Photographs missing from a grid of lights and views: refuse the set, or interpolate them from the others (fill)
    /// [default: refuse]
    #[arg(long, value_parser = args::named::<Missing>())]
    missing: Option<Missing>,
    /// One luminance function times a colour (lrgb), or one function per channel (rgb); not needed for grey
    /// photographs [default: lrgb for ptm and hsh9, rgb for others]
    #[arg(long, value_parser = args::color())]
    color: Option<PlaneLayout>,
    /// Fit sRGB-encoded values (srgb) or values proportional to light (linear) [default: srgb for .ptm, shapes and learned
    /// functions, linear for others in an .exr and for .btf]
    #[arg(long, value_parser = args::named::<Space>())]
    space: Option<Space>,
    /// Penalise rough functions, where there are many for the lights: `auto` for the weight by which each photograph is
    /// best predicted from the others, or a weight such as 0.001 [default: none]
    #[arg(long, value_name = "WEIGHT", value_parser = ridge)]
    ridge: Option<Ridge>,
    /// At each texel leave out the darkest quarter and the brightest tenth of the photographs (trimmed), or let those
    /// count less that differ much from its function (reweighted) [default: none]
    #[arg(long, value_parser = args::named::<Robust>())]
    robust: Option<Robust>,
    /// Store an .exr or .btf in 16-bit floats
    #[arg(long)]
    half: bool,
    /// Also measure how well each photograph is predicted from all others
    #[arg(long)]
    leave_one_out: bool,
    /// Photographs that take no part in the fit, as a light-position file: relight the result under their lights and
    /// compare, as encoded 8-bit values. They are developed as those of the fit, with the same mask, part and near lamps; what is
    /// known of the fitted photographs alone is said
    #[arg(long, value_name = "FILE.lp")]
    test: Option<PathBuf>,
    /// Also write a report on the quality of the fit: one page with the errors of each light and of each place, each
    /// photograph predicted from the others, the coverage of the hemisphere, and photographs that look wrong
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Number of texels of each photograph to compare with the result, or `all` [default: 65536; 1024 for learned functions and
    /// models, for which these texels of all photographs are kept in memory]
    #[arg(long, value_name = "N", value_parser = texels)]
    report_texels: Option<usize>,
    /// A picture of which the bright pixels belong to the surface: others are black in the texture, and not measured. Its size is
    /// that of the photographs, with which it is cropped and reduced, or of what is left of them
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    #[command(flatten)]
    photographs: PhotographArgs,
}

/// Fits a capture, or a texture of light and view, and writes the field.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let is_btf = Btf::is_at(&args.capture);
    let default = if is_btf { BasisChoice::Learned } else { BasisChoice::OfLight(Basis::Ptm) };
    let basis = args.basis.clone().unwrap_or(default);
    args.check(is_btf, &basis)?;
    args.check_model(is_btf)?;
    args.report.iter().try_for_each(|path| output::expect(path, "a page", &["html", "htm"]))?;
    let mut outputs = Outputs::new(context);
    let mut read = vec![args.capture.as_path()];
    let files = args.photographs.files();
    read.extend(files.iter().map(PathBuf::as_path));
    read.extend(args.mask.as_deref());
    for written in std::iter::once(&args.output).chain(&args.report) {
        outputs.file(written, &read)?;
    }
    let format = output_format(args, &basis)?;
    let inputs = Inputs::open(args, is_btf, &basis, context)?;
    if args.model.is_none() && basis == BasisChoice::Learned {
        check_pairs(args, format, &inputs)?;
    }
    if let Some(model) = &args.model {
        return parametric::run(args, model, format, &inputs, outputs, context);
    }
    let basis = match basis {
        BasisChoice::OfLight(basis) => basis,
        BasisChoice::Interpolated(rule) => {
            let lights: Vec<_> = inputs.pairs().iter().map(|(_, pair)| pair.light).collect();
            Basis::Interpolated(Interpolated::new(&lights, rule).map_err(|e| e.at(inputs.place()))?)
        }
        BasisChoice::Learned => return args.learn(format, inputs, outputs, context),
    };
    match format {
        FittedFormat::Field(format) => light::run(args, basis, format, inputs, outputs, context),
        FittedFormat::Btf(_) => {
            Err(Error::usage("a .btf file holds learned functions: give also --basis learned")
                .at(&args.output))
        }
    }
}

impl Args {
    /// Learns functions, and writes them in the form asked for.
    fn learn(
        &self,
        format: FittedFormat,
        inputs: Inputs,
        outputs: Outputs,
        context: &Context,
    ) -> Result<Report> {
        match (self.factors, format) {
            (None | Some(Factorisation::Common), _) => learned::run(self, format, inputs, outputs, context),
            (Some(of), FittedFormat::Btf(scalar)) => {
                factors::run(self, of, scalar, &inputs, outputs, context)
            }
            (Some(_), FittedFormat::Field(_)) => {
                Err(Error::usage("--factors is of .btf files: name one to write").at(&self.output))
            }
        }
    }

    /// Whether what is fitted needs each light with each view.
    fn needs_grid(&self) -> bool {
        let is_separable = self.model.as_ref().is_some_and(|model| model.starts_with("separable"));
        is_separable || self.rounding.is_some() || is_btf(&self.output)
    }

    /// Refuses options without a part in the fit of a reflectance model.
    fn check_model(&self, is_btf: bool) -> Result<()> {
        let Some(model) = &self.model else { return Ok(()) };
        if !is_btf {
            return Err(Error::usage(format!(
                "--model {model} is of textures of light and view, and this is a capture of lights"
            ))
            .at(&self.capture));
        }
        let given = [(self.test.is_some(), "--test"), (self.report.is_some(), "--report")];
        match given.iter().find(|(given, _)| *given) {
            Some((_, name)) => Err(Error::usage(format!(
                "{name} is of linear functions, and --model {model} fits none: `relume compare` measures it"
            ))),
            None => Ok(()),
        }
    }

    /// Refuses options without a part in the fit asked for.
    fn check(&self, is_btf: bool, basis: &BasisChoice) -> Result<()> {
        let learns = *basis == BasisChoice::Learned;
        let only_learned = [
            (self.rank.is_some(), "--rank"),
            (self.error.is_some(), "--error"),
            (self.clusters.is_some(), "--clusters"),
            (self.rounding.is_some(), "--rounding"),
            (self.factors.is_some(), "--factors"),
            (self.hold_out.is_some(), "--hold-out"),
        ];
        let never_learned = [
            (self.leave_one_out, "--leave-one-out"),
            (self.color.is_some(), "--color"),
            (self.ridge.is_some(), "--ridge"),
            (self.robust.is_some(), "--robust"),
        ];
        if let Some((_, name)) = only_learned.iter().find(|(given, _)| *given && !learns) {
            return Err(Error::usage(format!(
                "{name} is of functions that are learned: give also --basis learned"
            )));
        }
        if let Some((_, name)) = never_learned.iter().find(|(given, _)| *given && learns) {
            return Err(Error::usage(format!(
                "{name} has no meaning for learned functions, which have values for each channel; --hold-out N measures \
                 how well directions are predicted"
            )));
        }
        if is_btf && self.mask.is_some() {
            return Err(Error::usage(
                "--mask is of captures of lights, and this is a texture of light and view",
            ));
        }
        if !is_btf && self.missing.is_some() {
            return Err(Error::usage(
                "--missing is of textures of light and view, and this is a capture of lights",
            ));
        }
        Ok(())
    }
}

/// The fields of a report on a fitted texture.
fn described(
    field: &ReflectanceField,
    report: Value,
    test: Option<&Test>,
    quality: Option<&QualityReport>,
) -> Value {
    let mut json = json!({
        "width": field.size().width,
        "height": field.size().height,
        "basis": field.basis(),
        "color": field.layout(),
        "report": report,
    });
    if let Some(test) = test {
        (json["test_psnr_db"], json["test"]) = test.described();
    }
    if let Some(quality) = quality {
        json["quality"] = json!(quality);
    }
    json
}

fn texels(text: &str) -> std::result::Result<usize, String> {
    let number = if text == "all" { Some(usize::MAX) } else { text.parse().ok().filter(|n| *n > 0) };
    number.ok_or_else(|| "expected a number of at least 1, or all".to_owned())
}

fn ridge(text: &str) -> std::result::Result<Ridge, String> {
    match text {
        "none" => Ok(Ridge::None),
        "auto" => Ok(Ridge::LeaveOneOut),
        _ => {
            let weight: Option<f64> = text.parse().ok();
            let expected = || "expected auto, none or a number above 0".to_owned();
            let ridge = weight.map(Ridge::Weight).ok_or_else(expected)?;
            ridge.validate().map(|()| ridge).map_err(|e| e.message().to_owned())
        }
    }
}
