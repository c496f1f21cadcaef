//! The files of a folder, on disk or anywhere else.

use std::path::Path;

use super::whole::read_file;
use crate::error::{Error, Result};
use crate::job::Job;

/// Reads a file of a folder by its path within it; `None` where there is none.
pub(super) type ReadFile<'a> = dyn Fn(&str) -> Result<Option<Vec<u8>>> + Sync + 'a;

/// Stores a file under its path within the folder.
pub(super) type StoreFile<'a> = dyn FnMut(&str, &[u8]) -> Result<()> + 'a;

/// Reads the files of a folder on disk.
pub(super) fn files_of<'a>(
    folder: &'a Path,
    job: &'a Job,
) -> impl Fn(&str) -> Result<Option<Vec<u8>>> + Sync + 'a {
    move |name| {
        let path = folder.join(name);
        if !path.is_file() {
            return Ok(None);
        }
        read_file(&path, |_| true, job).map(Some)
    }
}

/// The error for a file that a folder should have.
pub(super) fn missing(name: &str) -> Error {
    Error::invalid(format!("the folder has no file {name}: it is incomplete"))
}
