//! Whole files as bytes.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::brdf::UTIA_BYTES;
use crate::error::{Error, Result};
use crate::job::Job;

/// The bytes by which a file is recognised.
pub(super) const HEAD_BYTES: usize = 1 << 16;

/// The most bytes that are read of a file whose first ones say nothing: one more than the longest that is recognised by its
/// length has.
const MOST_UNKNOWN: usize = UTIA_BYTES + 1;

/// All bytes of a file, refused when they exceed the limits; or the first two megabytes alone where `is_known` finds no
/// reason in the first [`HEAD_BYTES`] to read on. The file is opened once and read sequentially, so it may be a pipe.
pub(super) fn read_file(path: &Path, is_known: impl Fn(&[u8]) -> bool, job: &Job) -> Result<Vec<u8>> {
    let read = || {
        let io = |source: std::io::Error| Error::io("cannot read the file", &source);
        let file = File::open(path).map_err(io)?;
        let metadata = file.metadata().map_err(io)?;
        if metadata.is_dir() {
            return Err(Error::usage("this is a folder: expected a file"));
        }
        read_bytes(file, metadata.len(), is_known, job)
    };
    read().map_err(|error| error.at(path))
}

/// As [`read_file`], of a reader of which `expected` bytes are known in advance: a pipe or a device has no length, so
/// reading is bounded as well.
pub(super) fn read_bytes(
    mut source: impl Read,
    expected: u64,
    is_known: impl Fn(&[u8]) -> bool,
    job: &Job,
) -> Result<Vec<u8>> {
    let io = |error: std::io::Error| Error::io("cannot read the file", &error);
    let mut bytes = Vec::new();
    source.by_ref().take(HEAD_BYTES as u64).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() < HEAD_BYTES || !is_known(&bytes) {
        source.take((MOST_UNKNOWN - bytes.len()) as u64).read_to_end(&mut bytes).map_err(io)?;
        job.check_bytes("the file", bytes.len() as u64)?;
        return Ok(bytes);
    }
    job.check_bytes("the file", expected)?;
    let more = usize::try_from(expected).unwrap_or(usize::MAX).saturating_sub(bytes.len());
    bytes.try_reserve_exact(more).map_err(|_| {
        Error::limit(format!("the file has {expected} bytes, and the system has no memory for them"))
    })?;
    let most = job.limits().max_bytes.saturating_add(1).saturating_sub(bytes.len() as u64);
    source.take(most).read_to_end(&mut bytes).map_err(io)?;
    job.check_bytes("the file", bytes.len() as u64)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_endless_file_of_an_unknown_kind_is_not_read_to_its_end() {
        let bytes = read_bytes(std::io::repeat(0), 0, |_| false, &Job::default()).unwrap();
        assert_eq!(bytes.len(), MOST_UNKNOWN);
        let long = vec![7; 3 * HEAD_BYTES + 5];
        assert!(read_bytes(&long[..], 1 << 17, |_| true, &Job::default()).unwrap() == long);
        assert!(read_bytes(&long[..9], 0, |_| false, &Job::default()).unwrap() == [7; 9]);
        let small = Job::new(crate::limits::Limits { max_bytes: 1 << 17, ..Default::default() });
        assert!(read_bytes(std::io::repeat(0), 0, |_| true, &small).is_err());
    }
}
