//! `relume relight`: pictures of a texture under chosen lights, its normals, its albedo.

use std::path::{Path, PathBuf};

use relume::direction::Directions;
use relume::field::Basis;
use relume::format::{Depth, PictureFormat, encode_normals, encode_picture_with};
use relume::render::{Sweep, relight_under};
use relume::surface::NormalDoubt;
use relume::workflow::{Btf, Missing};
use relume::{Direction, Error, Footprint, Job, ReflectanceField, Result, Size};
use serde_json::json;

use crate::context::Context;
use crate::film::{Film, FilmArgs, FilmShape};
use crate::output::Outputs;
use crate::report::{Report, counted};
use crate::{args, environment, evaluated, normals, output};

/// Arguments of `relume relight`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume relight wool.ptm --light 0.7,0.3,0.6 -o wool.png\n  \
                        relume relight wool.ptm --sweep orbit:24 -o wool.gif\n  \
                        relume relight wool.ptm --env sky -o outdoors.png")]
pub struct Args {
    /// A .ptm, an .exr field, a picture, or a .rlm model; or a folder or .zip of photographs under light and view; - is
    /// standard input
    file: PathBuf,
    #[command(flatten)]
    what: What,
    /// Direction towards the viewer, for textures of light and view [default: straight above]
    #[arg(long, value_name = "X,Y,Z", value_parser = args::view, allow_hyphen_values = true)]
    view: Option<Direction>,
    /// The light of --view-sweep [default: 0.5,0.5,0.7]
    #[arg(long, value_name = "X,Y,Z", value_parser = args::light, allow_hyphen_values = true)]
    sweep_light: Option<Direction>,
    /// The picture to write (.png, .jpg, .tif, .exr, .pfm, .hdr); for a sweep .png or .gif is an animation,
    /// .mp4 a film (by ffmpeg), and any other name a folder of numbered PNG files; - is standard output, as PNG
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    adjustment: environment::Adjustment,
    #[command(flatten)]
    normal_maps: normals::Args,
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    evaluated: evaluated::Args,
}

#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct What {
    /// Direction towards the light: x right, y up, z to the viewer, of any length
    #[arg(long, value_name = "X,Y,Z", value_parser = args::light, allow_hyphen_values = true)]
    light: Option<Direction>,
    /// N lights in a circle (orbit:N) or over the zenith from left to right (arc:N)
    #[arg(long, value_name = "PATH:N")]
    sweep: Option<Sweep>,
    /// N views on the same paths, of a texture of light and view; --sweep-light is the light
    #[arg(long, value_name = "PATH:N")]
    view_sweep: Option<Sweep>,
    /// Light from all around: an equirectangular map (.hdr, .exr or any picture), or sky, which is built in; the
    /// texture faces the edges of the map
    #[arg(long, value_name = "MAP")]
    env: Option<PathBuf>,
    /// Write the surface normals instead: 0..1 in integer files, -1..1 in EXR
    #[arg(long)]
    normals: bool,
    /// Write the colour of the texture without its shading instead: each texel at its brightest
    #[arg(long)]
    albedo: bool,
}

/// Reads the field, makes the pictures, writes them.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    if args.sweep_light.is_some() && args.what.view_sweep.is_none() {
        return Err(Error::usage(
            "--sweep-light is the light of --view-sweep, which is not given: leave it out",
        ));
    }
    if Btf::is_at(&args.file) {
        return of_photographs(args, context);
    }
    if let Some(directions) = sweep_directions(args)? {
        return run_sweep(args, &directions, context);
    }
    refuse_rate(args, "one picture")?;
    let format = still_format(&args.output)?;
    let mut outputs = Outputs::new(context);
    let inputs: Vec<&Path> =
        [&*args.file].into_iter().chain(environment::file(args.what.env.as_ref())).collect();
    outputs.file(&args.output, &inputs)?;
    let view = args.view.unwrap_or(Direction::ZENITH);
    let (bytes, still) = match args.what.light {
        Some(light) => lit(args, Directions { light, view }, format, context)?,
        None => unlit(args, format, context)?,
    };
    outputs.write(&args.output, bytes)?;
    let written = outputs.commit()?;
    let Still { what, size, warnings } = still;
    let y = args.what.normals.then(|| args.normal_maps.of_output(&args.output));
    let text = format!("{}: {what}, {size}", args.output.display());
    let json = json!({
        "what": what,
        "width": size.width,
        "height": size.height,
        "light": args.what.light.map(Direction::to_array),
        "view": args.what.light.map(|_| view.to_array()),
        "normal_y": y,
        "environment": args.what.env.as_ref().map(|map| environment::described(map, &args.adjustment)),
    });
    Ok(Report::new(text, json).with_outputs(written).with_warnings(warnings))
}

