//! Random-field models: the speed of estimation and generation, and the bound set by the arithmetic.
//!
//! `cargo bench -p relume-benches --bench random_field`

use std::hint::black_box;
use std::time::Instant;

use relume::numeric::pyramid::Kernel;
use relume::procedural::{Material, MaterialOptions};
use relume::random_field::level::{Level, Weights};
use relume::random_field::neighbourhood::causal;
use relume::random_field::realisation::Realisation;
use relume::random_field::{ModelOptions, RealisationOptions, SelectionOrder, estimate};
use relume::{Job, Planes, Rect, Size};

const ROUNDS: usize = 5;

fn main() {
    let threads = rayon::current_num_threads();
    println!("{threads} threads, best of {ROUNDS}");
    recursion(threads);
    estimation();
}

/// One level: only noise and recursion.
fn recursion(threads: usize) {
    let side = 2048;
    let peak = multiply_adds();
    println!("fused multiply-adds: {:.1} Gflop/s a thread", 2.0 * peak / 1e9);
    for (planes, neighbours) in [(3, 0), (3, 20), (1, 20), (3, 40), (18, 20)] {
        let level = [level(planes, neighbours)];
        let kernel = Kernel::new(2).expect("two is a factor");
        let side = if planes > 3 { side / 4 } else { side };
        let area = Rect::new(0, 0, Size::new(side, side));
        let seconds = best(|| {
            drop(black_box(Realisation::new(&level, &kernel, None, 1, None).field(area, &Job::default())))
        });
        let rate = (side * side) as f64 / seconds;
        let operations = 2.0 * (planes * planes * neighbours) as f64;
        println!(
            "d = {planes:2}, eta = {neighbours:2}: {seconds:6.3} s, {:6.1} Mtexel/s, {:5.1} % of the multiply-adds",
            rate / 1e6,
            100.0 * operations * rate / (2.0 * peak * threads as f64)
        );
    }
}

fn level(planes: usize, neighbours: usize) -> Level {
    let count = neighbours * planes * planes;
    let weights: Vec<f64> = (0..count).map(|i| 0.8 / (count as f64) * ((i % 7) as f64 - 3.0)).collect();
    Level {
        gain: None,
        unevenness: 0,
        neighbours: causal(neighbours),
        coarse: Vec::new(),
        weights: Weights::nearest(&weights, neighbours, vec![1e-3; 2 * planes], vec![1e-2; planes]),
        noise: (0..planes).flat_map(|i| (0..=i).map(move |j| if i == j { 1.0 } else { 0.3 })).collect(),
        burn_in: 16,
        log_evidence: 0.0,
        texels: 0,
    }
}

fn estimation() {
    let job = Job::default();
    for side in [256, 1024] {
        let planes = colour(side);
        for search in [SelectionOrder::Nested, SelectionOrder::Forward, SelectionOrder::Backward] {
            let options = ModelOptions { search, ..ModelOptions::default() };
            let seconds = best(|| drop(black_box(estimate(&planes, &options, &job).expect("it varies"))));
            println!(
                "estimation, {side} x {side} colour, 4 levels, 40 neighbours, {search:?}: {seconds:.3} s"
            );
        }
    }
    let (model, _) = estimate(&colour(256), &ModelOptions::default(), &job).expect("it varies");
    let options = RealisationOptions { origin: [0, 0], size: Size::new(2048, 2048), seed: 1, period: None };
    let seconds = best(|| drop(black_box(model.synthesize(&options, &job).expect("it fits"))));
    let neighbours: Vec<_> =
        model.levels.iter().map(|l| (l.neighbours.len(), l.coarse.len(), l.burn_in)).collect();
    println!(
        "synthesis of 2048 x 2048 colour, 4 levels of (causal, coarse, margin) {neighbours:?}: {seconds:.3} s, {:.1} Mtexel/s",
        4.194_304 / seconds
    );
}

fn colour(side: usize) -> Planes {
    let options = MaterialOptions { size: Size::new(side, side), ..MaterialOptions::default() };
    let maps = Material::Bark.make(&options, &Job::default()).expect("the size is allowed");
    let mut planes = maps.albedo;
    for plane in planes.iter_mut() {
        plane.iter_mut().zip(maps.height.plane(0)).for_each(|(v, h)| *v *= 1.0 + 0.02 * h);
    }
    planes
}

/// Fused multiply-adds per second on one thread: twelve independent chains of eight lanes.
fn multiply_adds() -> f64 {
    #[inline(always)]
    fn chains(rounds: usize) -> f32 {
        let mut sums = [[1.0f32; 8]; 12];
        let factor = black_box(0.999_999f32);
        for _ in 0..rounds {
            for sum in &mut sums {
                sum.iter_mut().for_each(|s| *s = s.mul_add(factor, 1e-6));
            }
        }
        sums.iter().flatten().sum()
    }
    let rounds = 2_000_000;
    let run = || {
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp_v3() {
            return simd.vectorize(
                #[inline(always)]
                || chains(rounds),
            );
        }
        chains(rounds)
    };
    let seconds = best(|| {
        black_box(run());
    });
    96.0 * rounds as f64 / seconds
}

#[cfg(target_arch = "x86_64")]
fn pulp_v3() -> Option<pulp::x86::V3> {
    pulp::x86::V3::try_new()
}

fn best(mut job: impl FnMut()) -> f64 {
    let times = (0..ROUNDS).map(|_| {
        let start = Instant::now();
        job();
        start.elapsed().as_secs_f64()
    });
    times.fold(f64::INFINITY, f64::min)
}
