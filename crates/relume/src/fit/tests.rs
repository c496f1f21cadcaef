//! The fast fit against the slow one, and its report against refitting.

use proptest::prelude::*;

use super::*;
use crate::limits::Limits;
use crate::numeric::random::{Purpose, Stream as Random};
use crate::raster::Samples;
use crate::size::Size;

/// Lights all over the hemisphere.
fn lights(count: usize, random: &mut Random) -> Vec<(String, Direction)> {
    let light = |i: usize| {
        let polar = (0.1 + 0.9 * random.unit()).acos();
        (format!("p{i}.png"), Direction::from_angles(polar, std::f64::consts::TAU * random.unit()))
    };
    (0..count).map(light).collect()
}

/// Photographs of shaded coloured bumps with white gloss of random strength, so that no colour model fits
/// exactly.
fn photographs(
    size: Size,
    channels: usize,
    lights: &[(String, Direction)],
    random: &mut Random,
) -> Vec<Raster> {
    let texels: Vec<(Direction, [f64; 3])> = (0..size.texels())
        .map(|_| {
            let normal = Direction::from_disk(0.8 * random.unit() - 0.4, 0.8 * random.unit() - 0.4);
            (normal, std::array::from_fn(|_| 0.1 + 0.8 * random.unit()))
        })
        .collect();
    let mut shade = |light: Direction| -> Vec<f64> {
        let texel = |(normal, color): &(Direction, [f64; 3])| {
            let cosine = normal.dot(light).max(0.0);
            let gloss = 0.3 * random.unit();
            color.iter().take(channels).map(|c| 0.8 * c * cosine + gloss * cosine.powi(8)).collect::<Vec<_>>()
        };
        texels.iter().flat_map(texel).collect()
    };
    let raster = |values: Vec<f64>| {
        let codes = values.into_iter().map(|v| (255.0 * v).round().clamp(0.0, 255.0) as u8).collect();
        Raster::new(size, channels, Samples::U8(codes)).unwrap()
    };
    lights.iter().map(|(_, light)| raster(shade(*light))).collect()
}

fn run(lights: &[(String, Direction)], photographs: &[Raster], options: &FitOptions) -> Fit {
    fit(lights, &|i| Ok(photographs[i].clone()), options, &Job::default()).unwrap()
}

fn slow(lights: &[(String, Direction)], photographs: &[Raster], options: &FitOptions) -> ReflectanceField {
    let directions: Vec<_> = lights.iter().map(|l| l.1).collect();
    let pictures: Vec<_> = photographs.iter().map(|p| p.to_picture(options.space)).collect();
    let color = if photographs[0].channels() == 1 { PlaneLayout::LUMINANCE } else { options.layout.clone() };
    reference::fit(&options.basis, &color, &directions, &pictures).unwrap()
}

