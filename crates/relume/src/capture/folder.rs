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
        if pairs.is_empty() {
            return Err(Error::invalid(
                "no photograph with a light is listed: expected a line for each, its name and x y z",
            )
            .at(&light_file));
        }
        warnings.extend(at_the_horizon(&pairs));
        let photograph =
            |(path, entry): (PathBuf, LpEntry)| Photograph { path, light: entry.light, vector: entry.vector };
        let photographs = pairs.into_iter().map(photograph).collect();
        Ok(Self { light_file, photographs, warnings })
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
mod tests;
