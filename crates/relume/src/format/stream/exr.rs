//! EXR fields in blocks of rows.

use std::io::{Read, Seek, Write};

use super::{Kind, Lane, Rows};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::format::ExrDepth;
use crate::format::exr;
use crate::planes::Size;

/// The samples of each channel, in the order of the file.
pub(super) fn lanes(field: &ReflectanceField, depth: ExrDepth) -> Result<(Vec<Lane>, Kind)> {
    let (names, attributes) = exr::field_head(field);
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&a, &b| names[a].cmp(&names[b]));
    let lane = |&k: &usize| {
        let data = exr::sample_bytes(field.coefficients().plane(k), depth);
        Lane { bytes_per_texel: depth.bytes(), data }
    };
    let lanes = order.iter().map(lane).collect();
    let names = order.iter().map(|&k| names[k].clone()).collect();
    Ok((lanes, Kind::Exr { names, depth, attributes }))
}

/// Writes the file.
pub(super) fn write(
    names: &[String],
    depth: ExrDepth,
    attributes: &[(&'static str, String)],
    size: Size,
    out: impl Read + Write + Seek,
    rows: &mut Rows<'_>,
) -> Result<()> {
    exr::write_rows(names, depth, attributes, size, out, rows)
}
