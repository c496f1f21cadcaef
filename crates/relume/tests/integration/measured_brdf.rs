//! Measured reflectances, MERL, UTIA and RGL: files made from formulas by an independent writer give the formulas
//! back at the nodes of their tables, and within bounds between them.

use std::f64::consts::{FRAC_PI_2, PI};

use relume::brdf::{BrdfSamples, MeasuredBrdf};
use relume::direction::Directions;
use relume::format::{Content, decode_brdf, read};
use relume::numeric::random::{Purpose, Stream};
use relume::{ErrorKind, Job, Limits, Samples};

use crate::brdf_files::{
    Field, RglSetup, Vector, direction, lobe, merl, merl_middle, mirrored, small_rgl_files, tensor_file,
    unit, utia,
};
use crate::support::job;

fn decoded(bytes: &[u8]) -> MeasuredBrdf {
    decode_brdf(bytes, &Job::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn message(bytes: &[u8]) -> String {
    decode_brdf(bytes, &Job::default()).expect_err("a broken file").message().to_owned()
}

fn evaluate(brdf: &MeasuredBrdf, light: Vector, view: Vector) -> Vector {
    brdf.evaluate(Directions { light: direction(light), view: direction(view) })
}

fn turned([x, y, z]: Vector, angle: f64) -> Vector {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y, z]
}

/// The largest difference over channels.
fn difference(a: Vector, b: Vector) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f64::max)
}

/// Random directions with a polar angle of at most `most`.
fn random_pair(random: &mut Stream, most: f64) -> (Vector, Vector) {
    let mut one = || unit(most * random.unit(), 2.0 * PI * random.unit());
    (one(), one())
}

#[test]
fn merl_files_give_the_value_of_their_cell() {
    let reflectance = lobe([-0.6, -0.6, 0.7], 4);
    let file = merl(&reflectance);
    let listening = Job::default();
    let brdf = decode_brdf(&file, &listening).unwrap();
    assert!(listening.remarks()[0].contains("are negative"), "{:?}", listening.remarks());
    let mut random = Stream::new(1, Purpose::Sample, [0]);
    // At the middles of cells the formula itself, whichever way the pair is turned.
    let mut seen = 0;
    for _ in 0..2000 {
        let (light, view) = merl_middle([90, 90, 180].map(|cells| random.below(cells)));
        if light[2] > 0.0 && view[2] > 0.0 {
            let turn = 2.0 * PI * random.unit();
            let found = evaluate(&brdf, turned(light, turn), turned(view, turn));
            assert!(difference(found, reflectance(light, view)) < 1e-9, "{light:?} {view:?}");
            // The azimuth of the difference has the period pi: light and view may change places.
            assert!(difference(found, evaluate(&brdf, view, light)) < 1e-9);
            seen += 1;
        }
    }
    assert!(seen > 500, "{seen} middles lie above the surface");
    // Elsewhere within what the formula changes over half a cell: a degree of the half vector (the widest cells), half
    // a degree of both other angles, and a slope of at most 4 * 0.5 a radian.
    let most = 2.0 * (1.0f64 + 0.5 + 0.5).to_radians();
    for _ in 0..2000 {
        let (light, view) = random_pair(&mut random, 1.2);
        let apart = difference(evaluate(&brdf, light, view), reflectance(light, view));
        assert!(apart <= most, "{light:?} {view:?}: {apart} of {most}");
    }
    assert_eq!(evaluate(&brdf, [0.0, 0.6, -0.8], [0.0, 0.0, 1.0]), [0.0; 3]);
    assert_eq!(evaluate(&brdf, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]), [0.0; 3]);
}

#[test]
fn merl_files_that_are_cut_or_broken_are_refused() {
    let file = merl(&|_, _| [1.0 / PI; 3]);
    for length in [12, 20, file.len() / 2, file.len() - 1] {
        assert!(message(&file[..length]).contains("damaged or truncated"), "{length}");
    }
    assert!(message(&file[..11]).contains("not a measured BRDF"));
    let mut broken = file.clone();
    broken[12 + 8 * 77..][..8].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(message(&broken).contains("number 77 of the MERL BRDF is not finite"));
    let tight = Job::new(Limits { max_bytes: 1 << 20, ..Limits::default() });
    assert_eq!(decode_brdf(&file, &tight).unwrap_err().kind(), ErrorKind::Limit);
    let opened = read(&file[..], "white.binary", &Job::default()).unwrap();
    assert_eq!(opened.content(), Content::Brdf);
    assert_eq!(opened.into_brdf().unwrap().name(), "MERL");
}

