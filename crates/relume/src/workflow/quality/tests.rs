use super::*;
use crate::direction::Directions;
use crate::field::{Basis, Interpolated, Interpolation, PlaneLayout};
use crate::numeric::random::{Purpose, Stream};
use crate::planes::Planes;
use crate::raster::{Raster, Samples};
use crate::render::relight_srgb8;
use crate::size::Size;
use crate::space::Space;

const SIZE: Size = Size { width: 40, height: 30 };

/// A rough grey texture of first degree, and its pictures under lights.
fn scene(count: usize) -> (ReflectanceField, Vec<(String, Directions)>, Vec<Vec<u8>>) {
    let mut stream = Stream::new(1, Purpose::Sample, [0]);
    let mut plane = |low: f64, high: f64| -> Vec<f32> {
        (0..SIZE.texels()).map(|_| (low + (high - low) * stream.unit()) as f32).collect()
    };
    let data = [plane(0.3, 0.6), plane(-0.2, 0.2), plane(-0.2, 0.2)].concat();
    let planes = Planes::from_vec(SIZE, 3, data).unwrap();
    let basis = Basis::from_name("linear").unwrap();
    let field = ReflectanceField::new(basis, PlaneLayout::LUMINANCE, Space::Srgb, planes).unwrap();
    let lights: Vec<(String, Directions)> =
        (0..count).map(|i| (format!("p{i}.png"), Direction::fibonacci(count)(i).into())).collect();
    let pictures = lights.iter().map(|(_, pair)| {
        let mut codes = vec![0; 3 * SIZE.texels()];
        relight_srgb8(&field, *pair, &mut codes);
        codes.iter().enumerate().map(|(i, code)| code.saturating_add((i % 5) as u8)).collect()
    });
    let pictures = pictures.collect();
    (field, lights, pictures)
}

fn report(pictures: &[Vec<u8>], field: &ReflectanceField, lights: &[(String, Directions)]) -> QualityReport {
    let load = |i: usize| Raster::new(SIZE, 3, Samples::U8(pictures[i].clone()));
    let photographs = ComparedPhotographs {
        pairs: lights,
        load: &load,
        lamps: None,
        mask: None,
        are_fitted: true,
        set_aside: Vec::new(),
    };
    quality(field, &photographs, 16, &Job::default()).unwrap()
}

#[test]
fn sound_photographs_are_not_doubted() {
    let (field, lights, pictures) = scene(20);
    let found = report(&pictures, &field, &lights);
    assert_eq!(found.warnings, Vec::<String>::new());
    assert_eq!((found.map_size, found.error_map.len()), ([14, 10], 140));
    // Codes are off by 0 to 4, two in the mean: the root of 6.
    assert!(found.error_map.iter().all(|rms| (rms - 6f32.sqrt()).abs() < 0.8), "{:?}", found.error_map);
    assert!(found.coverage.widest_gap_deg < 30.0, "{:?}", found.coverage);
}

#[test]
fn photographs_moved_turned_or_of_another_exposure_are_named() {
    let (field, lights, mut pictures) = scene(20);
    let texel = |codes: &[u8], x: usize, y: usize| -> [u8; 3] {
        codes[3 * SIZE.index(x, y)..][..3].try_into().unwrap()
    };
    let rearranged = |codes: &[u8], place: &dyn Fn(usize, usize) -> (usize, usize)| -> Vec<u8> {
        let texels = (0..SIZE.texels()).map(|t| place(t % SIZE.width, t / SIZE.width));
        texels.flat_map(|(x, y)| texel(codes, x, y)).collect()
    };
    pictures[3] = rearranged(&pictures[3], &|x, y| ((x + 38) % SIZE.width, (y + 29) % SIZE.height));
    pictures[7] = rearranged(&pictures[7], &|x, y| (SIZE.width - 1 - x, SIZE.height - 1 - y));
    pictures[11] = pictures[11].iter().map(|code| code / 2).collect();
    let found = report(&pictures, &field, &lights);
    assert_eq!(found.lights[3].shift, [2, 1]);
    assert!(found.lights[3].doubts[0].contains("2 to the right and 1 down"));
    assert!(found.lights[7].doubts[0].contains("upside down"), "{:?}", found.lights[7].doubts);
    assert!(found.lights[11].doubts[0].contains("another exposure"), "{:?}", found.lights[11].doubts);
    let doubted: Vec<usize> = (0..20).filter(|i| !found.lights[*i].doubts.is_empty()).collect();
    assert_eq!(doubted, [3, 7, 11]);
}

#[test]
fn lights_on_one_side_leave_a_gap_that_is_said() {
    let (field, lights, pictures) = scene(20);
    let right: Vec<usize> = (0..20).filter(|i| lights[*i].1.light.x() > 0.1).collect();
    let lights: Vec<_> = right.iter().map(|i| lights[*i].clone()).collect();
    let pictures: Vec<_> = right.iter().map(|i| pictures[*i].clone()).collect();
    let found = report(&pictures, &field, &lights);
    assert!(found.coverage.gap[0] < 0.0 && found.coverage.widest_gap_deg > 60.0, "{:?}", found.coverage);
    assert!(found.warnings[0].contains("is a guess"), "{:?}", found.warnings);
}

