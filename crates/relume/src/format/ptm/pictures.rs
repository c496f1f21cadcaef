//! The bytes of a field as pictures of three planes, for formats that store such pictures.

use super::header::{Header, Layout};
use super::{PtmEncoding, Under, encode};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;

/// Scale and bias of a field, and its bytes: of LRGB and luminance u^2, v^2 and uv, then u, v and 1, then colours; of
/// RGB one picture for each coefficient. Three interleaved channels, rows from the top.
///
/// # Errors
/// As [`encode`].
pub(in crate::format) fn pictures(
    field: &ReflectanceField,
    job: &Job,
) -> Result<(PtmEncoding, Vec<Vec<u8>>)> {
    let raw = encode(field, Under::Chosen, job)?;
    let header = Header::parse(&raw)?;
    let planes: Vec<[usize; 3]> = match header.layout {
        Layout::Rgb => (0..6).map(|k| [k, 6 + k, 12 + k]).collect(),
        _ => (0..3).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
    };
    let (size, payload) = (header.size, &raw[header.payload..]);
    let picture = |three: [usize; 3]| -> Vec<u8> {
        let combs = three.map(|plane| header.layout.comb(plane, size.texels()));
        // Rows run from the bottom in the file.
        let texels = (0..size.height).rev().flat_map(|y| y * size.width..(y + 1) * size.width);
        texels.flat_map(|texel| combs.map(|comb| payload[comb.start + texel * comb.stride])).collect()
    };
    Ok((header.encoding, planes.into_iter().map(picture).collect()))
}
