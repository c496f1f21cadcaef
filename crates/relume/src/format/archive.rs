//! Zip archives of pictures: entries are read one at a time, in any order, and never written to a disk.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use zip::{CompressionMethod, ZipArchive};

use super::opacity::OPACITY_UNUSED;
use super::raster::decode_raster;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::raster::Raster;

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
    /// A file that cannot be read or is not a complete zip archive, names that lead out of a folder, and two entries of one name.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).map_err(|e| Error::io("cannot read the file", &e).at(path))?;
        let damaged = || {
            Error::invalid(
                "the file is not a complete zip archive: copy or download it again, or extract it and name the folder",
            )
            .at(path)
        };
        let mut file = BufReader::new(file);
        let double = first_double(&mut file);
        let archive = ZipArchive::new(file).map_err(|_| damaged())?;
        if let Some(name) = double {
            return Err(Error::invalid(format!(
                "the archive holds two entries of the name {}, of which only one can be meant: make the archive again",
                name.escape_default()
            ))
            .at(path));
        }
        let names = (0..archive.len()).map(|i| {
            let name = archive.name_for_index(i).and_then(Result::ok).ok_or_else(damaged)?;
            if leads_out(&name) {
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

    /// The picture in an entry. An opacity is left out, with a remark of the job.
    ///
    /// # Errors
    /// As [`ImageArchive::read`], and an entry that is no picture.
    pub fn raster(&self, index: usize, job: &Job) -> Result<Raster> {
        let bytes = self.read(index, job)?;
        let place = self.path.join(&self.names[index]);
        let job = job.about(&place);
        let raster = decode_raster(&bytes, &job).map_err(|e| e.at(&place))?;
        if raster.opacity().is_some() {
            job.remark(OPACITY_UNUSED);
        }
        Ok(raster.without_opacity())
    }

    /// The content of an entry.
    ///
    /// # Errors
    /// Entries that are damaged, encrypted, compressed by a method other than deflate, or exceed the limits.
    pub fn read(&self, index: usize, job: &Job) -> Result<Vec<u8>> {
        let place = || self.path.join(self.names.get(index).map_or("", String::as_str));
        let mut archive = self.archive.lock().unwrap_or_else(PoisonError::into_inner);
        if let Ok(entry) = archive.by_index_raw(index)
            && !matches!(entry.compression(), CompressionMethod::Stored | CompressionMethod::Deflated)
        {
            return Err(Error::unsupported(format!(
                "the entry of the archive is compressed by {}, and deflate is read: make the archive again with deflate, or extract \
                 it and name the folder",
                entry.compression()
            ))
            .at(place()));
        }
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

/// Whether a path is one from the root or of a drive, or leads to a folder above.
fn leads_out(name: &str) -> bool {
    let is_of_drive =
        name.as_bytes().first().is_some_and(u8::is_ascii_alphabetic) && name[1..].starts_with(':');
    is_of_drive || name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..")
}

/// The first name that two entries of the directory of an archive have, which reading by name would not show. None of archives
/// beyond 65,534 entries or 4 GiB, and of damaged ones.
fn first_double(file: &mut (impl Read + Seek)) -> Option<String> {
    /// The bytes of the end of a directory without its comment, and the longest comment.
    const END: u64 = 22;
    const LONGEST: u64 = 0xffff;
    /// The bytes of an entry of a directory before its name.
    const ENTRY: usize = 46;
    let length = file.seek(SeekFrom::End(0)).ok()?;
    let from = length.saturating_sub(END + LONGEST);
    file.seek(SeekFrom::Start(from)).ok()?;
    let mut tail = Vec::new();
    file.read_to_end(&mut tail).ok()?;
    let end = tail.windows(END as usize).rposition(|bytes| bytes.starts_with(b"PK\x05\x06"))?;
    let short = |at: usize| u16::from_le_bytes([tail[end + at], tail[end + at + 1]]);
    let long = |at: usize| u32::from(short(at)) | u32::from(short(at + 2)) << 16;
    let (count, bytes, start) = (short(10), long(12), long(16));
    if count == u16::MAX || bytes == u32::MAX || start == u32::MAX || u64::from(bytes) > length {
        return None;
    }
    file.seek(SeekFrom::Start(u64::from(start))).ok()?;
    let mut directory = vec![0; bytes as usize];
    file.read_exact(&mut directory).ok()?;
    let (mut seen, mut at) = (BTreeSet::new(), 0);
    for _ in 0..count {
        let entry = directory.get(at..at + ENTRY).filter(|entry| entry.starts_with(b"PK\x01\x02"))?;
        let short = |k: usize| usize::from(u16::from_le_bytes([entry[k], entry[k + 1]]));
        let (name, more) = (short(28), short(30) + short(32));
        let name_bytes = directory.get(at + ENTRY..at + ENTRY + name)?;
        if !seen.insert(name_bytes) {
            return Some(String::from_utf8_lossy(name_bytes).into_owned());
        }
        at += ENTRY + name + more;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_from_a_root_and_of_a_drive_lead_out() {
        for name in ["/a.png", "\\a.png", "C:\\x\\a.png", "c:a.png", "a/../../b.png", ".."] {
            assert!(leads_out(name), "{name}");
        }
        for name in ["a.png", "a/b..c.png", "tv 1:2.png", "", "é:a.png"] {
            assert!(!leads_out(name), "{name}");
        }
    }
}
