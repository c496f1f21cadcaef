//! Every basis and any channels pass through all stages: index planes, synthesis, gathering, relighting,
//! files.

use relume::field::{Basis, Domain, IndexSpace, Metric, PlaneLayout};
use relume::fit::{FitOptions, fit};
use relume::format::{ExrDepth, FieldFormat, decode_field, encode_field};
use relume::render::relight;
use relume::synthesis::{BlockOptions, Boundary, Exemplar, gather, synthesize};
use relume::{Direction, Job, Raster, ReflectanceField, Samples, Size, Space};

use crate::support::random_field;

const SIZE: Size = Size { width: 24, height: 18 };

fn material() -> PlaneLayout {
    PlaneLayout::of_channels(["base", "metallic", "roughness", "height", "590 nm"]).unwrap()
}

/// The field resynthesised from the index planes of a field, and the source of each texel.
fn resynthesised(field: &ReflectanceField) -> (ReflectanceField, Vec<usize>) {
    let space = IndexSpace::new(field, Metric::Function, Domain::Hemisphere).unwrap();
    let index = space.index_planes(field);
    let layout = field.layout();
    let functions = if layout.is_product() { layout.channels() } else { layout.functions() };
    assert_eq!(index.count(), field.basis().len() * functions);
    let options = BlockOptions {
        size: Size::new(20, 16),
        block: 8,
        overlap: 3,
        boundary: Boundary::Torus,
        ..BlockOptions::default()
    };
    let exemplar = Exemplar { index: &index, excluded: None };
    let map = synthesize(&[exemplar], &options, &Job::default()).unwrap().map;
    let sources = map.copies().iter().map(|from| field.size().index(from.x as usize, from.y as usize));
    let sources = sources.collect();
    (gather(&map, &[field], &Job::default()).unwrap(), sources)
}

#[test]
fn five_named_channels_go_through_synthesis_relighting_and_a_file() {
    for basis in Basis::examples().into_iter().filter(|basis| material().takes(basis.channels())) {
        let field = random_field(basis, material(), Space::Linear, SIZE, 7);
        let (made, sources) = resynthesised(&field);
        assert_eq!(made.layout(), &material());

        let light = Direction::from_disk(0.4, -0.2);
        let (before, after) = (relight(&field, light), relight(&made, light));
        assert_eq!(after.planes.count(), 5);
        for channel in 0..5 {
            for (texel, &from) in sources.iter().enumerate() {
                assert_eq!(after.planes.plane(channel)[texel], before.planes.plane(channel)[from]);
            }
        }
        let truth = made.values(3, 5, light);
        (0..5).for_each(|c| assert!((after.planes.at(c, 3, 5) - truth[c]).abs() < 1e-5));

        let file = encode_field(&made, FieldFormat::Exr(ExrDepth::Float), None, &Job::default()).unwrap();
        assert!(decode_field(&file, &Job::default()).unwrap().field == made);
    }
}

#[test]
fn single_channels_are_textures_of_their_own() {
    let field = random_field(Basis::Ptm, material(), Space::Linear, SIZE, 2);
    let chosen = field.of_channels(&["height", "base"], &Job::default()).unwrap();
    assert_eq!(chosen.layout().channel_names(), ["height", "base"]);
    let light = Direction::from_disk(-0.3, 0.5);
    let [all, two] = [&field, &chosen].map(|field| relight(field, light).planes);
    assert_eq!((two.plane(0), two.plane(1)), (all.plane(3), all.plane(0)));
    let error = field.of_channels(&["opacity"], &Job::default()).unwrap_err().to_string();
    assert!(error.contains("no channel 'opacity'") && error.contains("590 nm"), "{error}");
    // For a product, the function of the channel is multiplied out.
    let product = random_field(Basis::HSH9, PlaneLayout::LRGB, Space::Srgb, SIZE, 2);
    let green = product.of_channels(&["G"], &Job::default()).unwrap();
    let difference = green.values(4, 9, light)[0] - product.value(4, 9, light)[1];
    assert!(difference.abs() < 1e-5, "{difference}");
}

#[test]
fn harmonics_and_learned_bases_are_synthesised_with_every_layout() {
    for basis in Basis::examples() {
        for layout in PlaneLayout::examples(&basis) {
            let field = random_field(basis.clone(), layout, Space::Linear, SIZE, 3);
            let (made, sources) = resynthesised(&field);
            for (plane, source) in made.coefficients().iter().zip(field.coefficients().iter()) {
                plane.iter().zip(&sources).for_each(|(value, &from)| assert_eq!(*value, source[from]));
            }
        }
    }
}

#[test]
fn fields_of_different_learned_bases_are_not_mixed() {
    let learned = random_field(Basis::examples().pop().unwrap(), PlaneLayout::RGB, Space::Linear, SIZE, 3);
    let harmonics = random_field(Basis::HSH9, PlaneLayout::RGB, Space::Linear, SIZE, 3);
    let index = learned.coefficients();
    let exemplars = [Exemplar { index, excluded: None }, Exemplar { index, excluded: None }];
    let options = BlockOptions { size: Size::new(16, 16), block: 8, overlap: 2, ..BlockOptions::default() };
    let map = synthesize(&exemplars, &options, &Job::default()).unwrap().map;
    let error = gather(&map, &[&learned, &harmonics], &Job::default()).unwrap_err().to_string();
    assert!(error.contains("hsh9") && error.contains("learned"), "{error}");
}

/// Photographs of a matt plane of three tones; nine harmonics represent its function except for the fold at
/// the horizon.
#[test]
fn a_fit_of_harmonics_relights_a_matt_surface() {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    let light = |i: usize| Direction::from_angles((1.0 - (i as f64 + 0.5) / 48.0).acos(), golden * i as f64);
    let lights: Vec<(String, Direction)> = (0..48).map(|i| (format!("p{i}"), light(i))).collect();
    let photograph = |i: usize| {
        let value = lights[i].1.z() as f32;
        Raster::new(Size::new(3, 1), 3, Samples::F32((1..=9).map(|t| 0.1 * t as f32 * value).collect()))
    };
    let options = FitOptions { basis: Basis::HSH9, space: Space::Linear, ..FitOptions::default() };
    let fitted = fit(&lights, &photograph, &options, &Job::default()).unwrap();
    assert_eq!((fitted.field.basis(), fitted.field.layout()), (&Basis::HSH9, &PlaneLayout::LRGB));
    assert!(fitted.report.error.psnr_db > 60.0, "{}", fitted.report.error.psnr_db);
}
