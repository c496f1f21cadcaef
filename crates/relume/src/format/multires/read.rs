//! A folder to a field.

use super::INFO_FILE;
use super::info::{MultiresInfo, MultiresKind};
use super::quadtree::{BORDER, Leaves};
use crate::error::{Error, Result};
use crate::field::{Basis, PlaneLayout, ReflectanceField};
use crate::format::folder::{ReadFile, missing};
use crate::format::hsh::HshEncoding;
use crate::format::kind::Kind;
use crate::format::meaning::Meaning;
use crate::format::ptm::PtmEncoding;
use crate::format::{jpeg, raster};
use crate::job::Job;
use crate::memory;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::Samples;
use crate::size::Size;
use crate::space::Space;

/// How the bytes of the tiles are meant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::format) enum TileEncoding {
    Ptm(PtmEncoding),
    Hsh(HshEncoding),
    /// Colours.
    Image,
}

impl TileEncoding {
    fn of(info: &MultiresInfo) -> Result<Self> {
        match info.kind {
            MultiresKind::Image => Ok(Self::Image),
            // What the file calls the bias is the factor.
            MultiresKind::Hsh => Ok(Self::Hsh(HshEncoding::new(&info.bias, &info.scale))),
            MultiresKind::LrgbPtm | MultiresKind::RgbPtm => {
                if let Some(k) = info.scale.iter().position(|scale| scale.abs() < 1e-20) {
                    return Err(Error::invalid(format!(
                        "scale {} of 6 in info.xml is zero, which leaves nothing of the coefficient: the file is broken",
                        k + 1
                    )));
                }
                let six = |list: &[f32]| std::array::from_fn(|k| list[k]);
                Ok(Self::Ptm(PtmEncoding { scale: six(&info.scale), bias: six(&info.bias) }))
            }
        }
    }

    /// The value of a byte of function `k`; of colours after the functions.
    fn value(&self, k: Option<usize>, byte: u8) -> f32 {
        match (self, k) {
            (Self::Ptm(encoding), Some(k)) => encoding.value(k, byte),
            (Self::Hsh(encoding), Some(k)) => encoding.value(k, byte),
            _ => f32::from(byte) / 255.0,
        }
    }
}

/// The field of a folder, of which `read` gives the files, and how its bytes are meant.
///
/// # Errors
/// A folder that is incomplete or damaged, with the file at fault; kinds that are not read, by name.
pub(in crate::format) fn decode(read: &ReadFile<'_>, job: &Job) -> Result<(ReflectanceField, TileEncoding)> {
    let text = read(INFO_FILE)?.ok_or_else(|| missing(INFO_FILE))?;
    let (info, leaves) = MultiresInfo::parse(&text, job)?;
    let encoding = TileEncoding::of(&info)?;
    let (layout, basis) = functions(&info)?;
    let (size, count) = (info.tree.size, layout.planes(basis.len()));
    // The tiles of a picture, the picture, and the planes of the field.
    job.check("the folder of tiles", size, (9 + 4 * count) as u64)?;
    let mut planes = Planes::zeros_within(job, "the functions of the folder", size, count)?;
    for k in 0..info.pictures() {
        job.proceed()?;
        let samples = picture(&info, &leaves, k, read, job)?;
        for c in 0..3 {
            let (plane, function) = place(&info, k, c);
            let values: [f32; 256] = std::array::from_fn(|byte| encoding.value(function, byte as u8));
            let bytes = samples.iter().skip(c).step_by(3);
            planes
                .plane_mut(plane)
                .iter_mut()
                .zip(bytes)
                .for_each(|(out, &byte)| *out = values[usize::from(byte)]);
        }
    }
    Ok((ReflectanceField::new(basis, layout, Space::Srgb, planes)?, encoding))
}

