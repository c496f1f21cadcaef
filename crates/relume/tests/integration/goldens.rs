//! Pictures of our own material, inspected and kept: a capture fitted, enlarged and relit.
//!
//! `UPDATE_GOLDENS=1` rewrites them; do so only after looking at the difference picture that a
//! failure leaves.

use std::path::Path;

use relume::capture::dome::{Dome, DomeOptions, lights};
use relume::field::{Domain, IndexSpace, Metric};
use relume::fit::{FitOptions, fit};
use relume::format::{Depth, PictureFormat, decode_raster, encode_picture, read_raster};
use relume::procedural::{Material, MaterialOptions};
use relume::render::relight;
use relume::synthesis::{BlockOptions, Boundary, Exemplar, gather, synthesize};
use relume::{Direction, Job, Picture, Planes, Raster, ReflectanceField, Result, Size, Space};

const PNG: PictureFormat = PictureFormat::Png(Depth::Eight);

/// Differences in codes allowed between processors and mathematics libraries.
const TOLERANCE: f32 = 1.0;

fn fitted() -> Result<ReflectanceField> {
    let job = Job::default();
    let material = MaterialOptions { size: Size::new(48, 40), feature: 16.0, ..MaterialOptions::default() };
    let dome = Dome::new(Material::Pebbles.make(&material, &job)?, &DomeOptions::default(), &job)?;
    let lamps: Vec<(String, Direction)> =
        lights(12).into_iter().enumerate().map(|(i, light)| (i.to_string(), light)).collect();
    let photographs = lamps
        .iter()
        .map(|(_, light)| encode_picture(&dome.photograph(*light)?, PNG))
        .collect::<Result<Vec<_>>>()?;
    let load = |i: usize| decode_raster(&photographs[i], &job);
    Ok(fit(&lamps, &load, &FitOptions::default(), &job)?.field)
}

fn enlarged(field: &ReflectanceField) -> Result<ReflectanceField> {
    let index = IndexSpace::new(field, Metric::Function, Domain::Hemisphere)?.index_planes(field);
    let options = BlockOptions {
        size: Size::new(72, 64),
        block: 16,
        overlap: 4,
        boundary: Boundary::Torus,
        ..BlockOptions::default()
    };
    let job = Job::default();
    let made = synthesize(&[Exemplar { index: &index, excluded: None }], &options, &job)?;
    gather(&made.map, &[field], &job)
}

/// Compares a picture with the stored one of that name.
fn check(name: &str, picture: &Picture) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
    let bytes = encode_picture(picture, PNG).unwrap();
    if std::env::var_os("UPDATE_GOLDENS").is_some() {
        std::fs::write(&path, bytes).unwrap();
        return;
    }
    let job = Job::default();
    let (kept, made) = (read_raster(&path, &job).unwrap(), decode_raster(&bytes, &job).unwrap());
    assert_eq!(kept.size(), made.size(), "{name}");
    let differences = differences(&kept, &made);
    let largest = differences.as_slice().iter().fold(0.0f32, |a, &b| a.max(b));
    if largest > TOLERANCE {
        let seen = std::env::temp_dir().join(format!("difference_{name}"));
        let mut planes = differences;
        planes.as_mut_slice().iter_mut().for_each(|v| *v /= largest);
        std::fs::write(&seen, encode_picture(&Picture { planes, space: Space::Srgb }, PNG).unwrap()).unwrap();
        panic!("{name} differs by up to {largest} codes; look at {}", seen.display());
    }
}

/// Absolute differences in 8-bit codes.
fn differences(kept: &Raster, made: &Raster) -> Planes {
    let (mut a, b) = (kept.to_picture(Space::Srgb).planes, made.to_picture(Space::Srgb).planes);
    a.as_mut_slice().iter_mut().zip(b.as_slice()).for_each(|(a, b)| *a = ((*a - b) * 255.0).abs().round());
    a
}

#[test]
fn a_fitted_capture_relights_as_it_did() {
    let field = fitted().unwrap();
    check("pebbles_left.png", &relight(&field, Direction::new(-0.6, 0.2, 0.7).unwrap()));
    check("pebbles_above.png", &relight(&field, Direction::new(0.1, 0.8, 0.5).unwrap()));
}

#[test]
fn a_texture_enlarges_as_it_did() {
    let large = enlarged(&fitted().unwrap()).unwrap();
    check("pebbles_tile.png", &relight(&large, Direction::new(-0.6, 0.2, 0.7).unwrap()));
}
