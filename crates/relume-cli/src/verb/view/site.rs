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

use relume::format::share::blocks::block_of;
use relume::{Error, ErrorKind, Job, Result};

use super::blocks::ServedBlocks;
use super::notes::NoteFile;
use crate::paths;
use crate::viewer::{FOLDER_POLICY, MOST_BYTES, ServedPlane};

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

    /// Adds a file of annotations, which requests may replace; gives its name, which is that of another texture where both have the
    /// same file.
    pub fn add_notes(&mut self, name: String, path: PathBuf) -> String {
        let file = NoteFile::new(path);
        if let Some((known, _)) = self.notes.iter().find(|(_, other)| other.is_same(&file)) {
            return known.clone();
        }
        self.notes.insert(name.clone(), file);
        name
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
            ("GET" | "HEAD", Some(notes)) => notes.given(method == "HEAD"),
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
            Some(Err(error)) => failed("500 Internal Server Error", &error),
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

/// The length of the content that a request states; `None` for none, several, or a transfer in pieces.
pub(super) fn stated_length(headers: &[httparse::Header]) -> Option<usize> {
    let values = |name: &'static str| headers.iter().filter(move |h| h.name.eq_ignore_ascii_case(name));
    let mut stated = values("content-length");
    let digits = stated.next().filter(|_| stated.next().is_none())?.value;
    let is_number = digits.len() <= 9 && digits.iter().all(u8::is_ascii_digit);
    let in_pieces = values("transfer-encoding").next().is_some();
    std::str::from_utf8(digits).ok().filter(|_| is_number && !in_pieces)?.parse().ok()
}

pub(super) const JSON: &str = "application/json";

pub(super) fn found<'a>(kind: &str, body: Cow<'a, [u8]>, head_only: bool) -> Answer<'a> {
    let answer = answered("200 OK", &format!("Content-Type: {kind}\r\n"), body);
    if head_only { Answer { body: Cow::Borrowed(&[]), ..answer } } else { answer }
}

/// A sentence about what went wrong, which the page shows.
pub(super) fn failed(status: &str, error: &Error) -> Answer<'static> {
    let said = paths::on_one_line(&error.to_string());
    let body = serde_json::json!({ "error": said }).to_string().into_bytes();
    answered(status, &format!("Content-Type: {JSON}\r\n"), body.into())
}

/// An answer with further headers, each with its line end.
pub(super) fn answered<'a>(status: &str, headers: &str, body: Cow<'a, [u8]>) -> Answer<'a> {
    let head = format!(
        "HTTP/1.1 {status}\r\n{headers}Content-Length: {}\r\nContent-Security-Policy: {FOLDER_POLICY}; \
         frame-ancestors 'none'\r\n{COMMON}\r\n",
        body.len()
    );
    Answer { head, body }
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
