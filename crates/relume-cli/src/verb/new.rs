//! `relume new`: from a folder of photographs to a texture, its maps and a first picture, by the verbs of the program.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use relume::capture::balls::{MirrorBall, drawn, find_lights, lights_of};
use relume::capture::{Capture, holds_light_file, lp, pictures_in};
use relume::field::{Basis, PlaneLayout};
use relume::format::{Depth, PictureFormat, encode_picture_with};
use relume::surface::highlights::LEAST_LIGHTS;
use relume::surface::integrate::SurfaceBorder;
use relume::workflow::share::check_share_memory;
use relume::{Direction, Error, Footprint, Named, Result, Samples, Space};
use serde_json::{Map, Value, json};

use super::height::SurfaceFiles;
use super::lights::ball;
use crate::context::Context;
use crate::output::Folder;
use crate::photographs::{PhotographArgs, PhotographSet};
use crate::report::{Report, counted};
use crate::{input, paths};

/// Arguments of `relume new`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  relume new photographs -o coin\n  \
    relume new photographs -o coin --ball 385,346,260 --crop 700,0,2000,2000 --align --equalize\n\n\
    The folder holds the photographs and their .lp, .relight or .dome file; without one, the lamps are found by mirror \
    balls. Photographs that a matt surface explains clearly better as linear are read so, with a warning; --input-space \
    declares it.")]
pub struct Args {
    /// The folder of photographs, or their light file
    photographs: PathBuf,
    /// The folder to write: lights.lp, texture.ptm, texture.exr, report.html on its quality, page.html to look at it,
    /// normals_gl.png, albedo.png, height.exr, relit.png, under 12 far lamps or more roughness.png, and, where balls were found,
    /// balls.png
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,
    /// The outline of a mirror ball, as for `relume lights`; may be given several times
    #[arg(long, value_name = "X,Y,R", value_parser = ball)]
    ball: Vec<MirrorBall>,
    /// A picture of which the bright pixels belong to the surface. Its size is that of the photographs, with which it is cropped
    /// and reduced, or of what is left of them
    #[arg(long, value_name = "FILE")]
    mask: Option<PathBuf>,
    #[command(flatten)]
    development: PhotographArgs,
}

/// With this many lights nine harmonics are determined well, and fit gloss and shadows better than six polynomials.
const HARMONIC_LIGHTS: usize = 16;

/// Runs all steps.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    let read = inputs(args);
    let read: Vec<&Path> = read.iter().map(PathBuf::as_path).collect();
    let folder = Folder::stage(&args.output, &read, context)?;
    let scratch = folder.scratch()?;
    let mut warnings = Vec::new();
    let (mut light_file, mut shown, mut done) =
        (args.photographs.clone(), args.photographs.clone(), Vec::new());
    if !args.ball.is_empty() || needs_balls(&args.photographs) {
        light_file = scratch.path().join("lights.lp");
        let skips = by_balls(args, &folder, &light_file, &mut warnings, context)?;
        let place = folder_of(&args.photographs);
        shown = free_light_file(&place);
        done.push(lights_command(args, &place, &shown, skips));
    }
    let lights = Capture::open_paired(&light_file, args.development.pair.unwrap_or_default())?.lights();
    folder.add("lights.lp", lp::format(&lights)?.as_bytes())?;
    let stored = as_stored(args, &light_file, context)?;
    let has_roughness = lights.len() >= LEAST_LIGHTS && args.development.surface_mm.is_none();
    foresee(args, &stored, has_roughness.then_some("roughness.png"), context)?;
    let options = options(args, &stored, &mut warnings, context)?;
    let mut steps =
        Steps { args, light_file: &light_file, shown: &shown, folder: &folder, context, done, warnings };
    let directions: Vec<Direction> = lights.iter().map(|(_, light)| *light).collect();
    let mut facts = Map::new();
    facts.insert("lights".to_owned(), json!(lights.len()));
    match relume::fit::check_lights(&Basis::Ptm, &directions) {
        Ok(()) => {
            let fit = steps.run("fit LIGHTS -o DIR/texture.ptm --report DIR/report.html", &options)?;
            facts.insert("fit".to_owned(), fit["report"]["error"].clone());
            if lights.len() >= HARMONIC_LIGHTS
                && Basis::from_name("hsh9")
                    .is_some_and(|basis| relume::fit::check_lights(&basis, &directions).is_ok())
            {
                steps.run("fit LIGHTS -o DIR/texture.exr --basis hsh9 --half", &options)?;
            }
            steps.run("relight DIR/texture.ptm --light -0.55,0.5,0.67 -o DIR/relit.png", &[])?;
            let title =
                args.output.file_name().map(|name| format!("--title={}", name.to_string_lossy()).into());
            let page = "share DIR/texture.ptm --single-file -o DIR/page.html";
            steps.run(page, &Vec::from_iter(title))?;
        }
        Err(reason) => {
            steps.warn(format!("no texture of functions, only maps: {}", reason.message()));
        }
    }
    let height = "height LIGHTS -o DIR/height.exr --normals DIR/normals_gl.png --albedo-map DIR/albedo.png";
    let height =
        if has_roughness { format!("{height} --roughness-map DIR/roughness.png") } else { height.to_owned() };
    let height = steps.run(&height, &options)?;
    facts.insert("height".to_owned(), json!([height["lowest_texels"], height["highest_texels"]]));
    let Steps { done: commands, warnings, .. } = steps;
    facts.insert("commands".to_owned(), json!(commands));
    drop(scratch);
    folder.add("new.json", format!("{:#}\n", Value::Object(facts.clone())).as_bytes())?;
    let written = folder.commit()?;
    let photographs = counted(lights.len(), "photograph");
    let text = format!("{}: {photographs}\n{}", args.output.display(), commands.join("\n"));
    Ok(Report::new(text, Value::Object(facts)).with_outputs(written).with_warnings(warnings))
}

