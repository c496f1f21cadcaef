//! The program `relume`: reads the command line, runs one verb, prints its report.
//!
//! Every verb is a file in `verb/`: checked arguments go in, a [`report::Report`] comes out.
//! Outputs appear whole or not at all ([`output`]). Exit status: 0 done, 1 failure, 2 wrong usage.

mod args;
mod clock;
mod context;
mod evaluated;
mod gathered;
mod input;
mod normals;
mod output;
mod paths;
mod progress;
mod rearranged;
mod report;
mod signals;
mod verb;

use std::process::ExitCode;

use clap::Parser;
use relume::{Cancel, Error, ErrorKind};

use context::Context;
use verb::Cli;

fn main() -> ExitCode {
    let cli = Cli::parse();
    let json = cli.common.json;
    let result = watch().and_then(|cancel| Context::new(cli.common, cancel)).and_then(|context| {
        let report = verb::run(cli.verb, &context)?;
        report.print(&context)
    });
    signals::end_if_received();
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            report::print_error(&error, json);
            exit_code(&error)
        }
    }
}

/// What signals tell the work to stop by.
fn watch() -> relume::Result<Cancel> {
    let cancel = Cancel::default();
    let told = cancel.clone();
    signals::watch(move || told.cancel()).map_err(|e| Error::io("cannot watch for signals", &e))?;
    Ok(cancel)
}

fn exit_code(error: &Error) -> ExitCode {
    ExitCode::from(if error.kind() == ErrorKind::Usage { 2 } else { 1 })
}
