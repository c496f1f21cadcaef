//! Fitting speed from photographs in memory, and the bound set by the size of the photographs.
//!
//! `cargo bench -p relume-benches --bench fit`

use std::hint::black_box;
use std::time::Instant;

use relume::field::PlaneLayout;
use relume::fit::{FitOptions, fit};
use relume::numeric::random::{Purpose, Stream};
use relume::{Direction, Job, Raster, Samples, Size, Space};

const SIDE: usize = 1024;
const PHOTOGRAPHS: usize = 116;
const ROUNDS: usize = 3;

fn main() {
    let threads = rayon::current_num_threads();
    println!("{PHOTOGRAPHS} photographs of {SIDE} x {SIDE}, 8 bits, {threads} threads, best of {ROUNDS}");
    let lights: Vec<_> = (0..PHOTOGRAPHS).map(|i| (format!("p{i}"), light(i))).collect();
    for channels in [1, 3] {
        // Eight different photographs represent all: their content does not affect the time.
        let photographs: Vec<Raster> = (0..8).map(|i| photograph(channels, i)).collect();
        let samples = (PHOTOGRAPHS * channels * SIDE * SIDE) as f64;
        let copies = best(|| (0..PHOTOGRAPHS).for_each(|i| drop(black_box(photographs[i % 8].clone()))));
        println!("{channels} channels, copies alone      {copies:6.3} s");
        for (color, space) in [
            (PlaneLayout::RGB, Space::Srgb),
            (PlaneLayout::LRGB, Space::Srgb),
            (PlaneLayout::LRGB, Space::Linear),
        ] {
            let options = FitOptions { layout: color.clone(), space, ..FitOptions::default() };
            let (name, load) = (space.to_string(), |i: usize| Ok(photographs[i % 8].clone()));
            let seconds = best(|| {
                let fit = fit(&lights, &load, &options, &Job::default());
                drop(black_box(fit.expect("the lights suffice")));
            });
            println!(
                "{channels} channels, {:4} {name:6}          {seconds:6.3} s  {:5.2} Gsample/s",
                color.name(),
                samples / seconds / 1e9
            );
        }
    }
}

/// Lights evenly over the hemisphere, on a spiral.
fn light(i: usize) -> Direction {
    let polar = (0.1 + 0.9 * (i as f64 + 0.5) / PHOTOGRAPHS as f64).acos();
    Direction::from_angles(polar, 2.399_963 * i as f64)
}

fn photograph(channels: usize, place: u64) -> Raster {
    let mut stream = Stream::new(1, Purpose::Sample, [place]);
    let codes = (0..SIDE * SIDE * channels).map(|_| stream.below(256) as u8).collect();
    Raster::new(Size::new(SIDE, SIDE), channels, Samples::U8(codes)).expect("as many samples as texels")
}

fn best(mut job: impl FnMut()) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        job();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}
