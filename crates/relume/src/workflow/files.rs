//! Reading and writing fields and pictures by file name.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::format::{FieldFormat, PictureFormat, encode_field, encode_picture, read_field};
use crate::job::Job;
use crate::picture::Picture;

impl ReflectanceField {
    /// Reads a field from a `.ptm`, an EXR field, or any picture as a field of constants, recognised by
    /// content.
    ///
    /// # Errors
    /// A file that cannot be read, is truncated, of another kind, or larger than the default limits.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        Self::open_with(path, &Job::default())
    }

    /// [`ReflectanceField::open`] as a part of a job.
    ///
    /// # Errors
    /// As [`ReflectanceField::open`], within the job's limits.
    pub fn open_with(path: impl AsRef<Path>, job: &Job) -> Result<Self> {
        Ok(read_field(path.as_ref(), job)?.field)
    }

    /// Writes the field in the format of the file extension; an existing file is replaced.
    ///
    /// # Errors
    /// An extension without a format, a format that cannot hold the functions, and errors of the
    /// system.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        let format = FieldFormat::from_path(path)?;
        write(path, &encode_field(self, format, None, &Job::default()).map_err(|e| e.at(path))?)
    }
}

impl Picture {
    /// Writes the picture in the format of the file extension, `.png`, `.jpg`, `.tif` or `.exr`; an existing
    /// file is replaced.
    ///
    /// # Errors
    /// An extension without a format, and errors of the system.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        write(path, &encode_picture(self, PictureFormat::from_path(path)?).map_err(|e| e.at(path))?)
    }
}

/// Writes beside the place of the file and renames, so that the file is never seen incomplete.
fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.tmp", std::process::id()));
    let beside = path.with_file_name(name);
    let written = File::create_new(&beside)
        .and_then(|mut file| file.write_all(bytes).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&beside, path));
    written.map_err(|e| {
        // What is left of it is of no use; the error of the write is the one to report.
        let _ = fs::remove_file(&beside);
        Error::io("cannot write the file", &e).at(path)
    })
}
