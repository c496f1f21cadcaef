use super::*;
use crate::capture::dome::sampling::DirectionSampling;
use crate::direction::Direction;
use crate::field::{Basis, PerViewModel};
use crate::numeric::random::{Purpose, Stream};
use crate::raster::Samples;
use crate::size::Size;

const SIZE: Size = Size { width: 4, height: 3 };

fn grid(lights: usize, views: usize) -> Vec<(String, Directions)> {
    let all = DirectionSampling::Bonn.directions();
    let pick = |count: usize| -> Vec<Direction> { (0..count).map(|i| all[i * all.len() / count]).collect() };
    let (lights, views) = (pick(lights), pick(views));
    let pair = |i: usize| Directions { light: lights[i % lights.len()], view: views[i / lights.len()] };
    (0..lights.len() * views.len()).map(|i| (format!("p{i}"), pair(i))).collect()
}

/// Photographs of a texture of known numbers, in floats.
fn photographs(field: &ParametricField, pairs: &[(String, Directions)]) -> Vec<Raster> {
    let image = |(_, pair): &(String, Directions)| {
        let picture = field.picture(*pair, &Job::default()).unwrap().to_space(Space::Linear);
        let (n, channels) = (field.size().texels(), field.channels());
        let samples = (0..n * channels).map(|i| picture.planes.plane(i % channels)[i / channels]).collect();
        Raster::new(field.size(), channels, Samples::F32(samples)).unwrap()
    };
    pairs.iter().map(image).collect()
}

/// A texture whose texels have numbers around those given.
fn around(model: TexelModel, channels: usize, numbers: &[f32], spread: &[f32]) -> ParametricField {
    let mut stream = Stream::new(3, Purpose::Sample, [0]);
    let mut planes = Planes::zeros(SIZE, numbers.len());
    for (plane, (number, spread)) in planes.iter_mut().zip(numbers.iter().zip(spread)) {
        plane.iter_mut().for_each(|v| *v = number + spread * (2.0 * stream.unit() as f32 - 1.0));
    }
    ParametricField::new(model, channels, planes).unwrap()
}

fn refit(field: &ParametricField, form: ParametricForm, pairs: &[(String, Directions)]) -> ParametricFit {
    let images = photographs(field, pairs);
    let options = ParametricOptions { pairs: 500, ..ParametricOptions::of(form) };
    fit(pairs, &|i| Ok(images[i].clone()), &options, &Job::default()).unwrap()
}

/// The largest difference of the numbers of two textures.
fn differences(a: &ParametricField, b: &ParametricField) -> Vec<f32> {
    let plane = |k: usize| {
        let pairs = a.planes().plane(k).iter().zip(b.planes().plane(k));
        pairs.fold(0.0f32, |most, (a, b)| most.max((a - b).abs()))
    };
    (0..a.planes().count()).map(plane).collect()
}

#[test]
fn a_known_lobe_is_found() {
    let numbers = [0.2, 0.3, 0.1, 0.5, 0.4, 0.3, -0.8, -0.8, 1.0, 8.0];
    let spread = [0.1, 0.1, 0.05, 0.2, 0.1, 0.1, 0.1, 0.1, 0.0, 3.0];
    let truth = around(TexelModel::Lafortune { lobes: 1 }, 3, &numbers, &spread);
    let found = refit(&truth, ParametricForm::Lafortune(1), &grid(20, 20));
    assert!(found.report.fitted.error.rmse < 1e-3, "{:?}", found.report.fitted);
    let worst = differences(&found.field, &truth);
    assert!(worst[..9].iter().all(|d| *d < 0.02) && worst[9] < 0.3, "{worst:?}");
}

#[test]
fn two_lobes_show_what_those_photographed_do() {
    let numbers = [0.2, 0.6, -1.0, -1.0, 0.9, 12.0, 0.4, 0.7, 0.7, 1.0, 3.0];
    let truth = around(TexelModel::Lafortune { lobes: 2 }, 1, &numbers, &[0.03; 11]);
    let pairs = grid(20, 20);
    let [one, two] = [1, 2].map(|lobes| refit(&truth, ParametricForm::Lafortune(lobes), &pairs));
    let [a, b] = [&one, &two].map(|fit| fit.report.fitted.error.rmse);
    assert!(b < 0.25 * a && b < 0.01, "{a} with one lobe, {b} with two");
}

#[test]
fn known_facets_are_found() {
    let numbers = [0.5, 0.3, 0.2, 0.1, -0.1, 0.5, 0.05];
    let truth = around(TexelModel::Ggx, 3, &numbers, &[0.2, 0.1, 0.1, 0.2, 0.2, 0.15, 0.02]);
    let found = refit(&truth, ParametricForm::Ggx, &grid(25, 25));
    assert!(found.report.fitted.error.rmse < 2e-3, "{:?}", found.report.fitted);
    let worst = differences(&found.field, &truth);
    assert!(worst.iter().all(|d| *d < 0.02), "{worst:?}");
}

