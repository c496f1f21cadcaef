//! Folders of JPEG planes for viewers in browsers: the format of Relight, which OpenLIME and RelightLab show.
//!
//! `info.json` says the functions, the arrangement of colours, and a scale and a bias for each channel of each plane:
//! value = (texture - bias) scale, with the texture in 0..1. Three coefficients share a JPEG picture; pictures are whole
//! or cut into tiles of a pyramid. Rows run from the top.
//!
//! | type | functions | colours |
//! |---|---|---|
//! | `ptm` | 1, u, v, u^2, uv, v^2, and on by degrees | `rgb`, `lrgb` |
//! | `hsh` | hemispherical harmonics | `rgb`, `lrgb` |
//! | `sh` | spherical harmonics | `rgb`, `lrgb` |
//! | `rbf` | tables at the lights, interpolated by Gaussians | `mrgb`, `mycc` |
//! | `bilinear` | tables on a grid over the octahedron | `mrgb`, `mycc` |

mod functions;
mod info;
mod read;
mod tables;
mod tiles;
mod write;

use std::path::Path;

use super::folder::files_of;
use super::multires;
use crate::error::Result;
use crate::job::Job;
pub(super) use read::decode;
pub use write::{WebLayout, WebOptions, encode_web};

/// The file that makes a folder one of these.
pub(super) const INFO_FILE: &str = "info.json";

/// The bytes of `info.json` where a folder is one of these.
pub(super) fn info_of(folder: &Path, job: &Job) -> Result<Option<Vec<u8>>> {
    let says = |bytes: &[u8], word: &str| bytes.windows(word.len()).any(|w| w == word.as_bytes());
    let info = files_of(folder, job)(INFO_FILE)?;
    Ok(info.filter(|bytes| says(bytes, "\"type\"") && says(bytes, "\"width\"")))
}

/// Whether a folder describes a texture: one of Relight, or of the older web viewer.
pub fn is_at(folder: &Path) -> bool {
    [INFO_FILE, multires::INFO_FILE].iter().any(|name| folder.join(name).is_file())
}

/// The folder of a description that is named in its place.
pub(super) fn folder_of(info: &Path) -> Option<&Path> {
    let is_info = [INFO_FILE, multires::INFO_FILE].iter().any(|name| info.ends_with(name));
    let folder =
        info.parent().map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    folder.filter(|_| is_info && info.is_file())
}

/// The field of a folder whose files `read` gives by their paths within it, wherever they are: one of Relight, or of the
/// older web viewer.
///
/// # Errors
/// A folder that is incomplete or damaged, and kinds that are not read, by name.
pub fn decode_files(
    read: &(dyn Fn(&str) -> Result<Option<Vec<u8>>> + Sync),
    job: &Job,
) -> Result<crate::field::ReflectanceField> {
    match read(INFO_FILE)? {
        None if read(multires::INFO_FILE)?.is_some() => multires::decode(read, job).map(|(field, _)| field),
        _ => decode(read, job),
    }
}
