//! The whole way in the library: photographs under a virtual dome, a fit, a seamless enlargement,
//! and two pictures of it. Writes `01_small.png` and `01_large.png` into the current folder.

use relume::capture::dome::{Dome, DomeOptions, lights};
use relume::field::{Domain, IndexSpace, Metric, PlaneLayout};
use relume::fit::{FitOptions, fit};
use relume::format::{Depth, PictureFormat, decode_raster, encode_picture};
use relume::procedural::{Material, MaterialOptions};
use relume::render::relight;
use relume::synthesis::{BlockOptions, Boundary, Exemplar, gather, synthesize};
use relume::{Direction, Job, Result, Size, Space};

const PNG: PictureFormat = PictureFormat::Png(Depth::Eight);

fn main() -> Result<()> {
    let job = Job::default();

    // Photographs of a built-in material, encoded as a camera would.
    let material = MaterialOptions { size: Size::new(96, 96), feature: 24.0, ..MaterialOptions::default() };
    let dome = Dome::new(Material::Pebbles.make(&material, &job)?, &DomeOptions::default(), &job)?;
    let lamps: Vec<(String, Direction)> =
        lights(24).into_iter().enumerate().map(|(i, light)| (format!("photograph {i}"), light)).collect();
    let photographs = lamps
        .iter()
        .map(|(_, light)| encode_picture(&dome.photograph(*light)?, PNG))
        .collect::<Result<Vec<_>>>()?;

    // A function for every texel.
    let options = FitOptions { layout: PlaneLayout::LRGB, space: Space::Srgb, ..FitOptions::default() };
    let fitted = fit(&lamps, &|i| decode_raster(&photographs[i], &job), &options, &job)?;
    println!("fitted {} photographs: {:.2} dB", lamps.len(), fitted.report.error.psnr_db);

    // A larger texture that tiles: where each texel comes from, then the texels.
    let space = IndexSpace::new(&fitted.field, Metric::Function, Domain::Hemisphere)?;
    let index = space.index_planes(&fitted.field);
    let blocks = BlockOptions {
        size: Size::new(192, 192),
        block: 32,
        overlap: 8,
        boundary: Boundary::Torus,
        ..BlockOptions::default()
    };
    let made = synthesize(&[Exemplar { index: &index, excluded: None }], &blocks, &job)?;
    let large = gather(&made.map, &[&fitted.field], &job)?;
    println!("laid {} blocks", made.report.placements.len());

    // Pictures under one light.
    let light = Direction::from_vector(-0.5, 0.5, 0.7)?;
    for (name, field) in [("01_small.png", &fitted.field), ("01_large.png", &large)] {
        let bytes = encode_picture(&relight(field, light), PNG)?;
        std::fs::write(name, bytes).map_err(|e| relume::Error::io("cannot write", &e).at(name))?;
        println!("{name}: {}", field.size());
    }
    Ok(())
}
