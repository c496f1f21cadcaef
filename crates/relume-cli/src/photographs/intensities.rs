//! Files with the intensities of lamps.

use std::path::Path;

use relume::{Error, Result};

/// The intensities in a text file, one or three numbers a line.
pub(super) fn intensities(path: &Path, lights: usize) -> Result<Vec<[f64; 3]>> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io("cannot read the file", &e).at(path))?;
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
        if let Some(wrong) = three.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
            return Err(Error::invalid(format!(
                "line {}: the intensity {wrong}: expected numbers above 0",
                i + 1
            ))
            .at(path));
        }
        found.push(three);
    }
    if found.len() != lights {
        return Err(Error::invalid(format!(
            "holds {} intensities for {lights} lights: expected a line for each",
            found.len()
        ))
        .at(path));
    }
    Ok(found)
}
