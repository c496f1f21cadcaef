//! Tile sets in EXR files: fields of tiles stacked one below the other.
//!
//! | attribute | value |
//! |---|---|
//! | `relumeTiles` | the number of tiles of equal height |
//! | `relumeCorners` | the number of colours of their corners, if they have any |
//! | `relumeCell` | for oblique tiles, `w t s h`: the steps (w, t) to the right and (s, h) down |

use std::collections::BTreeMap;

use super::ExrDepth;
use super::field::encode_with;
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::numeric::cells::Cells;
use crate::numeric::corner_colors::CornerColors;
use crate::planes::Planes;

const TILES_KEY: &str = "relumeTiles";
const CELL_KEY: &str = "relumeCell";
const CORNERS_KEY: &str = "relumeCorners";

/// The bytes of a field of `tiles` tiles that fill the given cells, with their bounding rectangles stacked
/// one below the other, and of their opacity if they have one.
///
/// # Errors
/// As for any field; limits exceeded, and a cancelled job.
pub fn encode_tiles(
    field: &ReflectanceField,
    opacity: Option<&Planes>,
    tiles: usize,
    cells: &Cells,
    corners: CornerColors,
    depth: ExrDepth,
    job: &Job,
) -> Result<Vec<u8>> {
    let mut attributes = vec![(TILES_KEY, tiles.to_string())];
    if !cells.are_upright() {
        let ([w, t], [s, h]) = (cells.right(), cells.down());
        attributes.push((CELL_KEY, format!("{w} {t} {s} {h}")));
    }
    if corners.vary() {
        attributes.push((CORNERS_KEY, corners.count().to_string()));
    }
    encode_with(field, opacity, depth, &attributes, job)
}

/// The number of tiles according to the attributes of a file, the cells they fill if they are oblique, and the
/// number of colours of their corners; `None` if it holds no tiles.
///
/// # Errors
/// When the number or the cells are invalid.
pub(in crate::format) fn tiles_of(
    texts: &BTreeMap<String, String>,
) -> Result<Option<(usize, Option<Cells>, usize)>> {
    let Some(count) = texts.get(TILES_KEY) else { return Ok(None) };
    let wrong = |key: &str, text: &str, expected: &str| {
        Error::invalid(format!("the EXR attribute '{key}' is '{text}': expected {expected}"))
    };
    let number = count.parse().map_err(|_| wrong(TILES_KEY, count, "the number of tiles"))?;
    let cells = |text: &String| {
        cells_of(text)
            .ok_or_else(|| wrong(CELL_KEY, text, "two steps that are longer along their axis than across it"))
    };
    let corners = |text: &String| {
        text.parse().map_err(|_| wrong(CORNERS_KEY, text, "the number of colours of the corners"))
    };
    let corners = texts.get(CORNERS_KEY).map(corners).transpose()?.unwrap_or(1);
    Ok(Some((number, texts.get(CELL_KEY).map(cells).transpose()?, corners)))
}

fn cells_of(text: &str) -> Option<Cells> {
    let numbers: Option<Vec<i64>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    match *numbers? {
        [w, t, s, h] => Cells::new([w, t], [s, h]),
        _ => None,
    }
}
