//! Files with the intensities of lamps.

use std::path::Path;

use relume::{Error, Result};

use crate::report::counted;

/// Lamps of other intensities are mistakes: photographs divided by them would be white or black.
const LEAST: f64 = 1e-6;
const MOST: f64 = 1e6;

/// The intensities in a text file, one or three numbers a line.
pub(super) fn intensities(path: &Path, lights: usize) -> Result<Vec<[f64; 3]>> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("cannot read the file", &e).at(path))?;
    let text = String::from_utf8(bytes).map_err(|_| {
        Error::invalid(
            "is not a text: expected a line for each light, an intensity or those of red, green and blue",
        )
        .at(path)
    })?;
    let mut found = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let numbers: Option<Vec<f64>> = line.split_whitespace().map(|word| word.parse().ok()).collect();
        let three = match numbers.as_deref() {
            Some(&[one]) => [one; 3],
            Some(&[r, g, b]) => [r, g, b],
            _ => {
                return Err(Error::invalid(format!(
                    "line {}: expected an intensity, or those of red, green and blue, found `{}`",
                    i + 1,
                    line.chars().take(60).collect::<String>()
                ))
                .at(path));
            }
        };
        if let Some(wrong) = three.iter().find(|v| !(LEAST..=MOST).contains(*v)) {
            return Err(Error::invalid(format!(
                "line {}: the intensity {wrong}: expected numbers above 0, from {LEAST} to {MOST}",
                i + 1
            ))
            .at(path));
        }
        found.push(three);
    }
    if found.len() != lights {
        return Err(Error::invalid(format!(
            "holds {} for {}: expected a line for each light",
            if found.len() == 1 { "1 intensity".to_owned() } else { format!("{} intensities", found.len()) },
            counted(lights, "light")
        ))
        .at(path));
    }
    Ok(found)
}