#[test]
fn a_white_lambertian_surface_is_1_in_the_unit_of_textures() {
    let pairs: Vec<Directions> = (0..5)
        .map(|i| Directions {
            light: direction(unit(0.3 * f64::from(i), 1.0)),
            view: direction(unit(0.2 * f64::from(i), 4.0)),
        })
        .collect();
    let samples = BrdfSamples::new(decoded(&merl(&|_, _| [1.0 / PI; 3])), pairs);
    assert_eq!((samples.size().texels(), samples.has_cosine(), samples.pairs().len()), (1, false, 5));
    for i in [3, 0, 4] {
        let image = samples.image(i, &job()).unwrap();
        let Samples::F32(values) = image.samples() else { panic!("floats") };
        assert!(values.len() == 3 && values.iter().all(|v| (v - 1.0).abs() < 1e-6), "{values:?}");
    }
}

#[test]
fn utia_files_are_interpolated_in_all_four_angles() {
    let polar = |v: Vector| v[0].hypot(v[1]).atan2(v[2]);
    let azimuth = |v: Vector| v[1].atan2(v[0]);
    // Linear in both polar angles, which are so reproduced exactly, also beyond the last ring.
    let plain = |light: Vector, view: Vector| {
        let (l, v) = (polar(light), polar(view));
        [0.2 + 0.3 * l, 0.5 - 0.1 * v, 0.1 + 0.2 * l * v]
    };
    // Second derivatives by the azimuths of at most 0.5 and 2.
    let wavy = |light: Vector, view: Vector| {
        let value = 1.0 + 0.5 * azimuth(light).cos() * (2.0 * azimuth(view)).cos();
        [value, 0.5 * value, polar(light) * value]
    };
    let mut random = Stream::new(2, Purpose::Sample, [0]);
    let linear = decoded(&utia(&plain));
    for _ in 0..2000 {
        let (light, view) = random_pair(&mut random, 1.55);
        assert!(difference(evaluate(&linear, light, view), plain(light, view)) < 1e-9, "{light:?} {view:?}");
    }
    let brdf = decoded(&utia(&wavy));
    let node = |i: usize| unit((15.0 * (i / 48) as f64).to_radians(), (7.5 * (i % 48) as f64).to_radians());
    for _ in 0..2000 {
        let (light, view) = (node(48 + random.below(240)), node(48 + random.below(240)));
        assert!(difference(evaluate(&brdf, light, view), wavy(light, view)) < 1e-9, "{light:?} {view:?}");
    }
    // Linear interpolation errs by at most an eighth of the square of the step times the second derivative.
    let step = 7.5f64.to_radians();
    let most = step * step / 8.0 * (0.5 + 2.0) * FRAC_PI_2;
    for _ in 0..2000 {
        let (light, view) = random_pair(&mut random, 1.55);
        // Within the first ring azimuths have nodes at the zenith that the formula does not.
        if polar(light) > 0.27 && polar(view) > 0.27 {
            let apart = difference(evaluate(&brdf, light, view), wavy(light, view));
            assert!(apart <= most, "{light:?} {view:?}: {apart} of {most}");
        }
    }
}

#[test]
fn utia_files_are_recognised_by_their_length() {
    let mut file = utia(&|_, _| [0.25, 0.5, -0.75]);
    assert_eq!(file.len(), 1_990_656);
    let opened = read(&file[..], "a.bin", &Job::default()).unwrap();
    assert_eq!(opened.content(), Content::Brdf);
    let brdf = opened.into_brdf().unwrap();
    // Negative values are 0.
    assert!(difference(evaluate(&brdf, unit(0.4, 1.0), unit(0.9, 2.0)), [0.25, 0.5, 0.0]) < 1e-12);
    assert!(message(&file[1..]).contains("UTIA .bin of 1990656 bytes"));
    file[80..88].copy_from_slice(&f64::INFINITY.to_le_bytes());
    assert!(message(&file).contains("number 10 of the UTIA BRDF"));
}

/// Azimuths from `first` on over a part of the circle.
fn azimuths(first: f64, span: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| first + span * i as f64 / (count - 1) as f64).collect()
}

fn rgl(azimuths: Vec<f64>) -> RglSetup {
    let polars = (0..12).map(|i| 0.01 + 1.45 * f64::from(i) / 11.0).collect();
    RglSetup { azimuths, polars, nodes: 33, spectrum: Vec::new(), jacobian: true }
}