#[test]
fn polished_metal_is_not_taken_for_a_dielectric() {
    let truth = around(
        TexelModel::Ggx,
        3,
        &[0.02, 0.02, 0.02, 0.0, 0.0, 0.5, 0.6],
        &[0.02, 0.02, 0.02, 0.1, 0.1, 0.1, 0.1],
    );
    for aim in [FacetAim::Pictures, FacetAim::Maps] {
        let pairs = grid(20, 20);
        let images = photographs(&truth, &pairs);
        let options = ParametricOptions { aim, ..ParametricOptions::of(ParametricForm::Ggx) };
        let found = fit(&pairs, &|i| Ok(images[i].clone()), &options, &Job::default()).unwrap();
        let worst = differences(&found.field, &truth);
        assert!(worst.iter().all(|d| *d < 0.05), "{aim:?}: {worst:?}");
    }
}

#[test]
fn functions_of_each_view_are_found_and_views_left_out_predicted() {
    let pairs = grid(16, 12);
    let mut views: Vec<Direction> = pairs.iter().map(|(_, pair)| pair.view).collect();
    views.dedup();
    let function = ViewFunction::Basis(Basis::Ptm, Space::Linear);
    let model = TexelModel::PerView(PerViewModel::new(&views, function.clone()).unwrap());
    let count = model.numbers(1);
    let numbers: Vec<f32> = (0..count).map(|k| if k % 6 == 5 { 0.5 } else { 0.04 }).collect();
    let truth = around(model, 1, &numbers, &vec![0.02; count]);
    let found = refit(&truth, ParametricForm::PerView(function.clone()), &pairs);
    assert_eq!(found.report.numbers, 12 * 6);
    assert!(differences(&found.field, &truth).iter().all(|d| *d < 1e-3));
    // A twelfth of views and a fourth of lights left out.
    let images = photographs(&truth, &pairs);
    let options =
        ParametricOptions { hold_out: Some(4), ..ParametricOptions::of(ParametricForm::PerView(function)) };
    let held = fit(&pairs, &|i| Ok(images[i].clone()), &options, &Job::default()).unwrap();
    assert_eq!(held.report.numbers, 9 * 6);
    let out = held.report.held_out.unwrap();
    assert_eq!(out.pairs, 16 * 12 - 12 * 9);
    assert!(out.error.rmse > held.report.fitted.error.rmse && out.error.rmse < 0.1, "{out:?}");
}

/// Texels of two products are found by two, in any order of their photographs, and not by one.
#[test]
fn products_are_found_and_more_of_them_err_less() {
    let pairs = grid(12, 10);
    let mut views: Vec<Direction> = pairs.iter().map(|(_, pair)| pair.view).collect();
    views.dedup();
    let lights: Vec<Direction> = pairs[..12].iter().map(|(_, pair)| pair.light).collect();
    let model = TexelModel::Separable(SeparableModel::new(&views, &lights, 2, Space::Srgb).unwrap());
    let count = model.numbers(3);
    let truth = around(model, 3, &vec![0.45; count], &vec![0.2; count]);
    let form = |products| ParametricForm::from_name(&format!("separable{products}"), Space::Srgb).unwrap();
    let [one, two] = [1, 2].map(|products| refit(&truth, form(products), &pairs));
    assert_eq!((two.report.model.as_str(), two.report.numbers), ("separable2", 2 * (10 + 36)));
    assert_eq!(two.report.pairs_fitted, pairs.len());
    let [a, b] = [&one, &two].map(|fit| fit.report.fitted.error.rmse);
    assert!(a > 0.01 && b < 1e-5, "{a} {b}");
    // Photographs in any order, and some lights and views left out.
    let mut turned = pairs.clone();
    turned.reverse();
    turned.swap(3, 40);
    assert!(refit(&truth, form(2), &turned).report.fitted.error.rmse < 1e-5);
    let images = photographs(&truth, &pairs);
    let options = ParametricOptions { hold_out: Some(4), ..ParametricOptions::of(form(2)) };
    let held = fit(&pairs, &|i| Ok(images[i].clone()), &options, &Job::default()).unwrap();
    assert_eq!(held.report.numbers, 2 * (8 + 27));
    assert!(held.report.held_out.unwrap().error.rmse > held.report.fitted.error.rmse);
    // A pair that is missing.
    let error =
        fit(&pairs[1..], &|i| Ok(images[i + 1].clone()), &ParametricOptions::of(form(1)), &Job::default());
    assert!(error.unwrap_err().to_string().contains("the 119 photographs"));
    assert_eq!(ParametricForm::from_name("separable0", Space::Srgb), None);
    assert_eq!(ParametricForm::from_name("separable17", Space::Srgb), None);
}

