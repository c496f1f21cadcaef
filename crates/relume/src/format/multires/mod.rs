//! Folders of the older web viewer of reflectance transformation images (WebRTIViewer, Palma, ISTI-CNR, 2013-2015):
//! `info.xml`, and pictures of coefficients cut into the tiles of a quadtree.
//!
//! | type | functions | picture k, from 1 |
//! |---|---|---|
//! | `LRGB_PTM` | u^2, v^2, uv, u, v, 1 | 1 and 2: three coefficients of luminance each; 3: colour |
//! | `RGB_PTM` | the same | red, green and blue of coefficient k |
//! | `HSH_RTI` | 4 or 9 hemispherical harmonics | red, green and blue of harmonic k |
//! | `IMAGE` | a picture that no light changes | 1: its colours |
//!
//! A polynomial is (byte - bias) scale / 255, with white at 1. Of harmonics the two lists have changed places: what the
//! file calls the bias is the factor, and what it calls the scale is added, value = byte / 255 bias + scale. Rows run from
//! the top. The picture lies in the middle of a square whose side is the tile's times a power of two. Node i of the tree
//! has the children 4 i + 1 to 4 i + 4: upper left, upper right, lower left, lower right. Node i has the files `N_k.jpg`
//! with N = i + 1, of tiles with a border of one texel around them. The nodes are listed in the file, or follow from the
//! sizes where they are not. Nodes beside the picture have no files.

mod info;
mod quadtree;
mod read;
mod write;

use std::path::Path;

use super::folder::files_of;
use crate::error::Result;
use crate::job::Job;
pub(super) use read::{TileEncoding, decode};
pub(super) use write::encode;

/// The file that makes a folder one of these.
pub(super) const INFO_FILE: &str = "info.xml";

/// The bytes of `info.xml` where a folder is one of these.
pub(super) fn info_of(folder: &Path, job: &Job) -> Result<Option<Vec<u8>>> {
    let info = files_of(folder, job)(INFO_FILE)?;
    Ok(info.filter(|bytes| bytes.windows(9).any(|w| w == b"<MultiRes")))
}
