//! What a verb says when it is done: a text for people and the same as JSON.

use std::io::{ErrorKind as IoErrorKind, Write};

use relume::{Error, Result};
use serde_json::{Value, json};

use crate::context::Context;

/// The result of a verb.
#[derive(Debug)]
pub struct Report {
    /// For people; lines without a final newline.
    pub text: String,
    /// For programs.
    pub json: Value,
    /// Whether standard output already carries the verb's output, so the report must not.
    pub stdout_taken: bool,
}

impl Report {
    /// A report for standard output.
    pub fn new(text: impl Into<String>, json: Value) -> Self {
        Self { text: text.into(), json, stdout_taken: false }
    }

    /// Sends the report to standard error when `taken`.
    #[must_use]
    pub fn with_stdout_taken(mut self, taken: bool) -> Self {
        self.stdout_taken = taken;
        self
    }

    /// Prints it as the options ask.
    pub fn print(&self, context: &Context) -> Result<()> {
        context.bar.clear();
        let line = if context.json { format!("{:#}", self.json) } else { self.text.clone() };
        if line.is_empty() {
            return Ok(());
        }
        if self.stdout_taken {
            eprintln!("{line}");
            return Ok(());
        }
        write_stdout(format!("{line}\n").as_bytes())
    }
}

/// Writes to standard output; a reader that has gone away is no error.
pub fn write_stdout(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(bytes).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != IoErrorKind::BrokenPipe => {
            Err(Error::io("cannot write to standard output", &error))
        }
        _ => Ok(()),
    }
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
