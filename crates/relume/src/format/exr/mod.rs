//! OpenEXR files: named channels, plain linear pictures, and lossless fields.
//!
//! One part of scan lines, ZIP-compressed, in increasing order, rows from the top; large files optionally in
//! tiles of one resolution. Layout of the container: "OpenEXR File Layout", Academy Software Foundation.

#[cfg(not(feature = "exr"))]
mod absent;
#[cfg(feature = "exr")]
mod attributes;
mod blocks;
mod channels;
mod clustered;
mod container;
mod field;
#[cfg(feature = "exr")]
mod huffman;
mod learned;
mod nonlinear;
mod numbers;
mod parametric;
mod picture;
#[cfg(feature = "exr")]
mod reading;
mod tiles;
#[cfg(feature = "exr")]
mod writing;
#[cfg(feature = "exr")]
mod zip;

/// What decodes and encodes.
mod codec {
    #[cfg(not(feature = "exr"))]
    pub(in crate::format) use super::absent::{decode, head, write_blocks};
    #[cfg(feature = "exr")]
    pub(in crate::format) use super::{
        reading::{decode, head},
        writing::write_blocks,
    };
}

pub(super) use blocks::{Head, ROWS, write_samples};
pub(super) use codec::{head, write_blocks};
pub(super) use field::{ExrField, decode_field, decode_picture, encode_field, field_head, is_field};
pub(super) use picture::encode_picture;
pub(super) use tiles::tiles_of;

pub use clustered::{decode_clustered, encode_clustered};
pub(super) use nonlinear::{holds_models, nonlinear};
pub use parametric::{decode_parametric, encode_parametric};
pub use tiles::encode_tiles;

use crate::clipping::{Clipper, Clipping};
use crate::error::Result;
use crate::job::Job;
use crate::planes::Planes;
use container::Layer;

/// The type of the samples of an EXR file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ExrDepth {
    /// 16-bit floats: 11 significant bits, up to 65,504.
    Half,
    /// 32-bit floats: lossless.
    Float,
}

/// Counts the values that samples of this type cannot hold.
pub(super) fn count_clipped(planes: &Planes, depth: ExrDepth, job: &Job) {
    if depth == ExrDepth::Half {
        job.count_clipped(Clipper::Halves, Clipping::of(planes.as_slice(), Clipper::Halves));
    }
}

impl ExrDepth {
    /// Bytes of one sample.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Float => 4,
        }
    }
}

/// The bytes of an EXR file with a channel for each plane, under the given names: maps of measured
/// quantities, source maps. Integers are exact as floats up to 2^24.
///
/// # Errors
/// When the numbers of names and planes differ, or a name is empty, not plain text or given twice.
pub fn encode_labelled(names: &[&str], planes: &Planes, depth: ExrDepth) -> Result<Vec<u8>> {
    encode_with_texts(names, planes, depth, &[], &Job::unlimited())
}

/// [`encode_labelled`] as a part of a job.
///
/// # Errors
/// As [`encode_labelled`]; limits exceeded, and a cancelled job.
pub fn encode_labelled_with(names: &[&str], planes: &Planes, depth: ExrDepth, job: &Job) -> Result<Vec<u8>> {
    encode_with_texts(names, planes, depth, &[], job)
}

/// As [`encode_labelled_with`], with text attributes.
pub(super) fn encode_with_texts(
    names: &[&str],
    planes: &Planes,
    depth: ExrDepth,
    texts: &[(&str, String)],
    job: &Job,
) -> Result<Vec<u8>> {
    let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
    container::encode(&names, planes, depth, texts, job)
}

/// All channels of an EXR file, in alphabetical order of their names.
///
/// # Errors
/// As for pictures.
pub fn decode_labelled(bytes: &[u8], job: &Job) -> Result<(Vec<String>, Planes)> {
    let Layer { names, planes, .. } = codec::decode(bytes, job)?;
    Ok((names, planes))
}