fn largest_difference(a: &ReflectanceField, b: &ReflectanceField) -> f32 {
    assert_eq!((a.layout(), a.space(), a.size(), a.lights()), (b.layout(), b.space(), b.size(), b.lights()));
    let pairs = a.coefficients().as_slice().iter().zip(b.coefficients().as_slice());
    pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

fn all_options() -> impl Strategy<Value = FitOptions> {
    let bases = prop::sample::select(Basis::NAMED.to_vec());
    let colors = prop::sample::select(vec![PlaneLayout::RGB, PlaneLayout::LRGB]);
    let spaces = prop::sample::select(vec![Space::Srgb, Space::Linear]);
    (bases, colors, spaces).prop_map(|(basis, color, space)| FitOptions {
        basis,
        layout: color,
        space,
        ..FitOptions::default()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn the_fast_fit_equals_the_slow_one(
        options in all_options(),
        width in 1usize..70,
        height in 1usize..20,
        spare in 6usize..34,
        grey in any::<bool>(),
        seed in any::<u64>(),
    ) {
        let mut random = Random::new(seed, Purpose::Sample, [0]);
        // Functions of much detail need more lights to be well determined.
        let functions = options.basis.len();
        let lights = lights(2 * functions + spare, &mut random);
        let channels = if grey { 1 } else { 3 };
        // The slow fit takes long with many functions.
        let most = if functions > 10 { 4 } else { 70 };
        let size = Size::new(width.min(most), height.min(most));
        let photographs = photographs(size, channels, &lights, &mut random);
        let fitted = run(&lights, &photographs, &options);
        let slow = slow(&lights, &photographs, &options);
        let difference = largest_difference(&fitted.field, &slow);
        let largest = slow.coefficients().as_slice().iter().fold(1.0f32, |most, c| most.max(c.abs()));
        prop_assert!(difference < 5e-4 * largest, "{options:?}: {difference}");
    }
}

/// A capture of odd size that spans several bands and fills its last vector only partly.
fn capture(channels: usize, count: usize) -> (Vec<(String, Direction)>, Vec<Raster>) {
    let mut random = Random::new(5, Purpose::Sample, [channels as u64]);
    let lights = lights(count, &mut random);
    let photographs = photographs(Size::new(67, 49), channels, &lights, &mut random);
    (lights, photographs)
}

#[test]
fn several_bands_and_batches_equal_the_slow_fit() {
    for (channels, color) in [(1, PlaneLayout::LRGB), (3, PlaneLayout::RGB), (3, PlaneLayout::LRGB)] {
        let (lights, photographs) = capture(channels, 37);
        let options = FitOptions { layout: color.clone(), ..FitOptions::default() };
        let fitted = run(&lights, &photographs, &options);
        let difference = largest_difference(&fitted.field, &slow(&lights, &photographs, &options));
        assert!(difference < 1e-4, "{channels} {color:?}: {difference}");
    }
}

#[test]
fn every_depth_is_fitted_alike() {
    let (lights, photographs) = capture(3, 20);
    let deeper = |p: &Raster| {
        let Samples::U8(codes) = p.samples() else { panic!("8 bits") };
        let sixteen = Samples::U16(codes.iter().map(|&c| u16::from(c) * 257).collect());
        let linear = p.to_picture(Space::Linear);
        let float = (0..3 * p.size().texels()).map(|i| linear.planes.plane(i % 3)[i / 3]).collect();
        [sixteen, Samples::F32(float)].map(|s| Raster::new(p.size(), 3, s).unwrap())
    };
    for space in [Space::Srgb, Space::Linear] {
        let options = FitOptions { space, ..FitOptions::default() };
        let expected = run(&lights, &photographs, &options);
        for depth in 0..2 {
            let deep: Vec<_> = photographs.iter().map(|p| deeper(p)[depth].clone()).collect();
            let fitted = run(&lights, &deep, &options);
            assert!(largest_difference(&fitted.field, &expected.field) < 1e-5);
        }
    }
}

#[test]
fn the_result_is_the_same_at_any_number_of_threads() {
    let (lights, photographs) = capture(3, 40);
    let options = FitOptions { leave_one_out: true, report_texels: 500, ..FitOptions::default() };
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&lights, &photographs, &options))
    };
    let (one, five) = (with(1), with(5));
    assert_eq!(one.field, five.field);
    assert_eq!(one.report, five.report);
}

/// The root mean square error of a photograph, by the slow relighting of the field itself.
fn slow_rmse(field: &ReflectanceField, light: Direction, photograph: &Raster) -> f64 {
    let truth = photograph.to_picture(field.space()).planes;
    let mut sum = 0.0;
    for (c, plane) in truth.iter().enumerate() {
        for (texel, value) in plane.iter().enumerate() {
            let (x, y) = (texel % truth.size().width, texel / truth.size().width);
            let relit = field.value(x, y, light)[c].clamp(0.0, 1.0);
            sum += f64::from(relit - value).powi(2);
        }
    }
    (sum / truth.as_slice().len() as f64).sqrt()
}

#[test]
fn reported_errors_are_those_of_relighting() {
    for (channels, color) in [(1, PlaneLayout::LRGB), (3, PlaneLayout::RGB), (3, PlaneLayout::LRGB)] {
        let (lights, photographs) = capture(channels, 20);
        let Fit { field, report } =
            run(&lights, &photographs, &FitOptions { layout: color.clone(), ..FitOptions::default() });
        assert_eq!((report.texels, report.texels_measured), (67 * 49, 67 * 49));
        let mut worst = 0;
        for (i, light) in report.lights.iter().enumerate() {
            let rmse = slow_rmse(&field, lights[i].1, &photographs[i]);
            assert!((light.error.rmse - rmse).abs() < 1e-6);
            assert!((light.error.psnr_db + 20.0 * rmse.log10()).abs() < 1e-3);
            assert_eq!((&light.name, light.direction), (&lights[i].0, lights[i].1.to_array()));
            worst = if rmse > report.lights[worst].error.rmse { i } else { worst };
        }
        assert_eq!(report.worst, worst);
        let mean = report.lights.iter().map(|l| l.error.rmse.powi(2)).sum::<f64>() / 20.0;
        assert!((report.error.rmse - mean.sqrt()).abs() < 1e-12);
        assert!(report.leave_one_out.is_none() && report.warnings.is_empty(), "{:?}", report.warnings);
    }
}

