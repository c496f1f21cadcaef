//! Pictures side by side at true scale: a contact sheet.
//!
//! `04_contact_sheet sheet.jpg A.png B.png / C.png D.png` has two rows; columns are as wide as their widest picture. A
//! picture given as `A.png:half` is shifted by half of its sides, so that its borders meet in the middle. Without arguments,
//! `04_contact_sheet.jpg` shows a built-in material, a texture of it that tiles, and that texture shifted.
//!
//! The sheets of docs/methods.md consist of the pictures of `docs/pictures/sheets.sh`.

use std::ffi::OsStr;
use std::path::Path;

use relume::capture::dome::{Dome, DomeOptions};
use relume::format::{PictureFormat, encode_picture};
use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::Boundary;
use relume::{Direction, Error, Job, Picture, Planes, ReflectanceField, Result, Size, Space, SynthOptions};
use relume::{relight, synthesize};

/// Texels between pictures.
const GAP: usize = 8;
/// The quality of the JPEG, enough for textures.
const QUALITY: u8 = 80;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.split_first() {
        Some((path, names)) => {
            let row = |names: &[String]| names.iter().map(|name| named(name)).collect::<Result<Vec<_>>>();
            let rows = names.split(|word| word == "/").map(row).collect::<Result<Vec<_>>>()?;
            save(&sheet(&rows), Path::new(path))
        }
        None => save(&sheet(&[built_in()?]), Path::new("04_contact_sheet.jpg")),
    }
}

/// A leather, a texture of it that tiles, and that texture shifted.
fn built_in() -> Result<Vec<Picture>> {
    let job = Job::default();
    let material = MaterialOptions { size: Size::new(64, 64), feature: 16.0, ..MaterialOptions::default() };
    let dome = Dome::new(Material::Leather.make(&material, &job)?, &DomeOptions::default(), &job)?;
    let exemplar = dome.photograph(Direction::new(-0.5, 0.5, 0.7)?)?;
    let field = ReflectanceField::from_picture(exemplar.clone());
    let size = Size::new(96, 96);
    let made =
        synthesize(&field, &SynthOptions { size, boundary: Boundary::Torus, ..SynthOptions::default() })?;
    let texture = seen(&made.field)?;
    let shifted = shifted(&texture);
    Ok(vec![exemplar, texture, shifted])
}

/// The picture of a file, shifted if it is named so.
fn named(name: &str) -> Result<Picture> {
    match name.strip_suffix(":half") {
        Some(path) => Ok(shifted(&seen(&ReflectanceField::open(path)?)?)),
        None => seen(&ReflectanceField::open(name)?),
    }
}

fn seen(field: &ReflectanceField) -> Result<Picture> {
    Ok(relight(field, Direction::new(0.0, 0.0, 1.0)?).to_space(Space::Srgb))
}

/// The same moved around the torus by half of its sides.
fn shifted(picture: &Picture) -> Picture {
    let Size { width, height } = picture.size();
    let moved = picture.planes.repeated(2, 2).crop(width / 2, height / 2, picture.size());
    Picture { planes: moved.expect("half of a doubled plane fits"), space: picture.space }
}

/// All pictures on white, in rows, RGB.
fn sheet(rows: &[Vec<Picture>]) -> Picture {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let of_column = |k: usize| rows.iter().filter_map(move |row| Some(row.get(k)?.size().width)).max();
    let widths: Vec<usize> = (0..columns).map(|k| of_column(k).unwrap_or(0)).collect();
    let heights: Vec<usize> =
        rows.iter().map(|row| row.iter().map(|one| one.size().height).max().unwrap_or(0)).collect();
    let along =
        |sides: &[usize]| sides.iter().map(|side| side + GAP).sum::<usize>().saturating_sub(GAP).max(1);
    let mut planes = Planes::zeros(Size::new(along(&widths), along(&heights)), 3);
    planes.as_mut_slice().fill(1.0);
    let mut y = 0;
    for (row, height) in rows.iter().zip(&heights) {
        let mut x = 0;
        for (picture, width) in row.iter().zip(&widths) {
            paste(&mut planes, picture, (x, y));
            x += width + GAP;
        }
        y += height + GAP;
    }
    Picture { planes, space: Space::Srgb }
}

fn paste(onto: &mut Planes, picture: &Picture, (x, y): (usize, usize)) {
    let picture = picture.to_space(Space::Srgb);
    let (whole, Size { width, height }) = (onto.size(), picture.size());
    for k in 0..3 {
        let from = picture.planes.plane(k.min(picture.planes.count() - 1));
        let to = onto.plane_mut(k);
        for row in 0..height {
            to[whole.index(x, y + row)..][..width].copy_from_slice(&from[row * width..][..width]);
        }
    }
}

fn save(picture: &Picture, path: &Path) -> Result<()> {
    let is_jpeg = path.extension().and_then(OsStr::to_str) == Some("jpg");
    let format =
        if is_jpeg { PictureFormat::Jpeg { quality: QUALITY } } else { PictureFormat::from_path(path)? };
    std::fs::write(path, encode_picture(picture, format)?).map_err(|e| Error::io("cannot write", &e).at(path))
}
