//! Files in one zip archive, written one after another.
//!
//! All entries lie in one folder, so that the archive unpacks like a folder of files. Pictures are compressed already
//! and are stored; everything else is deflated. Times are left at the beginning of zip's calendar, so the same
//! files give the same bytes. More than 65,535 files, or 4 GiB, make a zip64 archive.

use std::io::{Seek, Write};
use std::path::Path;

use ::zip::write::SimpleFileOptions;
use ::zip::{CompressionMethod, ZipWriter};

use super::picture::extension;
use crate::error::{Error, Result};

/// The extensions of files that compression does not shrink.
const COMPRESSED: [&str; 4] = ["png", "jpg", "jpeg", "exr"];

/// A zip archive that is being written.
pub struct ZipArchive<W: Write + Seek> {
    writer: ZipWriter<W>,
    root: String,
}

impl<W: Write + Seek> ZipArchive<W> {
    /// An archive whose files lie in the folder `root`.
    pub fn new(out: W, root: impl Into<String>) -> Self {
        Self { writer: ZipWriter::new(out), root: root.into() }
    }

    /// Adds a file; `name` is its path below the root, with forward slashes.
    ///
    /// # Errors
    /// A name that is there already, and errors of the system.
    pub fn add(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let is_compressed = COMPRESSED.contains(&extension(Path::new(name)).as_str());
        let method = if is_compressed { CompressionMethod::Stored } else { CompressionMethod::Deflated };
        let options = SimpleFileOptions::default()
            .compression_method(method)
            .unix_permissions(0o644)
            .large_file(u32::try_from(bytes.len()).is_err());
        let started = self.writer.start_file(format!("{}/{name}", self.root), options);
        started.map_err(|e| unwritable(e.into()))?;
        self.writer.write_all(bytes).map_err(unwritable)
    }

    /// Writes the list of files at the end of the archive.
    ///
    /// # Errors
    /// Errors of the system.
    pub fn finish(self) -> Result<W> {
        let mut out = self.writer.finish().map_err(|e| unwritable(e.into()))?;
        out.flush().map_err(unwritable)?;
        Ok(out)
    }
}

fn unwritable(error: std::io::Error) -> Error {
    Error::io("cannot write the archive", &error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Read};

    #[test]
    fn files_are_found_again_by_name_and_in_order() {
        let write = || {
            let mut archive = ZipArchive::new(Cursor::new(Vec::new()), "weave");
            archive.add("tv000_pv000/00000 tl000 pl000 tv000 pv000.jpg", &[7; 1000]).unwrap();
            archive.add("btf.json", &[b' '; 1000]).unwrap();
            archive.finish().unwrap().into_inner()
        };
        assert_eq!(write(), write());
        let mut read = ::zip::ZipArchive::new(Cursor::new(write())).unwrap();
        let names: Vec<String> =
            (0..2).map(|k| read.by_index(k).unwrap().name().unwrap().into_owned()).collect();
        assert_eq!(names, ["weave/tv000_pv000/00000 tl000 pl000 tv000 pv000.jpg", "weave/btf.json"]);
        let sizes = [0, 1].map(|k| read.by_index(k).unwrap().compressed_size());
        assert!(sizes[0] == 1000 && sizes[1] < 100, "{sizes:?}");
        let mut bytes = Vec::new();
        read.by_index(0).unwrap().read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, [7; 1000]);
    }

    #[test]
    fn a_name_that_is_there_already_is_refused() {
        let mut archive = ZipArchive::new(Cursor::new(Vec::new()), "a");
        archive.add("b.json", b"{}").unwrap();
        assert!(archive.add("b.json", b"{}").unwrap_err().to_string().contains("archive"));
    }
}
