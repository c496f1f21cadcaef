//! Block synthesis: `cargo bench -p relume-benches --bench synth`.
//!
//! Wall-clock seconds on all threads of the machine, pictures of built-in materials, RGB, blocks of 32 with
//! overlap 8: every search on 256 x 256 texels to 512 x 512, all of which must place the same blocks; then
//! the stages of the projection search with growing exemplar and output.

use relume::procedural::{Material, MaterialOptions};
use relume::synthesis::search::{SearchMethod, SearchOptions};
use relume::synthesis::{BlockOptions, Exemplar, Synthesis, synthesize};
use relume::{Job, Planes, Size};

fn main() {
    println!("{} threads", rayon::current_num_threads());
    for material in [Material::Sponge, Material::Weave, Material::Pebbles] {
        let exemplar = albedo(material, 256);
        let mut truth = None;
        for method in [SearchMethod::Brute, SearchMethod::Projection, SearchMethod::Fft] {
            let made = enlarged(&exemplar, 512, method);
            print_times(&format!("{} {method:?}", material.name()), &made);
            assert_eq!(*truth.get_or_insert_with(|| made.map.clone()), made.map, "searches differ");
        }
    }
    for (exemplar, output) in [(128, 512), (256, 512), (512, 512), (256, 1024), (256, 2048), (512, 1024)] {
        let made = enlarged(&albedo(Material::Pebbles, exemplar), output, SearchMethod::Projection);
        print_times(&format!("pebbles {exemplar} to {output}"), &made);
    }
}

fn albedo(material: Material, side: usize) -> Planes {
    let options = MaterialOptions { size: Size::new(side, side), ..MaterialOptions::default() };
    material.make(&options, &Job::default()).expect("the options are valid").albedo
}

fn enlarged(exemplar: &Planes, side: usize, method: SearchMethod) -> Synthesis {
    let search = SearchOptions { method, ..SearchOptions::default() };
    let size = Size::new(side, side);
    let options = BlockOptions { size, block: 32, overlap: 8, search, ..BlockOptions::default() };
    let exemplars = [Exemplar { index: exemplar, excluded: None }];
    synthesize(&exemplars, &options, &Job::default()).expect("the options are valid")
}

fn print_times(what: &str, made: &Synthesis) {
    let times = made.times;
    println!(
        "{what:<20} prepare {:.3} s, search {:.3} s, join {:.3} s",
        times.prepare_s, times.search_s, times.join_s
    );
}
