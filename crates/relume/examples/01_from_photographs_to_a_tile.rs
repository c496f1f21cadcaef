//! The whole pipeline in the library: photographs under a virtual dome, a fit, a seamless enlargement,
//! and two pictures of the result. Writes the folder `01_capture` and the pictures `01_small.png` and
//! `01_large.png` into the current folder.

use relume::capture::dome::{Dome, DomeOptions, lights};
use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::Boundary;
use relume::workflow;
use relume::{Capture, Direction, FitOptions, Job, Result, Size, SynthOptions, fit, relight, synthesize};

fn main() -> Result<()> {
    // Photographs of a built-in material, encoded as a camera would.
    let job = Job::default();
    let material = MaterialOptions { size: Size::new(96, 96), feature: 24.0, ..MaterialOptions::default() };
    let dome = Dome::new(Material::Pebbles.make(&material, &job)?, &DomeOptions::default(), &job)?;
    workflow::capture::save(&dome, &lights(24), "01_capture", &job)?;

    // A function for every texel.
    let capture = Capture::open("01_capture")?;
    let small = fit(&capture, &FitOptions::default())?;
    println!("fitted {} photographs: {:.2} dB", capture.photographs.len(), small.report.error.psnr_db);

    // A larger texture that tiles.
    let options = SynthOptions {
        size: Size::new(192, 192),
        boundary: Boundary::Torus,
        overlap: Some(8),
        ..SynthOptions::default()
    };
    let large = synthesize(&small.field, &options)?;
    println!("laid {} of {} texels", large.field.size(), large.map.exemplars()[0]);

    // Pictures under one light.
    let light = Direction::new(-0.5, 0.5, 0.7)?;
    relight(&small.field, light).save("01_small.png")?;
    relight(&large.field, light).save("01_large.png")
}
