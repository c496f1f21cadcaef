//! OpenEXR files: named channels, plain linear pictures, and fields without loss.
//!
//! One part of scan lines, ZIP-compressed, in increasing order, rows from the top. Layout of the
//! container: "OpenEXR File Layout", Academy Software Foundation.

mod attributes;
mod container;
mod field;
mod picture;

pub(super) use field::{decode_field, encode_field};
pub(super) use picture::{decode_picture, encode_picture};

use crate::error::Result;
use crate::limits::Limits;
use crate::planes::Planes;
use container::Layer;

/// The type of the samples of an EXR file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ExrDepth {
    /// 16-bit floats: 11 significant bits, up to 65,504.
    Half,
    /// 32-bit floats: nothing is lost.
    Float,
}

/// The bytes of an EXR file with a channel for each plane, under the given names: maps of
/// measured quantities, source maps. Whole numbers are exact as floats up to 2^24.
///
/// # Errors
/// When the number of names differs from that of planes, or a name is empty, not plain text or
/// given twice.
pub fn encode_labelled(names: &[&str], planes: &Planes, depth: ExrDepth) -> Result<Vec<u8>> {
    let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
    container::encode(&names, planes, depth, &[])
}

/// The channels of an EXR file, whatever they are, in alphabetical order of their names.
///
/// # Errors
/// As for pictures.
pub fn decode_labelled(bytes: &[u8], limits: &Limits) -> Result<(Vec<String>, Planes)> {
    let Layer { names, planes, .. } = container::decode(bytes, limits)?;
    Ok((names, planes))
}
