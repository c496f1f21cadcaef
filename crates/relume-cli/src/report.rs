//! What a verb says when it is done: a text for people and the same as JSON.

use std::io::Write;
use std::path::PathBuf;

use relume::{Error, Result};
use serde_json::{Value, json};

use crate::context::Context;
use crate::output::is_stream;

/// The result of a verb.
#[derive(Debug)]
pub struct Report {
    /// For people; lines without a final newline.
    pub text: String,
    /// For programs.
    pub json: Value,
    /// What was written. Where standard output carries one of them, the report goes to standard error.
    pub outputs: Vec<PathBuf>,
}

impl Report {
    /// A report for standard output.
    pub fn new(text: impl Into<String>, json: Value) -> Self {
        Self { text: text.into(), json, outputs: Vec::new() }
    }

    /// Names what was written.
    #[must_use]
    pub fn with_outputs(mut self, outputs: Vec<PathBuf>) -> Self {
        self.outputs = outputs;
        self
    }

    /// Prints it as the options ask.
    pub fn print(&self, context: &Context) -> Result<()> {
        context.bar.clear();
        let line = if context.json { format!("{:#}", self.json) } else { self.text.clone() };
        if line.is_empty() {
            return Ok(());
        }
        if self.outputs.iter().any(|path| is_stream(path)) {
            eprintln!("{line}");
            return Ok(());
        }
        write_stdout(format!("{line}\n").as_bytes())
    }
}

/// Writes to standard output.
///
/// # Errors
/// Also when its reader has gone away: what it has got is cut off.
pub fn write_stdout(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(bytes).and_then(|()| stdout.flush());
    written.map_err(|error| Error::io("cannot write all of the standard output", &error))
}

/// Prints an error as one sentence on standard error, and as JSON on standard output when asked.
pub fn print_error(error: &Error, as_json: bool) {
    eprintln!("relume: {error}");
    if as_json {
        let kind = format!("{:?}", error.kind()).to_lowercase();
        let value = json!({ "error": { "kind": kind, "message": error.to_string() } });
        // The exit status already tells of the failure; a closed pipe adds nothing.
        let _ = write_stdout(format!("{value:#}\n").as_bytes());
    }
}
