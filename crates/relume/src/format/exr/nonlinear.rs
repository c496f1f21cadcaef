//! Textures in EXR files as they are, where they are not linear in the numbers of texels.

use super::codec;
use super::{ExrDepth, clustered, parametric};
use crate::error::Result;
use crate::field::NonlinearField;
use crate::format::kind::Kind;
use crate::job::Job;

/// The texture of a file as it is, where it is not linear in the numbers of texels, and the type of its samples.
pub(in crate::format) fn nonlinear(bytes: &[u8], job: &Job) -> Result<Option<(NonlinearField, ExrDepth)>> {
    if !holds(bytes, &[clustered::COUNTS_KEY, parametric::MODEL_KEY]) {
        return Ok(None);
    }
    let layer = codec::decode(bytes, job)?;
    let field = match clustered::is_clustered(&layer) {
        true => NonlinearField::Clusters(clustered::clustered_of(&layer, job)?),
        false => NonlinearField::Models(parametric::parametric_of(&layer)?),
    };
    Ok(Some((field, layer.depth)))
}

/// Whether a file holds reflectance models: its head says so.
pub(in crate::format) fn holds_models(bytes: &[u8]) -> bool {
    holds(bytes, &[parametric::MODEL_KEY])
}

fn holds(bytes: &[u8], keys: &[&str]) -> bool {
    let is_one = |key: &String| keys.contains(&key.as_str());
    Kind::of(bytes) == Some(Kind::Exr) && codec::head(bytes).is_ok_and(|(_, texts)| texts.keys().any(is_one))
}
