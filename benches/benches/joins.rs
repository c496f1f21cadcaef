//! Joining blocks: `cargo bench -p relume-benches --bench joins`.
//!
//! For each method, the wall-clock seconds of a 256 x 256 RGB picture of a built-in material to 512 x 512,
//! blocks of 32 with overlap 8, the least of three runs; and the mean energy of the seams over four seeds,
//! per output texel: for each pair of neighbours from different blocks, the squared differences, at both
//! texels, between the two blocks (values with white at 1, times 10,000).

use std::time::Instant;

use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::{Blend, BlockOptions, Exemplar, SourceMap, Texel, synthesize};
use relume::{Job, Planes, Size};

fn main() {
    println!("{} threads", rayon::current_num_threads());
    for material in Material::ALL {
        let maps = material.make(&MaterialOptions::default(), &Job::default()).expect("valid options");
        for (blend, feather) in
            [(Blend::Cut, 0), (Blend::GraphCut, 0), (Blend::Cut, 2), (Blend::GraphCut, 2), (Blend::Alpha, 0)]
        {
            let (mut seconds, mut energy) = (f64::INFINITY, 0.0);
            for seed in 0..4 {
                let (taken, map) = make(&maps.albedo, blend, feather, seed);
                seconds = seconds.min(taken);
                energy += seam_energy(&map, &maps.albedo) / 4.0;
            }
            let energy =
                if map_is_copies(blend, feather) { format!("{:.3}", 1e4 * energy) } else { "-".into() };
            println!("{:<8} {blend:?}, feather {feather}: {seconds:.2} s, energy {energy}", material.name());
        }
    }
}

fn map_is_copies(blend: Blend, feather: usize) -> bool {
    blend != Blend::Alpha && feather == 0
}

fn make(exemplar: &Planes, blend: Blend, feather: usize, seed: u64) -> (f64, SourceMap) {
    let size = Size::new(512, 512);
    let options = BlockOptions { size, block: 32, overlap: 8, blend, feather, seed, ..Default::default() };
    let begun = Instant::now();
    let exemplar = [Exemplar { index: exemplar, excluded: None }];
    let made = synthesize(&exemplar, &options, &Job::default()).expect("valid options");
    (begun.elapsed().as_secs_f64(), made.map)
}

/// The mean energy of the seams of a map of copies.
fn seam_energy(map: &SourceMap, exemplar: &Planes) -> f64 {
    let size = map.size();
    let at = |x: usize, y: usize| map.copies()[size.index(x, y)];
    let mut sum = 0.0;
    for (x, y) in (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))) {
        if x + 1 < size.width {
            sum += pair_energy(exemplar, at(x, y), at(x + 1, y), (1, 0));
        }
        if y + 1 < size.height {
            sum += pair_energy(exemplar, at(x, y), at(x, y + 1), (0, 1));
        }
    }
    sum / size.texels() as f64
}

/// The energy between an output texel from `a` and its neighbour from `b`, one step farther.
fn pair_energy(exemplar: &Planes, a: Texel, b: Texel, (dx, dy): (i64, i64)) -> f64 {
    let moved = |t: Texel, sign: i64| {
        let x = usize::try_from(i64::from(t.x) + sign * dx).ok()?;
        let y = usize::try_from(i64::from(t.y) + sign * dy).ok()?;
        let size = exemplar.size();
        (x < size.width && y < size.height).then_some(Texel { exemplar: 0, x: x as u32, y: y as u32 })
    };
    let here = moved(b, -1).map(|b| distance(exemplar, a, b));
    let there = moved(a, 1).map(|a| distance(exemplar, a, b));
    match (here, there) {
        (Some(here), Some(there)) => here + there,
        (Some(one), None) | (None, Some(one)) => 2.0 * one,
        (None, None) => 0.0,
    }
}

fn distance(exemplar: &Planes, a: Texel, b: Texel) -> f64 {
    let value = |k: usize, t: Texel| f64::from(exemplar.at(k, t.x as usize, t.y as usize));
    (0..exemplar.count()).map(|k| (value(k, a) - value(k, b)).powi(2)).sum()
}
