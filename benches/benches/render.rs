//! Time of a picture on each built-in object: 800 x 800 pixels, 3 x 3 samples, one light; and of a sphere under the
//! built-in sky, prefiltered and by 256 samples of it a pixel, one point a pixel.
//!
//! `cargo bench -p relume-benches --bench render`

use std::time::Instant;

use relume::field::{Basis, PlaneLayout};
use relume::numeric::random::{Purpose, Stream};
use relume::render::{Environment, EnvironmentLight, EnvironmentMethod, Primitive, RenderOptions, render};
use relume::{Job, Planes, ReflectanceField, Size, Space, surface};

const ROUNDS: usize = 5;

fn main() {
    println!("{} threads, best of {ROUNDS}", rayon::current_num_threads());
    let field = random_field(Size::new(1024, 1024));
    let normals = surface::normals(&field);
    for primitive in Primitive::ALL {
        let mesh = primitive.mesh();
        let options = RenderOptions { tiling: primitive.default_tiling(), ..RenderOptions::default() };
        let seconds = (0..ROUNDS).map(|_| {
            let start = Instant::now();
            render(&field, Some(&normals), &mesh, &options, &Job::default()).expect("it renders");
            start.elapsed().as_secs_f64()
        });
        println!("{:8} {:.2} s", primitive.name(), seconds.fold(f64::INFINITY, f64::min));
    }
    let sky = Environment::sky(&Job::default()).expect("it fits");
    let sampled = EnvironmentMethod::Sampled { samples: 256, seed: 0 };
    for (name, method) in [("prefiltered", EnvironmentMethod::Prefiltered), ("256 samples", sampled)] {
        let options = RenderOptions {
            samples: 1,
            lights: Vec::new(),
            environment: Some(EnvironmentLight { environment: sky.clone(), method }),
            tiling: Primitive::Sphere.default_tiling(),
            ..RenderOptions::default()
        };
        let start = Instant::now();
        render(&field, Some(&normals), &Primitive::Sphere.mesh(), &options, &Job::default())
            .expect("it renders");
        println!("sphere under the sky, {name}: {:.2} s", start.elapsed().as_secs_f64());
    }
}

fn random_field(size: Size) -> ReflectanceField {
    let mut stream = Stream::new(1, Purpose::Sample, [0]);
    let data = (0..size.texels() * 9).map(|_| stream.unit() as f32).collect();
    let planes = Planes::from_vec(size, 9, data).expect("the sizes agree");
    ReflectanceField::new(Basis::Ptm, PlaneLayout::LRGB, Space::Linear, planes).expect("nine planes")
}