#[test]
fn leave_one_out_is_refitting_without_the_light() {
    for (channels, color) in [(1, PlaneLayout::LRGB), (3, PlaneLayout::RGB), (3, PlaneLayout::LRGB)] {
        let (lights, photographs) = capture(channels, 14);
        let options = FitOptions { layout: color.clone(), leave_one_out: true, ..FitOptions::default() };
        let report = run(&lights, &photographs, &options).report;
        for i in 0..lights.len() {
            let (mut other_lights, mut others) = (lights.clone(), photographs.clone());
            other_lights.remove(i);
            others.remove(i);
            let without = run(&other_lights, &others, &options).field;
            let rmse = slow_rmse(&without, lights[i].1, &photographs[i]);
            let found = report.lights[i].leave_one_out.unwrap().rmse;
            assert!((found - rmse).abs() < 1e-5, "{color:?} {i}: {found} vs {rmse}");
            assert!(found > report.lights[i].error.rmse);
        }
    }
}

#[test]
fn a_light_that_the_others_need_has_no_leave_one_out_error() {
    let ring = |i: usize| Direction::from_angles(0.8, f64::from(i as u32));
    let mut lights: Vec<_> = (0..9).map(|i| (format!("{i}"), ring(i))).collect();
    lights.push(("top".into(), Direction::ZENITH));
    let photographs = photographs(Size::new(5, 5), 1, &lights, &mut Random::new(1, Purpose::Sample, [1]));
    let options = FitOptions { leave_one_out: true, ..FitOptions::default() };
    let report = run(&lights, &photographs, &options).report;
    assert!(report.lights[9].leave_one_out.is_none() && report.lights[9].leverage > 0.999);
    assert!(report.lights[..9].iter().all(|l| l.leave_one_out.is_some()));
}

#[test]
fn the_colour_is_better_than_the_mean_colour() {
    let (lights, photographs) = capture(3, 30);
    let Fit { field, report } = run(&lights, &photographs, &FitOptions::default());
    let rgb = run(&lights, &photographs, &FitOptions { layout: PlaneLayout::RGB, ..FitOptions::default() });
    let naive = with_mean_colors(&field, &photographs, &lights);
    let squares = |field: &ReflectanceField| -> f64 {
        lights.iter().zip(&photographs).map(|(l, p)| slow_rmse(field, l.1, p).powi(2)).sum::<f64>()
    };
    let (best, least, plain) = (squares(&field), squares(&rgb.field), squares(&naive));
    assert!(least < best && best - least < 0.9 * (plain - least), "{least} (rgb) < {best} < {plain} (mean)");
    assert!(report.error.psnr_db > 20.0);
}

/// The naive colour: the mean of each texel over the photographs, with the luminance fitted to the mean of
/// the channels divided by the mean of the colour.
fn with_mean_colors(
    like: &ReflectanceField,
    photographs: &[Raster],
    lights: &[(String, Direction)],
) -> ReflectanceField {
    let pictures: Vec<_> = photographs.iter().map(|p| p.to_picture(Space::Srgb)).collect();
    let size = like.size();
    let mut mean = Planes::zeros(size, 3);
    for picture in &pictures {
        mean.as_mut_slice().iter_mut().zip(picture.planes.as_slice()).for_each(|(m, v)| *m += v);
    }
    let grey: Vec<_> = pictures
        .iter()
        .map(|picture| {
            let mut planes = Planes::zeros(size, 1);
            for t in 0..size.texels() {
                let sum = |p: &Planes| (0..3).map(|c| p.plane(c)[t]).sum::<f32>();
                planes.as_mut_slice()[t] = sum(&picture.planes) / sum(&mean).max(1e-6);
            }
            crate::picture::Picture { planes, space: Space::Srgb }
        })
        .collect();
    let directions: Vec<_> = lights.iter().map(|l| l.1).collect();
    let luminance = reference::fit(&Basis::Ptm, &PlaneLayout::LUMINANCE, &directions, &grey).unwrap();
    let data = [luminance.coefficients().as_slice(), mean.as_slice()].concat();
    like.with_coefficients(Planes::from_vec(size, 9, data).unwrap()).unwrap()
}

#[test]
fn grids_too_large_to_keep_are_read_again() {
    let mut random = Random::new(9, Purpose::Sample, [9]);
    let lights = lights(9, &mut random);
    let size = Size::new(331, 211);
    assert!(size.texels() > sample::KEPT_TEXELS);
    let photographs = photographs(size, 1, &lights, &mut random);
    let reads = std::sync::atomic::AtomicUsize::new(0);
    let load = |i: usize| {
        reads.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        Ok(photographs[i].clone())
    };
    let options = FitOptions { report_texels: usize::MAX, ..FitOptions::default() };
    let Fit { field, report } = fit(&lights, &load, &options, &Job::default()).unwrap();
    assert_eq!((reads.into_inner(), report.texels_measured), (18, size.texels()));
    let rmse = slow_rmse(&field, lights[4].1, &photographs[4]);
    assert!((report.lights[4].error.rmse - rmse).abs() < 1e-6);
    let sampled = run(&lights, &photographs, &FitOptions::default()).report;
    assert!(sampled.texels_measured <= sample::KEPT_TEXELS);
    assert!((sampled.error.psnr_db - report.error.psnr_db).abs() < 0.2);
}

