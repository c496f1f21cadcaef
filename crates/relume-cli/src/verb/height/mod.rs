//! `relume height`: the height map of a surface, from photographs, functions, or normals.

mod compare;
mod foresight;
mod shape;

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::format::{
    Depth, HeightFormat, PictureFormat, encode_data_map, encode_height_with, encode_normals,
    encode_picture_with,
};
use relume::surface::integrate::{
    Discontinuities, IntegrateOptions, IntegrationMethod, SurfaceBorder, integrate, integrate_weighted,
};
use relume::surface::photometric_stereo::StereoOptions;
use relume::surface::{Ambient, Estimator};
use relume::{Direction, Error, Job, Picture, Planes, Result, Space};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output::{self, Outputs};
use crate::photographs::PhotographArgs;
use crate::report::Report;
use crate::{args, normals};
pub use foresight::SurfaceFiles;
use shape::{HeightMethod, Shape};

/// Arguments of `relume height`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume height photographs -o height.exr --border periodic\n  \
    relume height wool.ptm -o height.png --pixel-mm 0.05\n  \
    relume height photo.png --method shape-from-shading --light 0.8,0.1,0.6 -o height.exr\n  \
    relume height normals_gl.png --method normal-map -o height.exr")]
pub struct Args {
    /// A folder of photographs with its .lp file, or the .lp; a .ptm or .exr field; a photograph; a
    /// normal map
    input: PathBuf,
    /// The height map to write: .exr (floats, in texels, or in mm with --pixel-mm) or .png (16 bits,
    /// its range recorded)
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Source of the slopes [default: photometric-stereo for photographs, ptm-normals for fields]
    #[arg(long, value_parser = method())]
    method: Option<HeightMethod>,
    /// Whether the surface repeats beyond its borders
    #[arg(long, default_value = "open", value_parser = args::named::<SurfaceBorder>())]
    border: SurfaceBorder,
    /// Method of integration: differences of neighbours, or derivatives in the Fourier domain (Frankot and
    /// Chellappa)
    #[arg(long, default_value = "poisson", value_parser = args::named::<IntegrationMethod>())]
    integration: IntegrationMethod,
    /// A picture of which the bright pixels belong to the surface; others are left level and black. Its size is that of the photographs,
    /// with which it is cropped and reduced, or of what is left of them
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    /// Whether cliffs become ramps (smooth) or stay (preserve)
    #[arg(long, default_value = "smooth", value_parser = args::named::<Discontinuities>())]
    discontinuities: Discontinuities,
    /// The steepest plausible slope in degrees, below 90 [default: 87; 50 for ptm-normals]
    #[arg(long, value_name = "DEG")]
    steepest: Option<f64>,
    /// The size of a texel in millimetres: heights are then written in millimetres
    #[arg(long, value_name = "MM", value_parser = args::texel_mm)]
    pixel_mm: Option<f64>,
    /// Also write the normals: 0..1 in integer files, -1..1 in EXR
    #[arg(long, value_name = "FILE")]
    normals: Option<PathBuf>,
    /// Also write the albedo estimated by photometric stereo
    #[arg(long, value_name = "FILE")]
    albedo_map: Option<PathBuf>,
    /// Also write the roughness, by a lobe fitted to what a matt body leaves over of the photographs (12 lights or more)
    #[arg(long, value_name = "FILE")]
    roughness_map: Option<PathBuf>,
    /// Also write the strength of those highlights: reflectance at normal incidence over 0.08, so that 0.5 is that of glass
    #[arg(long, value_name = "FILE")]
    specular_map: Option<PathBuf>,
    #[command(flatten)]
    normal_maps: normals::Args,
    #[command(flatten)]
    photographs: PhotographArgs,
    #[command(flatten)]
    stereo: StereoArgs,
    #[command(flatten)]
    shading: ShadingArgs,
    #[command(flatten)]
    truth: compare::Truth,
}

/// Photographs under many lights.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Photometric stereo")]
struct StereoArgs {
    /// Treatment of shadows and highlights: reduced weight (robust; cauchy with a wider tail, for reliefs of which much is in
    /// shadow), left out (trimmed), or none (least-squares); or robust with a reflectance that all texels share, learned from them (shared) [default: robust]
    #[arg(long, value_parser = args::named::<Estimator>())]
    estimator: Option<Estimator>,
    /// Estimate a constant light common to all photographs
    #[arg(long)]
    ambient: bool,
}

