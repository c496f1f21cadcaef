//! Planes as whole pictures, or as tiles of a pyramid.
//!
//! Level 0 of a pyramid is the coarsest; each level has half of the sides of the next, rounded down.

use serde_json::Value;

use crate::error::{Error, Result};
use crate::format::folder::{ReadFile, missing};
use crate::format::jpeg;
use crate::format::xml::attribute;
use crate::job::Job;
use crate::memory;
use crate::size::Size;

/// The side of the tiles that are written.
pub(super) const TILE_SIDE: usize = 256;

/// The places of the tiles of the finest level of a plane.
#[derive(Debug)]
pub(super) enum PlaneTiles {
    /// One picture for each plane.
    Whole,
    /// Files `plane_K_files/LEVEL/X_Y.jpg`.
    Files { level: usize, grid: TileGrid },
    /// Ranges of one file for each plane, or of one for all.
    Ranges { grid: TileGrid, stride: usize, archives: Vec<(Vec<u8>, Vec<usize>)> },
}

/// Tiles of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct TileGrid {
    pub size: Size,
    pub side: usize,
    pub overlap: usize,
}

impl TileGrid {
    pub(super) fn across(&self) -> usize {
        self.size.width.div_ceil(self.side)
    }

    pub(super) fn down(&self) -> usize {
        self.size.height.div_ceil(self.side)
    }

    /// The size of a tile with its overlaps.
    fn tile(&self, x: usize, y: usize) -> Size {
        Size::new(self.span(x, self.size.width).1, self.span(y, self.size.height).1)
    }

    /// The first texel and the number of texels of a tile along an axis of `length`.
    pub(super) fn span(&self, index: usize, length: usize) -> (usize, usize) {
        let first = (index * self.side).saturating_sub(self.overlap);
        (first, ((index + 1) * self.side + self.overlap).min(length) - first)
    }
}

/// The sides of all levels, from the coarsest, of which the whole picture is one tile.
pub(super) fn levels(size: Size, side: usize) -> Vec<Size> {
    let mut levels = vec![size];
    let mut last = size;
    while last.width.max(last.height) > side {
        last = Size::new((last.width / 2).max(1), (last.height / 2).max(1));
        levels.push(last);
    }
    levels.reverse();
    levels
}

/// Finds how the planes of a folder are stored.
pub(super) fn find(size: Size, pictures: usize, read: &ReadFile<'_>) -> Result<PlaneTiles> {
    if read("plane_0.jpg")?.is_some() {
        return Ok(PlaneTiles::Whole);
    }
    if let Some(text) = read("plane_0.dzi")? {
        return deepzoom(&text, size, read);
    }
    if let Some(text) = read("planes.tzi")? {
        let (grid, stride, archive) = ranges(&text, size, "planes", read)?;
        if stride < pictures {
            return Err(Error::invalid(format!("planes.tzi holds {stride} planes: expected {pictures}")));
        }
        return Ok(PlaneTiles::Ranges { grid, stride, archives: vec![archive] });
    }
    if read("plane_0.tzi")?.is_some() {
        let mut archives = Vec::with_capacity(pictures);
        let mut first = None;
        for k in 0..pictures {
            let name = format!("plane_{k}");
            let text = read(&format!("{name}.tzi"))?.ok_or_else(|| missing(&format!("{name}.tzi")))?;
            let (grid, _, archive) = ranges(&text, size, &name, read)?;
            if *first.get_or_insert(grid) != grid {
                return Err(Error::invalid(format!("{name}.tzi has other tiles than plane_0.tzi")));
            }
            archives.push(archive);
        }
        let grid = first.ok_or_else(|| missing("plane_0.tzi"))?;
        return Ok(PlaneTiles::Ranges { grid, stride: 1, archives });
    }
    if read("plane_0/ImageProperties.xml")?.is_some() {
        return Err(Error::unsupported(
            "the planes of the folder are tiled as zoomify, which is not read: expected whole pictures, deepzoom, tarzoom \
             or itarzoom",
        ));
    }
    Err(Error::invalid(
        "the folder has no planes: expected plane_0.jpg, plane_0.dzi, plane_0.tzi or planes.tzi beside info.json",
    ))
}

fn deepzoom(text: &[u8], size: Size, read: &ReadFile<'_>) -> Result<PlaneTiles> {
    let text = String::from_utf8_lossy(text);
    let number = |name: &str, range: std::ops::RangeInclusive<usize>| {
        attribute(&text, name).and_then(|n| n.parse().ok()).filter(|n| range.contains(n)).ok_or_else(|| {
            Error::invalid(format!("plane_0.dzi has no {name} from {} to {}", range.start(), range.end()))
        })
    };
    let (side, overlap) = (number("TileSize", 16..=1 << 16)?, number("Overlap", 0..=64)?);
    let said = Size::new(number("Width", 1..=1 << 24)?, number("Height", 1..=1 << 24)?);
    if said != size {
        return Err(Error::invalid(format!("plane_0.dzi has {said} texels, and info.json {size}")));
    }
    // A pyramid may go on down to a single texel.
    let deepest = (usize::BITS - (size.width.max(size.height) - 1).leading_zeros()) as usize;
    for level in (0..=deepest).rev() {
        if read(&format!("plane_0_files/{level}/0_0.jpg"))?.is_some() {
            return Ok(PlaneTiles::Files { level, grid: TileGrid { size, side, overlap } });
        }
    }
    Err(missing("plane_0_files/0/0_0.jpg"))
}

