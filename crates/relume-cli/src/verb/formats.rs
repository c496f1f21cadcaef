//! `relume formats`: what is read and written.

use std::fmt::Write;

use relume::Result;
use relume::format::SUPPORTED;
use serde_json::json;

use crate::report::Report;

/// Arguments of `relume formats`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  relume formats\n  relume formats --json")]
pub struct Args {}

/// Lists the formats.
pub fn run(_: &Args) -> Result<Report> {
    let mut text = String::from("files are recognised by their content, whatever their names");
    for format in SUPPORTED {
        let names = format.extensions.iter().map(|e| format!(".{e}")).collect::<Vec<_>>().join(" ");
        let _ = write!(text, "\n{} {names} ({})", format.name, format.holds);
        for (what, said) in [("reads", format.read), ("writes", format.written), ("limits", format.limits)] {
            if !said.is_empty() {
                let _ = write!(text, "\n  {what:<7} {said}");
            }
        }
    }
    Ok(Report::new(text, json!({ "formats": SUPPORTED })))
}
