//! A capture on disk: a light-position file and the photographs it names.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::lp::{self, Entry, excerpt};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::names::named;
use crate::stamp::Stamp;

/// The largest light file: real ones are a few kilobytes; larger files are something else.
const MAX_LIGHT_FILE_BYTES: u64 = 16 << 20;

/// Extensions taken as photographs when pairing by order, in lower case.
const PICTURE_EXTENSIONS: [&str; 6] = ["png", "jpg", "jpeg", "tif", "tiff", "exr"];

/// How lights are paired with photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Pairing {
    /// By the name in the light file: its relative path, otherwise its file name in the folder of the light
    /// file; upper and lower case are equivalent if there is no exact match.
    #[default]
    ByName,
    /// The k-th light belongs to the k-th picture of the folder, with names sorted so that numbers compare as
    /// numbers.
    ByOrder,
}

named!(Pairing { ByName => "name", ByOrder => "order" });

/// A photograph and the light it was taken under.
#[derive(Debug, Clone, PartialEq)]
pub struct Photograph {
    /// The picture file.
    pub path: PathBuf,
    /// The direction of its light.
    pub light: Direction,
}

/// Photographs of one surface from one viewpoint, each under its own light.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// The light-position file it was opened from.
    pub light_file: PathBuf,
    /// The stamp of that file.
    pub light_stamp: Stamp,
    /// In the order of the light file.
    pub photographs: Vec<Photograph>,
}

impl Capture {
    /// Opens a capture from a `.lp` file or a folder that holds exactly one. Photographs are located, not
    /// read.
    ///
    /// # Errors
    /// Everything that [`lp::parse`] refuses, a folder with no or several light files, and lights whose
    /// photograph is missing or ambiguous.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::open_paired(path, Pairing::default())
    }

    /// [`Capture::open`] with a choice of pairing.
    ///
    /// # Errors
    /// As [`Capture::open`].
    pub fn open_paired(path: impl AsRef<Path>, pairing: Pairing) -> Result<Self> {
        let path = path.as_ref();
        let light_file = if path.is_dir() { only_light_file(path)? } else { path.to_path_buf() };
        let bytes = read_light_file(&light_file)?;
        let entries = lp::parse(&bytes).map_err(|e| e.at(&light_file))?;
        let folder = match light_file.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let paths = match pairing {
            Pairing::ByName => pair_by_name(&entries, folder),
            Pairing::ByOrder => pair_by_order(&entries, folder),
        };
        let paths = paths.map_err(|e| e.at(&light_file))?;
        let pairs = paths.into_iter().zip(&entries);
        let photographs = pairs.map(|(path, entry)| Photograph { path, light: entry.light }).collect();
        Ok(Self { light_file, light_stamp: Stamp::of(&bytes), photographs })
    }

    /// The file name and the light of every photograph, as needed for a fit.
    pub fn lights(&self) -> Vec<(String, Direction)> {
        let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        self.photographs.iter().map(|p| (name(&p.path), p.light)).collect()
    }
}

fn only_light_file(folder: &Path) -> Result<PathBuf> {
    let mut found: Vec<String> =
        list(folder)?.into_iter().filter(|name| extension(name).as_deref() == Some("lp")).collect();
    match found.len() {
        1 => Ok(folder.join(found.remove(0))),
        0 => Err(Error::invalid("the folder holds no light-position file (.lp)").at(folder)),
        n => Err(Error::usage(format!(
            "the folder holds {n} light-position files ({}): name the one to use",
            listing(&found)
        ))
        .at(folder)),
    }
}

fn read_light_file(path: &Path) -> Result<Vec<u8>> {
    let io = |e: &std::io::Error| Error::io("cannot read the light file", e).at(path);
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|e| io(&e))?;
    file.take(MAX_LIGHT_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(|e| io(&e))?;
    if bytes.len() as u64 > MAX_LIGHT_FILE_BYTES {
        return Err(
            Error::limit("the file is larger than 16 MiB, so it is not a light-position file").at(path)
        );
    }
    Ok(bytes)
}

/// The names of the entries of a folder, sorted so that numbers compare as numbers.
fn list(folder: &Path) -> Result<Vec<String>> {
    let io = |e: std::io::Error| Error::io("cannot list the folder", &e).at(folder);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        names.extend(entry.map_err(io)?.file_name().into_string());
    }
    names.sort_by_cached_key(|name| natural_key(name));
    Ok(names)
}

