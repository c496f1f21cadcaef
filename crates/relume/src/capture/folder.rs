//! A capture on disk: a light-position file and the photographs it names.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::finder::{Finder, is_hidden, list, listing};
use super::lp::{List, LpEntry, printable};
use super::relightlab::{self, ProjectLights};
use crate::direction::Direction;
use crate::error::{Error, Result};
use crate::names::named;
use crate::stamp::Stamp;

/// The largest light file: real ones are a few kilobytes; larger files are something else.
const MAX_LIGHT_FILE_BYTES: u64 = 16 << 20;

/// Extensions taken as photographs when pairing by order, in lower case.
const PICTURE_EXTENSIONS: [&str; 9] = ["png", "jpg", "jpeg", "tif", "tiff", "exr", "pfm", "hdr", "pic"];

/// How lights are paired with photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Pairing {
    /// By the name in the light file: its path as listed, else ever shorter tails of it in the light
    /// file's folder and, while they name a folder, in the one above; else in the one folder below,
    /// above or beside that holds them all. Upper and lower case count where both exist.
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
    /// The vector of its light as listed: a position where its length is not 1.
    pub vector: [f64; 3],
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
    /// What may surprise: photographs found in another folder, pictures without a line, a count that is not the number
    /// of lines, lights at the horizon. One sentence each.
    pub warnings: Vec<String>,
}

impl Capture {
    /// Opens a capture from a `.lp` file, a project or dome of RelightLab (`.relight`, `.dome`), or a folder that holds
    /// exactly one of them. Photographs are located, not read.
    ///
    /// # Errors
    /// Everything [`super::lp::parse`] refuses, a folder with no or several light files, and lights
    /// whose photograph is missing or not the only one.
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
        let folder = match light_file.parent() {
            Some(parent) if parent != Path::new("") => parent,
            _ => Path::new("."),
        };
        let paired = if is_project(&light_file) {
            pair_project(&bytes, folder, pairing)
        } else {
            List::parse(&bytes).and_then(|list| pair_list(&list, folder, pairing))
        };
        let Paired { pairs, mut warnings } = paired.map_err(|e| e.at(&light_file))?;
        warnings.extend(at_the_horizon(&pairs));
        let photograph =
            |(path, entry): (PathBuf, LpEntry)| Photograph { path, light: entry.light, vector: entry.vector };
        let photographs = pairs.into_iter().map(photograph).collect();
        Ok(Self { light_file, light_stamp: Stamp::of(&bytes), photographs, warnings })
    }

    /// The file name and the light of every photograph, as needed for a fit.
    pub fn lights(&self) -> Vec<(String, Direction)> {
        let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        self.photographs.iter().map(|p| (name(&p.path), p.light)).collect()
    }
}

/// Whether a folder holds a light file: a `.lp`, `.relight` or `.dome`.
pub fn holds_light_file(folder: impl AsRef<Path>) -> bool {
    let is_one = |name: &OsString| {
        let ending = extension(name).unwrap_or_default();
        !is_hidden(name) && ["lp", "relight", "dome"].contains(&ending.as_str())
    };
    list(folder.as_ref()).is_ok_and(|names| names.iter().any(is_one))
}

/// The pictures in a folder, by names in which numbers compare as numbers; hidden files are none.
///
/// # Errors
/// A folder that cannot be read, or that holds no picture.
pub fn pictures_in(folder: impl AsRef<Path>) -> Result<Vec<PathBuf>> {
    let folder = folder.as_ref();
    let names = list(folder)?.into_iter().filter(|name| is_picture(name));
    let pictures: Vec<PathBuf> = names.map(|name| folder.join(name)).collect();
    if pictures.is_empty() {
        return Err(Error::invalid(format!(
            "the folder holds no picture: expected photographs whose names end in {}",
            PICTURE_EXTENSIONS.join(", ")
        ))
        .at(folder));
    }
    Ok(pictures)
}

/// Photographs with their lights, and what is to be said of how they were found.
struct Paired {
    pairs: Vec<(PathBuf, LpEntry)>,
    warnings: Vec<String>,
}

/// Whether a light file is a project or a dome of RelightLab.
fn is_project(light_file: &Path) -> bool {
    let extension = extension(light_file.as_os_str());
    extension.is_some_and(|extension| ["relight", "dome"].contains(&extension.as_str()))
}

