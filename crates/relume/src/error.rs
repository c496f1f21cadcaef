//! One error type for the library: who is at fault, and one sentence that says what failed, where, what was
//! expected, what was found and what to do.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A library result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Who is at fault for an [`Error`].
///
/// [`ErrorKind::Usage`] is the fault of the caller, [`ErrorKind::Invalid`] and [`ErrorKind::Unsupported`]
/// that of a file; the others concern the machine and the job.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An option or argument cannot be used; the caller has to change it.
    Usage,
    /// The content of a file violates its format.
    Invalid,
    /// The content is valid, but this version does not support it.
    Unsupported,
    /// The job is larger than the limits allow.
    Limit,
    /// The operating system refused a read or a write.
    Io,
    /// The job was cancelled before it was done.
    Cancelled,
}

/// What went wrong, in one sentence, and the file concerned, if any.
#[derive(Debug, Clone)]
pub struct Error {
    kind: ErrorKind,
    message: String,
    path: Option<PathBuf>,
    source: Option<Arc<io::Error>>,
}

impl Error {
    /// An error of the given kind, not yet with a file; see [`Error::at`].
    pub fn new(kind: ErrorKind, message: impl Into<String>) -> Self {
        Self { kind, message: message.into(), path: None, source: None }
    }

    /// A [`ErrorKind::Usage`] error.
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Usage, message)
    }

    /// A [`ErrorKind::Invalid`] error.
    pub fn invalid(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Invalid, message)
    }

    /// A [`ErrorKind::Unsupported`] error.
    pub fn unsupported(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Unsupported, message)
    }

    /// A [`ErrorKind::Limit`] error.
    pub fn limit(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Limit, message)
    }

    /// An [`ErrorKind::Io`] error: the operation, and the reason given by the system, whose error is kept as
    /// the [`source`](std::error::Error::source).
    pub fn io(doing: impl fmt::Display, source: &io::Error) -> Self {
        let message = format!("{doing}: {source}");
        let copy = match source.raw_os_error() {
            Some(code) => io::Error::from_raw_os_error(code),
            None => io::Error::new(source.kind(), source.to_string()),
        };
        Self { source: Some(Arc::new(copy)), ..Self::new(ErrorKind::Io, message) }
    }

    /// Adds the file concerned, unless a more specific place has already been named.
    #[must_use]
    pub fn at(mut self, path: impl AsRef<Path>) -> Self {
        self.path.get_or_insert_with(|| path.as_ref().to_path_buf());
        self
    }

    /// Who is at fault.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// The sentence without the file name.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The file concerned, if any.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.path {
            Some(path) => write!(f, "{}: {}", path.display(), self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.source.as_deref().map(|source| source as _)
    }
}

/// Errors are equal when they say the same; the system's error is part of the message.
impl PartialEq for Error {
    fn eq(&self, other: &Self) -> bool {
        (self.kind, &self.message, &self.path) == (other.kind, &other.message, &other.path)
    }
}

impl Eq for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_reason_is_the_source() {
        let refused = io::Error::from_raw_os_error(13);
        let error = Error::io("cannot read the file", &refused).at("a.png");
        let source = std::error::Error::source(&error).and_then(|e| e.downcast_ref::<io::Error>());
        assert_eq!(source.and_then(io::Error::raw_os_error), Some(13));
        assert!(error.to_string().starts_with("a.png: cannot read the file: "), "{error}");
        assert!(std::error::Error::source(&Error::usage("asked wrongly")).is_none());
    }
}
