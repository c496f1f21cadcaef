//! The report of a verb or of its failure: a text for people and the same as JSON.
//!
//! The JSON has one structure for all verbs, which `docs/json.md` describes field by field.

use std::io::Write;
use std::path::{Path, PathBuf};

pub use relume::words::counted;
use relume::{Error, ErrorKind, Result};
use serde_json::{Map, Value, json};

use crate::context::Context;
use crate::paths::{self, is_stream};

/// The result of a verb.
#[derive(Debug)]
pub struct Report {
    /// For people; lines without a final newline.
    pub text: String,
    /// For programs: the fields of the verb.
    pub json: Value,
    /// Possible causes of failure, a sentence each.
    pub warnings: Vec<String>,
    /// The written files. If standard output carries one of them, the report goes to standard error.
    pub outputs: Vec<PathBuf>,
}

impl Report {
    /// A report for standard output.
    pub fn new(text: impl Into<String>, json: Value) -> Self {
        Self { text: text.into(), json, warnings: Vec::new(), outputs: Vec::new() }
    }

    /// Adds the written files.
    #[must_use]
    pub fn with_outputs(mut self, outputs: Vec<PathBuf>) -> Self {
        self.outputs = outputs;
        self
    }

    /// Adds lines for people.
    #[must_use]
    pub fn with_lines(mut self, lines: &[String]) -> Self {
        for line in lines {
            self.text.push('\n');
            self.text.push_str(line);
        }
        self
    }

    /// Adds warnings.
    #[must_use]
    pub fn with_warnings(mut self, warnings: impl IntoIterator<Item = impl ToString>) -> Self {
        self.warnings.extend(warnings.into_iter().map(|warning| warning.to_string()));
        self
    }

    /// Prints it in the requested form.
    pub fn print(&self, verb: &str, context: &Context) -> Result<()> {
        context.bar.clear();
        let line =
            if context.json { format!("{:#}", self.whole(verb)) } else { paths::visible(&self.lines()) };
        if line.is_empty() {
            return Ok(());
        }
        if self.outputs.iter().any(|path| is_stream(path)) {
            write_stderr(&line);
            return Ok(());
        }
        write_stdout(format!("{line}\n").as_bytes())
    }

    fn lines(&self) -> String {
        let warnings = self.warnings.iter().map(|warning| format!("\nwarning: {warning}"));
        std::iter::once(self.text.clone()).chain(warnings).collect()
    }

    /// The common fields, and then those of the verb.
    fn whole(&self, verb: &str) -> Value {
        let mut whole = Map::new();
        whole.insert("verb".to_owned(), json!(verb));
        whole.insert("outputs".to_owned(), json!(self.outputs.iter().map(paths::text).collect::<Vec<_>>()));
        if self.outputs.iter().any(|path| path.to_str().is_none()) {
            let encoded: Vec<String> = self.outputs.iter().map(|path| paths::percent_encoded(path)).collect();
            whole.insert("outputs_percent_encoded".to_owned(), json!(encoded));
        }
        whole.insert("warnings".to_owned(), json!(self.warnings));
        for (name, value) in self.json.as_object().into_iter().flatten() {
            whole.entry(name).or_insert_with(|| value.clone());
        }
        Value::Object(whole)
    }
}

/// Writes to standard output.
///
/// # Errors
/// Also when its reader has gone away, since the output it got is incomplete.
pub fn write_stdout(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    let written = stdout.write_all(bytes).and_then(|()| stdout.flush());
    written.map_err(|error| Error::io("cannot write all of the standard output", &error))
}

/// Writes a line to standard error. Where nobody can be told, the exit status says what happened.
pub fn write_stderr(line: &str) {
    let _ = std::io::stderr().lock().write_all(format!("{line}\n").as_bytes());
}

/// The reason of a failure.
#[derive(Debug)]
pub struct Failure {
    /// The verb, if the command line names one.
    pub verb: Option<String>,
    /// The kind of the error, in one word.
    pub kind: String,
    /// One sentence.
    pub message: String,
    /// The file concerned.
    pub path: Option<PathBuf>,
    /// 1 for a failure, 2 for wrong usage.
    pub status: u8,
}

impl Failure {
    /// The failure of a verb.
    pub fn of(verb: &str, error: &Error) -> Self {
        Self {
            verb: Some(verb.to_owned()),
            kind: format!("{:?}", error.kind()).to_lowercase(),
            message: error.to_string(),
            path: error.path().map(Path::to_owned),
            status: if error.kind() == ErrorKind::Usage { 2 } else { 1 },
        }
    }

    /// Prints it as JSON on standard output. The exit status already shows the failure; a closed pipe adds
    /// nothing.
    pub fn print_json(&self) {
        let _ = write_stdout(format!("{:#}\n", self.whole()).as_bytes());
    }

    fn whole(&self) -> Value {
        let mut error = json!({ "kind": self.kind, "message": self.message, "exit_status": self.status });
        if let Some(path) = &self.path {
            error["path"] = json!(paths::text(path));
            if path.to_str().is_none() {
                error["path_percent_encoded"] = json!(paths::percent_encoded(path));
            }
        }
        json!({ "verb": self.verb, "error": error })
    }
}
