//! PNG files row by row.

use std::io::Write;

use super::{Lane, StreamKind, unwritable};
use crate::error::Result;
use crate::format::png::{encoder, failed};
use crate::format::rows::Rows;
use crate::format::{Depth, codes};
use crate::job::Job;
use crate::picture::Picture;
use crate::size::Size;

/// The codes of a picture.
pub(super) fn lanes(picture: &Picture, depth: Depth, job: &Job) -> Result<(Vec<Lane>, StreamKind)> {
    let channels = picture.planes.count();
    let (bytes, data) = match depth {
        Depth::Eight => (1, codes::interleaved8(picture, job)?),
        Depth::Sixteen => {
            (2, codes::interleaved16(picture, job)?.into_iter().flat_map(u16::to_be_bytes).collect())
        }
    };
    Ok((vec![Lane { bytes_per_texel: bytes * channels, data }], StreamKind::Png { channels, depth }))
}

/// Writes the file.
pub(super) fn write(
    size: Size,
    channels: usize,
    depth: Depth,
    out: impl Write,
    rows: &mut Rows<'_>,
) -> Result<()> {
    let (bits, bytes) = match depth {
        Depth::Eight => (::png::BitDepth::Eight, 1),
        Depth::Sixteen => (::png::BitDepth::Sixteen, 2),
    };
    let mut file = encoder(out, size, channels, bits)?.write_header().map_err(failed)?;
    let mut stream = file.stream_writer().map_err(failed)?;
    let mut row = vec![0; size.width * channels * bytes];
    for y in 0..size.height {
        rows(0, 0, y, &mut row)?;
        stream.write_all(&row).map_err(|e| unwritable(&e))?;
    }
    stream.finish().map_err(failed)?;
    file.finish().map_err(failed)
}
