//! Files of tiles: a texture in which tiles of equal height lie one below the other.
//!
//! An EXR file says by itself how many, and how they lean where they do; beside any other file lies
//! `FILE.json` that says it.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use relume::format::{FieldFile, exr};
use relume::numeric::cells::Cells;
use relume::synthesis::roller::TileSet;
use relume::{Error, Job, Result, Size};
use serde_json::{Value, json};

use crate::input;
use crate::output::is_stream;

/// A set of tiles read from a file.
pub struct TileSetFile {
    /// All tiles, one below the other.
    pub file: FieldFile,
    /// How many there are.
    pub count: usize,
    /// The cells that they fill.
    pub cells: Cells,
}

/// Tiles in words: `4 tiles of 86 x 85`, `one leaning tile with steps of (219, 25) and (-5, 150)`.
pub fn in_words(count: usize, cells: &Cells) -> String {
    let number = if count == 1 { "one".to_owned() } else { count.to_string() };
    let plural = if count == 1 { "" } else { "s" };
    if cells.are_upright() {
        return format!("{number} tile{plural} of {}", cells.bounds());
    }
    let ([w, t], [s, h]) = (cells.right(), cells.down());
    format!("{number} leaning tile{plural} with steps of ({w}, {t}) and ({s}, {h})")
}

/// The keys of both kinds of file.
const KEY: &str = "relumeTiles";
const CELL_KEY: &str = "cell";

/// The largest file beside the tiles that is read: it holds a few numbers.
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
pub fn sidecar(tiles: &TileSet) -> Vec<u8> {
    let (tile, cells) = (tiles.tile(), tiles.cells());
    let mut value = json!({ KEY: tiles.count(), "tile_width": tile.width, "tile_height": tile.height });
    if !cells.are_upright() {
        value[CELL_KEY] = json!([cells.right(), cells.down()]);
    }
    format!("{value:#}\n").into_bytes()
}

/// Reads a set of tiles; none where a file is something else.
pub fn open(path: &Path, job: &Job) -> Result<Option<TileSetFile>> {
    if is_stream(path) {
        return Ok(None);
    }
    let found = match sidecar_path(path).filter(|path| path.is_file()) {
        Some(sidecar) => tiles_in(&sidecar)?,
        None => exr::tiles_in(path, job)?,
    };
    let Some((count, cells)) = found else { return Ok(None) };
    let file = input::field(path, job)?;
    let Size { width, height } = file.field.size();
    if count == 0 || !height.is_multiple_of(count) {
        return Err(Error::invalid(format!(
            "is {height} texels high and said to hold {count} tiles one below the other: the height must be a \
             multiple of their number"
        ))
        .at(path));
    }
    let tile = Size::new(width, height / count);
    let cells = cells.or_else(|| Cells::upright(tile)).filter(|cells| cells.bounds() == tile);
    let cells = cells.ok_or_else(|| {
        Error::invalid(format!(
            "holds {count} tiles of {tile}, and their cells are said to have another size"
        ))
        .at(path)
    })?;
    Ok(Some(TileSetFile { file, count, cells }))
}

/// What a file beside tiles says; none where it is some other JSON file.
fn tiles_in(path: &Path) -> Result<Option<(usize, Option<Cells>)>> {
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
    let Some(cell) = value.get(CELL_KEY) else { return Ok(Some((number, None))) };
    let steps = serde_json::from_value::<[[i64; 2]; 2]>(cell.clone()).ok();
    let cells = steps.and_then(|[right, down]| Cells::new(right, down)).ok_or_else(|| {
        Error::invalid(format!(
            "'{CELL_KEY}' is {cell}: expected two steps that lean less than they are long"
        ))
        .at(path)
    })?;
    Ok(Some((number, Some(cells))))
}
