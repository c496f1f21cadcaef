//! What the fuzz targets do with bytes: every reader gives a value or an error, never a panic, within its memory.

use std::path::Path;
use std::sync::Arc;

use relume::capture::lp;
use relume::direction::{Direction, Directions};
use relume::format::bonn::BonnBtf;
use relume::format::web::decode_files;
use relume::format::{
    Content, decode_brdf, decode_field, decode_height, decode_mask, decode_mesh, decode_normals,
    decode_raster, npy, rlm,
};
use relume::{Job, Limits};

/// The memory that a reader may take for a file of some kilobytes.
const BYTES: u64 = 64 << 20;

fn job() -> Job {
    Job::new(Limits { max_bytes: BYTES, ..Limits::default() })
}

/// A file as any verb opens it, and then as everything it might be.
pub fn front(bytes: &[u8]) {
    let Ok(opened) = relume::format::read(bytes, "fuzz", &job()) else { return };
    let _ = match opened.content() {
        Content::Model => opened.into_model().map(drop),
        Content::Tiles => opened.into_tiles().map(drop),
        Content::Btf => opened.into_btf().map(drop),
        Content::Brdf => opened.into_brdf().map(drop),
        Content::Array => opened.into_array().map(drop),
        Content::Mesh | Content::Unknown => opened.into_mesh().map(drop),
        Content::Heights => opened.into_height().map(drop),
        _ => opened.into_exemplar().map(drop),
    };
}

/// Polynomial texture maps.
pub fn ptm(bytes: &[u8]) {
    let _ = decode_field(&with_start(b"PTM_1.", bytes), &job());
}

/// Harmonics.
pub fn hsh(bytes: &[u8]) {
    let _ = decode_field(&with_start(b"#HSH1.2\n", bytes), &job());
    let _ = decode_field(bytes, &job());
}

/// Random-field models.
pub fn rlm(bytes: &[u8]) {
    let _ = rlm::decode(bytes, &job());
}

/// EXR files.
pub fn exr(bytes: &[u8]) {
    let bytes = with_start(&[0x76, 0x2f, 0x31, 0x01], bytes);
    let _ = decode_field(&bytes, &job());
    let _ = relume::format::exr::decode_labelled(&bytes, &job());
}

/// Textures of light and view, and one of their images.
pub fn bonn(bytes: &[u8]) {
    let _ = BonnBtf::decode(Arc::new(bytes.to_vec()), &job());
}

/// Measured reflectances, and one of their values.
pub fn brdf(bytes: &[u8]) {
    if let Ok(brdf) = decode_brdf(bytes, &job()) {
        let value = brdf.evaluate(Directions::lit_from(Direction::from_angles(0.5, 1.0)));
        assert!(value.iter().all(|v| v.is_finite()));
    }
}

/// Arrays.
pub fn npy(bytes: &[u8]) {
    let _ = npy::decode_i32(bytes, &job());
}

/// Pictures.
pub fn picture(bytes: &[u8]) {
    let _ = decode_raster(bytes, &job());
}

/// Meshes.
pub fn mesh(bytes: &[u8]) {
    let _ = decode_mesh(bytes, &job());
}

/// Height maps.
pub fn heights(bytes: &[u8]) {
    let _ = decode_height(bytes, &job()).map(|map| map.texels(1.0));
}

/// Normal maps.
pub fn normals(bytes: &[u8]) {
    let _ = decode_normals(bytes, Path::new("normals.png"), None, &job());
}

/// Masks.
pub fn mask(bytes: &[u8]) {
    let _ = decode_mask(bytes, &job());
}

/// Light files.
pub fn lights(bytes: &[u8]) {
    let _ = lp::parse(bytes);
}

/// The header of a web folder up to the first zero, and one picture after it.
pub fn web(bytes: &[u8]) {
    let mut parts = bytes.splitn(2, |byte| *byte == 0);
    let (header, picture) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let file = |name: &str| Ok(Some(if name == "info.json" { header.to_vec() } else { picture.to_vec() }));
    let _ = decode_files(&file, &job());
}

/// The head of a folder of tiles up to the first zero, and one tile after it.
pub fn multires(bytes: &[u8]) {
    let mut parts = bytes.splitn(2, |byte| *byte == 0);
    let (header, tile) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    let file = |name: &str| {
        Ok(match name {
            "info.xml" => Some(header.to_vec()),
            "info.json" => None,
            _ => Some(tile.to_vec()),
        })
    };
    let _ = decode_files(&file, &job());
}

/// The bytes after a signature, so that no time goes into finding it.
fn with_start(signature: &[u8], bytes: &[u8]) -> Vec<u8> {
    if bytes.starts_with(signature) { bytes.to_vec() } else { [signature, bytes].concat() }
}
