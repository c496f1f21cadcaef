//! A preview of a material as binary glTF: an object with its textures, and the functions where there are any.

use super::MaterialMaps;
use super::presets::{DataMap, MapContent};
use crate::error::Result;
use crate::format::ktx2::TextureFormat;
use crate::format::share::ShareFiles;
use crate::format::{GlbMaterial, GlbPreview, NormalY, encode_glb};
use crate::job::Job;
use crate::render::Mesh;

/// What a preview shows.
#[derive(Debug)]
pub struct PreviewObject<'a> {
    /// The object.
    pub mesh: &'a Mesh,
    /// Repetitions of the texture along both directions.
    pub tiling: [f64; 2],
    /// The functions of the texture.
    pub functions: Option<&'a ShareFiles>,
}

/// The file of a preview. What is not known of the material is as in packed files.
///
/// # Errors
/// The limits, and a cancelled job.
pub fn encode_preview(
    maps: &MaterialMaps,
    name: &str,
    object: &PreviewObject<'_>,
    job: &Job,
) -> Result<Vec<u8>> {
    const ORM: &[DataMap] = &[DataMap::Occlusion, DataMap::Roughness, DataMap::Metallic];
    let png = |content| Ok(maps.encoded("", content, TextureFormat::Png, None, job)?.0);
    let material = GlbMaterial {
        name: name.to_owned(),
        base_color: png(MapContent::Color { translucent: true })?,
        is_translucent: maps.opacity.is_some(),
        occlusion_roughness_metallic: png(MapContent::Packed(ORM))?,
        normal: png(MapContent::Normal(NormalY::Up))?,
        functions: object.functions,
    };
    encode_glb(&GlbPreview { mesh: object.mesh, tiling: object.tiling, material: &material }, job)
}