/// The formula at nodes of the tables, which are exact to the floats of the file. Left out: the first and the last row,
/// which are one azimuth with two coordinates, and the ends of a part of the circle, where the folding is free.
fn assert_nodes(setup: &RglSetup, brdf: &MeasuredBrdf, reflectance: &dyn Fn(Vector, Vector) -> Vector) {
    let mut random = Stream::new(4, Purpose::Sample, [setup.azimuths.len() as u64]);
    let mut seen = 0;
    for _ in 0..1500 {
        let inner = setup.azimuths.len().saturating_sub(2);
        let azimuth = if inner > 0 { 1 + random.below(inner) } else { 0 };
        let (x, y) = (random.below(33), 1 + random.below(31));
        let (view, light) = setup.directions(azimuth, random.below(setup.polars.len()), x, y);
        if light[2] > 0.05 {
            let (found, expected) = (evaluate(brdf, light, view), reflectance(light, view));
            assert!(difference(found, expected) < 1e-3, "{light:?} {view:?}: {found:?} for {expected:?}");
            seen += 1;
        }
    }
    assert!(seen > 500, "{seen}");
}

/// The largest difference from the formula between the nodes, for directions away from the horizon.
fn largest_difference(brdf: &MeasuredBrdf, reflectance: &dyn Fn(Vector, Vector) -> Vector) -> f64 {
    let mut random = Stream::new(5, Purpose::Sample, [0]);
    let apart = |_| {
        let (light, view) = random_pair(&mut random, 1.1);
        difference(evaluate(brdf, light, view), reflectance(light, view))
    };
    (0..3000).map(apart).fold(0.0, f64::max)
}

#[test]
fn isotropic_rgl_files_give_their_formula() {
    let reflectance = lobe([-0.6, -0.6, 0.7], 2);
    for jacobian in [true, false] {
        let setup = RglSetup { jacobian, ..rgl(vec![0.0]) };
        let brdf = decoded(&setup.file(&reflectance));
        assert_nodes(&setup, &brdf, &reflectance);
        let most = largest_difference(&brdf, &reflectance);
        assert!(
            most < 0.02,
            "{most} of reflectances of about {:?}",
            reflectance(unit(0.3, 0.0), unit(0.3, PI))
        );
        // Turning both directions changes nothing.
        let (light, view) = (unit(0.7, 0.4), unit(0.5, 2.9));
        let (a, b) = (evaluate(&brdf, light, view), evaluate(&brdf, turned(light, 1.7), turned(view, 1.7)));
        assert!(difference(a, b) < 1e-9);
        assert_eq!(evaluate(&brdf, mirrored(light, [1.0, 0.0, 0.0]), [0.0, 0.0, -1.0]), [0.0; 3]);
    }
}

#[test]
fn anisotropic_rgl_files_give_their_formula_for_every_symmetry() {
    // Unlike along x and y, alike under mirrors.
    let reflectance = lobe([-0.7, -0.3, 0.6], 2);
    for (span, count) in [(2.0 * PI, 33), (PI, 17), (FRAC_PI_2, 9)] {
        let setup = rgl(azimuths(-PI, span, count));
        let brdf = decoded(&setup.file(&reflectance));
        assert_nodes(&setup, &brdf, &reflectance);
        let most = largest_difference(&brdf, &reflectance);
        assert!(most < 0.02, "{span}: {most}");
    }
    let third = rgl(azimuths(-PI, 2.0 * PI / 3.0, 9));
    assert!(message(&third.file(&reflectance)).contains("span 120.0 degrees"));
}

#[test]
fn a_half_turn_is_the_symmetry_of_half_a_circle() {
    // Alike after half a turn about the normal, but not under mirrors.
    let reflectance = |light: Vector, view: Vector| {
        let skew = light[0] * view[1] + light[1] * view[0];
        [0.3 + 0.1 * skew, 0.3, 0.3 - 0.05 * skew]
    };
    let setup = rgl(azimuths(-PI, PI, 17));
    let brdf = decoded(&setup.file(&reflectance));
    assert_nodes(&setup, &brdf, &reflectance);
    let most = largest_difference(&brdf, &reflectance);
    assert!(most < 0.02, "{most}");
}

