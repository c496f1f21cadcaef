//! The analysis of built-in materials, and of the same with planted faults.

use relume::analysis::{Analysis, Extents, Warning, analyze, draw};
use relume::numeric::periods::Pattern;
use relume::numeric::random::{Purpose, Stream};
use relume::procedural::{Material, MaterialOptions, Tiling};
use relume::{Job, Picture, Planes, Size, Space};

fn material(material: Material, size: usize, feature: f64) -> Planes {
    let size = Size::new(size, size);
    let options = MaterialOptions { size, feature, tiling: Tiling::Free, ..MaterialOptions::default() };
    material.make(&options, &Job::default()).unwrap().albedo
}

fn found(planes: &Planes) -> Analysis {
    analyze(planes, &Job::default()).unwrap()
}

/// Planes whose values are a function of plane, position and old value.
fn changed(planes: &Planes, value: impl Fn(usize, usize, f32) -> f32) -> Planes {
    let mut out = planes.clone();
    let width = planes.size().width;
    for plane in out.iter_mut() {
        plane.iter_mut().enumerate().for_each(|(i, v)| *v = value(i % width, i / width, *v));
    }
    out
}

/// The upper left quarter seen obliquely: one texel is `near` texels of the material at the bottom and 1 at
/// the top.
fn tilted(planes: &Planes, near: f64) -> Planes {
    let size = Size::new(planes.size().width / 2, planes.size().height / 2);
    let step = |y: usize| 1.0 + (near - 1.0) * y as f64 / size.height as f64;
    let rows: Vec<f64> =
        (0..size.height).scan(0.0, |at, y| Some(std::mem::replace(at, *at + step(y)))).collect();
    let mut out = Planes::zeros(size, planes.count());
    for (k, plane) in out.iter_mut().enumerate() {
        for (i, value) in plane.iter_mut().enumerate() {
            let (x, y) = (i % size.width, i / size.width);
            let across = planes.size().width as f64 / 2.0 + (x as f64 - size.width as f64 / 2.0) * step(y);
            *value = planes.at(k, across as usize, (rows[y] as usize).min(planes.size().height - 1));
        }
    }
    out
}

/// The built-in materials that are homogeneous and not stripes. Fire is inhomogeneous; wood is stripes.
const EVEN: [Material; 7] = [
    Material::Sponge,
    Material::Weave,
    Material::Pebbles,
    Material::Leather,
    Material::Bark,
    Material::Marble,
    Material::Clouds,
];

#[test]
fn fire_is_uneven_and_its_halves_differ() {
    let found = found(&material(Material::Fire, 256, 16.0));
    assert_eq!(found.warnings, [Warning::UnevenLight, Warning::Unrepresentative], "{found:?}");
}

#[test]
fn only_the_weave_repeats_and_none_is_faulty() {
    for kind in EVEN {
        let found = found(&material(kind, 256, 16.0));
        println!("{}: {found:?}", kind.name());
        assert_eq!(found.warnings, [], "{}: {found:?}", kind.name());
        match (kind, found.periods.pattern) {
            (Material::Weave, Pattern::Lattice(lattice)) => {
                // A plain weave repeats after one yarn to the side and one down.
                let pitch = 0.55 * 16.0;
                let truth = 2.0 * pitch * pitch;
                assert!((lattice.cell_area() / truth - 1.0).abs() < 0.03, "{lattice:?}");
            }
            (_, pattern) => {
                assert_eq!((kind == Material::Weave, pattern), (false, Pattern::None), "{}", kind.name())
            }
        }
    }
}

/// Was reported as a lattice: the rings of a plank are as far apart as the material specifies. Where few of
/// them fit, too little repeats.
#[test]
fn the_rings_of_wood_are_stripes_or_nothing() {
    let few = found(&material(Material::Wood, 256, 24.0));
    assert_eq!(few.periods.pattern, Pattern::None, "{few:?}");
    for feature in [12.0, 16.0] {
        let found = found(&material(Material::Wood, 256, feature));
        let Pattern::Stripes([x, y]) = found.periods.pattern else { panic!("{feature}: {found:?}") };
        assert!((x - feature / 4.0).abs() < 0.1 && y.abs() < 0.2, "{feature}: {found:?}");
    }
}

