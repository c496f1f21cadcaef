//! The Roller and noise: `cargo bench -p relume-benches --bench roller`.
//!
//! Wall-clock seconds on all threads of the machine, the best of five: analysis of a 256 x 256 RGB picture of
//! the built-in weave and of its six-term functions; bytes of output per second of windows of the endless
//! plane, as `f32` planes and as interleaved bytes, and of noise.

use std::time::Instant;

use relume::numeric::random::{Purpose, Stream};
use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::Exemplar;
use relume::synthesis::noise::{Noise, NoiseOptions};
use relume::synthesis::roller::{Endless, RollerOptions, roll};
use relume::{Job, Planes, Size};

fn main() {
    let job = Job::default();
    println!("{} threads", rayon::current_num_threads());
    let maps = Material::Weave.make(&MaterialOptions::default(), &job).expect("the options are valid");
    analyses("RGB, 3 planes", &maps.albedo);
    let many: Vec<f32> =
        (0..6).flat_map(|k| maps.albedo.as_slice().iter().map(move |v| v * (k + 1) as f32)).collect();
    analyses("18 planes", &Planes::from_vec(maps.albedo.size(), 18, many).expect("18 planes"));
    corners();
    windows();
    noise();
}

fn corners() {
    let maps =
        Material::Sponge.make(&MaterialOptions::default(), &Job::default()).expect("the options are valid");
    let exemplar = Exemplar { index: &maps.albedo, excluded: None };
    let options = RollerOptions { tiles: 16, vary: true, ..RollerOptions::default() };
    let seconds = best(|| roll(&exemplar, &options, &Job::default()).expect("the sponge has room for tiles"));
    println!("16 tiles whose borders vary, 3 planes: {seconds:.3} s");
}

fn best<T>(mut work: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let begun = Instant::now();
        std::hint::black_box(work());
        begun.elapsed().as_secs_f64()
    };
    (0..5).map(time).fold(f64::INFINITY, f64::min)
}

fn analyses(what: &str, index: &Planes) {
    let exemplar = Exemplar { index, excluded: None };
    for tiles in [1, 4] {
        let options = RollerOptions { tiles, ..RollerOptions::default() };
        let seconds = best(|| roll(&exemplar, &options, &Job::default()).expect("the weave has periods"));
        println!("analysis, {what}, {tiles} tiles: {seconds:.3} s");
    }
}

fn windows() {
    let (tile, count) = (Size::new(118, 107), 4);
    let stacked = Planes::zeros(Size::new(tile.width, tile.height * count), 3);
    let plane = Endless::new(tile, count, 1).expect("tiles");
    let size = Size::new(4096, 4096);
    let bytes = (size.texels() * 3 * 4) as f64;
    let seconds = best(|| plane.window(&stacked, -5000, 777, size, &Job::default()).expect("a window"));
    println!("enlargement, 3 f32 planes, memory allocated each time: {:.2} GB/s", bytes / seconds / 1e9);
    let interleaved = vec![7u8; stacked.size().texels() * 3];
    let mut row = vec![0u8; 65536 * 3];
    let rows = 1000;
    let seconds = best(|| (0..rows).for_each(|y| plane.copy_row(&interleaved, 3, -5000, y, &mut row)));
    println!(
        "enlargement, RGB bytes, one thread: {:.2} GB/s",
        (row.len() as i64 * rows) as f64 / seconds / 1e9
    );
}

fn noise() {
    let mut stream = Stream::new(1, Purpose::Sample, [0]);
    let size = Size::new(256, 256);
    let data = (0..3 * size.texels()).map(|_| stream.unit() as f32).collect();
    let index = Planes::from_vec(size, 3, data).expect("three planes");
    let make = || Noise::new(&index, &NoiseOptions::default(), &Job::default()).expect("noise suits");
    println!("noise, model of 256 x 256 RGB: {:.3} s", best(make));
    let (model, size) = (make(), Size::new(1024, 1024));
    let seconds = best(|| model.window(0, 0, size, &Job::default()).expect("a window"));
    println!("noise, 3 planes: {:.1} million texels a second", size.texels() as f64 / seconds / 1e6);
}
