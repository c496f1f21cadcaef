//! Names of textures for people, by which the page tells them apart.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use relume::{Error, Result};

use crate::paths;

/// Textures of a page, whose addresses have their numbers.
const MOST_TEXTURES: usize = 16;

/// The names of files without their extensions; those that are equal with their extensions, or folders, or numbers.
///
/// # Errors
/// More files than a page shows.
pub fn titles(files: &[PathBuf]) -> Result<Vec<String>> {
    if files.len() > MOST_TEXTURES {
        let count = files.len();
        return Err(Error::usage(format!(
            "{count} textures are given, and a page shows {MOST_TEXTURES}: make several pages"
        )));
    }
    let stems: Vec<String> = files.iter().map(|path| named(path.file_stem())).collect();
    let title = |i: usize| {
        let equal: Vec<usize> = (0..files.len()).filter(|&k| stems[k] == stems[i]).collect();
        if equal.len() == 1 {
            return stems[i].clone();
        }
        let number = equal.iter().position(|&k| k == i).map_or(0, |place| place + 1);
        let ways: [&dyn Fn(usize) -> String; 2] =
            [&|k| named(files[k].file_name()), &|k| format!("{} ({})", stems[k], folder_name(&files[k]))];
        let telling = ways.iter().find(|way| {
            let mut names: Vec<String> = equal.iter().map(|&k| way(k)).collect();
            names.sort();
            names.windows(2).all(|pair| pair[0] != pair[1])
        });
        telling.map_or_else(|| format!("{} ({number})", stems[i]), |way| way(i))
    };
    Ok((0..files.len()).map(title).collect())
}

fn named(part: Option<&OsStr>) -> String {
    part.map_or_else(|| "texture".to_owned(), paths::text)
}

fn folder_name(path: &Path) -> String {
    let folder = crate::output::folder_of(path);
    let folder = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    folder.file_name().map_or_else(|| paths::text(&folder), paths::text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(files: &[&str]) -> Vec<String> {
        titles(&files.iter().map(PathBuf::from).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn textures_with_equal_names_are_told_apart() {
        assert_eq!(of(&["a/wool.ptm", "b/silk.ptm"]), ["wool", "silk"]);
        assert_eq!(of(&["a/wool.ptm", "silk.ptm", "a/wool.exr"]), ["wool.ptm", "silk", "wool.exr"]);
        assert_eq!(of(&["a/wool.ptm", "b/wool.ptm"]), ["wool (a)", "wool (b)"]);
        assert_eq!(of(&["a/wool.ptm", "b/wool.ptm", "b/wool.ptm"]), ["wool (1)", "wool (2)", "wool (3)"]);
    }

    #[test]
    fn more_textures_than_a_page_shows_are_counted() {
        let error = titles(&vec![PathBuf::from("a.ptm"); 17]).unwrap_err().to_string();
        assert!(error.contains("17 textures") && error.contains("16"), "{error}");
    }
}
