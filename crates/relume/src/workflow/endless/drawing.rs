//! A window about to be written.

use std::fmt;
use std::io::{Cursor, Read, Seek, Write};
use std::sync::Arc;

use crate::error::{Error, Result};
use crate::format::{FieldFormat, Rows, Streamed};
use crate::job::Job;
use crate::size::Size;

/// The file for a window.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileTarget {
    /// Its format.
    pub format: FieldFormat,
    /// The tiles of an EXR file, so that readers can load any part alone.
    pub tile: Option<Size>,
}

impl FileTarget {
    /// In the requested tiles.
    pub(super) fn laid(&self, streamed: Streamed) -> Result<Streamed> {
        match self.tile {
            Some(tile) => streamed.in_tiles(tile),
            None => Ok(streamed),
        }
    }
}

/// A window about to be written: none of its texels are in memory yet, unless its format is not written in
/// rows.
pub struct Drawing<'a>(DrawingKind<'a>);

enum DrawingKind<'a> {
    Rows { streamed: Arc<Streamed>, size: Size, rows: Box<Rows<'a>>, job: &'a Job },
    Whole(Vec<u8>),
}

impl<'a> Drawing<'a> {
    /// A window written row by row; `rows` may contain the data that `streamed` encodes.
    pub(super) fn of_rows(streamed: Arc<Streamed>, size: Size, job: &'a Job, rows: Box<Rows<'a>>) -> Self {
        Self(DrawingKind::Rows { streamed, size, rows, job })
    }

    /// A window made as a whole.
    pub(super) fn whole(bytes: Vec<u8>) -> Self {
        Self(DrawingKind::Whole(bytes))
    }

    /// Writes the file.
    ///
    /// # Errors
    /// A size or rows beyond the limits, errors of the system, and a cancelled job.
    pub fn write(self, mut out: impl Read + Write + Seek) -> Result<()> {
        match self.0 {
            DrawingKind::Whole(bytes) => {
                out.write_all(&bytes).map_err(|e| Error::io("cannot write the file", &e))
            }
            DrawingKind::Rows { streamed, size, mut rows, job } => {
                job.check("the output", size, 0)?;
                job.check_bytes("the rows of the output", streamed.working_bytes(size))?;
                let across = size.width.div_ceil(streamed.block(size).width);
                job.start("drawing rows", (size.height * streamed.lanes().len() * across) as u64);
                streamed.write(size, out, &mut |lane, x, y, row| {
                    job.advance(1)?;
                    rows(lane, x, y, row)
                })
            }
        }
    }

    /// The bytes of the file, for outputs that cannot seek.
    ///
    /// # Errors
    /// As [`Drawing::write`], and a file beyond the limits.
    pub fn into_bytes(self) -> Result<Vec<u8>> {
        match self.0 {
            DrawingKind::Whole(bytes) => Ok(bytes),
            DrawingKind::Rows { ref streamed, size, job, .. } => {
                let texel: usize = streamed.lanes().iter().map(|lane| lane.bytes_per_texel).sum();
                job.check("the output", size, texel as u64)?;
                let mut bytes = Cursor::new(Vec::new());
                self.write(&mut bytes)?;
                Ok(bytes.into_inner())
            }
        }
    }
}

impl fmt::Debug for Drawing<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            DrawingKind::Rows { size, .. } => {
                f.debug_struct("Drawing").field("size", size).finish_non_exhaustive()
            }
            DrawingKind::Whole(bytes) => f.debug_struct("Drawing").field("bytes", &bytes.len()).finish(),
        }
    }
}