/// One photograph.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Shape from shading")]
struct ShadingArgs {
    /// Direction towards the light of the photograph: x right, y up, z to the viewer
    #[arg(long, value_name = "X,Y,Z", value_parser = args::light, allow_hyphen_values = true)]
    light: Option<Direction>,
    /// The number of the photograph in a folder, from 0 [default: the one whose light is nearest to 45
    /// degrees]
    #[arg(long, value_name = "N")]
    photograph: Option<usize>,
    /// Linear albedo of the surface [default: from the mean of the photograph]
    #[arg(long, value_name = "A")]
    albedo: Option<f64>,
    /// Number of rounds of steps and projections [default: 50]
    #[arg(long, value_name = "N")]
    rounds: Option<usize>,
    /// Undulations of this wavelength are halved and longer ones damped more, because one photograph hardly
    /// determines them [default: the longer side; none for periodic surfaces]
    #[arg(long, value_name = "TEXELS")]
    longest: Option<f64>,
}

impl Args {
    /// The files that are written.
    fn written(&self) -> impl Iterator<Item = &Path> {
        let maps = [&self.normals, &self.albedo_map, &self.roughness_map, &self.specular_map];
        std::iter::once(&self.output).chain(maps.into_iter().flatten()).map(PathBuf::as_path)
    }

    /// Refuses outputs that are photographs.
    fn refuse_photographs(&self, photographs: &[&Path]) -> Result<()> {
        self.written().try_for_each(|path| output::refuse_input(path, photographs))
    }
}

/// Estimates the shape, integrates it, writes and compares.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let format = HeightFormat::from_path(&args.output)?;
    if let Some(deg) = args.steepest.filter(|deg| !(*deg > 0.0 && *deg < 90.0)) {
        return Err(Error::usage(format!("--steepest {deg}: expected degrees between 0 and 90")));
    }
    let mut outputs = Outputs::new(context);
    let maps = [&args.normals, &args.albedo_map, &args.roughness_map, &args.specular_map];
    let mut read = vec![args.input.as_path()];
    let files = args.photographs.files();
    read.extend(files.iter().map(PathBuf::as_path));
    read.extend(args.mask.as_deref());
    read.extend(args.truth.files());
    for path in args.written() {
        outputs.file(path, &read)?;
    }
    for path in maps.into_iter().flatten() {
        PictureFormat::from_path(path)?;
    }
    let known = args.truth.read(args.normal_maps.normal_y, context)?;
    let shape = shape::find(args, &known, context)?;
    let albedo = albedo_map(args, &shape, &context.job)?;
    let lobes = lobe_maps(args, &shape, &context.job)?;
    let mask = shape.mask.as_deref();
    let height = integrated(args, &shape, mask, context)?;
    let compared = known.compare(&height, &shape.normals, mask)?;
    let pixel_mm = args.pixel_mm.or(shape.pixel_mm);

    outputs.write(&args.output, encode_height_with(&height, pixel_mm, format, &context.job)?)?;
    if let Some(path) = &args.normals {
        let y = args.normal_maps.of_output(path);
        outputs
            .write(path, encode_normals(&shape.normals, y, PictureFormat::from_path(path)?, &context.job)?)?;
    }
    if let (Some(path), Some(bytes)) = (&args.albedo_map, albedo) {
        outputs.write(path, bytes)?;
    }
    for (path, bytes) in lobes {
        outputs.write(&path, bytes)?;
    }
    Ok(report(args, &shape, &height, compared).with_outputs(outputs.commit()?))
}

/// The heights: by one division in the Fourier domain, or texel by texel where a mask or cliffs ask for it.
fn integrated(args: &Args, shape: &Shape, mask: Option<&[bool]>, context: &Context) -> Result<Planes> {
    if mask.is_none() && args.discontinuities == Discontinuities::Smooth {
        let options = IntegrateOptions { method: args.integration, border: args.border };
        return integrate(&shape.slopes, &options, &context.job);
    }
    if args.integration != IntegrationMethod::Poisson {
        return Err(Error::usage(
            "--integration frankot-chellappa needs the whole picture: leave out --mask and --discontinuities",
        ));
    }
    integrate_weighted(&shape.slopes, mask, args.border, args.discontinuities, &context.job)
}

