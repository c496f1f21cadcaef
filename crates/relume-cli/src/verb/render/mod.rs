//! `relume render`: a texture on an object.

mod motion;
mod relief;

use std::path::{Path, PathBuf};

use relume::format::{Depth, PictureFormat, encode_picture_with, read_mesh};
use relume::render::{
    self, Camera, CastShadows, Light, Mesh, MeshRelief, Primitive, RenderOptions, Specular, TexelShading,
};
use relume::{Direction, Footprint, Job, Picture, Result, Size, Space, surface};
use serde_json::json;

use crate::context::Context;
use crate::evaluated::Texture;
use crate::film::{Film, FilmShape};
use crate::output::Outputs;
use crate::report::{Report, counted};
use crate::{args, environment, evaluated, output, paths};

/// Arguments of `relume render`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume render wool.ptm --mesh sphere --light 1,0.4,0.3 -o wool.png\n  \
                        relume render wool.ptm --mesh sphere --light 1,0.4,0.3 --plain -o photograph.png\n  \
                        relume render wool.ptm --height wool.exr --displace 1x --mesh torus -o relief.png\n  \
                        relume render wool.ptm --env studio.hdr --env-rotate 90 -o studio.png\n  \
                        relume render wool.ptm --env sky --mesh cloth --camera 20,25 -o outdoors.png\n  \
                        relume render wool.ptm --mesh torus --turntable 60 --size 400x400 -o wool.mp4")]
pub struct Args {
    /// A .ptm, an .exr field, a picture, or a .rlm model; - is standard input
    file: PathBuf,
    /// The object: sphere, plane, torus, cloth, or a file: .obj or .glb
    #[arg(long, default_value = "sphere")]
    mesh: PathBuf,
    /// Direction towards a light in the frame of the picture (x right, y up, z to the viewer), with @I or
    /// @R,G,B for its strength or colour; may be repeated [default: -1,1,1, and none beside an environment]
    #[arg(long, value_name = "X,Y,Z[@I]", value_parser = light, allow_hyphen_values = true)]
    light: Vec<Light>,
    /// The picture to write (.png, .jpg, .tif, .exr, .pfm, .hdr); of a turntable or a sweep .png or .gif is an animation, .mp4 a film
    /// (by ffmpeg), and any other name a folder of numbered PNG files; - is standard output, as PNG
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Size of the picture in pixels
    #[arg(long, value_name = "WxH", value_parser = args::size, default_value = "800x800")]
    size: Size,
    /// Number of repetitions of the texture, along both directions or each [default: 4,2 on a sphere, 6,2 on
    /// a torus, 2,2 on cloth, otherwise 1]
    #[arg(long, value_name = "N[,M]", value_parser = tiling)]
    tiling: Option<[f64; 2]>,
    /// Position of the camera: degrees to the right, degrees up, and the distance in radii of the object
    /// [default distance: fits the object]
    #[arg(long, value_name = "AZ,EL[,DIST]", value_parser = orbit, allow_hyphen_values = true, default_value = "0,0")]
    camera: Orbit,
    /// Vertical field of view in degrees
    #[arg(long, value_name = "DEG", default_value = "30", value_parser = args::within(0.001, 179.0, "degrees"))]
    fov: f64,
    /// Show a conventional texture: one photograph under the light given here [default: 0,0,1], on a matt
    /// surface
    #[arg(long, value_name = "X,Y,Z", value_parser = args::light, num_args = 0..=1, require_equals = true,
          default_missing_value = "0,0,1")]
    plain: Option<Direction>,
    /// Strength of the highlights added from the normals of the texture, 0 to 1 [default: 0.04; 0 for textures of light and
    /// view, whose functions hold their highlights]
    #[arg(long, value_name = "S")]
    specular: Option<f64>,
    /// Roughness of the highlights, 0.05 to 1
    #[arg(long, value_name = "R", default_value_t = Specular::default().roughness)]
    roughness: f64,
    /// N x N samples per pixel
    #[arg(long, value_name = "N", default_value_t = 3)]
    samples: usize,
    /// Colour behind the object, sRGB from 0 to 1
    #[arg(long, value_name = "R,G,B", value_parser = color, default_value = "0,0,0")]
    background: [f32; 3],
    /// Leave out the shadows that the object casts on itself
    #[arg(long)]
    no_cast_shadows: bool,
    #[command(flatten)]
    motion: motion::MotionArgs,
    #[command(flatten)]
    environment: environment::SceneArgs,
    #[command(flatten)]
    relief: relief::ReliefArgs,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

