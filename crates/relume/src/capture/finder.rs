//! Location of the photographs of a light file.
//!
//! Light files move: from another computer, out of an archive, into another folder. A name is searched as it
//! is listed; then by ever shorter tails of its path in the folder of the light file (`C:\dome\photos\a.jpg`:
//! `photos/a.jpg`, then `a.jpg`); then by the tails that still name a folder in the parent folder. If that
//! finds none of the photographs, the folders below, above and beside the light file are tried, and one that
//! holds all of them is used. Upper and lower case matter only if both exist.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use super::lp::{self, LpEntry, printable};
use crate::error::{Error, Result};
use crate::words::listed;

/// The most folders searched below, above and beside a light file.
const MAX_FOLDERS: usize = 1000;

/// Finds photographs by the names of a light file; folders are listed once.
pub(super) struct Finder<'a> {
    folder: &'a Path,
    above: Option<PathBuf>,
    listings: BTreeMap<PathBuf, Listing>,
}

impl<'a> Finder<'a> {
    /// A finder for a light file that lies in `folder`.
    pub(super) fn new(folder: &'a Path) -> Result<Self> {
        let own = Listing::new(list(folder)?);
        let above = folder.canonicalize().ok().and_then(|path| path.parent().map(Path::to_path_buf));
        Ok(Self { folder, above, listings: BTreeMap::from([(folder.to_path_buf(), own)]) })
    }

    /// The photograph of each entry, as far as they exist, and the folder of all of them if it had to be
    /// guessed.
    pub(super) fn find(&mut self, entries: &[LpEntry]) -> Result<(Vec<Option<PathBuf>>, Option<PathBuf>)> {
        let found = entries.iter().map(|entry| self.find_one(entry)).collect::<Result<Vec<_>>>()?;
        if entries.is_empty() || found.iter().any(Option::is_some) {
            return Ok((found, None));
        }
        let mut whole = Vec::new();
        for folder in self.neighbours() {
            let found: Option<Vec<_>> = entries
                .iter()
                .map(|entry| self.resolve(&folder, &tail(entry, 1)?, entry).ok().flatten())
                .collect();
            whole.extend(found.map(|paths| (folder, paths)));
        }
        match whole.len() {
            0 => Ok((found, None)),
            1 => {
                let (folder, paths) = whole.remove(0);
                Ok((paths.into_iter().map(Some).collect(), Some(folder)))
            }
            n => {
                let folders: Vec<_> = whole.iter().map(|(folder, _)| folder.display().to_string()).collect();
                Err(Error::invalid(format!(
                    "the photographs are not beside the light file, and {n} other folders hold files of all these \
                     names ({}): move the light file into the right one",
                    listing(&folders)
                )))
            }
        }
    }

    /// The folders searched for a photograph, for a message.
    pub(super) fn searched(&self, entry: &LpEntry) -> String {
        let own = self.folder.display();
        match self.above.as_ref().filter(|_| components(entry).count() > 1) {
            Some(above) => format!("{own} and {}", above.display()),
            None => own.to_string(),
        }
    }

    fn find_one(&mut self, entry: &LpEntry) -> Result<Option<PathBuf>> {
        if let Some(named) = as_listed(entry, self.folder) {
            return Ok(Some(named));
        }
        let (folder, above) = (self.folder, self.above.clone());
        for length in (1..=components(entry).count()).rev() {
            let Some(tail) = tail(entry, length) else { continue };
            if let Some(path) = self.resolve(folder, &tail, entry)? {
                return Ok(Some(path));
            }
            if let Some(above) = above.as_deref().filter(|_| length > 1)
                && let Some(path) = self.resolve(above, &tail, entry)?
            {
                return Ok(Some(path));
            }
        }
        Ok(None)
    }

    /// The file at `tail` below `base`, by exact names, otherwise by the only ones that differ in case alone.
    fn resolve(&mut self, base: &Path, tail: &[String], entry: &LpEntry) -> Result<Option<PathBuf>> {
        let mut path = base.to_path_buf();
        for component in tail {
            match self.listing(&path).find(component) {
                [] => return Ok(None),
                [only] => path.push(only),
                several => {
                    let names: Vec<_> = several.iter().map(|n| n.to_string_lossy().into_owned()).collect();
                    return Err(Error::invalid(format!(
                        "line {}: {} could be any of {}, which differ only in upper and lower case",
                        entry.line,
                        printable(&entry.name),
                        listing(&names)
                    )));
                }
            }
        }
        Ok(can_be_read(&path).then_some(path))
    }

