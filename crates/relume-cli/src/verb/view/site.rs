//! What the server answers: a fixed set of files, to requests that know the token and come from this machine's browser. Of
//! these, files of annotations can be replaced, by annotations and nothing else.
//!
//! Pages of other sites can make a browser ask servers of its machine. So a request has to name the host by which the
//! server was announced (against rebinding of names), must not come from another origin, and its path begins with a
//! random token. Paths are compared as they are: nothing is decoded, joined or looked up on disk. Squares of endless planes have
//! two whole numbers in their names, in the one form in which they are written.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use relume::format::share::blocks::block_of;
use relume::{Error, ErrorKind, Job, Result};

use super::blocks::ServedBlocks;
use crate::paths;
use crate::viewer::{AnnotationFile, FOLDER_POLICY, MOST_BYTES, ServedPlane, save_annotations};

/// Headers of a request that are read; browsers send about fifteen.
const MOST_HEADERS: usize = 64;

/// The files of a page and the address at which they are.
#[derive(Debug)]
pub struct ViewerSite {
    port: u16,
    token: String,
    files: BTreeMap<String, SiteFile>,
    /// Endless planes by their folders.
    planes: BTreeMap<String, ServedBlocks>,
    job: Job,
    notes: BTreeMap<String, NoteFile>,
}

#[derive(Debug)]
struct SiteFile {
    kind: &'static str,
    bytes: Vec<u8>,
}

/// A file of annotations: where it is written, and what it holds.
#[derive(Debug)]
struct NoteFile {
    path: PathBuf,
    bytes: Mutex<Vec<u8>>,
}

/// The answer to a request.
#[derive(Debug, PartialEq)]
pub struct Answer<'a> {
    /// Status and headers, with the empty line.
    pub head: String,
    /// The content; empty for HEAD requests.
    pub body: Cow<'a, [u8]>,
}

impl ViewerSite {
    /// A site without files, with a token of 128 random bits; what it makes belongs to the job.
    ///
    /// # Errors
    /// When the system has no random numbers.
    pub fn new(port: u16, job: Job) -> Result<Self> {
        let mut bytes = [0u8; 16];
        getrandom::fill(&mut bytes).map_err(|e| {
            Error::new(ErrorKind::Io, format!("the system gives no random numbers for the address: {e}"))
        })?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let (files, planes, notes) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        Ok(Self { port, token, files, planes, job, notes })
    }

    /// The address of the page.
    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Adds a file by its path below the page; the page itself has the empty name.
    pub fn add(&mut self, name: &str, kind: &'static str, bytes: Vec<u8>) {
        self.files.insert(name.to_owned(), SiteFile { kind, bytes });
    }

    /// Adds an endless plane whose squares are in a folder, named with its last slash.
    pub fn add_plane(&mut self, folder: &str, plane: ServedPlane) {
        self.planes.insert(folder.to_owned(), ServedBlocks::new(plane));
    }

    /// Adds a file of annotations, which requests may replace.
    pub fn add_notes(&mut self, name: &str, path: PathBuf, bytes: Vec<u8>) {
        self.notes.insert(name.to_owned(), NoteFile { path, bytes: Mutex::new(bytes) });
    }

    /// Whether there is a file of that name.
    pub fn has(&self, name: &str) -> bool {
        self.files.contains_key(name)
    }