/// The position of a camera in degrees and radii.
#[derive(Debug, Clone, Copy)]
struct Orbit {
    azimuth_deg: f64,
    elevation_deg: f64,
    distance_radii: Option<f64>,
}

fn light(text: &str) -> Result<Light, String> {
    let (direction, strength) = text.split_once('@').unwrap_or((text, "1"));
    let wrong = "expected X,Y,Z, X,Y,Z@INTENSITY or X,Y,Z@R,G,B";
    let [x, y, z] = args::numbers(direction).ok_or(wrong)?;
    let color = args::numbers(strength).or_else(|| args::numbers(strength).map(|[i]| [i; 3])).ok_or(wrong)?;
    if color.iter().any(|c| !Light::COMPONENTS.contains(c)) {
        return Err(format!("expected intensities from 0 to {}", Light::COMPONENTS.end()));
    }
    let direction = Direction::new(x, y, z).map_err(|e| e.to_string())?;
    Ok(Light { direction, color: color.map(|c| c as f32) })
}

fn tiling(text: &str) -> Result<[f64; 2], String> {
    let both = || args::numbers(text).map(|[n]| [n; 2]);
    args::numbers(text).or_else(both).ok_or_else(|| "expected one or two numbers such as 4,2".to_owned())
}

fn orbit(text: &str) -> Result<Orbit, String> {
    let far = args::numbers(text).map(|[a, e, d]| (a, e, Some(d)));
    let found = far.or_else(|| args::numbers(text).map(|[a, e]| (a, e, None)));
    let (azimuth_deg, elevation_deg, distance_radii) =
        found.ok_or("expected two or three numbers such as 30,20 or 30,20,4")?;
    Ok(Orbit { azimuth_deg, elevation_deg, distance_radii })
}

fn color(text: &str) -> Result<[f32; 3], String> {
    let color = args::numbers(text).filter(|color: &[f64; 3]| color.iter().all(|c| (0.0..=1e3).contains(c)));
    let color = color
        .ok_or("expected red, green and blue from 0 (black) over 1 (white) to 1000, such as 0.1,0.1,0.1")?;
    Ok(color.map(|c| Space::Srgb.to_linear(c as f32)))
}

/// Reads texture and mesh, renders, writes.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let primitive = args.mesh.to_str().and_then(Primitive::from_name);
    let mut options = options(args, primitive);
    if !args.environment.is_given() {
        options.validate()?;
    }
    let more = args.relief.file().into_iter().chain(args.environment.file());
    let inputs: Vec<&Path> = [&*args.file, &*args.mesh].into_iter().chain(more).collect();
    let place = RenderOutput::claim(args, &inputs, context)?;
    let job = &context.job;
    let object = if primitive.is_none() { Some(read_mesh(&args.mesh, job)?) } else { None };
    options.environment = args.environment.read(job)?;
    options.validate()?;
    let Texture { field, source, of_model } = args.evaluated.texture_of(&args.file, job)?;
    if args.tiling.is_none() {
        options.tiling = as_large(options.tiling, source, field.size());
    }
    place.check_memory(args, job)?;
    let mesh = object.unwrap_or_else(|| {
        let [across, down] = options.tiling;
        let (width, height) = (field.size().width as f64, field.size().height as f64);
        primitive.expect("an object that is no file").mesh_with_aspect(across * width / (down * height))
    });
    let relief = args.relief.read(&args.evaluated, (&args.file, field.size(), of_model), job)?;
    let has_highlights = field.basis().depends_on_view() && args.specular.is_none();
    let shiny = args.plain.is_none() && !has_highlights && options.specular.strength > 0.0;
    let normals = shiny.then(|| surface::normals(&field));
    let normals = normals.as_ref();
    let (relief, fitted) = relief.map_or((None, None), |(relief, fitted)| (Some(relief), fitted));
    let relief = relief.as_ref();
    let written = place.write(args, context, |frame| {
        let options = args.motion.at(frame, args, &options);
        render::render_relief(&field, normals, relief, &mesh, &options, job)
    })?;
    Ok(report(args, &mesh, &options, relief).with_outputs(written).with_warnings(fitted))
}

/// Where the picture or the film goes.
enum RenderOutput<'a> {
    Still(PictureFormat, Outputs),
    Film(Film<'a>),
}

impl<'a> RenderOutput<'a> {
    fn claim(args: &'a Args, inputs: &[&Path], context: &Context) -> Result<Self> {
        if args.motion.frames().is_some() {
            return Film::claim(&args.output, inputs, args.motion.film(), context).map(Self::Film);
        }
        args.motion.refuse_rate()?;
        let format = if output::is_stream(&args.output) {
            PictureFormat::Png(Depth::Eight)
        } else {
            PictureFormat::from_path(&args.output)?
        };
        let mut outputs = Outputs::new(context);
        outputs.file(&args.output, inputs)?;
        Ok(Self::Still(format, outputs))
    }