fn failure(lights: &[(String, Direction)], photographs: &[Raster], options: &FitOptions) -> String {
    let load = |i: usize| Ok(photographs[i].clone());
    fit(lights, &load, options, &Job::default()).unwrap_err().to_string()
}

#[test]
fn photographs_that_differ_are_named() {
    let (lights, mut photographs) = capture(3, 30);
    let size = Size::new(3, 2);
    photographs[20] = Raster::new(size, 3, Samples::U8(vec![0; 18])).unwrap();
    let text = failure(&lights, &photographs, &FitOptions::default());
    assert!(text.contains("p20.png is 3 x 2") && text.contains("p0.png is 67 x 49"), "{text}");
    photographs[20] = Raster::new(Size::new(67, 49), 1, Samples::U8(vec![0; 67 * 49])).unwrap();
    let text = failure(&lights, &photographs, &FitOptions::default());
    assert!(text.contains("p20.png is grey and p0.png is in colour"), "{text}");
}

#[test]
fn black_photographs_are_named_and_refused_where_all_are() {
    let (lights, mut photographs) = capture(1, 12);
    let black = Raster::new(photographs[0].size(), 1, Samples::U8(vec![0; photographs[0].size().texels()]));
    photographs = photographs.iter().map(|_| black.clone().unwrap()).collect();
    let text = failure(&lights, &photographs, &FitOptions::default());
    assert!(text.contains("all 12 photographs are black"), "{text}");
    let (_, lit) = capture(1, 12);
    photographs[..11].clone_from_slice(&lit[..11]);
    let warnings = run(&lights, &photographs, &FitOptions::default()).report.warnings;
    assert!(warnings.iter().any(|w| w.contains("1 of 12") && w.contains("p11.png")), "{warnings:?}");
}

#[test]
fn samples_that_are_no_numbers_are_named() {
    let (lights, photographs) = capture(1, 20);
    for (place, value) in [(7, f32::NAN), (0, f32::INFINITY), (19, -1e30)] {
        let mut broken = photographs.clone();
        let mut samples = vec![0.5; 67 * 49];
        samples[2 * 67 + 3] = value;
        broken[place] = Raster::new(Size::new(67, 49), 1, Samples::F32(samples)).unwrap();
        let text = failure(&lights, &broken, &FitOptions::default());
        assert!(text.contains(&format!("p{place}.png")) && text.contains("texel (3, 2)"), "{text}");
    }
}

#[test]
fn what_cannot_be_fitted_is_refused_before_reading() {
    let (lights, photographs) = capture(3, 20);
    let load = |_: usize| -> Result<Raster> { panic!("no photograph may be read") };
    let try_fit = |lights: &[(String, Direction)], options: &FitOptions| {
        fit(lights, &load, options, &Job::default()).unwrap_err().to_string()
    };
    assert!(try_fit(&lights[..5], &FitOptions::default()).contains("found 5"));
    assert!(try_fit(&[], &FitOptions::default()).contains("found 0"));
    let none = FitOptions { report_texels: 0, ..FitOptions::default() };
    assert!(try_fit(&lights, &none).contains("at least 1 texel"));
    let grey = FitOptions { layout: PlaneLayout::LUMINANCE, ..FitOptions::default() };
    assert!(failure(&lights, &photographs, &grey).contains("coloured"));
    let small = Job::new(Limits { max_bytes: 200_000, ..Limits::default() });
    let load = |i: usize| Ok(photographs[i].clone());
    let refused = fit(&lights, &load, &FitOptions::default(), &small).unwrap_err();
    assert_eq!(refused.kind(), crate::ErrorKind::Limit);
}

#[test]
fn warnings_name_poor_conditions() {
    let close = |i: usize| Direction::from_angles(0.7 + 0.02 * (i % 3) as f64, i as f64);
    let lights: Vec<_> = (0..20).map(|i| (format!("{i}"), close(i))).collect();
    let photographs = photographs(Size::new(4, 4), 1, &lights, &mut Random::new(1, Purpose::Sample, [2]));
    let report = run(&lights, &photographs, &FitOptions::default()).report;
    assert!(report.warnings.len() == 1 && report.warnings[0].contains("condition number"));
    let (lights, photographs) = capture(1, 6);
    let report = run(&lights, &photographs, &FitOptions::default()).report;
    assert!(report.warnings.iter().any(|w| w.contains("just enough")));
}

/// The ridge in closed form for one texel, by the normal equations.
mod near_lamps;
mod penalised;
