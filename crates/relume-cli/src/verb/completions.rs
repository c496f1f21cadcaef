//! `relume completions`: shell completions of verbs, options and names.

use clap::CommandFactory;
use clap_complete::{Shell, generate};
use relume::Result;
use serde_json::json;

use super::Cli;
use crate::report::Report;

/// Arguments of `relume completions`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  relume completions bash > ~/.local/share/bash-completion/completions/relume\n  \
                        relume completions zsh > ~/.zfunc/_relume"
)]
pub struct Args {
    /// The shell
    shell: Shell,
}

/// The script for the shell, as the report.
pub fn run(args: &Args) -> Result<Report> {
    let mut script = Vec::new();
    generate(args.shell, &mut Cli::command(), "relume", &mut script);
    let script = String::from_utf8_lossy(&script).trim_end().to_owned();
    let json = json!({ "shell": args.shell.to_string(), "script": script });
    Ok(Report::new(script, json))
}
