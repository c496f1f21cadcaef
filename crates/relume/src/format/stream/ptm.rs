//! Polynomial texture maps block by block, each from its last row to its first.

use std::io::{BufWriter, Write};

use super::{Kind, Lane, Rows, unwritable};
use crate::error::{Error, Result};
use crate::planes::Size;

/// The places of width and height among the lines of the header that this program writes.
const SIZE_LINES: [usize; 2] = [2, 3];

/// The blocks of a file that this program wrote, and the lines of its header.
pub(super) fn lanes(file: &[u8], size: Size) -> Result<(Vec<Lane>, Kind)> {
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
    Ok((lanes, Kind::Ptm { header }))
}

/// Writes the file.
pub(super) fn write(
    header: &[String],
    lanes: &[Lane],
    size: Size,
    out: impl Write,
    rows: &mut Rows<'_>,
) -> Result<()> {
    let mut out = BufWriter::new(out);
    let mut header = header.to_vec();
    for (line, side) in SIZE_LINES.into_iter().zip([size.width, size.height]) {
        header[line] = side.to_string();
    }
    let mut put = |bytes: &[u8]| out.write_all(bytes).map_err(|e| unwritable(&e));
    header.iter().try_for_each(|line| put(format!("{line}\n").as_bytes()))?;
    for (number, lane) in lanes.iter().enumerate() {
        let mut row = vec![0; size.width * lane.bytes_per_texel];
        for y in (0..size.height).rev() {
            rows(number, 0, y, &mut row)?;
            put(&row)?;
        }
    }
    out.flush().map_err(|e| unwritable(&e))
}