#[test]
fn spectra_become_linear_srgb() {
    let reflectance = lobe([-0.6, -0.6, 0.7], 2);
    let grey: Vec<(f64, f64)> = (0..20).map(|i| (380.0 + 20.0 * f64::from(i), 1.0)).collect();
    let setup = RglSetup { spectrum: grey, ..rgl(vec![0.0]) };
    let listening = Job::default();
    let brdf = decode_brdf(&setup.file(&reflectance), &listening).unwrap();
    assert!(listening.remarks().is_empty());
    assert_nodes(&setup, &brdf, &|light, view| [reflectance(light, view)[1]; 3]);
    // A reflectance of long waves only is red.
    let red: Vec<(f64, f64)> = grey_steps().map(|nm| (nm, f64::from(u8::from(nm > 590.0)))).collect();
    let brdf = decoded(&RglSetup { spectrum: red, ..rgl(vec![0.0]) }.file(&reflectance));
    let [r, g, b] = evaluate(&brdf, unit(0.3, 0.0), unit(0.3, PI));
    assert!(r > 3.0 * g.abs() && r > 3.0 * b.abs(), "{r} {g} {b}");
    let narrow = RglSetup { spectrum: vec![(450.0, 1.0), (600.0, 1.0)], ..rgl(vec![0.0]) };
    let listening = Job::default();
    decode_brdf(&narrow.file(&reflectance), &listening).unwrap();
    assert!(listening.remarks()[0].contains("from 450 to 600 nm"), "{:?}", listening.remarks());
}

fn grey_steps() -> impl Iterator<Item = f64> {
    (0..35).map(|i| 380.0 + 10.0 * f64::from(i))
}

/// The fields of a small file, changed.
fn with(change: impl Fn(&mut Vec<Field>)) -> Vec<u8> {
    let setup = RglSetup {
        azimuths: vec![0.0],
        polars: vec![0.1, 1.2],
        nodes: 3,
        spectrum: vec![(400.0, 1.0), (700.0, 0.5)],
        jacobian: true,
    };
    let mut fields = setup.fields(&lobe([-0.5, -0.5, 0.8], 1));
    change(&mut fields);
    tensor_file(&fields)
}

fn find<'a>(fields: &'a mut [Field], name: &str) -> &'a mut Field {
    fields.iter_mut().find(|field| field.name == name).expect("the field is there")
}

#[test]
fn broken_tensor_files_say_what_and_where() {
    assert!(decode_brdf(&with(|_| ()), &Job::default()).is_ok());
    let float = |value: f32| value.to_le_bytes();
    type Change = Box<dyn Fn(&mut Vec<Field>)>;
    let cases: Vec<(Change, &str)> = vec![
        (Box::new(|f| f.retain(|field| field.name != "sigma")), "no array 'sigma'"),
        (Box::new(|f| find(f, "ndf").shape = vec![49]), "expected 2 dimensions"),
        (Box::new(|f| find(f, "ndf").shape = vec![1 << 40, 1 << 40]), "does not lie inside"),
        (Box::new(|f| find(f, "ndf").kind = 12), "type 12"),
        (Box::new(|f| find(f, "ndf").kind = 5), "expected floats"),
        (
            Box::new(move |f| find(f, "ndf").data[8..12].copy_from_slice(&float(f32::NAN))),
            "number 2 of the table 'ndf'",
        ),
        (Box::new(move |f| find(f, "vndf").data[..4].copy_from_slice(&float(-1.0))), "is negative"),
        (Box::new(|f| find(f, "vndf").data.fill(0)), "no number above 0"),
        (Box::new(|f| find(f, "vndf").shape[..2].reverse()), "1 azimuths and 2 polar angles"),
        (Box::new(|f| find(f, "spectra").shape[2] = 1), "1 channels: expected 2"),
        (
            Box::new(move |f| find(f, "theta_i").data[..4].copy_from_slice(&float(1.3))),
            "'theta_i' of the BRDF do not",
        ),
        (Box::new(move |f| find(f, "wavelengths").data[..4].copy_from_slice(&float(900.0))), "do not ascend"),
        (Box::new(|f| find(f, "sigma").shape = vec![1, 36]), "at least 2 x 2"),
    ];
    for (change, expected) in cases {
        let found = message(&with(change));
        assert!(found.contains(expected), "{expected}: {found}");
    }
    let mut file = with(|_| ());
    file[12] = 2;
    assert!(message(&file).contains("version 2.0"));
    file[12] = 1;
    file[14..18].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(message(&file).contains("truncated"));
    for (name, file) in small_rgl_files() {
        let opened = read(&file[..], "a.bsdf", &job()).unwrap();
        assert_eq!(opened.content(), Content::Brdf, "{name}");
        assert!(opened.into_field().unwrap_err().message().contains("a measured reflectance (BRDF)"));
    }
}
