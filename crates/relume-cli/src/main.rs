//! The program `relume`: reads the command line, runs one verb, prints its report.
//!
//! Every verb is a file in `verb/`: checked arguments go in, a [`report::Report`] comes out. Outputs appear
//! completely or not at all ([`output`]). Exit status: 0 done, 1 failure, 2 wrong usage, 128 + n ended by
//! signal n.

mod args;
mod clock;
mod context;
mod decibels;
mod environment;
mod evaluated;
mod fault;
mod film;
mod gathered;
mod html;
mod input;
mod map_folder;
mod memory;
mod normals;
mod opacity;
mod output;
mod paths;
mod photographs;
mod progress;
mod rearranged;
mod rearranged_btf;
mod registered;
mod report;
mod signals;
mod tiling;
mod usage;
mod verb;
mod viewer;

use std::ffi::OsString;
use std::process::ExitCode;

use relume::{Cancel, Error};

use context::Context;
use report::{Failure, write_stderr};

fn main() -> ExitCode {
    memory::restrain_allocator();
    fault::keep_quiet();
    let typed: Vec<OsString> = std::env::args_os().collect();
    let status = fault::caught(|| run(&typed)).unwrap_or_else(|message| {
        let verb = verb::named(&typed);
        fail(&Failure { verb, kind: "fault".to_owned(), message, path: None, status: 1 }, &typed)
    });
    signals::end_if_received();
    ExitCode::from(status)
}

/// Runs the command line, and prints its report or the reason of a failure.
fn run(typed: &[OsString]) -> u8 {
    let cli = match verb::parsed(typed) {
        Ok(cli) => cli,
        Err(error) => return misunderstood(&error, typed),
    };
    let name = verb::named(typed).unwrap_or_default();
    let done = watch().and_then(|cancel| Context::new(cli.common, cancel)).and_then(|context| {
        let report = verb::run(cli.verb, &context)?;
        report.with_warnings(context.job.remarks()).print(&name, &context)
    });
    done.map_or_else(|error| fail(&Failure::of(&name, &error), typed), |()| 0)
}

/// Reports a failure; returns the exit status.
fn fail(failure: &Failure, typed: &[OsString]) -> u8 {
    // A command stopped by a signal has no reason of its own.
    signals::end_if_received();
    write_stderr(&format!("relume: {}", paths::on_one_line(&failure.message)));
    if asks_for_json(typed) {
        failure.print_json();
    }
    failure.status
}

/// Prints help if requested, or the error in the command line.
fn misunderstood(error: &clap::Error, typed: &[OsString]) -> u8 {
    let clear = usage::in_words(&error.to_string());
    let printed = match &clear {
        Some(text) => {
            write_stderr(text.trim_end());
            Ok(())
        }
        None => error.print(),
    };
    if !error.use_stderr() {
        // A reader that has gone away has read enough of a help.
        return match printed {
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
                write_stderr(&format!("relume: cannot write all of the standard output: {error}"));
                1
            }
            _ => 0,
        };
    }
    if asks_for_json(typed) {
        let text = clear.unwrap_or_else(|| error.to_string());
        let is_help = |line: &str| line.starts_with("Usage:") || line.starts_with("For more information");
        let said = text.lines().map(str::trim).take_while(|line| !is_help(line));
        let words: Vec<&str> = said.filter(|line| !line.is_empty()).collect();
        let message = words.join(" ").trim_start_matches("error: ").to_owned();
        let verb = verb::named(typed);
        Failure { verb, kind: "usage".to_owned(), message, path: None, status: 2 }.print_json();
    }
    2
}

/// Whether `--json` is among the options, even if they cannot be parsed.
fn asks_for_json(typed: &[OsString]) -> bool {
    typed.iter().take_while(|word| *word != "--").any(|word| word == "--json")
}

/// The cancellation flag set by signals.
fn watch() -> relume::Result<Cancel> {
    let cancel = Cancel::default();
    let told = cancel.clone();
    signals::watch(move || told.cancel()).map_err(|e| Error::io("cannot watch for signals", &e))?;
    Ok(cancel)
}
