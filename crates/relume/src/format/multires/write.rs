//! A field to a folder.

use super::INFO_FILE;
use super::info::{MultiresInfo, MultiresKind};
use super::quadtree::{BORDER, Quadtree, TreeNode};
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::format::folder::StoreFile;
use crate::format::{hsh, jpeg, ptm};
use crate::job::Job;
use crate::parallel;
use crate::size::Size;
use crate::space::Space;

/// The side of the tiles that are written.
const TILE_SIDE: usize = 256;

/// Writes a field of polynomials, or of 4 or 9 harmonics: `store` gets the files, by their paths within the folder.
///
/// # Errors
/// Functions that the viewer does not show, named channels, linear values and values that are not finite; those of
/// `store`.
pub(in crate::format) fn encode(
    field: &ReflectanceField,
    quality: u8,
    job: &Job,
    store: &mut StoreFile<'_>,
) -> Result<()> {
    check_basis(field.basis().name())?;
    if field.space() != Space::Srgb {
        return Err(Error::usage(
            "the older web viewer shows sRGB-encoded values and this texture is linear: give --space srgb, or fit encoded \
             values",
        ));
    }
    // The bytes of all coefficients twice, a picture's coarser copies, and the tiles of a level.
    job.check("the tiles of the folder", field.size(), (2 * field.coefficients().count() + 12) as u64)?;
    let (info, pictures) = coded(field, job)?;
    store(INFO_FILE, info.to_text().as_bytes())?;
    for (k, picture) in pictures.into_iter().enumerate() {
        let (left, top) = info.tree.offset();
        let mut finest = PlacedPicture { left, top, size: field.size(), texels: picture };
        for level in (0..info.tree.levels()).rev() {
            job.proceed()?;
            for (number, file) in tiles(&info.tree, level, &finest, quality)? {
                store(&format!("{number}_{}.jpg", k + 1), &file)?;
            }
            finest = finest.halved();
        }
    }
    Ok(())
}

/// Refuses functions, by their name, that the viewer does not show.
///
/// # Errors
/// The sentence says which it shows.
fn check_basis(name: &str) -> Result<()> {
    match name {
        "ptm" | "hsh4" | "hsh9" => Ok(()),
        other => Err(Error::usage(format!(
            "the older web viewer shows ptm, hsh4 and hsh9, not {other}: relume convert --basis hsh9 makes the nearest"
        ))),
    }
}

/// What the folder says, and its pictures.
fn coded(field: &ReflectanceField, job: &Job) -> Result<(MultiresInfo, Vec<Vec<u8>>)> {
    let tree = Quadtree::of(field.size(), TILE_SIDE);
    if field.basis().name() == "ptm" {
        let (encoding, pictures) = ptm::pictures(field, job)?;
        let kind = if pictures.len() == 3 { MultiresKind::LrgbPtm } else { MultiresKind::RgbPtm };
        let (scale, bias) = (encoding.scale.to_vec(), encoding.bias.to_vec());
        return Ok((MultiresInfo { kind, terms: 6, scale, bias, tree, extension: "jpg" }, pictures));
    }
    let (encoding, pictures) = hsh::pictures(field, job)?;
    // What the file calls the bias is the factor.
    let (scale, bias) = (encoding.bias().to_vec(), encoding.scale().to_vec());
    let terms = pictures.len();
    Ok((MultiresInfo { kind: MultiresKind::Hsh, terms, scale, bias, tree, extension: "jpg" }, pictures))
}

/// A picture at its place in the square of a level, three interleaved channels.
struct PlacedPicture {
    left: usize,
    top: usize,
    size: Size,
    texels: Vec<u8>,
}

impl PlacedPicture {
    /// The texel at a place of the square, or the nearest one of the picture.
    fn at(&self, x: isize, y: isize) -> &[u8] {
        let clamped = |place: isize, first: usize, length: usize| {
            (place - first as isize).clamp(0, length as isize - 1) as usize
        };
        let (x, y) = (clamped(x, self.left, self.size.width), clamped(y, self.top, self.size.height));
        &self.texels[3 * (y * self.size.width + x)..][..3]
    }

    /// Half the resolution: every texel is the mean of four.
    fn halved(&self) -> Self {
        let half = |first: usize, length: usize| (first / 2, (first + length).div_ceil(2) - first / 2);
        let ((left, width), (top, height)) =
            (half(self.left, self.size.width), half(self.top, self.size.height));
        let row = |y: usize| {
            (left..left + width).flat_map(move |x| {
                let (x, y) = (2 * x as isize, 2 * y as isize);
                let four = [self.at(x, y), self.at(x + 1, y), self.at(x, y + 1), self.at(x + 1, y + 1)];
                [0, 1, 2].map(|c| ((four.iter().map(|texel| u32::from(texel[c])).sum::<u32>() + 2) / 4) as u8)
            })
        };
        let rows: Vec<Vec<u8>> = parallel::map(top..top + height, |y| row(y).collect());
        Self { left, top, size: Size::new(width, height), texels: rows.concat() }
    }

    /// The texels of a tile with its border; beside the picture its nearest ones, which JPEG blurs least.
    fn tile(&self, node: TreeNode) -> Vec<u8> {
        let side = TILE_SIDE + 2 * BORDER;
        let first = |place: usize| (place * TILE_SIDE) as isize - BORDER as isize;
        let (left, top) = (first(node.column), first(node.row));
        let mut out = Vec::with_capacity(3 * side * side);
        for y in 0..side as isize {
            (0..side as isize).for_each(|x| out.extend_from_slice(self.at(left + x, top + y)));
        }
        out
    }
}

/// The numbers and the files of the tiles of a level.
fn tiles(tree: &Quadtree, level: u32, picture: &PlacedPicture, quality: u8) -> Result<Vec<(u64, Vec<u8>)>> {
    let side = TILE_SIDE + 2 * BORDER;
    let there: Vec<TreeNode> = Quadtree::nodes(level).filter(|node| tree.touches(*node)).collect();
    let tile = |node: TreeNode| {
        let file = jpeg::encode(&picture.tile(node), Size::new(side, side), 3, quality)?;
        Ok((node.index() + 1, file))
    };
    parallel::try_map(there, tile)
}
