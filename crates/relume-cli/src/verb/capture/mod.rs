//! `relume capture`: maps or a built-in material under a virtual light dome, photographed from above or measured
//! from all sides.

mod btf;
pub mod maps;
mod truth;

use std::path::{Path, PathBuf};

use relume::capture::dome::mirror_balls::BallStrip;
use relume::capture::dome::{Bounce, Dome, DomeOptions, ReliefBorder, Surface, lights};
use relume::maps::SurfaceMaps;
use relume::procedural::{Material, MaterialOptions, Tiling};
use relume::workflow::capture::{PhotographFormat, Shoot, footprint, photographs};
use relume::{Error, Footprint, Result, Size};
use serde_json::{Value, json};

use super::material::MaterialArgs;
use crate::context::Context;
use crate::output::{Folder, is_archive};
use crate::paths;
use crate::report::{Report, counted};
use crate::{args, normals};
use btf::BtfArgs;
use maps::{MapFiles, NamedBy, ReadMaps, Reading};

/// Arguments of `relume capture`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume capture sponge -o sponge --lights 50\n  \
    relume capture materials/bark -o bark --height-scale 60 --format exr\n  \
    relume capture weave --size 128 --views bonn -o weave.zip")]
pub struct Args {
    /// A built-in material (sponge, weave, pebbles, leather, bark, marble, wood, clouds, fire), or a folder
    /// of maps recognised by their names: height or displacement, albedo or color, normal, roughness, metallic
    maps: Option<PathBuf>,
    /// The folder to write: photographs, `lights.lp`, `capture.json`, and the ground truth in `truth`. With --views and
    /// --pairs also a `.zip` archive
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of lamps, spread evenly from the zenith to 75 degrees from it [default: 50; with --views as many as
    /// views]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    lights: Option<u32>,
    /// Lay this many mirror balls at the right of the surface, in photographs from above: `relume lights` finds the
    /// lamps by them
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=8))]
    balls: Option<u32>,
    /// File format of the photographs; integers are sRGB-encoded, floats linear [default: png; jpg with --views and
    /// --pairs]
    #[arg(long, value_parser = args::named::<PhotographFormat>())]
    format: Option<PhotographFormat>,
    #[command(flatten)]
    btf: BtfArgs,
    #[command(flatten)]
    files: Files,
    #[command(flatten)]
    material: MaterialArgs,
    #[command(flatten)]
    dome: DomeArgs,
}

/// Maps by file.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Maps")]
struct Files {
    /// The height map
    #[arg(long, value_name = "FILE")]
    height: Option<PathBuf>,
    /// The albedo map
    #[arg(long, value_name = "FILE")]
    albedo: Option<PathBuf>,
    /// The normal map; without one, normals are computed from the height
    #[arg(long, value_name = "FILE")]
    normal: Option<PathBuf>,
    /// The roughness map; without one, roughness is 1
    #[arg(long, value_name = "FILE")]
    roughness: Option<PathBuf>,
    /// The map of bare metal, whose colour is the albedo; without one, there is none
    #[arg(long, value_name = "FILE")]
    metallic: Option<PathBuf>,
    /// Texels from height 0 to height 1 [default: the record in the file; a 25th of the width for integer
    /// files without a record; 1 for floats, which are in texels]
    #[arg(long, value_name = "TEXELS")]
    height_scale: Option<f64>,
    #[command(flatten)]
    normals: normals::ReadArgs,
}

/// Options of the dome.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Light")]
struct DomeArgs {
    /// Whether maps repeat beyond their borders or end there
    #[arg(long, default_value = "wrap", value_parser = args::named::<ReliefBorder>())]
    border: ReliefBorder,
    /// Radiance of the sky, as a fraction of that of a white matte surface facing the lamp [default: 0.04; 0 with
    /// --views and --pairs]
    #[arg(long, value_name = "FRACTION")]
    ambient: Option<f64>,
    /// Angular radius of a lamp in degrees, which determines the softness of shadows
    #[arg(long, value_name = "DEGREES", default_value = "1", value_parser = args::within(0.0, 45.0, "degrees"))]
    lamp_radius: f64,
    /// Leave out the light reflected from one part of the surface to another
    #[arg(long)]
    no_bounce: bool,
    /// Leave out the gloss: a Lambertian surface
    #[arg(long)]
    matte: bool,
}

/// Photographs under every lamp, or from every view, and writes the files.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    match args.btf.pairs(args.lights)? {
        Some(_) if args.balls.is_some() => Err(Error::usage(
            "--balls is of photographs from above: leave it out, or leave out --views and --pairs",
        )),
        Some(pairs) => btf::run(args, pairs, context),
        None => photograph(args, context),
    }
}

