//! Files of tiles: a texture of tiles of equal height stacked one below the other.
//!
//! An EXR file records the number of tiles itself, and their steps if they are oblique
//! ([`encode_tiles`](super::exr::encode_tiles)). Other files have a companion `FILE.json` with this record
//! and the stamp of the file it belongs to.

use std::ffi::OsString;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::field_file::FieldFile;
use crate::error::{Error, Result};
use crate::numeric::cells::Cells;
use crate::numeric::corner_colors::CornerColors;
use crate::size::Size;
use crate::stamp::Stamp;

/// A set of tiles read from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct TileSetFile {
    /// All tiles, one below the other.
    pub file: FieldFile,
    /// The number of tiles.
    pub count: usize,
    /// The cells that they fill.
    pub cells: Cells,
    /// The colours of their corners.
    pub corners: CornerColors,
}

impl TileSetFile {
    /// The tiles that a file is declared to hold.
    pub(super) fn new(file: FieldFile, Said { count, cells, corners, .. }: Said) -> Result<Self> {
        let Size { width, height } = file.field.size();
        if count == 0 || !height.is_multiple_of(count) {
            return Err(Error::invalid(format!(
                "is {height} texels high and declared to hold {count} tiles one below the other: the height must be a \
                 multiple of their number"
            )));
        }
        let tile = Size::new(width, height / count);
        let cells = cells.or_else(|| Cells::upright(tile)).filter(|cells| cells.bounds() == tile);
        let cells = cells.ok_or_else(|| {
            Error::invalid(format!(
                "holds {count} tiles of {tile}, but their cells are declared with another size"
            ))
        })?;
        let corners = CornerColors::new(corners, count).ok_or_else(|| {
            Error::invalid(format!(
                "holds {count} tiles, declared to have corners of {corners} colours: expected 1 to 4, and a tile for \
                 every choice of four"
            ))
        })?;
        Ok(Self { file, count, cells, corners })
    }
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

/// The keys of the companion file.
const KEY: &str = "relumeTiles";
const CELL_KEY: &str = "cell";
const CORNERS_KEY: &str = "corner_colors";
const STAMP_KEY: &str = "file";

/// The largest companion file that is read: it holds a few numbers.
const LARGEST_SIDECAR: u64 = 1 << 16;

/// The companion file of a tile set; `None` if the file itself holds the record.
pub fn sidecar_path(tiles: &Path) -> Option<PathBuf> {
    if tiles.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr")) {
        return None;
    }
    let mut name = OsString::from(tiles);
    name.push(".json");
    Some(PathBuf::from(name))
}

/// The contents of the companion file for the given number of tiles, cells and colours of corners,
/// beside a file of these bytes.
pub fn sidecar(count: usize, cells: &Cells, corners: CornerColors, file: &[u8]) -> Vec<u8> {
    let tile = cells.bounds();
    let mut value = json!({ KEY: count, "tile_width": tile.width, "tile_height": tile.height });
    if !cells.are_upright() {
        value[CELL_KEY] = json!([cells.right(), cells.down()]);
    }
    if corners.vary() {
        value[CORNERS_KEY] = json!(corners);
    }
    value[STAMP_KEY] = json!(Stamp::of(file));
    format!("{value:#}\n").into_bytes()
}

/// The record of a tile set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Said {
    pub count: usize,
    /// The cells, if the tiles are oblique.
    pub cells: Option<Cells>,
    /// The number of colours of the corners, 1 if there are none.
    pub corners: usize,
    /// The stamp of the file described.
    pub stamp: Option<Stamp>,
}

/// The record in the companion of `tiles`, a file of these bytes; `None` if there is no companion, or it is
/// about something else.
///
/// # Errors
/// The error names the file: a companion that is damaged or belongs to another file, since a tile set must
/// not pass for a picture.
pub(super) fn beside(tiles: &Path, bytes: &[u8]) -> Result<Option<Said>> {
    let Some(path) = sidecar_path(tiles).filter(|path| path.is_file()) else { return Ok(None) };
    let mut text = Vec::new();
    File::open(&path)
        .and_then(|file| file.take(LARGEST_SIDECAR + 1).read_to_end(&mut text))
        .map_err(|e| Error::io("cannot read the file", &e).at(&path))?;
    if text.len() as u64 > LARGEST_SIDECAR {
        return Ok(None);
    }
    let said = said(&text).map_err(|e| e.at(&path))?;
    refuse_other(said.and_then(|said| said.stamp), Stamp::of(bytes)).map_err(|e| e.at(tiles))?;
    Ok(said)
}

