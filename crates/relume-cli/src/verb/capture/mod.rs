//! `relume capture`: maps or a built-in material under a virtual light dome.

mod maps;
mod truth;

use std::path::{Path, PathBuf};

use relume::capture::dome::{Bounce, Dome, DomeOptions, ReliefBorder, Surface, lights};
use relume::maps::SurfaceMaps;
use relume::procedural::{Material, MaterialOptions, Tiling};
use relume::workflow::capture::{PhotographFormat, footprint, photographs};
use relume::{Error, Footprint, Result, Size};
use serde_json::json;

use super::material::MaterialArgs;
use crate::context::Context;
use crate::output::Folder;
use crate::paths;
use crate::report::Report;
use crate::{args, normals};
use maps::MapFiles;

/// Arguments of `relume capture`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume capture sponge -o sponge --lights 50\n  \
    relume capture materials/bark -o bark --height-scale 60 --format exr")]
pub struct Args {
    /// A built-in material (sponge, weave, pebbles, leather, bark, marble, wood, clouds, fire), or a folder
    /// of maps recognised by their names: height or displacement, albedo or color, normal, roughness
    #[arg(required_unless_present_all = ["height", "albedo"])]
    maps: Option<PathBuf>,
    /// The folder to write: photographs, `lights.lp`, `capture.json`, and the ground truth in `truth`
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// Number of lamps, spread evenly from the zenith to 75 degrees from it
    #[arg(long, value_name = "N", default_value = "50", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    lights: u32,
    /// File format of the photographs; integers are sRGB-encoded, floats linear
    #[arg(long, default_value = "png", value_parser = args::named::<PhotographFormat>())]
    format: PhotographFormat,
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
    /// Texels from height 0 to height 1 [default: the record in the file; a 25th of the width for integer
    /// files without a record; 1 for floats, which are in texels]
    #[arg(long, value_name = "TEXELS")]
    height_scale: Option<f64>,
    #[command(flatten)]
    normals: normals::Args,
}

/// Options of the dome.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Light")]
struct DomeArgs {
    /// Whether maps repeat beyond their borders or end there
    #[arg(long, default_value = "wrap", value_parser = args::named::<ReliefBorder>())]
    border: ReliefBorder,
    /// Radiance of the sky, as a fraction of that of a white matte surface facing the lamp
    #[arg(long, value_name = "FRACTION", default_value_t = DomeOptions::default().ambient)]
    ambient: f64,
    /// Angular radius of a lamp in degrees, which determines the softness of shadows
    #[arg(long, value_name = "DEGREES", default_value = "1")]
    lamp_radius: f64,
    /// Leave out the light reflected from one part of the surface to another
    #[arg(long)]
    no_bounce: bool,
    /// Leave out the gloss: a Lambertian surface
    #[arg(long)]
    matte: bool,
}

/// Photographs under every lamp and writes the folder.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let options = args.dome.options();
    options.validate()?;
    let inputs: Vec<&Path> =
        args.maps.as_deref().filter(|path| material(path).is_none()).into_iter().collect();
    let mut folder = Folder::stage(&args.output, &inputs, context)?;
    let (name, maps, unused) = source(args, context)?;
    foresee(args, maps.size(), &options, context)?;
    let dome = Dome::new(maps, &options, &context.job).map_err(|e| match &args.maps {
        Some(path) if material(path).is_none() => e.at(path),
        _ => e,
    })?;
    let lamps = lights(args.lights as usize);
    let mut keep = |name: &str, bytes: &[u8]| folder.add(name, bytes);
    let clipped = photographs(&dome, &lamps, args.format, &context.job, &mut keep)?;
    truth::write(&dome, &mut folder, &context.job)?;
    let (low, high) = dome.maps().height.range(0);
    let json = json!({
        "source": name,
        "width": dome.size().width,
        "height": dome.size().height,
        "lights": lamps.len(),
        "photographs": args.format.file_name(0).replace("000", "*"),
        "exposure": "a white Lambertian that faces the lamp is 1",
        "clipped_fraction": clipped,
        "border": format!("{:?}", options.border).to_lowercase(),
        "ambient": options.ambient,
        "bounce": format!("{:?}", options.bounce).to_lowercase(),
        "lamp_radius_deg": args.dome.lamp_radius,
        "truth": {
            "height_texels": { "file": "truth/height.exr", "lowest": low, "highest": high },
            "albedo_linear": "truth/albedo.exr",
            "normals_y_up": ["truth/normals.exr", "truth/normals_gl.png"],
        },
    });
    folder.add("capture.json", format!("{json:#}\n").as_bytes())?;
    let written = folder.commit()?;
    let report = Report::new(summary(args, &name, &dome, clipped), json).with_outputs(written);
    Ok(report.with_warnings(ignored(&unused)))
}