    fn check_memory(&self, args: &Args, job: &Job) -> Result<()> {
        let Self::Still(format, _) = self else { return Ok(()) };
        let pixels = Footprint::of_texels(args.size, 12, 12).then(format.footprint(args.size, 3));
        job.check_bytes("the picture and its file", pixels.peak)
    }

    /// Makes and writes the frames, of which a picture has one.
    fn write(
        self,
        args: &Args,
        context: &Context,
        mut make: impl FnMut(usize) -> Result<Picture>,
    ) -> Result<Vec<PathBuf>> {
        match self {
            Self::Still(format, mut outputs) => {
                outputs.write(&args.output, encode_picture_with(&make(0)?, format, &context.job)?)?;
                outputs.commit()
            }
            Self::Film(film) => {
                let frames = args.motion.frames().expect("a film has frames");
                film.write(FilmShape { frames, size: args.size, channels: 3 }, context, make)
            }
        }
    }
}

/// The tiling that shows the features of a model's tile as large as `tiling` shows those of its source,
/// rounded to whole repeats.
fn as_large(tiling: [f64; 2], source: Size, made: Size) -> [f64; 2] {
    let sides = [(source.width, made.width), (source.height, made.height)];
    std::array::from_fn(|axis| match sides[axis] {
        (source, made) if source == made => tiling[axis],
        (source, made) => (tiling[axis] * source as f64 / made as f64).round().max(1.0),
    })
}

/// The lights in the frame of the picture.
fn lights(args: &Args) -> Vec<Light> {
    if !args.light.is_empty() || args.environment.is_given() {
        return args.light.clone();
    }
    let direction = Direction::new(-1.0, 1.0, 1.0).expect("a vector with a length");
    vec![Light { direction, color: [1.0; 3] }]
}

/// Lights in the frame of the picture, as the object sees them.
fn in_world(camera: &Camera, lights: &[Light]) -> Vec<Light> {
    lights.iter().map(|light| Light { direction: camera.to_world(light.direction), ..*light }).collect()
}

fn options(args: &Args, primitive: Option<Primitive>) -> RenderOptions {
    let field_of_view_rad = args.fov.to_radians();
    let distance = args.camera.distance_radii;
    let camera = Camera {
        azimuth_rad: args.camera.azimuth_deg.to_radians(),
        elevation_rad: args.camera.elevation_deg.to_radians(),
        distance_radii: distance.unwrap_or_else(|| Camera::distance_to_fit(field_of_view_rad, args.size)),
        field_of_view_rad,
    };
    RenderOptions {
        size: args.size,
        samples: args.samples,
        camera,
        lights: in_world(&camera, &lights(args)),
        environment: None,
        tiling: args.tiling.unwrap_or(primitive.map_or([1.0; 2], Primitive::default_tiling)),
        background: args.background,
        shading: args.plain.map_or(TexelShading::Reflectance, |light| TexelShading::Plain { light }),
        specular: Specular {
            strength: args.specular.unwrap_or(Specular::default().strength),
            roughness: args.roughness,
        },
        shadows: if args.no_cast_shadows { CastShadows::Off } else { CastShadows::On },
    }
}

fn report(args: &Args, mesh: &Mesh, options: &RenderOptions, relief: Option<&MeshRelief>) -> Report {
    let lights: Vec<_> = lights(args)
        .iter()
        .map(|light| json!({ "direction": light.direction.to_array(), "color": light.color }))
        .collect();
    let text = format!(
        "{}: {}{}, {}, {}{}",
        args.output.display(),
        args.motion.frames().map_or_else(String::new, |n| format!("{}, ", counted(n, "picture"))),
        args.size,
        counted(mesh.triangles().len(), "triangle"),
        counted(lights.len(), "light"),
        if args.environment.is_given() { " and an environment" } else { "" }
    );
    let json = json!({
        "width": args.size.width,
        "height": args.size.height,
        "mesh": paths::text(&args.mesh),
        "triangles": mesh.triangles().len(),
        "tiling": options.tiling,
        "shading": if args.plain.is_some() { "plain" } else { "reflectance" },
        "lights": lights,
        "frames": args.motion.frames(),
        "environment": args.environment.described(),
        "displacement_factor": relief.map(|r| r.displacement),
        "bump_factor": relief.map(|r| r.bump),
    });
    Report::new(text, json)
}