/// A fault: a robust fit leaves shadows out, and photographs a third in shadow passed for others of another exposure.
#[test]
fn shadows_that_a_fit_leaves_out_are_no_exposures() {
    let (field, lights, mut pictures) = scene(20);
    for codes in &mut pictures[4..7] {
        codes
            .as_chunks_mut::<3>()
            .0
            .iter_mut()
            .step_by(3)
            .for_each(|texel| *texel = texel.map(|code| code / 3));
    }
    let found = report(&pictures, &field, &lights);
    let exposures: Vec<&String> = found.warnings.iter().filter(|w| w.contains("exposure")).collect();
    assert!(exposures.is_empty(), "{exposures:?}");
    pictures[9] = pictures[9].iter().map(|code| (u32::from(*code) * 3 / 5) as u8).collect();
    pictures[12].fill(1);
    let found = report(&pictures, &field, &lights);
    let doubted: Vec<usize> =
        (0..20).filter(|i| found.lights[*i].doubts.iter().any(|d| d.contains("exposure"))).collect();
    assert_eq!(doubted, [9, 12]);
}

/// Where brightness changes slowly, the error falls with every step, and there is no shift.
#[test]
fn flat_pictures_are_not_moved() {
    let size = Size::new(200, 60);
    let planes =
        Planes::from_vec(size, 1, (0..size.texels()).map(|i| 0.3 + 0.001 * (i % 200) as f32).collect());
    let field = ReflectanceField::from_picture(crate::picture::Picture {
        planes: planes.unwrap(),
        space: Space::Srgb,
    });
    let lights: Vec<(String, Directions)> =
        (0..9).map(|i| (i.to_string(), Direction::fibonacci(9)(i).into())).collect();
    let mut codes = vec![0; 3 * size.texels()];
    relight_srgb8(&field, lights[0].1, &mut codes);
    let brighter: Vec<u8> = codes.iter().map(|code| code + 8).collect();
    let load =
        |i: usize| Raster::new(size, 3, Samples::U8(if i == 3 { brighter.clone() } else { codes.clone() }));
    let photographs = ComparedPhotographs {
        pairs: &lights,
        load: &load,
        lamps: None,
        mask: None,
        are_fitted: true,
        set_aside: Vec::new(),
    };
    let found = quality(&field, &photographs, 16, &Job::default()).unwrap();
    assert_eq!(found.lights[3].shift, [0, 0]);
    assert!(found.lights[3].doubts.iter().all(|doubt| !doubt.contains("moved")));
}

/// The report on a texture that interpolates between pictures by radial basis functions.
fn interpolated(lights: &[(String, Directions)], pictures: &[Vec<u8>]) -> QualityReport {
    let directions: Vec<Direction> = lights.iter().map(|(_, pair)| pair.light).collect();
    let table = Interpolated::new(&directions, Interpolation::RadialBasis).unwrap();
    let data =
        pictures.iter().flat_map(|codes| codes.as_chunks::<3>().0.iter().map(|c| f32::from(c[1]) / 255.0));
    let planes = Planes::from_vec(SIZE, lights.len(), data.collect()).unwrap();
    let basis = Basis::Interpolated(table);
    let field = ReflectanceField::new(basis, PlaneLayout::LUMINANCE, Space::Srgb, planes).unwrap();
    report(pictures, &field, lights)
}

/// A fault: a texture that interpolates between its photographs shows each as it is, so none was ever doubted.
#[test]
fn photographs_that_are_interpolated_are_compared_with_the_others() {
    let (_, lights, mut pictures) = scene(20);
    pictures[11] = pictures[11].iter().map(|code| code / 2).collect();
    let found = interpolated(&lights, &pictures);
    assert_eq!(found.compared, ComparedWith::Others);
    assert!(found.lights[11].doubts.iter().any(|doubt| doubt.contains("exposure")), "{:?}", found.lights[11]);
    assert!(found.lights.iter().all(|light| light.psnr_db.is_finite()));
}

/// A fault: a black photograph, and one that was mirrored, brought those of the lights around them into doubt.
#[test]
fn a_wrong_photograph_does_not_bring_its_neighbours_into_doubt() {
    let (_, lights, mut pictures) = scene(30);
    pictures[11].fill(0);
    let mirrored = |t: usize| SIZE.index(SIZE.width - 1 - t % SIZE.width, t / SIZE.width);
    pictures[24] = (0..SIZE.texels()).flat_map(|t| pictures[24][3 * mirrored(t)..][..3].to_vec()).collect();
    let found = interpolated(&lights, &pictures);
    let doubted: Vec<usize> = (0..30).filter(|i| !found.lights[*i].doubts.is_empty()).collect();
    assert_eq!((doubted.as_slice(), found.set_aside.len()), (&[11, 24][..], 2));
}