/// Refuses a capture that cannot be taken and written within the memory, beside its maps.
fn foresee(args: &Args, size: Size, options: &DomeOptions, context: &Context) -> Result<()> {
    let (dome, one) = (Dome::footprint(size, options), footprint(size, options, args.format));
    let written = Footprint { peak: one.peak.max(truth::footprint(size).peak), kept: 0 };
    context.job.check_bytes("the virtual dome and its photographs", dome.then(written).peak)
}

fn summary(args: &Args, name: &str, dome: &Dome, clipped: f64) -> String {
    let (low, high) = dome.maps().height.range(0);
    let mut lines = vec![
        format!("{}: {} photographs of {name}, {} texels", args.output.display(), args.lights, dome.size()),
        format!("relief {:.1} texels high; lights in lights.lp, the truth in truth/", high - low),
    ];
    if clipped > 0.0 {
        lines
            .push(format!("{:.3} % of the values are brighter than white and were cut off", 100.0 * clipped));
    }
    lines.join("\n")
}

/// The name of the maps, the maps, and the pictures beside them.
fn source(args: &Args, context: &Context) -> Result<(String, SurfaceMaps, Vec<PathBuf>)> {
    match args.maps.as_deref() {
        Some(path) if material(path).is_some() => {
            args.files.refuse("a built-in material has its own maps")?;
            let material = material(path).expect("the arm's condition");
            Ok((material.name().to_owned(), made(material, args, context)?, Vec::new()))
        }
        folder => {
            args.material.refuse()?;
            let named = MapFiles {
                height: args.files.height.clone(),
                albedo: args.files.albedo.clone(),
                normal: args.files.normal.clone(),
                roughness: args.files.roughness.clone(),
            };
            let files = match folder {
                Some(folder) => named.or(MapFiles::find(folder)?),
                None => named,
            };
            let name = folder.unwrap_or(Path::new("the maps")).display().to_string();
            let unused = folder.map_or(Ok(Vec::new()), |folder| files.unused(folder))?;
            Ok((
                name,
                files.read(args.files.height_scale, args.files.normals.normal_y, &context.job)?,
                unused,
            ))
        }
    }
}

/// The maps of a built-in material, unless the photographs of them would not fit into the memory.
fn made(material: Material, args: &Args, context: &Context) -> Result<SurfaceMaps> {
    let options = args.material.options(Tiling::Torus);
    options.validate()?;
    let maps = context.job.hold("a material's maps", MaterialOptions::footprint(options.size).kept)?;
    foresee(args, options.size, &args.dome.options(), context)?;
    drop(maps);
    material.make(&options, &context.job)
}

/// What is said of pictures beside the maps.
fn ignored(unused: &[PathBuf]) -> Option<String> {
    let names: Vec<String> = unused.iter().filter_map(|path| path.file_name()).map(paths::text).collect();
    (!names.is_empty()).then(|| {
        format!("not used: {}; height, albedo, normals and roughness are photographed", names.join(", "))
    })
}

fn material(path: &Path) -> Option<Material> {
    path.to_str().and_then(Material::from_name)
}

impl Files {
    fn refuse(&self, why: &str) -> Result<()> {
        let given = [
            ("--height", self.height.is_some()),
            ("--albedo", self.albedo.is_some()),
            ("--normal", self.normal.is_some()),
            ("--roughness", self.roughness.is_some()),
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
    fn options(&self) -> DomeOptions {
        let default = DomeOptions::default();
        DomeOptions {
            border: self.border,
            ambient: self.ambient,
            bounce: if self.no_bounce { Bounce::None } else { Bounce::Once },
            surface: if self.matte { Surface::Matte } else { default.surface },
            lamp_radius_rad: self.lamp_radius.to_radians(),
            sectors: default.sectors,
        }
    }
}
