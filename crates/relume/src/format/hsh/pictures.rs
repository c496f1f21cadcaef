//! The bytes of a field as a picture for each harmonic, for formats that store such pictures.

use super::header::HshHeader;
use super::{HshEncoding, encode_rti};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::job::Job;

/// Scale and bias of a field, and its bytes, red, green and blue of each harmonic. Rows run from the top.
///
/// # Errors
/// As [`encode_rti`].
pub(in crate::format) fn pictures(
    field: &ReflectanceField,
    job: &Job,
) -> Result<(HshEncoding, Vec<Vec<u8>>)> {
    if field.layout().is_product() {
        return pictures(&field.of_channels(&["R", "G", "B"], job)?, job);
    }
    let raw = encode_rti(field, None, job)?;
    let HshHeader { encoding, payload, .. } = HshHeader::parse(&raw)?;
    let terms = encoding.scale().len();
    let picture = |k: usize| -> Vec<u8> {
        let texels = raw[payload..].chunks_exact(3 * terms);
        texels.flat_map(|texel| [texel[k], texel[terms + k], texel[2 * terms + k]]).collect()
    };
    Ok((encoding, (0..terms).map(picture).collect()))
}