fn pair_project(bytes: &[u8], folder: &Path, pairing: Pairing) -> Result<Paired> {
    let (entries, pairing) = match relightlab::parse(bytes)? {
        ProjectLights::Named(entries) => (entries, pairing),
        ProjectLights::InOrder(entries) => (entries, Pairing::ByOrder),
    };
    pair_list(&List::of(entries), folder, pairing)
}

fn pair_list(list: &List, folder: &Path, pairing: Pairing) -> Result<Paired> {
    let mut paired = match pairing {
        Pairing::ByName => pair_by_name(list, folder)?,
        Pairing::ByOrder => {
            let paths = pair_by_order(&list.entries, folder)?;
            let pairs = paths.into_iter().zip(list.entries.iter().cloned()).collect();
            Paired { pairs, warnings: Vec::new() }
        }
    };
    if let Some(mismatch) = list.mismatch() {
        let taken = paired.pairs.len();
        paired.warnings.push(format!("{mismatch}; the {taken} that have a photograph are taken"));
    }
    Ok(paired)
}

/// That lights were raised above the horizon, where some were.
fn at_the_horizon(pairs: &[(PathBuf, LpEntry)]) -> Option<String> {
    let low: Vec<String> =
        pairs.iter().filter(|(_, entry)| entry.is_raised).map(|(_, entry)| printable(&entry.name)).collect();
    (!low.is_empty()).then(|| {
        format!("the lights of {} are at or below the horizon and are taken as just above it", listing(&low))
    })
}

fn only_light_file(folder: &Path) -> Result<PathBuf> {
    let ending = |name: &OsString| if is_hidden(name) { None } else { extension(name) };
    let names = list(folder)?;
    let with = |wanted: &str| -> Vec<OsString> {
        names.iter().filter(|name| ending(name).as_deref() == Some(wanted)).cloned().collect()
    };
    let found = ["lp", "relight", "dome"].map(with).into_iter().find(|found| !found.is_empty());
    let found = found.unwrap_or_default();
    match found.len() {
        1 => Ok(folder.join(&found[0])),
        0 => Err(Error::invalid(format!(
            "the folder holds no light-position file (.lp), nor a .relight or .dome{}",
            below(folder)
        ))
        .at(folder)),
        n => Err(Error::usage(format!(
            "the folder holds {n} light-position files ({}): name the one to use",
            listing(&found.iter().map(|name| name.to_string_lossy().into_owned()).collect::<Vec<_>>())
        ))
        .at(folder)),
    }
}