/// A grid, the pictures of a tile, and the bytes of an archive with their offsets.
type Archived = (TileGrid, usize, (Vec<u8>, Vec<usize>));

fn ranges(text: &[u8], size: Size, name: &str, read: &ReadFile<'_>) -> Result<Archived> {
    let wrong = |what: &str| Error::invalid(format!("{name}.tzi {what}"));
    let json: Value = serde_json::from_slice(text).map_err(|_| wrong("is not JSON"))?;
    let number = |entry: &str, most: u64| json.get(entry).and_then(Value::as_u64).filter(|n| *n <= most);
    let side =
        number("tilesize", 1 << 16).filter(|n| *n >= 16).ok_or_else(|| wrong("has no tilesize"))? as usize;
    let overlap = number("overlap", 64).unwrap_or(0) as usize;
    let said = [number("width", 1 << 24), number("height", 1 << 24)].map(|n| n.unwrap_or(0) as usize);
    if said != [size.width, size.height] {
        return Err(wrong(&format!("has {} x {} texels, and info.json {size}", said[0], said[1])));
    }
    let stride = number("stride", 300).unwrap_or(1).max(1) as usize;
    let list = json.get("offsets").and_then(Value::as_array).ok_or_else(|| wrong("has no offsets"))?;
    let offsets: Option<Vec<usize>> = list.iter().map(|n| n.as_u64().map(|n| n as usize)).collect();
    let offsets = offsets.ok_or_else(|| wrong("has offsets that are not whole numbers"))?;
    let file = format!("{name}.tzb");
    let bytes = read(&file)?.ok_or_else(|| missing(&file))?;
    let tiles = levels(size, side).into_iter().map(|size| TileGrid { size, side, overlap });
    let count: usize = tiles.map(|grid| grid.across() * grid.down()).sum();
    let fits = offsets.len() > count * stride && offsets.windows(2).all(|pair| pair[0] <= pair[1]);
    if !fits || offsets.last().is_none_or(|end| *end > bytes.len()) {
        return Err(Error::invalid(format!(
            "{name}.tzi does not match {file}: expected {} rising offsets up to {}",
            count * stride + 1,
            bytes.len()
        )));
    }
    Ok((TileGrid { size, side, overlap }, stride, (bytes, offsets)))
}

/// The samples of a picture of three coefficients, interleaved.
pub(super) fn picture(
    tiles: &PlaneTiles,
    k: usize,
    size: Size,
    read: &ReadFile<'_>,
    job: &Job,
) -> Result<Vec<u8>> {
    match tiles {
        PlaneTiles::Whole => {
            let name = format!("plane_{k}.jpg");
            let bytes = read(&name)?.ok_or_else(|| missing(&name))?;
            samples(&bytes, &name, size, job)
        }
        PlaneTiles::Files { level, grid } => assembled(*grid, job, |x, y| {
            let name = format!("plane_{k}_files/{level}/{x}_{y}.jpg");
            let bytes = read(&name)?.ok_or_else(|| missing(&name))?;
            samples(&bytes, &name, grid.tile(x, y), job)
        }),
        PlaneTiles::Ranges { grid, stride, archives } => {
            let coarser =
                levels(grid.size, grid.side).into_iter().rev().skip(1).map(|size| TileGrid { size, ..*grid });
            let before: usize = coarser.map(|grid| grid.across() * grid.down()).sum();
            let one_for_all = archives.len() == 1;
            let (bytes, offsets) = &archives[if one_for_all { 0 } else { k }];
            assembled(*grid, job, |x, y| {
                let number = before + y * grid.across() + x;
                let at = if one_for_all { number * stride + k } else { number };
                let name = format!("tile {x}, {y} of plane {k}");
                samples(&bytes[offsets[at]..offsets[at + 1]], &name, grid.tile(x, y), job)
            })
        }
    }
}

/// A picture put together of the samples of tiles. Where tiles overlap, both hold the same texels.
fn assembled(grid: TileGrid, job: &Job, tile: impl Fn(usize, usize) -> Result<Vec<u8>>) -> Result<Vec<u8>> {
    let Size { width, height } = grid.size;
    let mut out = memory::zeros("a plane of the folder", 3 * grid.size.texels())?;
    for (x, y) in (0..grid.down()).flat_map(|y| (0..grid.across()).map(move |x| (x, y))) {
        job.proceed()?;
        let ((left, across), (top, down)) = (grid.span(x, width), grid.span(y, height));
        let found = tile(x, y)?;
        for row in 0..down {
            let to = 3 * ((top + row) * width + left);
            out[to..to + 3 * across].copy_from_slice(&found[3 * row * across..][..3 * across]);
        }
    }
    Ok(out)
}

/// The samples of a JPEG picture of a size, as three channels.
fn samples(bytes: &[u8], name: &str, size: Size, job: &Job) -> Result<Vec<u8>> {
    let within = |e: Error| Error::new(e.kind(), format!("{name}: {}", e.message()));
    let found = jpeg::decode(bytes, job).map_err(within)?;
    if found.size != size {
        return Err(Error::invalid(format!("{name} has {} texels: expected {size}", found.size)));
    }
    match found.channels {
        3 => Ok(found.samples),
        _ => Ok(found.samples.iter().flat_map(|&grey| [grey; 3]).collect()),
    }
}