#[test]
fn lobes_of_each_view_are_found() {
    let pairs = grid(24, 3);
    let views = [pairs[0].1.view, pairs[24].1.view, pairs[48].1.view];
    let model = TexelModel::PerView(PerViewModel::new(&views, ViewFunction::Lobes(1)).unwrap());
    let numbers = [0.1, 0.6, 0.6, 0.0, 0.8, 6.0].repeat(3);
    let truth = around(model, 1, &numbers, &[0.05, 0.1, 0.1, 0.1, 0.0, 1.0].repeat(3));
    let found = refit(&truth, ParametricForm::PerView(ViewFunction::Lobes(1)), &pairs);
    assert!(found.report.fitted.error.rmse < 5e-3, "{:?}", found.report.fitted);
    // The length of the weights is 1.
    let length = |t: usize| (1..4).map(|k| found.field.planes().plane(1 + k)[t].powi(2)).sum::<f32>();
    assert!((0..SIZE.texels()).all(|t| (length(t) - 1.0).abs() < 1e-4));
}

#[test]
fn bands_of_texels_make_no_difference() {
    let truth = around(TexelModel::Ggx, 1, &[0.4, 0.0, 0.1, 0.6, 0.04], &[0.2, 0.1, 0.1, 0.1, 0.0]);
    let pairs = grid(12, 12);
    let images = photographs(&truth, &pairs);
    let options = ParametricOptions::of(ParametricForm::Ggx);
    let load = |i: usize| Ok(images[i].clone());
    let whole = fit(&pairs, &load, &options, &Job::default()).unwrap();
    // The numbers, the texels compared, and those of the sample, in floats, twice.
    let least = 4 * 144 * 3 + 4 * 12 * 5 + 3 * 4 * 144 * 12;
    let small = Job::new(crate::Limits { max_bytes: least + 2000, ..crate::Limits::default() });
    let banded = fit(&pairs, &load, &options, &small).unwrap();
    assert_eq!(whole.field, banded.field);
    assert_eq!(whole.report, banded.report);
}

#[test]
fn the_linear_form_is_nearly_the_texture() {
    for field in crate::field::parametric::examples::all() {
        let (linear, error) = linear_form(&field, &Job::default()).unwrap();
        assert_eq!((linear.size(), linear.layout().channels()), (field.size(), field.channels()));
        // Of fifteen texels, all functions are kept.
        assert!(error < 1e-3, "{}: {error}", field.model().name());
        let pair = Directions { light: Direction::ZENITH, view: Direction::ZENITH };
        let (a, b) = (field.evaluate(1, 1, pair), linear.value(1, 1, pair));
        let shown = field.model().space().to_srgb(a[0]).clamp(0.0, 1.0);
        assert!((shown - b[0]).abs() < 0.02, "{}: {shown} and {}", field.model().name(), b[0]);
    }
}

#[test]
fn options_without_meaning_and_too_few_photographs_are_refused() {
    let refused = |options: ParametricOptions, pairs: usize| {
        let all = grid(20, 20);
        let load = |_| Raster::new(SIZE, 3, Samples::U8(vec![9; 36]));
        fit(&all[..pairs], &load, &options, &Job::default()).unwrap_err().to_string()
    };
    let of = ParametricOptions::of;
    assert!(refused(of(ParametricForm::Lafortune(0)), 50).contains("1 to 3 lobes"));
    assert!(refused(of(ParametricForm::Lafortune(4)), 50).contains("not 4"));
    assert!(refused(of(ParametricForm::Ggx), 5).contains("5 photographs do not determine"));
    let few = ParametricOptions { pairs: 3, ..of(ParametricForm::Ggx) };
    assert!(refused(few, 50).contains("at least 8 pairs"));
    let none = ParametricOptions { report_texels: 0, ..of(ParametricForm::Ggx) };
    assert!(refused(none, 50).contains("at least 1 texel"));
    let all = ParametricOptions { hold_out: Some(1), ..of(ParametricForm::Ggx) };
    assert!(refused(all, 50).contains("leaves none"));
    let ptm = ParametricForm::from_name("views-ptm", Space::Srgb).unwrap();
    let message = refused(of(ptm), 22);
    assert!(message.contains("photographs of the view of"), "{message}");
    assert_eq!(ParametricForm::from_name("views-nothing", Space::Srgb), None);
}

/// A fault: every 16th of 81 x 81 pairs has few lights of each view, and lobes fitted to them err by a tenth more.
#[test]
fn pairs_chosen_for_the_fit_have_all_lights_and_views() {
    assert_eq!(spread(5, 9).into_iter().collect::<Vec<_>>(), [0, 1, 2, 3, 4]);
    let chosen = spread(6561, 400);
    assert_eq!(chosen.len(), 400);
    for of in [|i: &usize| i % 81, |i: &usize| i / 81] {
        let counts = (0..81).map(|k| chosen.iter().filter(|i| of(i) == k).count());
        assert!(counts.clone().all(|count| (1..=10).contains(&count)), "{:?}", counts.collect::<Vec<_>>());
    }
}