#[test]
fn features_grow_with_the_material() {
    for kind in [Material::Sponge, Material::Pebbles, Material::Leather] {
        let [small, large] = [12.0, 24.0].map(|size| found(&material(kind, 256, size)).feature.unwrap());
        assert!((large / small - 2.0).abs() < 0.5, "{}: {small} and {large}", kind.name());
    }
}

#[test]
fn bark_runs_upwards_and_pebbles_nowhere() {
    let bark = found(&material(Material::Bark, 256, 16.0)).orientation;
    assert!((bark.angle_deg - 90.0).abs() < 10.0 && bark.coherence > 0.2, "{bark:?}");
    let pebbles = found(&material(Material::Pebbles, 256, 16.0)).orientation;
    assert!(pebbles.coherence < 0.1, "{pebbles:?}");
    let size = Size::new(64, 48);
    let line = |i: usize| (0.5 * (i % 64) as f32 + 0.3 * (i / 64) as f32).sin();
    let lines =
        found(&Planes::from_vec(size, 1, (0..size.texels()).map(line).collect()).unwrap()).orientation;
    // The gradient is (0.5, 0.3) with y down: lines run along (0.3, 0.5) with y up.
    assert!((lines.angle_deg - 0.5f64.atan2(0.3).to_degrees()).abs() < 0.5, "{lines:?}");
    assert!(lines.coherence > 0.99, "{lines:?}");
}

#[test]
fn uneven_light_is_named_and_measured() {
    for kind in [Material::Pebbles, Material::Weave, Material::Bark] {
        let planes = material(kind, 256, 16.0);
        let lit = changed(&planes, |x, _, v| v * (0.4 + 1.2 * x as f32 / 256.0));
        let found = found(&lit);
        assert!(found.warnings.contains(&Warning::UnevenLight), "{}: {found:?}", kind.name());
    }
    // A plane alone is all trend; the remaining texture has no period.
    let slope = Planes::from_vec(Size::new(40, 30), 1, (0..1200).map(|i| (i % 40) as f32).collect()).unwrap();
    assert!((found(&slope).trend - 1.0).abs() < 1e-6);
}

#[test]
fn perspective_is_named_where_the_grain_is_resolved() {
    let mut named = Vec::new();
    for kind in EVEN {
        let found = found(&tilted(&material(kind, 512, 14.0), 1.7));
        println!("{} tilted: {:?}", kind.name(), found.scale);
        assert!(
            found.scale[0].factor.ln().abs() < 0.1,
            "{}: nothing changes from left to right",
            kind.name()
        );
        assert!(found.scale[1].factor < 0.95, "{}: features become smaller downwards", kind.name());
        if kind == Material::Weave {
            let factor = found.scale[1].factor;
            assert!((factor.ln() + 1.7f64.ln()).abs() < 0.06, "{factor} is not 1 / 1.7");
        }
        if found.warnings.contains(&Warning::Perspective) {
            named.push(kind);
        }
    }
    // Sponge stays just below the threshold, and pebbles have a grain of single texels, which does not shrink
    // with distance.
    let expected = EVEN.into_iter().filter(|kind| !matches!(kind, Material::Sponge | Material::Pebbles));
    assert_eq!(named, expected.collect::<Vec<_>>());
}

#[test]
fn a_half_that_is_another_texture_is_named() {
    for kind in [Material::Pebbles, Material::Leather] {
        let planes = material(kind, 256, 16.0);
        let mean = planes.as_slice().iter().sum::<f32>() / planes.as_slice().len() as f32;
        let half = changed(&planes, |_, y, v| if y < 128 { v } else { mean + 0.4 * (v - mean) });
        let found = found(&half);
        assert!(found.warnings.contains(&Warning::Unrepresentative), "{}: {found:?}", kind.name());
    }
}