fn functions(info: &MultiresInfo) -> Result<(PlaneLayout, Basis)> {
    match info.kind {
        MultiresKind::LrgbPtm => Ok((PlaneLayout::LRGB, Basis::Ptm)),
        MultiresKind::RgbPtm => Ok((PlaneLayout::RGB, Basis::Ptm)),
        MultiresKind::Image => Ok((PlaneLayout::RGB, Basis::Constant)),
        MultiresKind::Hsh => {
            let name = format!("hsh{}", info.terms);
            let basis = Basis::from_name(&name).ok_or_else(|| {
                Error::unsupported(format!(
                    "folders of {} harmonics are not read: expected 4 or 9",
                    info.terms
                ))
            })?;
            Ok((PlaneLayout::RGB, basis))
        }
    }
}

/// The plane of the field for channel `c` of picture `k`, and its function unless it is a colour.
fn place(info: &MultiresInfo, k: usize, c: usize) -> (usize, Option<usize>) {
    match info.kind {
        MultiresKind::LrgbPtm => (3 * k + c, Some(3 * k + c).filter(|function| *function < 6)),
        _ => (c * info.terms + k, Some(k)),
    }
}

/// Picture `k` put together of its tiles: three interleaved channels.
fn picture(
    info: &MultiresInfo,
    leaves: &Leaves,
    k: usize,
    read: &ReadFile<'_>,
    job: &Job,
) -> Result<Vec<u8>> {
    let tree = &info.tree;
    let ((left, top), Size { width, height }) = (tree.offset(), tree.size);
    let side = tree.tile + 2 * BORDER;
    let [columns, rows] = tree.covered();
    let mut out = memory::zeros("a picture of the folder", 3 * tree.size.texels())?;
    for row in rows {
        job.proceed()?;
        let tile = |column: usize| -> Result<(usize, Vec<u8>)> {
            let name = format!("{}_{}.{}", leaves[&(column, row)], k + 1, info.extension);
            let bytes = read(&name)?.ok_or_else(|| missing(&name))?;
            Ok((column, samples(&bytes, &name, side, job)?))
        };
        let tiles = parallel::try_map(columns.clone(), tile);
        // The part of the picture in a tile along an axis: from, to, of the square.
        let part = |at: usize, first: usize, length: usize| {
            ((at * tree.tile).max(first), ((at + 1) * tree.tile).min(first + length))
        };
        let (upper, lower) = part(row, top, height);
        for (column, texels) in tiles? {
            let (from, to) = part(column, left, width);
            for y in upper..lower {
                let at = (y - row * tree.tile + BORDER) * side + from - column * tree.tile + BORDER;
                let place = (y - top) * width + from - left;
                out[3 * place..3 * (place + to - from)]
                    .copy_from_slice(&texels[3 * at..3 * (at + to - from)]);
            }
        }
    }
    Ok(out)
}

/// The samples of a tile, as three channels.
fn samples(bytes: &[u8], name: &str, side: usize, job: &Job) -> Result<Vec<u8>> {
    let within = |e: Error| Error::new(e.kind(), format!("{name}: {}", e.message()));
    let (size, channels, samples) = match Kind::of(bytes) {
        Some(Kind::Png) => {
            let raster = raster::decode_as(bytes, Meaning::Data, job).map_err(within)?;
            let (size, channels) = (raster.size(), raster.channels());
            match raster.samples() {
                Samples::U8(samples) => (size, channels, samples.clone()),
                _ => return Err(Error::unsupported(format!("{name} has 16 bits a sample: expected 8"))),
            }
        }
        _ => {
            let found = jpeg::decode(bytes, job).map_err(within)?;
            (found.size, found.channels, found.samples)
        }
    };
    if size != Size::new(side, side) {
        return Err(Error::invalid(format!("{name} has {size} texels: expected {side} x {side}")));
    }
    match channels {
        3 => Ok(samples),
        _ => Ok(samples.iter().flat_map(|&grey| [grey; 3]).collect()),
    }
}