fn photograph(args: &Args, context: &Context) -> Result<Report> {
    if is_archive(&args.output) {
        return Err(Error::usage(
            "photographs go into a folder; archives hold the images of --views or --pairs: name a folder",
        )
        .at(&args.output));
    }
    let (format, options) =
        (args.format.unwrap_or_default(), args.dome.options(DomeOptions::default().ambient));
    options.validate()?;
    let folder = Folder::stage(&args.output, &args.inputs(), context)?;
    let CapturedSurface { name, dome, unused } =
        source(args, &options, &|size| footprint(size, format), context)?;
    let lamps = lights(args.lights.unwrap_or(LIGHTS) as usize);
    let mut keep = |name: &str, bytes: &[u8]| folder.add(name, bytes);
    let strip = strip(args, dome.size())?;
    let shoot = Shoot { dome: &dome, lamps: &lamps, balls: strip.as_ref(), format };
    let clipped = photographs(shoot, &context.job, &mut keep)?;
    truth::write(&dome, &mut keep, &context.job)?;
    let mut json = json!({
        "source": name,
        "width": dome.size().width,
        "height": dome.size().height,
        "lights": lamps.len(),
        "photographs": format.file_name(0).replace("000", "*"),
    });
    if let Some(strip) = &strip {
        append(&mut json, json!({ "balls": strip.balls() }));
    }
    append(&mut json, conditions(args, &dome, clipped));
    folder.add("capture.json", format!("{json:#}\n").as_bytes())?;
    let written = folder.commit()?;
    let what = counted(lamps.len(), "photograph");
    let report = Report::new(summary(args, &what, &name, &dome, clipped), json).with_outputs(written);
    Ok(report.with_warnings(ignored(&unused).into_iter().chain(shadowed(args))))
}

/// The mirror balls beside photographs of a size.
fn strip(args: &Args, size: Size) -> Result<Option<BallStrip>> {
    let Some(count) = args.balls else { return Ok(None) };
    let strip = BallStrip::new(size, count as usize).ok_or_else(|| {
        Error::usage(format!("--balls {count}: the photographs of {size} texels are too small for them"))
    });
    strip.map(Some)
}

/// The number of lamps unless another is asked for.
const LIGHTS: u32 = 50;

/// Under which conditions the surface was seen, and where its truth is.
fn conditions(args: &Args, dome: &Dome, clipped: f64) -> Value {
    let options = dome.options();
    json!({
        "exposure": "a white Lambertian that faces the lamp is 1",
        "clipped_fraction": clipped,
        "border": format!("{:?}", options.border).to_lowercase(),
        "ambient": options.ambient,
        "bounce": format!("{:?}", options.bounce).to_lowercase(),
        "lamp_radius_deg": args.dome.lamp_radius,
        "truth": truth::describe(dome),
    })
}

/// Adds the fields of an object to another.
fn append(json: &mut Value, more: Value) {
    let (Value::Object(json), Value::Object(more)) = (json, more) else { unreachable!("both are objects") };
    json.extend(more);
}

fn summary(args: &Args, what: &str, name: &str, dome: &Dome, clipped: f64) -> String {
    let (low, high) = dome.maps().height.range(0);
    let mut lines = vec![
        format!("{}: {what} of {name}, {} texels", args.output.display(), dome.size()),
        format!("relief {:.1} texels high; the conditions in capture.json, the truth in truth/", high - low),
    ];
    if clipped > 0.0 {
        let percent = match 100.0 * clipped {
            few if few < 0.001 => "less than 0.001".to_owned(),
            percent => format!("{percent:.3}"),
        };
        lines.push(format!("{percent} % of the values are brighter than white and were cut off"));
    }
    lines.join("\n")
}

/// A surface under the dome.
struct CapturedSurface {
    /// The material, or the folder of maps.
    name: String,
    dome: Dome,
    /// The pictures beside the maps.
    unused: Vec<PathBuf>,
}

/// Puts the maps under the dome, unless they do not fit into the memory beside one picture.
fn source(
    args: &Args,
    options: &DomeOptions,
    picture: &dyn Fn(Size) -> Footprint,
    context: &Context,
) -> Result<CapturedSurface> {
    let foresee = |size: Size| {
        let written = Footprint { peak: picture(size).peak.max(truth::footprint(size).peak), kept: 0 };
        let all = Dome::footprint(size, options).then(written);
        context.job.check_bytes("the virtual dome and its photographs", all.peak)
    };
    let (name, maps, unused) = maps(args, &foresee, context)?;
    foresee(maps.size())?;
    let dome = Dome::new(maps, options, &context.job).map_err(|e| match args.inputs().first() {
        Some(path) => e.at(path),
        None => e,
    })?;
    Ok(CapturedSurface { name, dome, unused })
}

