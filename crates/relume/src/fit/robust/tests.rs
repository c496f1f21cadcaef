use super::super::accumulate::accumulate;
use super::*;
use crate::direction::Direction;
use crate::field::Basis;
use crate::raster::Samples;
use crate::size::Size;
use crate::space::Space;

/// Photographs of a function of `linear` shape, a fifth of them in shadow at each texel.
fn shadowed(lights: &[Direction], size: Size) -> (Vec<Raster>, Vec<f32>) {
    let truth = [0.5f32, 0.2, -0.15];
    let value = |light: &Direction| truth[0] + truth[1] * light.x() as f32 + truth[2] * light.y() as f32;
    let photograph = |(i, light): (usize, &Direction)| {
        let texel = |t: usize| if (i + 3 * t).is_multiple_of(5) { 0.0 } else { value(light) };
        Raster::new(size, 1, Samples::F32((0..size.texels()).map(texel).collect())).unwrap()
    };
    (lights.iter().enumerate().map(photograph).collect(), truth.to_vec())
}

#[test]
fn shadows_of_a_fifth_of_the_photographs_do_not_count() {
    let lights: Vec<Direction> = (0..40).map(Direction::fibonacci(40)).collect();
    let size = Size::new(7, 5);
    let (photographs, truth) = shadowed(&lights, size);
    let basis = Basis::from_name("linear").unwrap();
    let design = Design::new(&basis, &lights).unwrap();
    let levels = SampleLevels::new(Space::Linear);
    let worst = |rule: Robust| {
        let mut sums = Planes::zeros(size, 3);
        accumulate(&mut sums, &design, 0, &photographs[..16], &levels);
        accumulate(&mut sums, &design, 16, &photographs[16..32], &levels);
        accumulate(&mut sums, &design, 32, &photographs[32..], &levels);
        let rule = TexelRule { robust: rule, lamps: None, mask: None };
        refine(&mut sums, &photographs, rule, &design, &levels, &Job::default()).unwrap();
        let errors =
            (0..3).flat_map(|k| sums.plane(k).iter().map(|c| (c - truth[k]).abs()).collect::<Vec<_>>());
        errors.fold(0.0f32, f32::max)
    };
    let (plain, trimmed, reweighted) =
        (worst(Robust::None), worst(Robust::Trimmed), worst(Robust::Reweighted));
    assert!(plain > 0.08, "{plain}");
    assert!(trimmed < 1e-5, "{trimmed}");
    assert!(reweighted < 0.5 * plain, "{reweighted} and {plain}");
}

/// The darkest quarter of seven photographs is one, which leaves as many as there are functions; of six, one too many.
#[test]
fn texels_whose_photographs_do_not_suffice_keep_least_squares() {
    let lights: Vec<Direction> = (0..6).map(Direction::fibonacci(6)).collect();
    let photograph = |i: usize| {
        Raster::new(Size::new(2, 1), 1, Samples::F32(vec![0.1 * i as f32, 0.3 - 0.01 * i as f32])).unwrap()
    };
    let photographs: Vec<Raster> = (0..6).map(photograph).collect();
    let design = Design::new(&Basis::Ptm, &lights).unwrap();
    let levels = SampleLevels::new(Space::Linear);
    let mut sums = Planes::zeros(Size::new(2, 1), 6);
    accumulate(&mut sums, &design, 0, &photographs, &levels);
    let before = sums.clone();
    let rule = TexelRule { robust: Robust::Trimmed, lamps: None, mask: None };
    let report = refine(&mut sums, &photographs, rule, &design, &levels, &Job::default()).unwrap().unwrap();
    assert_eq!(sums, before);
    assert_eq!((report.refitted, report.kept, report.darkest_left_out), (0, 2, 1));
    assert!(report.warning(Robust::Trimmed).unwrap().contains("at 2 of 2 texels"));
    let text = check(Robust::Trimmed, &design).unwrap_err().to_string();
    assert!(text.contains("leaves 5 of 6 photographs") && text.contains("6 functions"), "{text}");
}