/// Which folders in a folder hold light files, for a message.
fn below(folder: &Path) -> String {
    let holds = |name: &OsString| {
        let names = list(&folder.join(name)).unwrap_or_default();
        !is_hidden(name) && names.iter().any(|name| extension(name).as_deref() == Some("lp"))
    };
    let inner: Vec<OsString> = list(folder).unwrap_or_default().into_iter().filter(holds).collect();
    let inner: Vec<String> = inner.iter().map(|name| name.to_string_lossy().into_owned()).collect();
    if inner.is_empty() {
        String::new()
    } else {
        format!("; name one of the folders in it that do: {}", listing(&inner))
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

fn extension(name: &OsStr) -> Option<String> {
    Some(Path::new(name).extension()?.to_str()?.to_lowercase())
}

fn is_picture(name: &OsStr) -> bool {
    !is_hidden(name) && extension(name).is_some_and(|e| PICTURE_EXTENSIONS.contains(&e.as_str()))
}

/// The photographs of a list by their names. Lines without a photograph are left out where the first line of the file
/// does not count them either.
fn pair_by_name(list: &List, folder: &Path) -> Result<Paired> {
    let mut finder = Finder::new(folder)?;
    let (found, elsewhere) = finder.find(&list.entries)?;
    let present = found.iter().flatten().count();
    if let Some(missing) = missing(list, &found, &finder)
        && !(list.promises(present) && present > 0)
    {
        return Err(Error::invalid(missing));
    }
    let named = found.into_iter().zip(list.entries.iter().cloned());
    let (with, without): (Vec<_>, Vec<_>) = named.partition(|(path, _)| path.is_some());
    let pairs: Vec<(PathBuf, LpEntry)> =
        with.into_iter().filter_map(|(path, entry)| Some((path?, entry))).collect();
    let mut line_of: BTreeMap<&Path, usize> = BTreeMap::new();
    for (path, entry) in &pairs {
        if let Some(earlier) = line_of.insert(path, entry.line) {
            return Err(Error::invalid(format!(
                "lines {earlier} and {} both name {}: a photograph has one light",
                entry.line,
                path.display()
            )));
        }
    }
    let place = elsewhere.map(|place| {
        format!("no photograph is beside the light file; all were found in {}", place.display())
    });
    let absent: Vec<String> = without.iter().map(|(_, entry)| printable(&entry.name)).collect();
    let absent =
        (!absent.is_empty()).then(|| format!("there are lights but no photographs of {}", listing(&absent)));
    let paths: Vec<PathBuf> = pairs.iter().map(|(path, _)| path.clone()).collect();
    let warnings = place.into_iter().chain(absent).chain(without_a_line(&paths)?).collect();
    Ok(Paired { pairs, warnings })
}

/// That photographs are missing, in one sentence, where some are.
fn missing(list: &List, found: &[Option<PathBuf>], finder: &Finder) -> Option<String> {
    let mut missing =
        list.entries.iter().zip(found).filter(|(_, path)| path.is_none()).map(|(entry, _)| entry);
    let first = missing.next()?;
    let (more, name) = (missing.count(), printable(&first.name));
    if more + 1 == list.entries.len() && more > 0 {
        return Some(format!(
            "none of the {} names (the first is {name}) is a file in {}, and no folder near it holds all of them: \
             correct the names, or ask for pairing by order",
            list.entries.len(),
            finder.searched(first)
        ));
    }
    let others = if more == 0 { String::new() } else { format!(" ({more} more are missing)") };
    let count = list.mismatch().map_or(String::new(), |mismatch| format!("; also, {mismatch}"));
    Some(format!(
        "line {}: the photograph {name} is missing{others}, looked for in {}: add it, or remove its line{count}",
        first.line,
        finder.searched(first)
    ))
}

/// That pictures among the photographs have no line, where there are some.
fn without_a_line(paths: &[PathBuf]) -> Result<Option<String>> {
    let folders: BTreeSet<&Path> = paths.iter().filter_map(|path| path.parent()).collect();
    let named: BTreeSet<&Path> = paths.iter().map(PathBuf::as_path).collect();
    let mut unnamed = Vec::new();
    for folder in folders {
        let pictures = list(folder)?.into_iter().filter(|name| is_picture(name));
        let others = pictures.filter(|name| !named.contains(folder.join(name).as_path()));
        unnamed.extend(others.map(|name| name.to_string_lossy().into_owned()));
    }
    Ok((!unnamed.is_empty()).then(|| {
        let pictures =
            if unnamed.len() == 1 { "1 picture has" } else { &format!("{} pictures have", unnamed.len()) };
        format!("{pictures} no line in the light file and no part in the result: {}", listing(&unnamed))
    }))
}

fn pair_by_order(entries: &[LpEntry], folder: &Path) -> Result<Vec<PathBuf>> {
    let mut names = list(folder)?;
    names.retain(|name| is_picture(name));
    if names.len() != entries.len() {
        let names: Vec<_> = names.iter().map(|name| name.to_string_lossy().into_owned()).collect();
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder with a light file `lights.lp` and empty pictures.
    fn folder(lp: &str, pictures: &[&str]) -> tempfile::TempDir {
        set("lights.lp", lp.as_bytes(), pictures)
    }

    /// A folder with a light file somewhere in it, and empty pictures.
    fn set(light_file: &str, lp: &[u8], pictures: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(light_file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, lp).unwrap();
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
        assert!(message(&none, Pairing::ByName).contains("no light-position file (.lp)"));
        let below = set("Dome/lights.lp", b"0\n", &["Photos/a.jpg"]);
        assert!(message(&below, Pairing::ByName).ends_with("that do: Dome"));
    }

    #[test]
    fn a_light_file_may_be_named_itself() {
        let folder = folder("1\na.png 0 0 1", &["a.png", "second.lp"]);
        let capture = Capture::open(folder.path().join("lights.lp")).unwrap();
        assert_eq!(capture.lights(), [("a.png".to_owned(), Direction::ZENITH)]);
        assert!(Capture::open(folder.path().join("absent.lp")).is_err());
    }

    /// The photographs of a set whose light file has this name, below the real folder of the set.
    fn found(set: &tempfile::TempDir, light_file: &str) -> (Vec<String>, Vec<String>) {
        let capture = Capture::open_paired(set.path().join(light_file), Pairing::ByName).unwrap();
        let root = set.path().canonicalize().unwrap();
        let real = |p: &Photograph| p.path.canonicalize().unwrap();
        let names =
            capture.photographs.iter().map(|p| real(p).strip_prefix(&root).unwrap().display().to_string());
        (names.collect(), capture.warnings)
    }

    #[test]
    fn an_absolute_path_that_exists_is_taken_before_its_name_beside_the_light_file() {
        let elsewhere = folder("0\n", &["a b.png"]);
        let path = elsewhere.path().join("a b.png");
        let set = folder(&format!("1\n{} 0 0 1", path.display()), &["a b.png"]);
        let capture = Capture::open_paired(set.path(), Pairing::ByName).unwrap();
        assert_eq!(capture.photographs[0].path, path);
    }

    #[test]
    fn listed_folders_that_are_missing_or_spelt_otherwise_are_no_obstacle() {
        let lp =
            "4\nphotos/a.jpg 0 0 1\nC:\\dome\\Photos 2\\b.JPG 0 0 1\n..\\x\\c.jpg 0 0 1\nsub\\d.jpg 0 0 1";
        let set = folder(lp, &["a.jpg", "photos 2/b.jpg", "b.JPG", "c.jpg", "sub\\d.jpg"]);
        assert_eq!(found(&set, "lights.lp").0, ["a.jpg", "photos 2/b.jpg", "c.jpg", "sub\\d.jpg"]);
    }

    #[test]
    fn photographs_in_the_folder_beside_that_their_paths_name_are_found() {
        let lp = b"2\nC:\\rti\\jpeg-exports\\a.jpg 0 0 1\nC:\\rti\\jpeg-exports\\b.jpg 0 1 1";
        let pictures = ["jpeg-exports/a.jpg", "jpeg-exports/b.jpg", "other/a.jpg", "other/b.jpg"];
        let set = set("assembly-files/x.lp", lp, &pictures);
        assert_eq!(found(&set, "assembly-files/x.lp").0, ["jpeg-exports/a.jpg", "jpeg-exports/b.jpg"]);
    }

    #[test]
    fn bare_names_are_found_in_the_only_folder_near_that_holds_them_all_and_that_is_said() {
        let lp = b"2\na.jpg 0 0 1\nb.jpg 0 1 1";
        for place in ["set/photos/", "photos/", ""] {
            let files = [format!("{place}a.jpg"), format!("{place}b.jpg"), "half/a.jpg".to_owned()];
            let set = set("set/x.lp", lp, &files.each_ref().map(String::as_str));
            let (names, warnings) = found(&set, "set/x.lp");
            assert_eq!(names, files[..2]);
            assert!(warnings.len() == 1 && warnings[0].contains("all were found in"), "{warnings:?}");
        }
        let two = set("set/x.lp", lp, &["p/a.jpg", "p/b.jpg", "q/a.jpg", "q/b.jpg"]);
        let error =
            Capture::open_paired(two.path().join("set/x.lp"), Pairing::ByName).unwrap_err().to_string();
        assert!(error.contains("2 other folders hold files of all these names"), "{error}");
    }

    #[test]
    fn one_photograph_missing_is_not_borrowed_from_another_set() {
        let set =
            set("Test/x.lp", b"2\na.jpg 0 0 1\nb.jpg 0 1 1", &["Test/a.jpg", "Dome/a.jpg", "Dome/b.jpg"]);
        let error =
            Capture::open_paired(set.path().join("Test/x.lp"), Pairing::ByName).unwrap_err().to_string();
        assert!(error.contains("line 3: the photograph b.jpg is missing"), "{error}");
    }

    #[test]
    fn a_missing_name_is_told_whole_with_the_folders_searched() {
        let name = format!("C:\\{}\\photographs\\img_0001.jpg", "long ".repeat(30));
        let set = folder(&format!("2\na.png 0 0 1\n{name} 0 0 1"), &["a.png"]);
        let text = message(&set, Pairing::ByName);
        let above = set.path().canonicalize().unwrap();
        assert!(
            text.contains(&name) && text.contains(&above.parent().unwrap().display().to_string()),
            "{text}"
        );
    }

    #[test]
    fn files_of_systems_are_no_photographs_and_no_light_files() {
        let extra = ["._a.jpg", "._b.jpg", ".DS_Store", "Thumbs.db", "._lights.lp"];
        let set = folder("2\nx 0 0 1\ny 0 1 1", &[&["a.jpg", "b.jpg"][..], &extra].concat());
        assert_eq!(opened(&set, Pairing::ByOrder).unwrap(), ["a.jpg", "b.jpg"]);
        std::fs::write(set.path().join("lights.lp"), "2\na.jpg 0 0 1\nb.jpg 0 1 1").unwrap();
        assert_eq!(found(&set, "lights.lp").1, [""; 0]);
    }

    #[test]
    fn pictures_without_a_line_are_said() {
        let set = folder("1\na.jpg 0 0 1", &["a.jpg", "mask.png", "b.jpg", "notes.txt"]);
        let warnings = found(&set, "lights.lp").1;
        assert!(warnings.len() == 1 && warnings[0].contains("2 pictures have no line"), "{warnings:?}");
        assert!(warnings[0].ends_with("b.jpg, mask.png"), "{warnings:?}");
    }

    #[test]
    fn a_wrong_count_and_a_missing_photograph_are_said_together() {
        let set = folder("4\na.jpg 0 0 1\nb.jpg 0 1 1\nc.jpg 1 0 1\n\n", &["a.jpg", "b.jpg"]);
        let text = message(&set, Pairing::ByName);
        assert!(text.contains("line 4: the photograph c.jpg is missing"), "{text}");
        assert!(text.contains("line 1 promises 4 lights, but 3 lines follow"), "{text}");
    }

    #[test]
    fn a_wrong_count_is_said_and_the_capture_usable() {
        let set = folder("2\na.jpg 0 0 1\nb.jpg 0 1 1\nc.jpg 1 0 1\n\n", &["a.jpg", "b.jpg", "c.jpg"]);
        let (names, warnings) = found(&set, "lights.lp");
        assert_eq!(names, ["a.jpg", "b.jpg", "c.jpg"]);
        assert!(
            warnings.len() == 1 && warnings[0].contains("promises 2 lights, but 3 lines"),
            "{warnings:?}"
        );
        // A line without a photograph that the first line does not count either.
        std::fs::remove_file(set.path().join("b.jpg")).unwrap();
        let (names, warnings) = found(&set, "lights.lp");
        assert_eq!(names, ["a.jpg", "c.jpg"]);
        assert!(warnings[0].contains("no photographs of b.jpg"), "{warnings:?}");
    }

    #[test]
    fn lights_at_the_horizon_are_said() {
        let set = folder("2\na.jpg 0 0.79 -0.001\nb.jpg 0 0 1.06", &["a.jpg", "b.jpg"]);
        let warnings = found(&set, "lights.lp").1;
        assert!(
            warnings.len() == 1 && warnings[0].contains("a.jpg are at or below the horizon"),
            "{warnings:?}"
        );
    }

    #[test]
    fn projects_and_domes_of_relightlab_are_captures() {
        let project =
            br#"{"folder": "jpg", "images": [{"filename": "b.jpg", "direction": {"x":0,"y":0,"z":1}}]}"#;
        let named = set("x.relight", project, &["jpg/b.jpg"]);
        assert_eq!(found(&named, "x.relight").0, ["jpg/b.jpg"]);
        assert_eq!(opened(&named, Pairing::ByName).unwrap(), ["jpg/b.jpg"]);
        let dome = set("x.dome", br#"{"directions": [[0,0,1],[0,1,1]]}"#, &["2.jpg", "10.jpg"]);
        assert_eq!(found(&dome, "x.dome").0, ["2.jpg", "10.jpg"]);
    }

    #[cfg(unix)]
    #[test]
    fn names_that_are_not_utf_8_are_found_by_their_bytes_or_as_latin_1() {
        use std::os::unix::ffi::OsStrExt;
        let set = set("lights.lp", b"2\nn\xe9.png 0 0 1\n\xe8.png 0 1 1", &["\u{e8}.png"]);
        let path = set.path().join(OsStr::from_bytes(b"n\xe9.png"));
        std::fs::write(&path, b"").unwrap();
        let capture = Capture::open_paired(set.path(), Pairing::ByName).unwrap();
        let paths: Vec<_> = capture.photographs.into_iter().map(|p| p.path).collect();
        assert_eq!(paths, [path.clone(), set.path().join("\u{e8}.png")]);
        std::fs::write(set.path().join("lights.lp"), "1\nN\u{e9}.png 0 0 1").unwrap();
        assert_eq!(Capture::open_paired(set.path(), Pairing::ByName).unwrap().photographs[0].path, path);
        std::fs::write(set.path().join("lights.lp"), "2\nx 0 0 1\ny 0 1 1").unwrap();
        assert_eq!(Capture::open_paired(set.path(), Pairing::ByOrder).unwrap().photographs[0].path, path);
    }
}
