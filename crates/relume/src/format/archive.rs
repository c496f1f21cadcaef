//! Zip archives of pictures: entries are read one at a time, in any order, and never written to a disk.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use zip::ZipArchive;

use crate::error::{Error, Result};
use crate::job::Job;

/// A zip archive that is read entry by entry, from several threads.
#[derive(Debug)]
pub struct ImageArchive {
    path: PathBuf,
    names: Vec<String>,
    archive: Mutex<ZipArchive<BufReader<File>>>,
}

impl ImageArchive {
    /// Opens an archive and reads its directory.
    ///
    /// # Errors
    /// A file that cannot be read or is not a complete zip archive, and names that lead out of a folder.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::io("cannot read the file", &e).at(path))?;
        let damaged = || {
            Error::invalid(
                "the file is not a complete zip archive: copy or download it again, or extract it and name the folder",
            )
            .at(path)
        };
        let archive = ZipArchive::new(BufReader::new(file)).map_err(|_| damaged())?;
        let names = (0..archive.len()).map(|i| {
            let name = archive.name_for_index(i).and_then(Result::ok).ok_or_else(damaged)?;
            let leaves = name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..");
            if leaves {
                return Err(Error::invalid(format!(
                    "the archive holds the name {}, which leads out of its folder: make the archive again",
                    name.escape_default()
                ))
                .at(path));
            }
            Ok(name.into_owned())
        });
        let names = names.collect::<Result<Vec<String>>>()?;
        Ok(Self { path: path.to_path_buf(), names, archive: Mutex::new(archive) })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The names of the entries, with folders, in the order of the archive.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The content of an entry.
    ///
    /// # Errors
    /// Entries that are damaged, encrypted, compressed by a method other than deflate, or exceed the limits.
    pub fn read(&self, index: usize, job: &Job) -> Result<Vec<u8>> {
        let place = || self.path.join(self.names.get(index).map_or("", String::as_str));
        let mut archive = self.archive.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = archive.by_index(index).map_err(|e| {
            let why = match e {
                zip::result::ZipError::UnsupportedArchive(_) => Error::unsupported(
                    "the entry is encrypted or compressed by another method than deflate: make the archive again without",
                ),
                _ => Error::invalid("the entry of the archive is damaged: copy or download the archive again"),
            };
            why.at(place())
        })?;
        let length = entry.size();
        job.check_bytes("an entry of the archive", length).map_err(|e| e.at(place()))?;
        let mut bytes = Vec::new();
        let read = entry.take(length.saturating_add(1)).read_to_end(&mut bytes);
        if read.is_err() || bytes.len() as u64 != length {
            return Err(Error::invalid(
                "the entry of the archive is damaged or cut short: copy or download the archive again",
            )
            .at(place()));
        }
        Ok(bytes)
    }
}
