//! Textures that tile: `cargo bench -p relume-benches --bench tiling`.
//!
//! Wall-clock seconds on all threads of the machine, the best of three, pictures of the built-in sponge, RGB: a
//! border closed by bridges and by the other methods, and the whole-texture methods at a size that does not halve
//! evenly.

use std::time::Instant;

use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::fill::{FillMethod, FillOptions, tileable};
use relume::synthesis::pixel::{NeighbourSearch, PatchMatchOptions, WeiLevoyOptions};
use relume::synthesis::{Boundary, Exemplar};
use relume::workflow::Plan;
use relume::{Job, Named, Planes, Size};

fn main() {
    println!("{} threads", rayon::current_num_threads());
    for (side, methods) in [(256, FillMethod::ALL), (1024, &[FillMethod::Bridges, FillMethod::Optimised][..])]
    {
        let index = albedo(side);
        for method in methods {
            let exemplar = Exemplar { index: &index, excluded: None };
            let options = FillOptions { method: *method, ..FillOptions::default() };
            let close =
                || tileable(exemplar, side / 8, &options, &Job::default()).expect("the band has room");
            println!("tileable, {side} squared, {}: {:.3} s", method.name(), best(close));
        }
    }
    let (index, size) = (albedo(256), Size::new(513, 511));
    let exemplars = [Exemplar { index: &index, excluded: None }];
    let search = NeighbourSearch::Coherence { candidates: 1, codewords: 0 };
    let plans = [
        Plan::PatchMatch(PatchMatchOptions { size, ..PatchMatchOptions::default() }),
        Plan::WeiLevoy(WeiLevoyOptions { size, search, ..WeiLevoyOptions::default() }, Boundary::Torus),
    ];
    for plan in plans {
        let make = || plan.run(&exemplars, &Job::default()).expect("the options are valid");
        println!("{}, 256 squared to {size}, tiling: {:.3} s", plan.method().name(), best(make));
    }
}

fn albedo(side: usize) -> Planes {
    let options = MaterialOptions { size: Size::new(side, side), ..MaterialOptions::default() };
    Material::Sponge.make(&options, &Job::default()).expect("the options are valid").albedo
}

fn best<T>(mut work: impl FnMut() -> T) -> f64 {
    let time = |_| {
        let begun = Instant::now();
        std::hint::black_box(work());
        begun.elapsed().as_secs_f64()
    };
    (0..3).map(time).fold(f64::INFINITY, f64::min)
}
