//! Files of tiles: a texture in which tiles of equal height lie one below the other.
//!
//! An EXR file says by itself how many, and their steps where they are oblique; beside any other file lies
//! `FILE.json` that says it, with the stamp of the file it belongs to.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use relume::format::{FieldFile, decode_field, exr};
use relume::numeric::cells::Cells;
use relume::synthesis::roller::TileSet;
use relume::{Error, Job, Result, Size, Stamp};
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

/// Tiles in words: `4 tiles of 86 x 85`, `one oblique tile with steps of (219, 25) and (-5, 150)`.
pub fn in_words(count: usize, cells: &Cells) -> String {
    let number = if count == 1 { "one".to_owned() } else { count.to_string() };
    let plural = if count == 1 { "" } else { "s" };
    if cells.are_upright() {
        return format!("{number} tile{plural} of {}", cells.bounds());
    }
    let ([w, t], [s, h]) = (cells.right(), cells.down());
    format!("{number} oblique tile{plural} with steps of ({w}, {t}) and ({s}, {h})")
}

/// The keys of both kinds of file.
const KEY: &str = "relumeTiles";
const CELL_KEY: &str = "cell";
const STAMP_KEY: &str = "file";

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

/// What that file holds, beside a file of these bytes.
pub fn sidecar(tiles: &TileSet, file: &[u8]) -> Vec<u8> {
    let (tile, cells) = (tiles.tile(), tiles.cells());
    let mut value = json!({ KEY: tiles.count(), "tile_width": tile.width, "tile_height": tile.height });
    if !cells.are_upright() {
        value[CELL_KEY] = json!([cells.right(), cells.down()]);
    }
    value[STAMP_KEY] = json!(Stamp::of(file));
    format!("{value:#}\n").into_bytes()
}

/// Reads a set of tiles; none where a file is something else.
pub fn open(path: &Path, job: &Job) -> Result<Option<TileSetFile>> {
    if is_stream(path) {
        return Ok(None);
    }
    let found = match sidecar_path(path).filter(|path| path.is_file()) {
        Some(sidecar) => Sidecar::read(&sidecar)?,
        None => exr::tiles_in(path, job)?.map(|(count, cells)| Sidecar { count, cells, stamp: None }),
    };
    let Some(Sidecar { count, cells, stamp }) = found else { return Ok(None) };
    let bytes = input::bytes(path, job)?;
    refuse_other(stamp, Stamp::of(&bytes)).map_err(|e| e.at(path))?;
    let file = decode_field(&bytes, job).map_err(|e| e.at(path))?;
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

/// Refuses tiles that are not those of the file beside them; one by hand may leave the stamp out.
fn refuse_other(said: Option<Stamp>, found: Stamp) -> Result<()> {
    match said.filter(|said| *said != found) {
        Some(said) => Err(Error::invalid(format!(
            "is {found}, and the .json beside it belongs to a file of {said}: make the tiles anew, or delete the \
             .json to use the file as a picture"
        ))),
        None => Ok(()),
    }
}

/// What a file beside tiles says.
struct Sidecar {
    count: usize,
    cells: Option<Cells>,
    stamp: Option<Stamp>,
}

impl Sidecar {
    /// Reads it; none where it is JSON of another kind.
    ///
    /// # Errors
    /// What is no JSON, or says something else than the numbers expected.
    fn read(path: &Path) -> Result<Option<Self>> {
        let failed = |e: &std::io::Error| Error::io("cannot read the file", e).at(path);
        if fs::metadata(path).map_err(|e| failed(&e))?.len() > LARGEST_SIDECAR {
            return Ok(None);
        }
        let text = fs::read(path).map_err(|e| failed(&e))?;
        let value: Value = serde_json::from_slice(&text).map_err(|e| {
            let message = "is damaged and may have said that the file beside it holds tiles: delete it to use that \
                           file as a picture";
            Error::invalid(format!("{message} ({e})")).at(path)
        })?;
        let said = Self::of(&value).map_err(|message| Error::invalid(message).at(path));
        value.get(KEY).map(|_| said).transpose()
    }

    fn of(value: &Value) -> Result<Self, String> {
        let count = &value[KEY];
        let count = count.as_u64().and_then(|count| usize::try_from(count).ok()).filter(|count| *count > 0);
        let count =
            count.ok_or_else(|| format!("'{KEY}' is {}: expected the number of tiles", value[KEY]))?;
        let steps = |cell: &Value| {
            let steps = serde_json::from_value::<[[i64; 2]; 2]>(cell.clone()).ok();
            steps.and_then(|[right, down]| Cells::new(right, down)).ok_or_else(|| {
                format!("'{CELL_KEY}' is {cell}: expected two steps that lean less than they are long")
            })
        };
        let stamp = |stamp: &Value| {
            serde_json::from_value(stamp.clone())
                .map_err(|_| format!("'{STAMP_KEY}' is {stamp}: expected 'bytes' and 'crc32'"))
        };
        let cells = value.get(CELL_KEY).map(steps).transpose()?;
        Ok(Self { count, cells, stamp: value.get(STAMP_KEY).map(stamp).transpose()? })
    }
}