/// What is said of one picture.
struct Still {
    what: String,
    size: Size,
    warnings: Vec<String>,
}

/// The picture for a light and a view.
fn lit(args: &Args, pair: Directions, format: PictureFormat, context: &Context) -> Result<(Vec<u8>, Still)> {
    let job = &context.job;
    let texture = args.evaluated.shown(&args.file, job)?;
    check_view(args, texture.basis_of_one_view())?;
    let (size, channels) = (texture.size(), texture.channels());
    foresee(size, channels, channels, format, context)?;
    let bytes = encode_picture_with(&texture.pictures(job)?.picture(pair, job)?, format, job)?;
    Ok((bytes, Still { what: "picture".to_owned(), size, warnings: Vec::new() }))
}

/// The picture under an environment, the normals, or the albedo.
fn unlit(args: &Args, format: PictureFormat, context: &Context) -> Result<(Vec<u8>, Still)> {
    let job = &context.job;
    if args.what.env.is_some() {
        let field = args.evaluated.texture(&args.file, job)?;
        check_view(args, Some(field.basis()).filter(|basis| !basis.depends_on_view()))?;
        foresee(field.size(), 3, 3, format, context)?;
        let bytes = under_environment(args, &field, format, job)?;
        return Ok((bytes, Still { what: "picture".to_owned(), size: field.size(), warnings: Vec::new() }));
    }
    let texture = args.evaluated.shown(&args.file, job)?;
    check_view(args, texture.basis_of_one_view())?;
    let (size, channels) = (texture.size(), texture.channels());
    // Normals and a packed copy of them.
    let (planes, channels, stored) = match args.what.normals {
        true => (6, 3, format.with_depth(Depth::Sixteen)),
        false => (channels, channels, format),
    };
    foresee(size, planes, channels, stored, context)?;
    let surface = texture.into_surface(job)?;
    if !args.what.normals {
        let bytes = encode_picture_with(&surface.albedo(), format, job)?;
        return Ok((bytes, Still { what: "albedo".to_owned(), size, warnings: Vec::new() }));
    }
    let (found, y) =
        (surface.normals().map_err(|e| e.at(&args.file))?, args.normal_maps.of_output(&args.output));
    let warnings = doubted(&surface.doubts(&found));
    Ok((encode_normals(&found, y, format, job)?, Still { what: normals::described(y), size, warnings }))
}

/// A picture from photographs under light and view, without a fit.
fn of_photographs(args: &Args, context: &Context) -> Result<Report> {
    let Some(light) = args.what.light else {
        return Err(Error::usage(
            "photographs under light and view are shown for one --light (and --view); `relume fit` makes a texture of them \
             for everything else",
        )
        .at(&args.file));
    };
    let format = still_format(&args.output)?;
    let mut outputs = Outputs::new(context);
    outputs.file(&args.output, &[&args.file])?;
    let view = args.view.unwrap_or(Direction::ZENITH);
    let btf = Btf::open(&args.file, Missing::Fill, &context.job)?;
    let absent =
        btf.list().absent().map(|absent| format!("{absent}: their values are interpolated from the others"));
    let picture = btf.relit(Directions { light, view }, &context.job)?;
    let (size, channels) = (picture.size(), picture.planes.count());
    context.job.check_bytes("the picture's file", format.footprint(size, channels).peak)?;
    outputs.write(&args.output, encode_picture_with(&picture, format, &context.job)?)?;
    let written = outputs.commit()?;
    let text = format!("{}: picture, {size}, from photographs", args.output.display());
    let json = json!({
        "what": "picture",
        "width": size.width,
        "height": size.height,
        "light": light.to_array(),
        "view": view.to_array(),
    });
    Ok(Report::new(text, json).with_outputs(written).with_warnings(absent))
}