/// All that is read: the files, and the folders of photographs.
fn inputs(args: &Args) -> Vec<PathBuf> {
    let named = std::iter::once(&args.photographs).chain(&args.mask).cloned();
    let listed = Capture::open_paired(&args.photographs, args.development.pair.unwrap_or_default());
    let photographs = listed.into_iter().flat_map(|capture| capture.photographs).map(|one| one.path);
    let with_folder = |path: PathBuf| [folder_of(&path), path];
    named.chain(args.development.files()).chain(photographs.flat_map(with_folder)).collect()
}

/// The photographs of the surface as they are stored: nothing is measured in all of them.
fn as_stored(args: &Args, light_file: &Path, context: &Context) -> Result<PhotographSet> {
    let PhotographArgs { pair, orientation, crop, reduce, .. } = args.development;
    let part = PhotographArgs { pair, orientation, crop, reduce, ..PhotographArgs::default() };
    PhotographSet::open(light_file, &part, None, &context.job)
}

/// Refuses, before the first step works, what a later one would refuse for want of memory. `roughness` is the name of its
/// map, if there will be one.
fn foresee(args: &Args, stored: &PhotographSet, roughness: Option<&str>, context: &Context) -> Result<()> {
    let job = &context.job;
    let first = stored.photograph(0, job)?;
    let (size, channels) = (first.size(), first.channels());
    let files = SurfaceFiles {
        heights: Path::new("height.exr"),
        albedo: Some(Path::new("albedo.png")),
        normals: Some(Path::new("normals_gl.png")),
        lobes: roughness.into_iter().map(Path::new).collect(),
        border: SurfaceBorder::Open,
    };
    let planes = PlaneLayout::LRGB.planes(Basis::Ptm.len());
    let shared = || {
        let texture = Footprint::of_texels(size, 4 * planes as u64, 0).peak;
        let _texture = job.hold("the texture", texture)?;
        check_share_memory(size, planes, job)
    };
    let surface = files.check(size, channels, stored.lights().len(), job);
    surface.and_then(|()| shared()).map_err(|e| e.at(&args.photographs))
}

/// Whether a folder holds photographs and nothing that lists their lights.
fn needs_balls(photographs: &Path) -> bool {
    photographs.is_dir() && !holds_light_file(photographs)
}

/// Finds the lamps by mirror balls, and writes a light file whose names are whole paths. Whether photographs were left out.
fn by_balls(
    args: &Args,
    folder: &Folder,
    light_file: &Path,
    warnings: &mut Vec<String>,
    context: &Context,
) -> Result<bool> {
    let place = folder_of(&args.photographs);
    let job = &context.job;
    let photographs: Vec<PathBuf> =
        pictures_in(&place)?.into_iter().map(|path| std::fs::canonicalize(&path).unwrap_or(path)).collect();
    let names: Vec<String> = photographs.iter().map(paths::text).collect();
    let load = |i: usize| input::raster(&photographs[i], job);
    let found = match args.ball.as_slice() {
        [] => find_lights(&names, &load, job).map_err(|e| match e.path() {
            Some(_) => e,
            None => Error::new(e.kind(), format!("there is no light file, and {}", e.message())).at(&place),
        })?,
        balls => lights_of(&names, &load, balls, job)?,
    };
    if found.lights().len() < 3 {
        let advice = if found.lights().is_empty() { "" } else { ": at least 3 with one are needed" };
        found
            .refuse_problems()
            .map_err(|e| Error::new(e.kind(), format!("{}{advice}", e.message())).at(&place))?;
    }
    let troubles: Vec<String> = found.frames.iter().filter_map(|frame| frame.trouble()).collect();
    warnings.extend(troubles.iter().map(|trouble| format!("left out: {trouble}")));
    let outlines: Vec<String> =
        found.balls.iter().map(|b| format!("{:.1},{:.1},{:.1}", b.x, b.y, b.radius)).collect();
    if args.development.crop.is_none() {
        warnings.push(format!(
            "the texture shows the mirror balls ({}): choose the surface with --crop X,Y,W,H",
            outlines.join(" ")
        ));
    }
    std::fs::write(light_file, lp::format(&found.lights())?)
        .map_err(|e| Error::io("cannot write the lights", &e).at(light_file))?;
    let picture = drawn(&found, &load, job)?;
    folder.add("balls.png", &encode_picture_with(&picture, PictureFormat::Png(Depth::Eight), job)?)?;
    Ok(!troubles.is_empty())
}