    /// The names in a folder; empty if it does not exist or cannot be listed.
    fn listing(&mut self, folder: &Path) -> &Listing {
        let read = || Listing::new(list(folder).unwrap_or_default());
        self.listings.entry(folder.to_path_buf()).or_insert_with(read)
    }

    /// Visible folders below, above and beside that of the light file.
    fn neighbours(&mut self) -> Vec<PathBuf> {
        let own = self.folder.canonicalize().ok();
        let mut places = vec![self.folder.to_path_buf()];
        places.extend(self.above.clone());
        let mut folders: Vec<PathBuf> = self.above.clone().into_iter().collect();
        for place in places {
            let names = self.listing(&place).names.clone();
            let inner = names.into_iter().filter(|name| !is_hidden(name)).map(|name| place.join(name));
            folders.extend(inner.filter(|path| path.is_dir() && path.canonicalize().ok() != own));
            folders.truncate(MAX_FOLDERS);
        }
        folders
    }
}

/// The names in a folder, exactly and without regard to case.
struct Listing {
    names: Vec<OsString>,
    by_key: BTreeMap<String, Vec<OsString>>,
}

impl Listing {
    fn new(names: Vec<OsString>) -> Self {
        let mut by_key: BTreeMap<String, Vec<OsString>> = BTreeMap::new();
        for name in &names {
            by_key.entry(text(name).to_lowercase()).or_default().push(name.clone());
        }
        Self { names, by_key }
    }

    /// The name with this spelling, otherwise all that differ in case alone.
    fn find(&self, name: &str) -> &[OsString] {
        let alike = self.by_key.get(&name.to_lowercase()).map_or(&[][..], Vec::as_slice);
        let exact = alike.iter().position(|other| text(other) == name);
        exact.map_or(alike, |i| &alike[i..=i])
    }
}

/// The file exactly as spelled in the line, also by its bytes if they are not UTF-8.
fn as_listed(entry: &LpEntry, folder: &Path) -> Option<PathBuf> {
    let slashed = entry.name.replace('\\', "/");
    let spellings = [path_of_bytes(&entry.raw_name), PathBuf::from(&entry.name), PathBuf::from(slashed)];
    // Joining an absolute path yields that path.
    spellings.into_iter().map(|path| folder.join(path)).find(|path| can_be_read(path))
}

#[cfg(unix)]
fn path_of_bytes(bytes: &[u8]) -> PathBuf {
    <OsStr as std::os::unix::ffi::OsStrExt>::from_bytes(bytes).into()
}

#[cfg(not(unix))]
fn path_of_bytes(bytes: &[u8]) -> PathBuf {
    lp::decode(bytes).into()
}

/// A name as text; Latin-1 if it is not UTF-8, as in a light file.
fn text(name: &OsStr) -> String {
    name.to_str().map_or_else(|| lp::decode(name.as_encoded_bytes()), str::to_owned)
}

/// The parts of a listed path, Windows or not, without a drive.
fn components(entry: &LpEntry) -> impl DoubleEndedIterator<Item = &str> + Clone {
    let parts = entry.name.split(['/', '\\']);
    parts.filter(|part| !matches!(*part, "" | "." | "..") && !part.ends_with(':'))
}

/// The last parts of a listed path; `None` if it has fewer.
fn tail(entry: &LpEntry, length: usize) -> Option<Vec<String>> {
    let parts = components(entry);
    let skipped = parts.clone().count().checked_sub(length)?;
    Some(parts.skip(skipped).map(str::to_owned).collect())
}

/// The names of the entries of a folder, sorted so that numbers compare as numbers.
pub(super) fn list(folder: &Path) -> Result<Vec<OsString>> {
    let io = |e: std::io::Error| Error::io("cannot list the folder", &e).at(folder);
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        names.push(entry.map_err(io)?.file_name());
    }
    names.sort_by_cached_key(|name| (natural_key(&text(name)), name.clone()));
    Ok(names)
}

/// Whether systems hide a name: `.DS_Store`, and `._a.jpg` beside `a.jpg` of macOS.
pub(super) fn is_hidden(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(b".")
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

/// The first names of a list, and how many more there are.
pub(super) fn listing(names: &[String]) -> String {
    listed(names, 8, ", ")
}

/// Whether a path is anything that can be read as a file: a pipe can.
fn can_be_read(path: &Path) -> bool {
    path.metadata().is_ok_and(|metadata| !metadata.is_dir())
}