/// The light and view of each picture of a sweep, if one is asked for.
fn sweep_directions(args: &Args) -> Result<Option<Vec<Directions>>> {
    if let Some(sweep) = args.what.sweep {
        let view = args.view.unwrap_or(Direction::ZENITH);
        let lights = sweep.directions().into_iter();
        return Ok(Some(lights.map(|light| Directions { light, view }).collect()));
    }
    let Some(sweep) = args.what.view_sweep else { return Ok(None) };
    if args.view.is_some() {
        return Err(Error::usage("--view-sweep moves the view: leave out --view"));
    }
    let light = args.sweep_light.map_or_else(|| Direction::new(0.5, 0.5, 0.7), Ok)?;
    let views = sweep.directions().into_iter();
    Ok(Some(views.map(|view| Directions { light, view }).collect()))
}

/// Refuses a rate of frames where there is no animation.
fn refuse_rate(args: &Args, what: &str) -> Result<()> {
    match args.film.fps {
        Some(_) => {
            Err(Error::usage(format!("--fps is of an animation, and {what} is written: leave it out")))
        }
        None => Ok(()),
    }
}

/// Refuses a view of a texture whose functions are those of one view.
fn check_view(args: &Args, of_one_view: Option<&Basis>) -> Result<()> {
    let asked = args.view.is_some() || args.what.view_sweep.is_some();
    if let Some(basis) = of_one_view.filter(|_| asked) {
        return Err(Error::usage(format!(
            "the functions of this texture ({}) are those of one view, and a view makes no difference: fit photographs of \
             light and view for one that has it",
            basis.name()
        ))
        .at(&args.file));
    }
    if args.view.is_some() && args.what.light.is_none() && args.what.sweep.is_none() {
        return Err(Error::usage("--view is of a picture or a sweep: give also --light or --sweep"));
    }
    Ok(())
}

/// The picture under an environment.
fn under_environment(
    args: &Args,
    field: &ReflectanceField,
    format: PictureFormat,
    job: &Job,
) -> Result<Vec<u8>> {
    let map = args.what.env.as_deref().expect("asked for an environment");
    let environment = environment::read(map, &args.adjustment, job)?;
    let picture = relight_under(field, &environment, job).map_err(|e| e.at(&args.file))?;
    drop(environment);
    encode_picture_with(&picture, format, job)
}

/// What is said of normals that are not to be trusted.
fn doubted(doubts: &[NormalDoubt]) -> Vec<String> {
    let reasons: Vec<String> = doubts.iter().map(ToString::to_string).collect();
    let warning = format!(
        "these normals are not to be trusted: {}; `relume height PHOTOGRAPHS -o height.exr --normals FILE` finds \
         better ones from the photographs",
        reasons.join("; ")
    );
    if reasons.is_empty() { Vec::new() } else { vec![warning] }
}

/// Refuses a picture that cannot be made, in so many planes, and written within the memory.
fn foresee(
    size: Size,
    planes: usize,
    channels: usize,
    format: PictureFormat,
    context: &Context,
) -> Result<()> {
    let made = Footprint::of_texels(size, 4 * planes as u64, 4 * planes as u64);
    context.job.check_bytes("the picture and its file", made.then(format.footprint(size, channels)).peak)
}

fn still_format(path: &Path) -> Result<PictureFormat> {
    if output::is_stream(path) {
        Ok(PictureFormat::Png(Depth::Eight))
    } else {
        PictureFormat::from_path(path)
    }
}

fn run_sweep(args: &Args, directions: &[Directions], context: &Context) -> Result<Report> {
    let film = Film::claim(&args.output, &[&args.file], &args.film, context)?;
    let texture = args.evaluated.shown(&args.file, &context.job)?;
    check_view(args, texture.basis_of_one_view())?;
    let shape = FilmShape { frames: directions.len(), size: texture.size(), channels: texture.channels() };
    let pictures = texture.pictures(&context.job)?;
    let written = film.write(shape, context, |i| pictures.picture(directions[i], &context.job))?;
    let arrays = |of: fn(&Directions) -> Direction| -> Vec<[f64; 3]> {
        directions.iter().map(|pair| of(pair).to_array()).collect()
    };
    let text =
        format!("{}: {}, {}", args.output.display(), counted(directions.len(), "picture"), texture.size());
    let json = json!({
        "what": "sweep",
        "width": texture.size().width,
        "height": texture.size().height,
        "lights": arrays(|pair| pair.light),
        "views": arrays(|pair| pair.view),
    });
    Ok(Report::new(text, json).with_outputs(written))
}