/// The folder of the photographs.
fn folder_of(photographs: &Path) -> PathBuf {
    if photographs.is_dir() {
        return photographs.to_path_buf();
    }
    let parent = photographs.parent().filter(|parent| !parent.as_os_str().is_empty());
    parent.unwrap_or(Path::new(".")).to_path_buf()
}

/// The name of a light file that is not yet beside the photographs.
fn free_light_file(place: &Path) -> PathBuf {
    let numbered = (1..).map(|i| format!("lights_{i}.lp"));
    let mut paths = std::iter::once("lights.lp".to_owned()).chain(numbered).map(|name| place.join(name));
    paths.find(|path| !path.exists()).unwrap_or_else(|| place.join("lights.lp"))
}

/// The command that writes what [`by_balls`] found.
fn lights_command(args: &Args, place: &Path, light_file: &Path, skips: bool) -> String {
    let ball = |ball: &MirrorBall| format!(" --ball {},{},{}", ball.x, ball.y, ball.radius);
    format!(
        "relume lights {} -o {}{}{}",
        paths::shell_word(place),
        paths::shell_word(light_file),
        args.ball.iter().map(ball).collect::<String>(),
        if skips { " --skip" } else { "" }
    )
}

/// The options for all verbs that read the photographs; samples are read as what a matt surface explains better, unless
/// that is declared.
fn options(
    args: &Args,
    stored: &PhotographSet,
    warnings: &mut Vec<String>,
    context: &Context,
) -> Result<Vec<OsString>> {
    let mut development = args.development.clone();
    if development.input_space.is_none() {
        warnings.extend(stored.warnings.iter().cloned());
        // Only a clear difference is a reason to leave the convention; floats are linear in any case.
        let is_float = matches!(stored.stored(0, &context.job)?.samples(), Samples::F32(_));
        let check = if is_float { None } else { stored.check_reading(&context.job)? };
        let check = check.filter(|check| check.is_clear());
        let taken = check.map_or(Space::Srgb, |check| check.better());
        if taken == Space::Linear {
            warnings.push(
                "the photographs look linear and are read so; declare --input-space srgb if they are not"
                    .to_owned(),
            );
            development.input_space = relume::capture::develop::InputSpace::from_name(taken.name());
        }
    }
    let mask = args.mask.iter().flat_map(|mask| ["--mask".into(), mask.clone().into_os_string()]);
    Ok(development.words().into_iter().chain(mask).collect())
}

/// Commands that were run.
struct Steps<'a> {
    args: &'a Args,
    light_file: &'a Path,
    /// The light file, or the folder that has one, as a user would type it.
    shown: &'a Path,
    folder: &'a Folder,
    context: &'a Context,
    /// As a user would type them.
    done: Vec<String>,
    /// Those of all commands, each once.
    warnings: Vec<String>,
}

impl Steps<'_> {
    /// Runs a command with its placeholders filled in; returns its report for programs.
    fn run(&mut self, command: &str, options: &[OsString]) -> Result<Value> {
        let words = |folder: &Path, lights: &Path| -> Vec<OsString> {
            let fill = |word: &str| match (word, word.strip_prefix("DIR/")) {
                ("LIGHTS", _) => lights.into(),
                (_, Some(name)) => folder.join(name).into_os_string(),
                _ => word.into(),
            };
            command.split(' ').map(fill).chain(options.iter().cloned()).collect()
        };
        let report = super::run_typed(words(self.folder.path(), self.light_file), self.context)
            .map_err(|e| self.of_the_user(e))?;
        report.warnings.into_iter().for_each(|warning| self.warn(warning));
        let shown = words(&self.args.output, self.shown);
        self.done
            .push(format!("relume {}", shown.iter().map(paths::shell_word).collect::<Vec<_>>().join(" ")));
        Ok(report.json)
    }

    /// The error with a file that the user knows: a photograph, or the photographs for a file that is made on the way.
    fn of_the_user(&self, error: Error) -> Error {
        let is_known = |path: &Path| {
            !path.starts_with(self.folder.path()) && (path != self.light_file || path == self.shown)
        };
        match error.path() {
            Some(path) if is_known(path) => error,
            _ => Error::new(error.kind(), error.message()).at(&self.args.photographs),
        }
    }

    fn warn(&mut self, warning: String) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }
}
