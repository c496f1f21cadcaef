//! Block synthesis by every search: `cargo bench -p relume-benches --bench synth`.
//!
//! Wall-clock seconds of a 256 x 256 RGB picture of a built-in material to 512 x 512, blocks of 32
//! with overlap 8, for the machine's number of threads; all searches must lay the same blocks.

use std::time::Instant;

use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::search::{SearchMethod, SearchOptions};
use relume::synthesis::{BlockOptions, Exemplar, synthesize};
use relume::{Limits, Size};

fn main() {
    let limits = Limits::default();
    let options =
        BlockOptions { size: Size::new(512, 512), block: 32, overlap: 8, ..BlockOptions::default() };
    println!("{} threads", rayon::current_num_threads());
    for material in [Material::Sponge, Material::Weave, Material::Pebbles] {
        let maps = material.make(&MaterialOptions::default(), &limits).expect("the options are valid");
        let exemplar = [Exemplar { index: &maps.albedo, excluded: None }];
        let mut truth = None;
        for method in [SearchMethod::Brute, SearchMethod::Projection, SearchMethod::Fft] {
            let search = SearchOptions { method, ..SearchOptions::default() };
            let begun = Instant::now();
            let made = synthesize(&exemplar, &BlockOptions { search, ..options.clone() }, &limits, &());
            let seconds = begun.elapsed().as_secs_f64();
            let map = made.expect("the options are valid").map;
            assert_eq!(*truth.get_or_insert_with(|| map.clone()), map, "searches differ");
            println!("{:<8} {method:?}: {seconds:.2} s", material.name());
        }
    }
}
