//! `relume demo`: the whole pipeline on a built-in material, by the verbs of the program, and pages.

mod page;
mod viewers;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use relume::capture::dome::lights;
use relume::field::Basis;
use relume::procedural::Material;
use relume::{Error, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output::Folder;
use crate::paths;
use crate::report::Report;
use page::DemoFits;

/// Arguments of `relume demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume demo -o demo\nthen open demo/index.html in a browser.")]
pub struct Args {
    /// The folder to write
    #[arg(short, long, value_name = "DIR", default_value = "relume-demo")]
    output: PathBuf,
    /// The built-in material: sponge, weave, pebbles, leather, bark, marble, wood, clouds or fire
    #[arg(long, value_name = "NAME", default_value = "sponge")]
    material: String,
    /// Number of photographs under the virtual dome
    #[arg(long, value_name = "N", default_value = "48", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    lights: u32,
}

/// The commands of the demo; DIR is the output folder, MATERIAL and N are the options.
const COMMANDS: [&str; 22] = [
    "capture MATERIAL -o DIR/capture --lights N --size 256x256 --feature 44",
    LIGHT_FIT,
    "synth DIR/small.ptm -o DIR/large.ptm --size 512x512 --tile --block 56 --overlap 14 --source-map DIR/source.npy",
    "relight DIR/small.ptm --normals -o DIR/normals_gl.png",
    "relight DIR/small.ptm --albedo -o DIR/albedo.png",
    "relight DIR/large.ptm --light -0.55,0.5,0.67 -o DIR/large.png",
    "relight DIR/small.ptm --sweep orbit:16 -o DIR/orbit.png",
    "render DIR/large.ptm --mesh sphere --light -1,0.7,0.35 --size 640x640 -o DIR/sphere.png",
    "render DIR/large.ptm --mesh sphere --light -1,0.7,0.35 --size 640x640 --plain -o DIR/sphere_plain.png",
    "render DIR/large.ptm --mesh cloth --light=-0.3,0.4,0.9 --camera 20,25 --size 640x640 -o DIR/cloth.png",
    "capture weave -o DIR/weave --lights 24 --size 256x256",
    "fit DIR/weave -o DIR/weave.ptm",
    "roll DIR/weave.ptm -k 4 -o DIR/tiles.ptm",
    "capture sponge -o DIR/noise --lights 24 --size 128x128 --feature 20",
    "fit DIR/noise -o DIR/noise.ptm --color rgb",
    "capture weave -o DIR/light_view.zip --views 25 --lights 19 --size 128x128 --feature 32",
    LIGHT_VIEW_FIT,
    "roll DIR/light_view.exr -k 4 -o DIR/light_view_tiles.exr",
    "relight DIR/light_view.exr --light 0,0.3,0.95 --view 0,0,1 -o DIR/view_above.png",
    "relight DIR/light_view.exr --light 0,0.3,0.95 --view=-0.8,0,0.6 -o DIR/view_left.png",
    "relight DIR/light_view.exr --light 0,0.3,0.95 --view 0.8,0,0.6 -o DIR/view_right.png",
    "relight DIR/light_view.exr --light 0,0.3,0.95 --view 0,-0.8,0.6 -o DIR/view_below.png",
];

/// The commands whose errors the page says.
const LIGHT_FIT: &str = "fit DIR/capture -o DIR/small.ptm";
const LIGHT_VIEW_FIT: &str = "fit DIR/light_view.zip -o DIR/light_view.exr --rank 24 --rounding 0.004";

/// The memory of the command that takes the most whatever the options, a rendering: measured.
const RENDERING_BYTES: u64 = 88 << 20;
/// The memory of fitting the photographs of 256 x 256 texels, beside their samples.
const FITTING_BYTES: u64 = 24 << 20;

/// The memory of the demo: each command would refuse only when its turn comes.
fn bytes(args: &Args) -> u64 {
    RENDERING_BYTES.max(FITTING_BYTES + u64::from(args.lights) * 256 * 256 * 3)
}

/// Runs the commands and writes the page.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    if Material::from_name(&args.material).is_none() {
        let names = Material::ALL.map(Material::name).join(", ");
        return Err(Error::usage(format!("there is no material '{}': choose one of {names}", args.material)));
    }
    context.job.check_bytes("the demo", bytes(args))?;
    relume::fit::check_lights(&Basis::Ptm, &lights(args.lights as usize))
        .map_err(|e| Error::usage(format!("--lights {}: {}", args.lights, e.message())))?;
    let folder = Folder::stage(&args.output, &[], context)?;
    let reports = COMMANDS
        .iter()
        .map(|command| {
            let done = super::run_typed(words(command, args, folder.path()), context);
            done.map_err(|error| named(&error, folder.path(), &args.output))
        })
        .collect::<Result<Vec<Report>>>()?;
    let shown: Vec<String> = COMMANDS.iter().map(|c| format!("relume {}", shown(c, args))).collect();
    let viewers = viewers::write(&folder, context)?;
    let fit = |command: &str| {
        let mut done = COMMANDS.iter().zip(&reports);
        done.find(|(c, _)| **c == command).map_or(&Value::Null, |(_, report)| &report.json["report"])
    };
    let fits = DemoFits { light: fit(LIGHT_FIT), light_view: fit(LIGHT_VIEW_FIT) };
    let page = page::write(folder.path(), args, &fits, &shown, &viewers, context)?;
    folder.add("index.html", page.as_bytes())?;
    let written = folder.commit()?;
    let index = args.output.join("index.html");
    let text = format!("{}\nOpen {} in a browser and drag the light.", shown.join("\n"), index.display());
    Ok(Report::new(text, json!({ "page": paths::text(&index), "commands": shown })).with_outputs(written))
}

/// The error of a command, with the place where its file would have been.
fn named(error: &Error, staged: &Path, output: &Path) -> Error {
    let place = |path: &Path| path.strip_prefix(staged).map_or(path.to_path_buf(), |name| output.join(name));
    let same = Error::new(error.kind(), error.message());
    error.path().map_or(same.clone(), |path| same.at(place(path)))
}

/// The words of a command with its placeholders filled in.
fn words(command: &str, args: &Args, folder: &Path) -> Vec<OsString> {
    let fill = |word: &str| match (word, word.strip_prefix("DIR/")) {
        ("MATERIAL", _) => args.material.clone().into(),
        ("N", _) => args.lights.to_string().into(),
        (_, Some(name)) => folder.join(name).into_os_string(),
        _ => word.into(),
    };
    command.split(' ').map(fill).collect()
}

/// A command as the page shows it.
fn shown(command: &str, args: &Args) -> String {
    let words = words(command, args, &args.output);
    words.iter().map(paths::text).collect::<Vec<_>>().join(" ")
}
