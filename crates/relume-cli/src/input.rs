//! Inputs by path, or `-` for standard input.

use std::io::Read;
use std::path::Path;

use relume::format::{self, FieldFile, HeightMap, rlm};
use relume::random_field::FieldModel;
use relume::{Error, Job, Planes, Raster, Result, Size};

use crate::output::is_stream;

/// Reads a field: a `.ptm`, an EXR field, or any picture as a texture of constants.
pub fn field(path: &Path, job: &Job) -> Result<FieldFile> {
    if is_stream(path) {
        return format::decode_field(&stdin(job)?, job).map_err(|e| e.at("standard input"));
    }
    format::read_field(path, job)
}

/// Reads a random-field model from a file; `None` where the file is another, or standard input.
pub fn model(path: &Path, job: &Job) -> Result<Option<FieldModel>> {
    if is_stream(path) {
        return Ok(None);
    }
    rlm::read_if_model(path, job)
}

/// Reads a picture as stored.
pub fn raster(path: &Path, job: &Job) -> Result<Raster> {
    if is_stream(path) {
        return format::decode_raster(&stdin(job)?, job).map_err(|e| e.at("standard input"));
    }
    format::read_raster(path, job)
}

/// Reads a file as it is.
pub fn bytes(path: &Path, job: &Job) -> Result<Vec<u8>> {
    if is_stream(path) {
        return stdin(job);
    }
    let failed = |e: std::io::Error| Error::io("cannot read the file", &e).at(path);
    let length = std::fs::metadata(path).map_err(failed)?.len();
    job.check_bytes("the file", length).map_err(|e| e.at(path))?;
    std::fs::read(path).map_err(failed)
}

/// Heights in texels, of integer maps without a record as if they spanned a 25th of the width.
pub fn texels(map: &HeightMap) -> Planes {
    map.texels(map.samples.size().width as f64 / 25.0)
}

/// Reads a height map with its recorded scale.
pub fn height(path: &Path, job: &Job) -> Result<HeightMap> {
    if is_stream(path) {
        return format::decode_height(&stdin(job)?, job).map_err(|e| e.at("standard input"));
    }
    format::read_height(path, job)
}

/// The planes of a map that says what is where; it must have the size of what it lies over.
pub fn guide(path: &Path, size: Size, job: &Job) -> Result<Planes> {
    let guide = field(path, job)?.field.coefficients().clone();
    if guide.size() != size {
        return Err(Error::usage(format!(
            "the guide is {} texels, what it lies over {size}: they must be equally large",
            guide.size()
        ))
        .at(path));
    }
    Ok(guide)
}

/// The texels of a mask that are brighter than half; it must have the size of what it masks.
pub fn mask(path: &Path, size: Size, job: &Job) -> Result<Vec<bool>> {
    let mask = raster(path, job)?;
    if mask.size() != size {
        return Err(Error::usage(format!(
            "the mask is {} texels, what it masks {size}: they must be equally large",
            mask.size()
        ))
        .at(path));
    }
    let bright = |texel: usize| mask.samples().value(texel * mask.channels()) > 0.5;
    Ok((0..size.texels()).map(bright).collect())
}

/// All of standard input, up to the memory limit.
fn stdin(job: &Job) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::io::stdin()
        .lock()
        .take(job.limits().max_bytes.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|e| Error::io("cannot read standard input", &e))?;
    job.check_bytes("standard input", bytes.len() as u64)?;
    Ok(bytes)
}