/// Refuses options that have no part in the method.
fn refuse_strangers(args: &Args, method: HeightMethod, is_capture: bool) -> Result<()> {
    let (stereo, shading) = (&args.stereo, &args.shading);
    let is_shading = method == HeightMethod::ShapeFromShading;
    let is_stereo = method == HeightMethod::PhotometricStereo;
    let given = [
        ("--estimator", stereo.estimator.is_some(), is_stereo),
        ("--ambient", stereo.ambient, is_stereo),
        ("--roughness-map", args.roughness_map.is_some(), is_stereo),
        ("--specular-map", args.specular_map.is_some(), is_stereo),
        ("--light", shading.light.is_some(), is_shading),
        ("--photograph", shading.photograph.is_some(), is_shading && is_capture),
        ("--albedo", shading.albedo.is_some(), is_shading),
        ("--rounds", shading.rounds.is_some(), is_shading),
        ("--longest", shading.longest.is_some(), is_shading),
        ("--steepest", args.steepest.is_some(), !is_shading),
    ];
    // Shape from shading takes one photograph, as it is stored.
    let pairing = PhotographArgs { pair: None, ..args.photographs.clone() };
    let photographs = if is_shading && is_capture { &pairing } else { &args.photographs };
    let of_photographs = photographs.given().map(|name| (name, true, is_capture && is_stereo));
    match given.iter().chain(&of_photographs).find(|(_, given, has_part)| *given && !has_part) {
        Some((option, ..)) => Err(Error::usage(format!(
            "{option} has no part in {} from this input: leave it out, or name another --method",
            method.name()
        ))),
        None => Ok(()),
    }
}

/// The bytes of the albedo map, if requested.
fn albedo_map(args: &Args, shape: &Shape, job: &Job) -> Result<Option<Vec<u8>>> {
    let Some(path) = &args.albedo_map else { return Ok(None) };
    let albedo = shape
        .albedo
        .as_ref()
        .ok_or_else(|| Error::usage(format!("{} finds no albedo", shape.method.name())).at(path))?;
    encode_picture_with(albedo, PictureFormat::from_path(path)?, job).map(Some)
}

/// The bytes of the maps of roughness and of the strength of highlights, if requested.
fn lobe_maps(args: &Args, shape: &Shape, job: &Job) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    /// The reflectance at normal incidence that such maps call 1.
    const WHOLE: f32 = 0.08;
    let encoded = |path: &PathBuf, planes: &Planes| {
        let bytes = match PictureFormat::from_path(path)? {
            PictureFormat::Png(_) => encode_data_map(planes, Depth::Sixteen, job)?,
            format => {
                encode_picture_with(&Picture { planes: planes.clone(), space: Space::Linear }, format, job)?
            }
        };
        Ok((path.clone(), bytes))
    };
    let Some(found) = &shape.highlights else { return Ok(Vec::new()) };
    let roughness = args.roughness_map.iter().map(|path| encoded(path, &found.roughness));
    let specular = args.specular_map.iter().map(|path| {
        let mut strength = found.reflectance.clone();
        strength.as_mut_slice().iter_mut().for_each(|v| *v = (*v / WHOLE).min(1.0));
        encoded(path, &strength)
    });
    roughness.chain(specular).collect()
}

fn report(args: &Args, shape: &Shape, height: &Planes, compared: compare::Compared) -> Report {
    let (low, high) = height.range(0);
    let (size, pixel_mm) = (height.size(), args.pixel_mm.or(shape.pixel_mm));
    let mut text = format!(
        "{}: {size} texels {}, heights {low:.2} to {high:.2} texels{}",
        args.output.display(),
        shape.how,
        pixel_mm.map_or(String::new(), |mm| format!(
            " ({:.3} to {:.3} mm)",
            f64::from(low) * mm,
            f64::from(high) * mm
        ))
    );
    let written = args.normals.as_ref().map(|path| args.normal_maps.of_output(path));
    let normals = written.map(|y| format!("wrote {}", normals::described(y)));
    for line in shape.notes.iter().chain(&normals).chain(&compared.lines()) {
        text.push('\n');
        text.push_str(line);
    }
    let json = json!({
        "width": size.width,
        "height": size.height,
        "method": shape.method.name(),
        "integration": args.integration,
        "border": args.border,
        "lowest_texels": low,
        "highest_texels": high,
        "discontinuities": args.discontinuities,
        "pixel_mm": pixel_mm,
        "normal_y": written,
        "facts": shape.facts,
        "height_error": compared.height,
        "normal_error": compared.normals,
    });
    Report::new(text, json).with_warnings(&shape.warnings)
}

/// One of a few names.
fn one_of<T: Copy + Send + Sync + 'static, const N: usize>(
    members: [(&'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(members.map(|(name, _)| name)).map(move |name| {
        members
            .into_iter()
            .find(|(known, _)| *known == name)
            .map(|(_, member)| member)
            .expect("a listed name")
    })
}

fn method() -> impl TypedValueParser<Value = HeightMethod> {
    one_of(HeightMethod::ALL.map(|method| (method.name(), method)))
}

impl StereoArgs {
    fn options(&self) -> StereoOptions {
        let ambient = if self.ambient { Ambient::Constant } else { Ambient::None };
        let usual = StereoOptions::default();
        StereoOptions { estimator: self.estimator.unwrap_or(usual.estimator), ambient }
    }
}

/// The facts of a method as JSON: none.
fn no_facts() -> Value {
    json!({})
}
