//! Relighting speed in texels per second, compared with the memory bandwidth of the machine.
//!
//! `cargo bench -p relume-benches --bench relight`

use std::hint::black_box;
use std::time::Instant;

use rayon::prelude::*;
use relume::field::{Basis, PlaneLayout};
use relume::numeric::random::{Purpose, Stream};
use relume::render::{relight, relight_srgb8};
use relume::{Direction, Planes, ReflectanceField, Size, Space};

const SIDE: usize = 2048;
const ROUNDS: usize = 15;

fn main() {
    println!("{SIDE} x {SIDE} texels, {} threads, best of {ROUNDS}", rayon::current_num_threads());
    let read = read_bandwidth();
    println!("memory read          {:6.2} GB/s", read / 1e9);
    println!("memory copy (r + w)  {:6.2} GB/s", copy_bandwidth() / 1e9);
    let light = Direction::from_disk(0.4, 0.3);
    for color in [PlaneLayout::LUMINANCE, PlaneLayout::LRGB, PlaneLayout::RGB] {
        for space in [Space::Linear, Space::Srgb] {
            let field = random_field(color.clone(), space);
            let planes = field.coefficients().count();
            let mut codes = vec![0u8; 3 * SIDE * SIDE];
            let seconds = best(|| relight_srgb8(&field, light, &mut codes));
            report(&format!("{} ptm, {space} -> sRGB8", color.name()), seconds, 4 * planes + 3, read);
            let seconds = best(|| drop(black_box(relight(&field, light))));
            report(
                &format!("{} ptm, {space} -> f32", color.name()),
                seconds,
                4 * (planes + color.channels()),
                read,
            );
        }
    }
}

fn report(what: &str, seconds: f64, bytes_per_texel: usize, read_bandwidth: f64) {
    let texels = (SIDE * SIDE) as f64 / seconds;
    let bytes = texels * bytes_per_texel as f64;
    println!(
        "{what:32} {:7.0} Mtexel/s  {:6.2} GB/s  {:3.0} % of read bandwidth",
        texels / 1e6,
        bytes / 1e9,
        100.0 * bytes / read_bandwidth
    );
}

fn best(mut job: impl FnMut()) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        job();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}

fn random_field(color: PlaneLayout, space: Space) -> ReflectanceField {
    let mut stream = Stream::new(1, Purpose::Sample, [0]);
    let size = Size::new(SIDE, SIDE);
    let count = color.planes(Basis::Ptm.len());
    let data = (0..size.texels() * count).map(|_| stream.unit() as f32).collect();
    let planes = Planes::from_vec(size, count, data).expect("the sizes agree");
    ReflectanceField::new(Basis::Ptm, color, space, planes).expect("the planes are those of the model")
}

/// Bytes per second of reading nine planes, all threads together.
fn read_bandwidth() -> f64 {
    let data: Vec<u32> = (0..9 * SIDE * SIDE).map(|i| i as u32).collect();
    let seconds = best(|| {
        let sums = data.par_chunks(1 << 16).map(|chunk| chunk.iter().fold(0u32, |a, &b| a.wrapping_add(b)));
        black_box(sums.reduce(|| 0, u32::wrapping_add));
    });
    (4 * data.len()) as f64 / seconds
}

/// Bytes per second, read and written, of copying nine planes.
fn copy_bandwidth() -> f64 {
    let data = vec![1u32; 9 * SIDE * SIDE];
    let mut copy = vec![0u32; data.len()];
    let seconds = best(|| {
        let chunks = copy.par_chunks_mut(1 << 16).zip(data.par_chunks(1 << 16));
        chunks.for_each(|(to, from)| to.copy_from_slice(from));
        black_box(&mut copy);
    });
    (8 * data.len()) as f64 / seconds
}
