//! `relume man`: manual pages, one for the program and one for each verb.

use std::path::PathBuf;

use clap::CommandFactory;
use relume::{Error, Result};
use serde_json::json;

use super::Cli;
use crate::context::Context;
use crate::output::{Outputs, is_stream};
use crate::report::Report;

/// Arguments of `relume man`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume man ~/.local/share/man/man1\nthen: man relume-synth")]
pub struct Args {
    /// The folder to write: relume.1 and relume-VERB.1 for each verb
    folder: PathBuf,
}

/// Writes the pages.
pub fn run(args: &Args, context: &Context) -> Result<Report> {
    if is_stream(&args.folder) {
        return Err(Error::usage("the pages are a folder of files: name one instead of -"));
    }
    let mut program = Cli::command();
    // Common options, names and versions reach the verbs.
    program.build();
    let verbs = program.get_subcommands().filter(|verb| verb.get_name() != "help");
    let pages: Vec<(PathBuf, clap::Command)> = std::iter::once(&program)
        .chain(verbs)
        .map(|command| {
            let name = command.get_display_name().unwrap_or(command.get_name()).to_owned();
            (args.folder.join(format!("{name}.1")), command.clone())
        })
        .collect();
    let mut outputs = Outputs::new(context);
    for (path, _) in &pages {
        outputs.file(path, &[])?;
    }
    for (path, command) in &pages {
        let mut page = Vec::new();
        let written = clap_mangen::Man::new(command.clone()).render(&mut page);
        written.map_err(|e| Error::io("cannot make the page", &e).at(path))?;
        outputs.write(path, page)?;
    }
    let text = format!("{}: {} pages", args.folder.display(), pages.len());
    Ok(Report::new(text, json!({ "pages": pages.len() })).with_outputs(outputs.commit()?))
}