/// Refuses tiles that do not match their companion; a handwritten one may omit the stamp.
fn refuse_other(said: Option<Stamp>, found: Stamp) -> Result<()> {
    match said.filter(|said| *said != found) {
        Some(said) => Err(Error::invalid(format!(
            "is {found}, and the .json beside it belongs to a file of {said}: make the tiles anew, or delete the \
             .json to use the file as a picture"
        ))),
        None => Ok(()),
    }
}

fn said(text: &[u8]) -> Result<Option<Said>> {
    let value: Value = serde_json::from_slice(text).map_err(|e| {
        Error::invalid(format!(
            "is damaged and may have described the file beside it as tiles: delete it to use that file as a \
             picture ({e})"
        ))
    })?;
    let Some(count) = value.get(KEY) else { return Ok(None) };
    let number = count.as_u64().and_then(|count| usize::try_from(count).ok()).filter(|count| *count > 0);
    let number =
        number.ok_or_else(|| Error::invalid(format!("'{KEY}' is {count}: expected the number of tiles")))?;
    let steps = |cell: &Value| {
        let steps = serde_json::from_value::<[[i64; 2]; 2]>(cell.clone()).ok();
        steps.and_then(|[right, down]| Cells::new(right, down)).ok_or_else(|| {
            Error::invalid(format!(
                "'{CELL_KEY}' is {cell}: expected two steps that are longer along their axis than across it"
            ))
        })
    };
    let stamp = |stamp: &Value| {
        serde_json::from_value(stamp.clone())
            .map_err(|_| Error::invalid(format!("'{STAMP_KEY}' is {stamp}: expected 'bytes' and 'crc32'")))
    };
    let cells = value.get(CELL_KEY).map(steps).transpose()?;
    let corners = |corners: &Value| {
        let count = corners.as_u64().and_then(|count| usize::try_from(count).ok());
        let expected = "expected the number of colours of the corners";
        count.ok_or_else(|| Error::invalid(format!("'{CORNERS_KEY}' is {corners}: {expected}")))
    };
    let corners = value.get(CORNERS_KEY).map(corners).transpose()?.unwrap_or(1);
    Ok(Some(Said { count: number, cells, corners, stamp: value.get(STAMP_KEY).map(stamp).transpose()? }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sidecar_says_what_it_was_told_and_a_damaged_one_is_an_error() {
        let upright = Cells::upright(Size::new(7, 5)).unwrap();
        let stamp = Some(Stamp::of(b"tiles"));
        let expected = Some(Said { count: 3, cells: None, corners: 1, stamp });
        assert_eq!(said(&sidecar(3, &upright, CornerColors::ALIKE, b"tiles")).unwrap(), expected);
        let expected = Some(Said { count: 17, cells: None, corners: 2, stamp });
        assert_eq!(said(&sidecar(17, &upright, CornerColors::most(17), b"tiles")).unwrap(), expected);
        let leaning = Cells::new([9, 1], [-2, 8]).unwrap();
        let text = sidecar(1, &leaning, CornerColors::ALIKE, b"tiles");
        assert_eq!(said(&text).unwrap(), Some(Said { count: 1, cells: Some(leaning), corners: 1, stamp }));
        assert_eq!(said(b"{\"made by\": \"another program\"}").unwrap(), None);
        for bad in [
            &text[..text.len() / 2],
            b"",
            b"{\"relumeTiles\": -1}",
            b"{\"relumeTiles\": 2, \"cell\": 3}",
            b"{\"relumeTiles\": 2, \"corner_colors\": -3}",
        ] {
            assert!(said(bad).is_err(), "{}", String::from_utf8_lossy(bad));
        }
    }
}
