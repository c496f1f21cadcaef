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

use super::whole::read_file;
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

/// Reads the files of a folder on disk.
pub(super) fn files_of<'a>(
    folder: &'a Path,
    job: &'a Job,
) -> impl Fn(&str) -> Result<Option<Vec<u8>>> + Sync + 'a {
    move |name| {
        let path = folder.join(name);
        if !path.is_file() {
            return Ok(None);
        }
        read_file(&path, |_| true, job).map(Some)
    }
}

/// Reads a file of the folder by its path within it; `None` where there is none.
pub(super) type ReadFile<'a> = dyn Fn(&str) -> Result<Option<Vec<u8>>> + Sync + 'a;

/// The field of a folder whose files `read` gives by their paths within it, wherever they are.
///
/// # Errors
/// A folder that is incomplete or damaged, and kinds that are not read, by name.
pub fn decode_files(
    read: &(dyn Fn(&str) -> Result<Option<Vec<u8>>> + Sync),
    job: &Job,
) -> Result<crate::field::ReflectanceField> {
    decode(read, job)
}
