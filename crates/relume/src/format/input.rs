//! Whole files as bytes, and what kind of file bytes are.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Result};
use crate::job::Job;

/// The kinds of files that readers know by their first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Ptm,
    Exr,
    Png,
    Jpeg,
    Tiff,
}

/// First bytes of each kind.
const SIGNATURES: [(&[u8], Kind); 6] = [
    (b"PTM_", Kind::Ptm),
    (&[0x76, 0x2f, 0x31, 0x01], Kind::Exr),
    (b"\x89PNG\r\n\x1a\n", Kind::Png),
    (&[0xff, 0xd8, 0xff], Kind::Jpeg),
    (b"II\x2a\0", Kind::Tiff),
    (b"MM\0\x2a", Kind::Tiff),
];

impl Kind {
    /// The kind of file that `bytes` are.
    pub(super) fn of(bytes: &[u8]) -> Result<Self> {
        let found = SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature));
        found.map(|&(_, kind)| kind).ok_or_else(|| unknown(bytes))
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ptm => "PTM",
            Self::Exr => "EXR",
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
        }
    }
}

fn unknown(bytes: &[u8]) -> Error {
    if bytes.is_empty() {
        return Error::invalid("the file is empty: expected PNG, JPEG, TIFF, EXR or PTM");
    }
    if super::rlm::is_model(bytes) {
        return Error::unsupported(
            "the file is a random-field model: expected a texture; `relume synth` makes one of it",
        );
    }
    let start: Vec<String> = bytes.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    Error::unsupported(format!(
        "the file is none of PNG, JPEG, TIFF, EXR and PTM (it begins with the bytes {}): convert it to one of these",
        start.join(" ")
    ))
}

/// All bytes of a file, refused when they exceed the limits.
pub(super) fn read_file(path: &Path, job: &Job) -> Result<Vec<u8>> {
    read_whole(path, job).map_err(|error| error.at(path))
}

fn read_whole(path: &Path, job: &Job) -> Result<Vec<u8>> {
    let io = |source: std::io::Error| Error::io("cannot read the file", &source);
    let file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    if metadata.is_dir() {
        return Err(Error::usage("this is a folder: expected a file"));
    }
    job.check_bytes("the file", metadata.len())?;
    // A pipe or a device has no length, so what is read is bounded as well.
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    file.take(job.limits().max_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    job.check_bytes("the file", bytes.len() as u64)?;
    Ok(bytes)
}

/// What a decoder of another crate complains of, on one line and not too long.
pub(super) fn complaint(kind: Kind, error: &impl std::fmt::Display) -> String {
    const LONGEST: usize = 200;
    let line = error.to_string().replace('\n', " ");
    let cut: String = line.chars().take(LONGEST).collect();
    let dots = if cut.len() < line.len() { "..." } else { "" };
    format!("the {} data cannot be decoded: {cut}{dots}", kind.name())
}
