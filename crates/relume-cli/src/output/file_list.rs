//! The files relume wrote into a folder: a list in the folder, with their stamps.
//!
//! It determines what `--force` may replace, and whether the files still belong together: a verb that reads a
//! capture refuses a photograph that differs from the one listed.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use relume::capture::Capture;
use relume::format::Opened;
use relume::{Error, Job, Result, Stamp};
use serde::{Deserialize, Serialize};

use super::temporary::{folder_of, is_temporary};
use crate::input;
use crate::paths::{percent_decoded, percent_encoded};

/// The name of the list.
const NAME: &str = "relume-files.json";

/// Files by their paths within the folder, parts joined by slashes.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct FileList {
    files: BTreeMap<String, Stamp>,
}

impl FileList {
    /// The list in a folder; empty if there is none.
    pub fn read(folder: &Path) -> Self {
        let text = fs::read(folder.join(NAME)).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }

    /// Adds a file.
    pub fn add(&mut self, name: &Path, stamp: Stamp) {
        self.files.insert(key(name), stamp);
    }

    /// Whether relume wrote a file, or a folder that holds such files.
    pub fn holds(&self, name: &Path) -> bool {
        let key = key(name);
        let inside = format!("{key}/");
        key == NAME || self.files.keys().any(|file| *file == key || file.starts_with(&inside))
    }

    /// The names of all entries of the folder that hold files of this list.
    pub fn top_entries(&self) -> Vec<OsString> {
        let tops: BTreeSet<&str> = self.files.keys().filter_map(|file| file.split('/').next()).collect();
        tops.into_iter().map(|top| percent_decoded(top).into_os_string()).collect()
    }

    /// This list, with the files that other verbs wrote into the folder.
    pub fn completed(mut self, folder: &Path) -> io::Result<Self> {
        for name in walk(folder)? {
            let path = folder.join(&name);
            if path.is_file() && !self.files.contains_key(&key(&name)) {
                self.add(&name, Stamp::of(&fs::read(path)?));
            }
        }
        Ok(self)
    }

    /// Refuses a file of the folder that differs from the one listed.
    fn check(&self, path: &Path, found: Stamp) -> Result<()> {
        let listed = path.file_name().and_then(|name| self.files.get(&key(Path::new(name))));
        match listed {
            Some(listed) if *listed != found => Err(Error::invalid(format!(
                "is {found}, but {NAME} beside it says {listed}: it is not of this capture; write the capture \
                 anew, or delete {NAME} if the file was changed on purpose"
            ))
            .at(path)),
            _ => Ok(()),
        }
    }
}

/// Writes a list into its folder.
pub fn write(folder: &Path, list: &FileList) -> io::Result<()> {
    let mut file = File::create(folder.join(NAME))?;
    file.write_all(format!("{}\n", serde_json::to_string_pretty(list)?).as_bytes())?;
    file.sync_all()
}

/// Everything in a folder except temporaries, by its path within it, folders before their contents.
pub fn walk(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut inner = vec![PathBuf::new()];
    while let Some(part) = inner.pop() {
        for entry in fs::read_dir(folder.join(&part))? {
            let entry = entry?;
            if part.as_os_str().is_empty() && is_temporary(&entry.file_name().to_string_lossy()) {
                continue;
            }
            let name = part.join(entry.file_name());
            if entry.file_type()?.is_dir() {
                inner.push(name.clone());
            }
            found.push(name);
        }
    }
    found.sort();
    Ok(found)
}

/// A name in the list. One that is not UTF-8 is percent-encoded.
fn key(name: &Path) -> String {
    let parts: Vec<String> = name.iter().map(|part| percent_encoded(Path::new(part))).collect();
    parts.join("/")
}

/// The photographs of a capture, each checked against the list of its folder, if there is one.
pub struct CaptureFiles {
    folder: PathBuf,
    list: FileList,
}

impl CaptureFiles {
    /// Reads the list beside a light file. That file is a text, which other verbs and people may write anew.
    ///
    /// # Errors
    /// A damaged list.
    pub fn of(capture: &Capture) -> Result<Self> {
        let folder = folder_of(&capture.light_file).to_path_buf();
        let path = folder.join(NAME);
        let list = match fs::read(&path) {
            Ok(text) => serde_json::from_slice(&text).map_err(|e| {
                Error::invalid(format!("is damaged ({e}): delete it if the capture is whole")).at(&path)
            })?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => FileList::default(),
            Err(error) => return Err(Error::io("cannot read the file", &error).at(&path)),
        };
        Ok(Self { folder, list })
    }

    /// Opens a photograph.
    ///
    /// # Errors
    /// A photograph that cannot be read, or differs from the one listed.
    pub fn open(&self, photograph: &Path, job: &Job) -> Result<Opened> {
        let opened = input::open(photograph, job)?;
        self.check(photograph, || opened.stamp())?;
        Ok(opened)
    }

    fn check(&self, photograph: &Path, stamp: impl Fn() -> Stamp) -> Result<()> {
        if folder_of(photograph) != self.folder || self.list.files.is_empty() {
            return Ok(());
        }
        self.list.check(photograph, stamp())
    }
}
