//! The verbs, one file each: `Args` defines the options, `run` does the work and reports.
//!
//! A verb claims its outputs ([`crate::output::Outputs`]) before it works, reads through
//! [`crate::input`], calls the library, and writes through [`crate::output`]. It prints nothing.
//! To add one: a file here, an arm in [`Verb`] and in [`run`].

mod analyze;
mod capture;
mod compare;
mod completions;
mod convert;
mod demo;
mod endless;
mod fill;
mod fit;
mod formats;
mod gallery;
mod height;
mod info;
mod lights;
mod man;
mod maps;
mod match_histogram;
mod material;
mod model;
mod new;
mod procedural;
mod relight;
mod render;
mod roll;
mod share;
mod synth;
mod tileable;
mod view;

use std::ffi::OsString;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use relume::{Error, Result};

use crate::context::{Common, Context};
use crate::report::Report;

/// Reflectance textures: fit photographs under moving light, synthesise, relight, render.
#[derive(Debug, Parser)]
#[command(name = "relume", version, max_term_width = 100, after_help = "Start with `relume demo`.")]
pub struct Cli {
    /// The common options of all verbs.
    #[command(flatten)]
    pub common: Common,
    /// The verb.
    #[command(subcommand)]
    pub verb: Verb,
}

/// The verbs of the program.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// The whole pipeline on a built-in material, with a page to look at
    Demo(demo::Args),
    /// Photograph maps or a built-in material under a virtual light dome
    Capture(capture::Args),
    /// Fill holes of a texture with copies of its own texels
    Fill(fill::Args),
    /// Fit reflectance functions to photographs under known lights
    Fit(fit::Args),
    /// Describe a texture: periods, direction, features, and possible causes of failure of a synthesis
    Analyze(analyze::Args),
    /// Measure the distance between two textures
    Compare(compare::Args),
    /// Write a texture in another format, in other functions, space or colours
    Convert(convert::Args),
    /// List what is read and written, with limits
    Formats(formats::Args),
    /// Run all methods of synthesis on a folder of exemplars and measure them, on one page
    Gallery(gallery::Args),
    /// Estimate the height map of a surface from photographs, functions or normals
    Height(height::Args),
    /// Describe the contents of a file
    Info(info::Args),
    /// Find the lamps of photographs by mirror balls beside the surface
    Lights(lights::Args),
    /// Make the height, albedo, roughness and normals of a built-in material
    Procedural(procedural::Args),
    /// Write the maps of a material under the names and in the packings of other programs
    Maps(maps::Args),
    /// Give a texture the distribution of values of another
    Match(match_histogram::Args),
    /// Model a texture as a random field: a few kilobytes for any size
    Model(model::Args),
    /// From a folder of photographs to a texture, its maps and a picture, in one command
    New(new::Args),
    /// Show a texture under a light, or a sweep of lights
    Relight(relight::Args),
    /// Show a texture on an object
    Render(render::Args),
    /// Make tiles of a regular texture that fit together in any order
    Roll(roll::Args),
    /// Make a texture of any size from a sample, or from tiles
    Synth(Box<synth::Args>),
    /// Write a page that shows textures under moving light, to put on a web server or to send
    Share(share::Args),
    /// Look at textures under moving light in the browser
    View(view::Args),
    /// Make a texture tile by refilling a band along its border
    Tileable(tileable::Args),
    /// Print shell completions
    Completions(completions::Args),
    /// Write manual pages, one for each verb
    Man(man::Args),
}

/// The program, in which the values of all options may be negative numbers.
fn program() -> clap::Command {
    with_negative_values(Cli::command())
}

fn with_negative_values(command: clap::Command) -> clap::Command {
    let allowed = |arg: clap::Arg| {
        let is_option = arg.get_action().takes_values() && !arg.is_positional();
        if is_option && !arg.is_allow_hyphen_values_set() { arg.allow_negative_numbers(true) } else { arg }
    };
    command.mut_args(allowed).mut_subcommands(with_negative_values)
}

/// The parsed command line.
///
/// # Errors
/// Words that are not understood.
pub fn parsed(typed: impl IntoIterator<Item = impl Into<OsString> + Clone>) -> Result<Cli, clap::Error> {
    let mut typed: Vec<OsString> = typed.into_iter().map(Into::into).collect();
    if let [_, help, what] = &mut typed[..]
        && help == "help"
        && (what == "--help" || what == "-h")
    {
        // The parser takes these for the name of a verb.
        *what = "help".into();
    }
    Cli::from_arg_matches(&program().try_get_matches_from(typed)?)
}

/// Runs one verb.
pub fn run(verb: Verb, context: &Context) -> Result<Report> {
    match verb {
        Verb::Demo(args) => demo::run(&args, context),
        Verb::Capture(args) => capture::run(&args, context),
        Verb::Fill(args) => fill::run(&args, context),
        Verb::Fit(args) => fit::run(&args, context),
        Verb::Analyze(args) => analyze::run(&args, context),
        Verb::Compare(args) => compare::run(&args, context),
        Verb::Convert(args) => convert::run(&args, context),
        Verb::Formats(args) => formats::run(&args),
        Verb::Gallery(args) => gallery::run(&args, context),
        Verb::Height(args) => height::run(&args, context),
        Verb::Info(args) => info::run(&args, context),
        Verb::Lights(args) => lights::run(&args, context),
        Verb::Procedural(args) => procedural::run(&args, context),
        Verb::Maps(args) => maps::run(&args, context),
        Verb::Match(args) => match_histogram::run(&args, context),
        Verb::Model(args) => model::run(&args, context),
        Verb::New(args) => new::run(&args, context),
        Verb::Relight(args) => relight::run(&args, context),
        Verb::Render(args) => render::run(&args, context),
        Verb::Roll(args) => roll::run(&args, context),
        Verb::Share(args) => share::run(&args, context),
        Verb::View(args) => view::run(&args, context),
        Verb::Synth(args) => synth::run(&args, context),
        Verb::Tileable(args) => tileable::run(&args, context),
        Verb::Completions(args) => completions::run(&args),
        Verb::Man(args) => man::run(&args, context),
    }
}

/// The verb among the words typed, also where they cannot be understood.
pub fn named(typed: &[OsString]) -> Option<String> {
    let program = Cli::command();
    let names: Vec<&str> = program.get_subcommands().map(clap::Command::get_name).collect();
    let mut words = typed.iter().skip(1).filter_map(|word| word.to_str());
    words.find(|word| names.contains(word)).map(str::to_owned)
}

/// Runs a verb as if these words followed `relume` on the command line.
fn run_typed(words: impl IntoIterator<Item: Into<OsString>>, context: &Context) -> Result<Report> {
    let typed = std::iter::once(OsString::from("relume")).chain(words.into_iter().map(Into::into));
    let cli = parsed(typed).map_err(|e| Error::usage(e.to_string()))?;
    run(cli.verb, context)
}
