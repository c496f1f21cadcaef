//! A texture of light and view in the library: a built-in weave under a virtual gonioreflectometer, its functions
//! learned from the images, an enlargement, and pictures from two sides. Writes `02_above.png`, `02_aside.png` and
//! `02_large.png` into the current folder.

use relume::capture::dome::sampling::{all_pairs, spread_directions};
use relume::capture::dome::{Dome, DomeOptions, Gonioreflectometer};
use relume::direction::Directions;
use relume::fit::learned::{self, LearnedOptions, Rank};
use relume::procedural::{Material, MaterialOptions};
use relume::{Direction, Job, Result, Size, SynthOptions, relight, synthesize};

fn main() -> Result<()> {
    // Images of a built-in material for all pairs of 24 lights and 16 views, with parallax and masking.
    let job = Job::default();
    let material = MaterialOptions { size: Size::new(64, 64), feature: 16.0, ..MaterialOptions::default() };
    let dome = Dome::new(Material::Weave.make(&material, &job)?, &DomeOptions::default(), &job)?;
    let pairs = all_pairs(&spread_directions(24, 1), &spread_directions(16, 2));
    let device = Gonioreflectometer::new(dome, pairs, &job)?;

    // Twelve functions of light and view, and as many numbers a texel.
    let named: Vec<(String, Directions)> =
        device.pairs().iter().enumerate().map(|(i, pair)| (format!("image {i}"), *pair)).collect();
    let options = LearnedOptions { rank: Rank::Functions(12), ..LearnedOptions::default() };
    let fit = learned::fit(&named, &|i| device.image(i, &job), &options, &job)?;
    println!("learned {} functions from {} images: {:.2} dB", 12, named.len(), fit.report.error.psnr_db);

    // The same light from two sides.
    let light = Direction::new(-0.5, 0.5, 0.7)?;
    let aside = Directions { light, view: Direction::new(0.8, 0.1, 0.6)? };
    relight(&fit.field, light).save("02_above.png")?;
    relight(&fit.field, aside).save("02_aside.png")?;

    // A larger texture, by the distance of the functions of light and view.
    let large =
        synthesize(&fit.field, &SynthOptions { size: Size::new(128, 128), ..SynthOptions::default() })?;
    relight(&large.field, aside).save("02_large.png")
}
