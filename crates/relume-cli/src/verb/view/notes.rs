//! Files of annotations behind the server. Several pages, and people with an editor, may change one file: a page sends the tag of
//! what it had read, and writes only over that (HTTP's `ETag` and `If-Match`, RFC 9110, sections 8.8.3 and 13.1.1).

use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use relume::{Error, ErrorKind, Result};

use super::site::{Answer, JSON, answered, failed, refused, stated_length};
use crate::output::folder_of;
use crate::viewer::{AnnotationFile, MOST_BYTES, followed_links, save_annotations};

/// The tag where there is no file.
const NO_FILE: &str = "\"none\"";

/// A file of annotations, which requests may read and replace.
#[derive(Debug)]
pub struct NoteFile {
    path: PathBuf,
    /// One request after another compares and writes.
    turn: Mutex<()>,
}

impl NoteFile {
    /// The file of a path, which need not exist.
    pub fn new(path: PathBuf) -> Self {
        Self { path, turn: Mutex::new(()) }
    }

    /// Whether both write the same file.
    pub fn is_same(&self, other: &Self) -> bool {
        place_of(&self.path) == place_of(&other.path)
    }

    /// What the file holds now.
    pub fn given(&self, head_only: bool) -> Answer<'static> {
        match AnnotationFile::read(&self.path) {
            Ok(file) => {
                let headers = format!("Content-Type: {JSON}\r\nETag: {}\r\n", tag_of(file.as_ref()));
                let mut answer = answered("200 OK", &headers, file.unwrap_or_default().bytes().into());
                if head_only {
                    answer.body = Vec::new().into();
                }
                answer
            }
            Err(error) => failed("409 Conflict", &error),
        }
    }

    /// Writes annotations over those that the sender had read; the answer says what is wrong with them, that the file holds others,
    /// or why it cannot be written.
    pub fn replaced(&self, headers: &[httparse::Header], body: &[u8]) -> Answer<'static> {
        let values = |name: &'static str| headers.iter().filter(move |h| h.name.eq_ignore_ascii_case(name));
        // Pages of other sites cannot send this type without being asked first.
        if !values("content-type").any(|h| h.value.starts_with(JSON.as_bytes())) {
            return refused("415 Unsupported Media Type");
        }
        match stated_length(headers) {
            None => return refused("411 Length Required"),
            Some(length) if length > MOST_BYTES => return refused("413 Content Too Large"),
            Some(length) if length != body.len() => return refused("400 Bad Request"),
            Some(_) => {}
        }
        let Some(known) = values("if-match").next() else { return refused("428 Precondition Required") };
        let file = match AnnotationFile::parse(body) {
            Ok(file) => file,
            Err(error) => return failed("400 Bad Request", &error),
        };
        let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
        match self.write_over(known.value, &file) {
            Ok(true) => answered("200 OK", &format!("ETag: {}\r\n", tag_of(Some(&file))), Vec::new().into()),
            Ok(false) => refused("412 Precondition Failed"),
            Err(error) if error.kind() == ErrorKind::Io => failed("500 Internal Server Error", &error),
            Err(error) => failed("409 Conflict", &error),
        }
    }

    /// Writes the file if it still has a tag; false where it has another.
    fn write_over(&self, tag: &[u8], file: &AnnotationFile) -> Result<bool> {
        // Other servers of the file wait; where the system locks no folders, only those of this process do.
        let folder = fs::File::open(folder_of(&followed_links(&self.path)));
        let _lock = folder.and_then(|folder| folder.lock().map(|()| folder));
        if tag_of(AnnotationFile::read(&self.path)?.as_ref()).as_bytes() != tag {
            return Ok(false);
        }
        let bytes = file.bytes();
        if bytes.len() > MOST_BYTES {
            let found = bytes.len();
            return Err(Error::limit(format!(
                "annotations have at most {MOST_BYTES} bytes in all: found {found}"
            )));
        }
        save_annotations(&self.path, bytes)?;
        Ok(true)
    }
}

/// What tells annotations from others; the same for as long as the program runs.
fn tag_of(file: Option<&AnnotationFile>) -> String {
    let Some(file) = file else { return NO_FILE.to_owned() };
    let mut hasher = DefaultHasher::new();
    file.bytes().hash(&mut hasher);
    format!("\"{:016x}\"", hasher.finish())
}

/// The one path of a file, however it is named.
fn place_of(path: &Path) -> PathBuf {
    let path = followed_links(path);
    let folder = fs::canonicalize(folder_of(&path)).unwrap_or_else(|_| folder_of(&path).to_owned());
    path.file_name().map_or_else(|| folder.clone(), |name| folder.join(name))
}