    /// The bytes that follow the head of a request which may send some; `None` for all others.
    pub fn body_length(&self, head: &[u8]) -> Option<usize> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        let _ = request.parse(head);
        let is_ours = request.method == Some("POST") && self.is_from_here(request.headers);
        let of_notes = self.notes.contains_key(self.name(request.path?)?);
        stated_length(request.headers).filter(|length| is_ours && of_notes && *length <= MOST_BYTES)
    }

    /// The answer to a request whose head, with its empty line, is in `head`.
    pub fn answer(&self, head: &[u8], body: &[u8]) -> Answer<'_> {
        let mut headers = [httparse::EMPTY_HEADER; MOST_HEADERS];
        let mut request = httparse::Request::new(&mut headers);
        if !matches!(request.parse(head), Ok(httparse::Status::Complete(_))) {
            return refused("400 Bad Request");
        }
        let (Some(method), Some(path)) = (request.method, request.path) else {
            return refused("400 Bad Request");
        };
        if !self.is_from_here(request.headers) {
            return refused("403 Forbidden");
        }
        let name = self.name(path);
        let notes = name.and_then(|name| self.notes.get(name));
        match (method, notes) {
            ("POST", Some(notes)) => notes.replaced(request.headers, body),
            ("GET" | "HEAD", Some(notes)) => found(JSON, Cow::Owned(notes.read()), method == "HEAD"),
            ("GET" | "HEAD", None) => self.given(name, method == "HEAD"),
            _ => refused("405 Method Not Allowed"),
        }
    }

    /// A file, or a square of an endless plane.
    fn given(&self, name: Option<&str>, head_only: bool) -> Answer<'_> {
        let Some(name) = name else { return refused("404 Not Found") };
        if let Some(file) = self.files.get(name) {
            return found(file.kind, Cow::Borrowed(&file.bytes), head_only);
        }
        match self.block(name) {
            Some(Ok(bytes)) => found("application/octet-stream", Cow::Owned(bytes), head_only),
            Some(Err(_)) => refused("500 Internal Server Error"),
            None => refused("404 Not Found"),
        }
    }

    /// The name of a file in a path; a query is ignored.
    fn name<'p>(&self, path: &'p str) -> Option<&'p str> {
        path.split('?').next()?.strip_prefix('/')?.strip_prefix(&*self.token)?.strip_prefix('/')
    }

    /// The square of an endless plane.
    fn block(&self, name: &str) -> Option<Result<Vec<u8>>> {
        let (folder, file) = name.split_at(name.rfind('/')? + 1);
        Some(self.planes.get(folder)?.get(block_of(file)?, &self.job))
    }

    /// Whether the host is that of the address, and the origin, if any, as well.
    fn is_from_here(&self, headers: &[httparse::Header]) -> bool {
        let values = |name: &'static str| {
            headers.iter().filter(move |h| h.name.eq_ignore_ascii_case(name)).map(|h| h.value)
        };
        let hosts = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        let is_ours = |value: &[u8]| hosts.iter().any(|host| host.as_bytes() == value);
        let mut named = values("host");
        let one_host = named.next().is_some_and(is_ours) && named.next().is_none();
        one_host && values("origin").all(|origin| origin.strip_prefix(b"http://").is_some_and(is_ours))
    }
}

impl NoteFile {
    fn read(&self) -> Vec<u8> {
        self.bytes.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Writes annotations; the answer says what is wrong with them, or why they cannot be written.
    fn replaced(&self, headers: &[httparse::Header], body: &[u8]) -> Answer<'static> {
        let is_json = headers
            .iter()
            .any(|h| h.name.eq_ignore_ascii_case("content-type") && h.value.starts_with(b"application/json"));
        // Pages of other sites cannot send this type without being asked first.
        if !is_json {
            return refused("415 Unsupported Media Type");
        }
        match stated_length(headers) {
            None => return refused("411 Length Required"),
            Some(length) if length > MOST_BYTES => return refused("413 Content Too Large"),
            Some(length) if length != body.len() => return refused("400 Bad Request"),
            Some(_) => {}
        }
        let mut kept = self.bytes.lock().unwrap_or_else(PoisonError::into_inner);
        let written = AnnotationFile::parse(body).and_then(|file| {
            save_annotations(&self.path, file.bytes())?;
            Ok(file.bytes())
        });
        match written {
            Ok(bytes) => {
                *kept = bytes;
                refused("204 No Content")
            }
            Err(error) => {
                let said = paths::on_one_line(&error.to_string());
                let body = serde_json::json!({ "error": said }).to_string().into_bytes();
                let status = if error.kind() == ErrorKind::Io {
                    "500 Internal Server Error"
                } else {
                    "400 Bad Request"
                };
                answered(status, JSON, body.into(), false)
            }
        }
    }
}

/// The length of the content that a request states; `None` for none, several, or a transfer in pieces.
fn stated_length(headers: &[httparse::Header]) -> Option<usize> {
    let values = |name: &'static str| headers.iter().filter(move |h| h.name.eq_ignore_ascii_case(name));
    let mut stated = values("content-length");
    let digits = stated.next().filter(|_| stated.next().is_none())?.value;
    let is_number = digits.len() <= 9 && digits.iter().all(u8::is_ascii_digit);
    let in_pieces = values("transfer-encoding").next().is_some();
    std::str::from_utf8(digits).ok().filter(|_| is_number && !in_pieces)?.parse().ok()
}

const JSON: &str = "application/json";

fn found<'a>(kind: &str, body: Cow<'a, [u8]>, head_only: bool) -> Answer<'a> {
    answered("200 OK", kind, body, head_only)
}

fn answered<'a>(status: &str, kind: &str, body: Cow<'a, [u8]>, head_only: bool) -> Answer<'a> {
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nContent-Security-Policy: {FOLDER_POLICY}; \
         frame-ancestors 'none'\r\n{COMMON}\r\n",
        body.len()
    );
    Answer { head, body: if head_only { Cow::Borrowed(&[]) } else { body } }
}

/// An answer without content.
pub fn refused(status: &str) -> Answer<'static> {
    Answer {
        head: format!("HTTP/1.1 {status}\r\nContent-Length: 0\r\n{COMMON}\r\n"),
        body: Cow::Borrowed(&[]),
    }
}

/// Headers of all answers.
const COMMON: &str = "Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
                      Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
                      Cross-Origin-Opener-Policy: same-origin\r\n";

#[cfg(test)]
mod tests;