/// The name of the maps, the maps, and the pictures beside them.
fn maps(
    args: &Args,
    foresee: &dyn Fn(Size) -> Result<()>,
    context: &Context,
) -> Result<(String, SurfaceMaps, Vec<PathBuf>)> {
    match args.maps.as_deref() {
        Some(path) if material(path).is_some() => {
            args.files.refuse("a built-in material has its own maps")?;
            let material = material(path).expect("the arm's condition");
            Ok((material.name().to_owned(), made(material, args, foresee, context)?, Vec::new()))
        }
        folder => {
            args.material.refuse()?;
            let files = match folder {
                Some(folder) => args.files.named().or(MapFiles::find(folder, NamedBy::Options)?),
                None => args.files.named().whole()?,
            };
            let name = folder.unwrap_or(Path::new("the maps")).display().to_string();
            let unused = folder.map_or(Ok(Vec::new()), |folder| files.unused(folder))?;
            let (height_scale, normal_y) = (args.files.height_scale, args.files.normals.normal_y);
            let reading = Reading { height_scale, normal_y, border: None };
            let ReadMaps { maps, opacity, .. } = files.read(&reading, foresee, &context.job)?;
            if opacity.is_some() {
                context.job.remark(format!("{name}: the opacity of the colours has no part in photographs"));
            }
            Ok((name, maps, unused))
        }
    }
}

/// The maps of a built-in material, unless the photographs of them would not fit into the memory.
fn made(
    material: Material,
    args: &Args,
    foresee: &dyn Fn(Size) -> Result<()>,
    context: &Context,
) -> Result<SurfaceMaps> {
    let options = args.material.options(Tiling::Torus);
    options.validate()?;
    let maps = context.job.hold("a material's maps", MaterialOptions::footprint(options.size).kept)?;
    foresee(options.size)?;
    drop(maps);
    material.make(&options, &context.job)
}

/// What is said of a folder that is called like a built-in material.
fn shadowed(args: &Args) -> Option<String> {
    let folder = args
        .maps
        .as_deref()
        .filter(|path| material(path).is_some() && path.is_dir() && *path != args.output)?;
    let name = folder.display();
    Some(format!("{name} is the built-in material; there is also a folder of this name: ./{name} names that"))
}

/// What is said of pictures beside the maps.
fn ignored(unused: &[PathBuf]) -> Option<String> {
    let names: Vec<String> = unused.iter().filter_map(|path| path.file_name()).map(paths::text).collect();
    (!names.is_empty()).then(|| {
        format!(
            "not used: {}; height, albedo, normals, roughness and metal are photographed",
            names.join(", ")
        )
    })
}

fn material(path: &Path) -> Option<Material> {
    path.to_str().and_then(Material::from_name)
}

impl Args {
    /// The folder of maps.
    fn inputs(&self) -> Vec<&Path> {
        self.maps.as_deref().filter(|path| material(path).is_none()).into_iter().collect()
    }
}

impl Files {
    fn named(&self) -> MapFiles {
        MapFiles {
            height: self.height.clone(),
            albedo: self.albedo.clone(),
            normal: self.normal.clone(),
            roughness: self.roughness.clone(),
            metallic: self.metallic.clone(),
            named_by: NamedBy::Options,
            folder: None,
        }
    }

    fn refuse(&self, why: &str) -> Result<()> {
        let given = [
            ("--height", self.height.is_some()),
            ("--albedo", self.albedo.is_some()),
            ("--normal", self.normal.is_some()),
            ("--roughness", self.roughness.is_some()),
            ("--metallic", self.metallic.is_some()),
            ("--height-scale", self.height_scale.is_some()),
            ("--normal-y", self.normals.normal_y.is_some()),
        ];
        match given.iter().find(|(_, given)| *given) {
            Some((option, _)) => Err(Error::usage(format!("{option} cannot be used: {why}"))),
            None => Ok(()),
        }
    }
}

impl DomeArgs {
    /// The options, with the ambient light that is usual.
    fn options(&self, ambient: f64) -> DomeOptions {
        let default = DomeOptions::default();
        DomeOptions {
            border: self.border,
            ambient: self.ambient.unwrap_or(ambient),
            bounce: if self.no_bounce { Bounce::None } else { Bounce::Once },
            surface: if self.matte { Surface::Matte } else { default.surface },
            lamp_radius_rad: self.lamp_radius.to_radians(),
            sectors: default.sectors,
        }
    }
}