fn extension(name: &str) -> Option<String> {
    Some(Path::new(name).extension()?.to_str()?.to_lowercase())
}

/// A key that sorts `image2` before `image10`: runs of digits by length without leading zeros, then by
/// digits; everything else by character. Ties are broken by the name itself.
fn natural_key(name: &str) -> (Vec<(usize, String)>, String) {
    let mut parts: Vec<(usize, String)> = Vec::new();
    let mut chars = name.chars().peekable();
    while let Some(c) = chars.next() {
        if !c.is_ascii_digit() {
            parts.push((usize::MAX, c.to_lowercase().collect()));
            continue;
        }
        let mut digits = String::from(c);
        while let Some(digit) = chars.next_if(char::is_ascii_digit) {
            digits.push(digit);
        }
        let value = digits.trim_start_matches('0').to_owned();
        parts.push((value.len(), value));
    }
    (parts, name.to_owned())
}

/// Finds pictures by the names of a light file.
struct Finder<'a> {
    folder: &'a Path,
    names: Vec<String>,
    by_lower_case: BTreeMap<String, Vec<usize>>,
}

impl<'a> Finder<'a> {
    fn new(folder: &'a Path) -> Result<Self> {
        let names = list(folder)?;
        let mut by_lower_case: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (i, name) in names.iter().enumerate() {
            by_lower_case.entry(name.to_lowercase()).or_default().push(i);
        }
        Ok(Self { folder, names, by_lower_case })
    }

    /// The picture of an entry, or `None`.
    fn find(&self, entry: &Entry) -> Result<Option<PathBuf>> {
        let slashed = entry.name.replace('\\', "/");
        let relative = Path::new(&slashed);
        let named = self.folder.join(relative);
        if relative.is_relative() && named.is_file() {
            return Ok(Some(named));
        }
        let file_name = slashed.rsplit('/').next().unwrap_or(&slashed);
        let candidates = self.by_lower_case.get(&file_name.to_lowercase()).map_or(&[][..], Vec::as_slice);
        let exact = candidates.iter().find(|&&i| self.names[i] == file_name);
        match (exact, candidates) {
            (Some(&i), _) | (None, &[i]) => Ok(Some(self.folder.join(&self.names[i]))),
            (None, []) => Ok(None),
            (None, several) => {
                let names: Vec<_> = several.iter().map(|&i| self.names[i].clone()).collect();
                Err(Error::invalid(format!(
                    "line {}: {} could be any of {}, which differ only in upper and lower case",
                    entry.line,
                    excerpt(&entry.name),
                    listing(&names)
                )))
            }
        }
    }
}

fn pair_by_name(entries: &[Entry], folder: &Path) -> Result<Vec<PathBuf>> {
    let finder = Finder::new(folder)?;
    let found = entries.iter().map(|entry| finder.find(entry)).collect::<Result<Vec<_>>>()?;
    if let (Some(first), true) = (entries.first(), found.iter().all(Option::is_none)) {
        return Err(Error::invalid(format!(
            "none of the {} names (the first is {}) is a file in {}: correct the names, or ask for pairing by order",
            entries.len(),
            excerpt(&first.name),
            folder.display()
        )));
    }
    let mut line_of: BTreeMap<PathBuf, usize> = BTreeMap::new();
    for (entry, path) in entries.iter().zip(&found) {
        let Some(path) = path else {
            return Err(Error::invalid(format!(
                "line {}: the photograph {} is missing from {}",
                entry.line,
                excerpt(&entry.name),
                folder.display()
            )));
        };
        if let Some(earlier) = line_of.insert(path.clone(), entry.line) {
            return Err(Error::invalid(format!(
                "lines {earlier} and {} both name {}: a photograph has one light",
                entry.line,
                path.display()
            )));
        }
    }
    Ok(found.into_iter().flatten().collect())
}

