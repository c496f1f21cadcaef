//! Files of tiles: a texture in which tiles of equal height lie one below the other.
//!
//! An EXR file says by itself how many; beside any other file lies `FILE.json` that says it.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use relume::format::{FieldFile, exr};
use relume::{Error, Limits, Result, Size};
use serde_json::{Value, json};

use crate::input;
use crate::output::is_stream;

/// A set of tiles read from a file.
pub struct TileSetFile {
    /// All tiles, one below the other.
    pub file: FieldFile,
    /// How many there are.
    pub count: usize,
}

impl TileSetFile {
    /// The size of one tile.
    pub fn tile(&self) -> Size {
        let size = self.file.field.size();
        Size::new(size.width, size.height / self.count)
    }
}

/// The key of both kinds of file.
const KEY: &str = "relumeTiles";

/// The largest file beside the tiles that is read: it holds three numbers.
const LARGEST_SIDECAR: u64 = 1 << 16;

/// The file beside a set of tiles that says how many there are; none where the file says it itself.
pub fn sidecar_path(tiles: &Path) -> Option<PathBuf> {
    if tiles.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        return None;
    }
    let mut name = OsString::from(tiles);
    name.push(".json");
    Some(PathBuf::from(name))
}

/// What that file holds.
pub fn sidecar(tile: Size, count: usize) -> Vec<u8> {
    let value = json!({ KEY: count, "tile_width": tile.width, "tile_height": tile.height });
    format!("{value:#}\n").into_bytes()
}

/// Reads a set of tiles; none where a file is something else.
pub fn open(path: &Path, limits: &Limits) -> Result<Option<TileSetFile>> {
    if is_stream(path) {
        return Ok(None);
    }
    let count = match sidecar_path(path).filter(|path| path.is_file()) {
        Some(sidecar) => count_in(&sidecar)?,
        None => exr::tiles_in(path, limits)?,
    };
    let Some(count) = count else { return Ok(None) };
    let file = input::field(path, limits)?;
    let height = file.field.size().height;
    if count == 0 || !height.is_multiple_of(count) {
        return Err(Error::invalid(format!(
            "is {height} texels high and said to hold {count} tiles one below the other: the height must be a \
             multiple of their number"
        ))
        .at(path));
    }
    Ok(Some(TileSetFile { file, count }))
}

/// The number in a file beside tiles; none where it is some other JSON file.
fn count_in(path: &Path) -> Result<Option<usize>> {
    let failed = |e: &std::io::Error| Error::io("cannot read the file", e).at(path);
    if fs::metadata(path).map_err(|e| failed(&e))?.len() > LARGEST_SIDECAR {
        return Ok(None);
    }
    let text = fs::read(path).map_err(|e| failed(&e))?;
    let value: Value = match serde_json::from_slice(&text) {
        Ok(value) => value,
        Err(_) => return Ok(None),
    };
    let Some(count) = value.get(KEY) else { return Ok(None) };
    let number = count.as_u64().and_then(|count| usize::try_from(count).ok()).ok_or_else(|| {
        Error::invalid(format!("'{KEY}' is {count}: expected the number of tiles")).at(path)
    })?;
    Ok(Some(number))
}
