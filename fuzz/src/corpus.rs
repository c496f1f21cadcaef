//! Writes the first files of each corpus by the library's own writers: `cargo run --bin corpus`, in this folder.

use std::error::Error;
use std::fs;
use std::path::Path;

use relume::capture::lp;
use relume::direction::Direction;
use relume::field::{Basis, PlaneLayout, ReflectanceField};
use relume::format::exr::encode_labelled;
use relume::format::web::{WebLayout, WebOptions, encode_web};
use relume::format::{
    Depth, ExrDepth, FieldFormat, HeightFormat, NormalY, PictureFormat, encode_field, encode_height,
    encode_normals, encode_picture, npy,
};
use relume::{Job, Picture, Planes, Size, Space};

const SIZE: Size = Size { width: 9, height: 6 };

fn main() -> Result<(), Box<dyn Error>> {
    for (basis, formats) in [
        (
            "ptm",
            &[FieldFormat::Ptm, FieldFormat::PtmJpeg { quality: 90 }, FieldFormat::Exr(ExrDepth::Half)][..],
        ),
        ("hsh9", &[FieldFormat::Rti, FieldFormat::Hsh, FieldFormat::Exr(ExrDepth::Float)]),
    ] {
        for layout in [PlaneLayout::RGB, PlaneLayout::LRGB] {
            for format in formats {
                let bytes = encode_field(&field(basis, layout.clone())?, *format, None, &Job::default())?;
                let target = match format {
                    FieldFormat::Rti | FieldFormat::Hsh => "hsh",
                    FieldFormat::Exr(_) => "exr",
                    _ => "ptm",
                };
                keep(&[target, "front"], &format!("{basis} {format:?} {}", layout.planes(1)), &bytes)?;
            }
        }
    }
    folders()?;
    for format in [
        PictureFormat::Png(Depth::Eight),
        PictureFormat::Png(Depth::Sixteen),
        PictureFormat::Tiff(Depth::Eight),
        PictureFormat::Jpeg { quality: 90 },
        PictureFormat::Exr(ExrDepth::Half),
        PictureFormat::Pfm,
        PictureFormat::Radiance,
    ] {
        for channels in [1, 3] {
            let picture = Picture { planes: planes(channels)?, space: Space::Srgb };
            let bytes = encode_picture(&picture, format)?;
            keep(&["picture", "mask", "front"], &format!("{channels} {format:?}"), &bytes)?;
        }
        let bytes = encode_normals(&planes(3)?, NormalY::Down, format, &Job::default())?;
        keep(&["normals"], &format!("{format:?}"), &bytes)?;
    }
    for format in [HeightFormat::Png, HeightFormat::Exr] {
        keep(&["heights", "front"], &format!("{format:?}"), &encode_height(&planes(1)?, Some(0.1), format)?)?;
    }
    keep(&["exr"], "named", &encode_labelled(&["x", "y"], &planes(2)?, ExrDepth::Float)?)?;
    keep(&["npy", "front"], "map", &npy::encode_i32(SIZE, 2, &[7; 108])?)?;
    let lights = [("a.png".to_owned(), Direction::from_angles(0.5, 1.0))];
    keep(&["lights", "front"], "one", lp::format(&lights).as_bytes())?;
    keep(
        &["mesh", "front"],
        "square",
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n",
    )?;
    Ok(())
}

/// The description of a folder, a zero, and one of its pictures.
fn folders() -> Result<(), Box<dyn Error>> {
    for (layout, target, info) in
        [(WebLayout::Plain, "web", "info.json"), (WebLayout::Multires, "multires", "info.xml")]
    {
        for (basis, color) in
            [("ptm", PlaneLayout::RGB), ("ptm", PlaneLayout::LRGB), ("hsh9", PlaneLayout::RGB)]
        {
            let (mut head, mut picture) = (Vec::new(), Vec::new());
            let mut store = |name: &str, bytes: &[u8]| {
                let part = if name == info { &mut head } else { &mut picture };
                *part = bytes.to_vec();
                Ok(())
            };
            let field = field(basis, color.clone())?;
            encode_web(&field, &WebOptions { layout, quality: 90 }, &Job::default(), &mut store)?;
            keep(&[target], &format!("{basis} {}", color.planes(1)), &[head, vec![0], picture].concat())?;
        }
    }
    Ok(())
}

/// Puts a file into the corpora of some targets.
fn keep(targets: &[&str], name: &str, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    let name: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    for target in targets {
        let folder = Path::new("corpus").join(target);
        fs::create_dir_all(&folder)?;
        fs::write(folder.join(&name), bytes)?;
    }
    Ok(())
}

fn planes(count: usize) -> Result<Planes, relume::Error> {
    let value = |i: usize| 0.5 + 0.4 * (0.7 * i as f32).sin();
    Planes::from_vec(SIZE, count, (0..SIZE.texels() * count).map(value).collect())
}

fn field(basis: &str, layout: PlaneLayout) -> Result<ReflectanceField, relume::Error> {
    let basis = Basis::from_name(basis).expect("a basis of this name");
    let planes = planes(layout.planes(basis.len()))?;
    ReflectanceField::new(basis, layout, Space::Srgb, planes)
}