fn pair_by_order(entries: &[Entry], folder: &Path) -> Result<Vec<PathBuf>> {
    let mut names = list(folder)?;
    names.retain(|name| extension(name).is_some_and(|e| PICTURE_EXTENSIONS.contains(&e.as_str())));
    if names.len() != entries.len() {
        return Err(Error::invalid(format!(
            "{} lights cannot be paired by order with the {} pictures in {} ({}): keep only the photographs there",
            entries.len(),
            names.len(),
            folder.display(),
            listing(&names)
        )));
    }
    Ok(names.into_iter().map(|name| folder.join(name)).collect())
}

/// The first names of a list, and how many more there are.
fn listing(names: &[String]) -> String {
    let shown = names.iter().take(8).map(String::as_str).collect::<Vec<_>>().join(", ");
    if names.len() > 8 { format!("{shown} and {} more", names.len() - 8) } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with a light file `lights.lp` and empty pictures.
    fn folder(lp: &str, pictures: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("lights.lp"), lp).unwrap();
        for name in pictures {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, b"").unwrap();
        }
        folder
    }

    fn opened(folder: &tempfile::TempDir, pairing: Pairing) -> Result<Vec<String>> {
        let capture = Capture::open_paired(folder.path(), pairing)?;
        let relative = |p: &Photograph| p.path.strip_prefix(folder.path()).unwrap().display().to_string();
        Ok(capture.photographs.iter().map(relative).collect())
    }

    fn message(folder: &tempfile::TempDir, pairing: Pairing) -> String {
        opened(folder, pairing).unwrap_err().to_string()
    }

    #[test]
    fn names_are_found_through_paths_and_case() {
        let lp =
            "5\nC:\\Dome\\A.JPG 0 0 1\nsub/b.png 0 0 1\nother/c.png 0 0 1\nd e.png 0 0 1\n/abs/x/f.png 0 0 1";
        let folder = folder(lp, &["a.jpg", "sub/b.png", "b.png", "c.png", "d e.png", "f.png", "F.png"]);
        let expected = ["a.jpg", "sub/b.png", "c.png", "d e.png", "f.png"];
        assert_eq!(opened(&folder, Pairing::ByName).unwrap(), expected);
    }

    #[test]
    fn a_missing_photograph_names_the_line() {
        let folder = folder("2\na.png 0 0 1\n\nb.png 0 0 1", &["a.png"]);
        let text = message(&folder, Pairing::ByName);
        assert!(text.contains("lights.lp: line 4: the photograph b.png is missing"), "{text}");
    }

    #[test]
    fn names_that_match_nothing_need_pairing_by_order() {
        let folder = folder("3\nx1 0 0 1\nx2 1 0 1\nx3 0 1 1", &["p10.png", "p2.PNG", "p1.png", "notes.txt"]);
        let text = message(&folder, Pairing::ByName);
        assert!(text.contains("none of the 3 names") && text.contains("by order"), "{text}");
        assert_eq!(opened(&folder, Pairing::ByOrder).unwrap(), ["p1.png", "p2.PNG", "p10.png"]);
    }

    #[test]
    fn pairing_by_order_counts() {
        let folder = folder("2\nx1 0 0 1\nx2 1 0 1", &["a.png", "b.png", "mask.png"]);
        let text = message(&folder, Pairing::ByOrder);
        assert!(text.contains("2 lights") && text.contains("3 pictures"), "{text}");
    }

    #[test]
    fn ambiguity_is_refused() {
        let twice = folder("2\na.png 0 0 1\nA.PNG 1 0 1", &["a.png"]);
        assert!(message(&twice, Pairing::ByName).contains("lines 2 and 3 both name"));
        let cases = folder("1\nA.png 0 0 1", &["a.png", "a.PNG"]);
        assert!(message(&cases, Pairing::ByName).contains("could be any of"));
        let two = folder("0\n", &["more.LP"]);
        let text = message(&two, Pairing::ByName);
        assert!(text.contains("2 light-position files (lights.lp, more.LP)"), "{text}");
        let none = tempfile::tempdir().unwrap();
        assert!(message(&none, Pairing::ByName).contains("no light-position file"));
    }

    #[test]
    fn a_light_file_may_be_named_itself() {
        let folder = folder("1\na.png 0 0 1", &["a.png", "second.lp"]);
        let capture = Capture::open(&folder.path().join("lights.lp")).unwrap();
        assert_eq!(capture.lights(), [("a.png".to_owned(), Direction::ZENITH)]);
        assert!(Capture::open(&folder.path().join("absent.lp")).is_err());
    }
}
