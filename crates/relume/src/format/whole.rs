//! Whole files as bytes.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};
use crate::job::Job;

/// All bytes of a file, refused when they exceed the limits. The file is opened once and read sequentially,
/// so it may be a pipe.
pub(super) fn read_file(path: &Path, job: &Job) -> Result<Vec<u8>> {
    let read = || {
        let io = |source: std::io::Error| Error::io("cannot read the file", &source);
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(Error::usage("this is a folder: expected a file"));
        }
        job.check_bytes("the file", metadata.len())?;
        read_bytes(file, metadata.len(), job)
    };
    read().map_err(|error| error.at(path))
}

/// All bytes of a reader, of which `expected` are known in advance: a pipe or a device has no length, so
/// reading is bounded as well.
pub(super) fn read_bytes(source: impl Read, expected: u64, job: &Job) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let expected = usize::try_from(expected).unwrap_or(usize::MAX);
    bytes.try_reserve_exact(expected).map_err(|_| {
        Error::limit(format!("the file has {expected} bytes, and the system has no memory for them"))
    })?;
    let read = source.take(job.limits().max_bytes.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|error| Error::io("cannot read the file", &error))?;
    job.check_bytes("the file", bytes.len() as u64)?;
    Ok(bytes)
}
