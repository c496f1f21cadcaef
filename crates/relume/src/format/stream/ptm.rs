//! Polynomial texture maps in rows, from the last one to the first.

use std::io::{Seek, SeekFrom, Write};

use super::{Lane, StreamKind, unwritable};
use crate::error::{Error, Result};
use crate::format::rows::Rows;
use crate::size::Size;

/// The positions of width and height among the header lines written by this program.
const SIZE_LINES: [usize; 2] = [2, 3];

/// The blocks of a file written by this program, and the lines of its header.
pub(super) fn lanes(file: &[u8], size: Size) -> Result<(Vec<Lane>, StreamKind)> {
    let mut header = Vec::new();
    let mut rest = file;
    for _ in 0..6 {
        let end =
            rest.iter().position(|&b| b == b'\n').ok_or_else(|| Error::invalid("a .ptm header is short"))?;
        header.push(String::from_utf8_lossy(&rest[..end]).into_owned());
        rest = &rest[end + 1..];
    }
    let blocks: &[usize] = if header[1] == "PTM_FORMAT_LRGB" { &[6, 3] } else { &[6, 6, 6] };
    let mut lanes = Vec::new();
    for &bytes_per_texel in blocks {
        let (block, later) = rest.split_at(size.texels() * bytes_per_texel);
        let rows = block.chunks_exact(size.width * bytes_per_texel).rev();
        lanes.push(Lane { bytes_per_texel, data: rows.flatten().copied().collect() });
        rest = later;
    }
    Ok((lanes, StreamKind::Ptm { header }))
}

/// Writes the file row by row from the last one, each into all blocks, so that computed rows are computed
/// once.
pub(super) fn write(
    header: &[String],
    lanes: &[Lane],
    size: Size,
    mut out: impl Write + Seek,
    rows: &mut Rows<'_>,
) -> Result<()> {
    let mut header = header.to_vec();
    for (line, side) in SIZE_LINES.into_iter().zip([size.width, size.height]) {
        header[line] = side.to_string();
    }
    let header = header.join("\n") + "\n";
    out.write_all(header.as_bytes()).map_err(|e| unwritable(&e))?;
    let mut blocks: Vec<Block> = Vec::new();
    for lane in lanes {
        let at = blocks.last().map_or(header.len() as u64, |block| block.end(size.height));
        blocks.push(Block { at, row: vec![0; size.width * lane.bytes_per_texel] });
    }
    for (from_bottom, y) in (0..size.height).rev().enumerate() {
        for (number, block) in blocks.iter_mut().enumerate() {
            rows(number, 0, y, &mut block.row)?;
            let place = SeekFrom::Start(block.end(from_bottom));
            out.seek(place).and_then(|_| out.write_all(&block.row)).map_err(|e| unwritable(&e))?;
        }
    }
    out.flush().map_err(|e| unwritable(&e))
}

/// The position of a block in the file, and one row of it.
struct Block {
    at: u64,
    row: Vec<u8>,
}

impl Block {
    /// The end of the given number of rows.
    fn end(&self, rows: usize) -> u64 {
        self.at + rows as u64 * self.row.len() as u64
    }
}