/// Squares of random shades.
fn squares(side: usize) -> Planes {
    let size = Size::new(160, 160);
    let mut random = Stream::new(2, Purpose::Sample, [0]);
    let shades: Vec<f32> = (0..160 * 160).map(|_| random.unit() as f32).collect();
    let value = |i: usize| shades[i / 160 / side * 160 + i % 160 / side];
    Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap()
}

#[test]
fn features_have_the_size_that_their_correlation_says() {
    // For squares, (1 - |x| / s) (1 - |y| / s): on average over directions one half at 0.45 s.
    for side in [6, 9, 12] {
        let feature = found(&squares(side)).feature.unwrap();
        assert!((feature / (0.9 * side as f64) - 1.0).abs() < 0.1, "{side}: {feature}");
    }
    // For waves, cos(2 pi x / p), whose mean over directions is the Bessel function J0: one half at 0.242 p.
    let wave = |i: usize| (std::f32::consts::TAU * (i % 160) as f32 / 20.0).sin();
    let waves = Planes::from_vec(Size::new(160, 160), 1, (0..160 * 160).map(wave).collect()).unwrap();
    let feature = found(&waves).feature.unwrap();
    assert!((feature / (0.484 * 20.0) - 1.0).abs() < 0.05, "{feature}");
}

#[test]
fn few_features_are_too_small_a_sample() {
    assert!(found(&squares(32)).warnings.contains(&Warning::TooSmall));
    assert!(!found(&squares(8)).warnings.contains(&Warning::TooSmall));
}

#[test]
fn any_texture_is_analysed_or_refused() {
    let job = Job::default();
    for (width, height) in [(16, 16), (17, 40), (61, 16)] {
        let flat = Planes::zeros(Size::new(width, height), 2);
        assert_eq!(found(&flat).periods.pattern, Pattern::None);
    }
    assert!(analyze(&Planes::zeros(Size::new(15, 40), 1), &job).is_err());
    let broken = changed(
        &Planes::zeros(Size::new(20, 20), 1),
        |x, y, _| if (x, y) == (3, 4) { f32::NAN } else { 0.0 },
    );
    assert!(analyze(&broken, &job).unwrap_err().message().contains("(3, 4)"));
}

#[test]
fn the_picture_shows_texture_correlation_and_spectrum() {
    let planes = material(Material::Weave, 64, 16.0);
    let picture = Picture { planes: planes.clone(), space: Space::Linear };
    let drawn = draw(&picture, &planes, &found(&planes), &Job::default()).unwrap();
    assert_eq!((drawn.size(), drawn.planes.count()), (Size::new(192, 64), 3));
    // The centre of the correlation is white, and the panel of the texture shows lines of the lattice.
    assert_eq!(drawn.planes.at(0, 64 + 32, 32), 1.0);
    let encoded = picture.to_space(Space::Srgb).planes;
    let lines =
        (0..64 * 64).filter(|i| drawn.planes.at(2, i % 64, i / 64) != encoded.at(2, i % 64, i / 64)).count();
    assert!((64..2048).contains(&lines), "{lines} texels of lines");
}

#[test]
fn quick_lengths_are_those_of_the_whole_analysis_to_a_reduced_texel() {
    let job = Job::default();
    for (side, feature, texel) in [(256, 24.0, 2.0), (400, 40.0, 4.0)] {
        for kind in Material::ALL {
            let planes = material(kind, side, feature);
            let quick = Extents::measure(&planes, &job).unwrap();
            let whole = Extents::of(&found(&planes), planes.size());
            println!("{} {side}: {quick:?} {whole:?}", kind.name());
            // Fine grain on smooth shapes is averaged away: features may appear larger, never smaller.
            match (quick.feature, whole.feature) {
                (Some(quick), Some(whole)) => assert!(quick > whole - texel, "{}", kind.name()),
                (quick, whole) => assert!(quick.is_none() || whole.is_some(), "{}", kind.name()),
            }
            if let (Some(quick), Some(whole)) = (quick.period, whole.period) {
                assert!((quick - whole).abs() < texel, "{}: {quick} {whole}", kind.name());
            }
        }
    }
}
