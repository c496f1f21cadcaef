//! The promises of the whole: planted fields are recovered, planes do not depend on how they are cut, and the
//! output has the statistics of the modelled texture.

use relume::field::{Basis, PlaneLayout};
use relume::numeric::Matrix;
use relume::numeric::pyramid::{self, Kernel};
use relume::numeric::random::{Purpose, Stream};
use relume::procedural::{Material, MaterialOptions};
use relume::random_field::candidates::NeighbourCandidates;
use relume::random_field::level::{Level, Weights};
use relume::random_field::neighbourhood::{Offset, causal};
use relume::random_field::normal_wishart::{Posterior, SufficientStatistics};
use relume::random_field::recursion::{Recursion, RecursionRun};
use relume::random_field::selection::{posterior, search};
use relume::random_field::stability::Stability;
use relume::random_field::{
    Budget, ModelOptions, RealisationOptions, SelectionOrder, Structure, Tiles, combine, estimate,
    model_lights,
};
use relume::render::relight;
use relume::{Direction, Job, Limits, Planes, ReflectanceField, Size, Space};

fn job() -> Job {
    Job::new(Limits { max_bytes: 1 << 30, max_side: 1 << 15 })
}

/// The colours of a built-in material, darkened where its relief is low.
fn material(material: Material, side: usize) -> Planes {
    let options = MaterialOptions { size: Size::new(side, side), feature: 24.0, ..Default::default() };
    let maps = material.make(&options, &job()).unwrap();
    let (low, high) = maps.height.range(0);
    let mut planes = maps.albedo.clone();
    for plane in planes.iter_mut() {
        plane
            .iter_mut()
            .zip(maps.height.plane(0))
            .for_each(|(v, h)| *v *= 0.4 + 0.6 * (h - low) / (high - low));
    }
    planes
}

fn realisation(origin: [i64; 2], width: usize, height: usize) -> RealisationOptions {
    RealisationOptions { origin, size: Size::new(width, height), seed: 7, period: None }
}

/// The same window as a tile.
fn closing(window: RealisationOptions) -> RealisationOptions {
    RealisationOptions { period: Some(window.size), ..window }
}

/// A field of `m` planes with given neighbours, weights and identity noise covariance.
fn planted(m: usize, parts: &[(i32, i32, Vec<f64>)], size: Size, seed: u64) -> Planes {
    let weights: Vec<f64> = parts.iter().flat_map(|p| p.2.clone()).collect();
    let level = Level {
        gain: None,
        unevenness: 0,
        neighbours: parts.iter().map(|p| Offset::new(p.0, p.1)).collect(),
        coarse: Vec::new(),
        weights: Weights::nearest(&weights, parts.len(), vec![1e-3; 2 * m], vec![1e-3; m]),
        noise: (0..m).flat_map(|i| (0..=i).map(move |j| f32::from(u8::from(i == j)))).collect(),
        burn_in: 0,
        log_evidence: 0.0,
        texels: 0,
    };
    let margin = 64;
    let area = Size::new(size.width + 2 * margin, size.height + margin);
    let run = RecursionRun { size: area, drive: None, strength: None, seed, period: None };
    Recursion::new(&level, 0).run_slow([0, 0], &run).crop(margin, margin, size).unwrap()
}

/// Statistics of all candidates, forward selection, and the standard error of each weight.
fn found(planes: &Planes, candidates: usize) -> (Vec<Offset>, Posterior, Matrix) {
    let m = planes.count();
    let set = NeighbourCandidates { near: causal(candidates), coarse: Vec::new() };
    let statistics = set.statistics(planes, m, &job()).unwrap();
    let prior = statistics.prior(1.0);
    let mut best = search(&statistics, &prior, SelectionOrder::Forward, candidates, &job()).unwrap()[0]
        .candidates
        .clone();
    best.sort_unstable();
    let posterior = posterior(&statistics, &prior, &best).unwrap();
    let regressors: Vec<usize> = best.iter().flat_map(|c| m * c..m * (c + 1)).collect();
    let errors = standard_errors(&statistics.subset(&regressors), &posterior);
    (best.iter().map(|&c| set.near[c]).collect(), posterior, errors)
}

/// sqrt(Sigma_jj (V_xx^-1)_rr).
fn standard_errors(statistics: &SufficientStatistics, posterior: &Posterior) -> Matrix {
    let (d, q) = (statistics.planes, statistics.regressors());
    let factor = Matrix::from_fn(q, q, |a, b| statistics.products[(d + a, d + b)]).cholesky().unwrap();
    let inverse = factor.lower_inverse();
    let variance = |r: usize| (0..q).map(|k| inverse[(k, r)].powi(2)).sum::<f64>();
    let noise = posterior.noise_covariance();
    Matrix::from_fn(q, d, |r, j| (variance(r) * noise[(j, j)]).sqrt())
}

#[test]
fn a_planted_field_is_found_again_on_95_of_100_seeds() {
    let parts: Vec<(i32, i32, Vec<f64>)> =
        [(-1, 0, 0.6), (0, -1, 0.5), (-1, -1, -0.3), (1, -1, 0.1), (-3, -2, 0.08)]
            .map(|(dx, dy, w)| (dx, dy, vec![w]))
            .to_vec();
    let mut offsets: Vec<Offset> = parts.iter().map(|p| Offset::new(p.0, p.1)).collect();
    offsets.sort_by_key(|o| causal(40).iter().position(|c| c == o));
    let is_found = |seed: u64| {
        let (neighbours, posterior, errors) = found(&planted(1, &parts, Size::new(128, 128), seed), 40);
        let truth = |o: &Offset| parts.iter().find(|p| (p.0, p.1) == (o.dx, o.dy)).unwrap().2[0];
        neighbours == offsets
            && neighbours
                .iter()
                .enumerate()
                .all(|(r, o)| (posterior.weights[(r, 0)] - truth(o)).abs() < 3.0 * errors[(r, 0)])
    };
    let hits = (0..100).filter(|&seed| is_found(seed)).count();
    println!("planted one-plane field: {hits} of 100");
    assert!(hits >= 95, "{hits} of 100");
}

#[test]
fn a_planted_field_of_three_planes_is_found_again() {
    let near = vec![0.5, 0.1, 0.0, 0.0, 0.4, 0.1, 0.1, 0.0, 0.3];
    let up = vec![0.3, 0.0, 0.1, 0.1, 0.3, 0.0, 0.0, 0.1, 0.4];
    let far = vec![-0.1, 0.0, 0.0, 0.0, -0.1, 0.05, 0.0, 0.0, -0.1];
    let parts = [(-1, 0, near), (0, -1, up), (2, -1, far)];
    let truth: Vec<f64> = parts.iter().flat_map(|p| p.2.clone()).collect();
    let (mut exact, mut within) = (0, 0);
    for seed in 0..100 {
        let (neighbours, posterior, errors) = found(&planted(3, &parts, Size::new(96, 96), seed), 24);
        let offsets = [Offset::new(-1, 0), Offset::new(0, -1), Offset::new(2, -1)];
        if neighbours == offsets {
            exact += 1;
            within += (0..27)
                .filter(|i| {
                    (posterior.weights[(i / 3, i % 3)] - truth[*i]).abs() < 3.0 * errors[(i / 3, i % 3)]
                })
                .count();
        }
    }
    println!(
        "planted three-plane field: {exact} of 100 exact, {within} of {} weights within 3 errors",
        27 * exact
    );
    assert!(exact >= 95, "{exact}");
    // A normal error is within three standard errors 99.73 times in a hundred.
    assert!(within as f64 >= 0.993 * 27.0 * f64::from(exact), "{within}");
}

#[test]
fn windows_of_the_endless_plane_are_the_same_however_they_are_cut() {
    let planes = material(Material::Bark, 96);
    let (model, _) =
        estimate(&planes, &ModelOptions { candidates: 14, ..Default::default() }, &job()).unwrap();
    let whole = model.synthesize(&realisation([-70, -40], 330, 190), &job()).unwrap();
    for (x, y, width, height) in
        [(0, 0, 1, 1), (3, 5, 200, 120), (150, 60, 180, 130), (329, 0, 1, 190), (60, 30, 37, 101)]
    {
        let part =
            model.synthesize(&realisation([x as i64 - 70, y as i64 - 40], width, height), &job()).unwrap();
        assert_eq!(part, whole.crop(x, y, Size::new(width, height)).unwrap(), "{x} {y}");
    }
    let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(
        single.install(|| model.synthesize(&realisation([-70, -40], 330, 190), &job()).unwrap()),
        whole
    );
    let other = model
        .synthesize(&RealisationOptions { seed: 8, ..realisation([-70, -40], 330, 190) }, &job())
        .unwrap();
    assert_ne!(other, whole);
}

/// The largest difference of neighbouring columns `a` and `b`, relative to that of columns inside.
fn seam(planes: &Planes, a: usize, b: usize) -> f64 {
    let size = planes.size();
    let step = |a: usize, b: usize| {
        let squares = (0..size.height).map(|y| f64::from(planes.at(0, a, y) - planes.at(0, b, y)).powi(2));
        (squares.sum::<f64>() / size.height as f64).sqrt()
    };
    let inside = (20..60).map(|x| step(x, x + 1)).sum::<f64>() / 40.0;
    step(a, b) / inside
}

#[test]
fn cells_meet_and_tiles_close_without_a_seam() {
    let planes = material(Material::Leather, 128);
    let (model, _) = estimate(&planes, &ModelOptions::default(), &job()).unwrap();
    let plane = model.synthesize(&realisation([0, 0], 300, 200), &job()).unwrap();
    let at_cells = seam(&plane, 127, 128);
    assert!((0.7..1.3).contains(&at_cells), "{at_cells}");
    let tile = closing(realisation([0, 0], 200, 136));
    let tile = model.synthesize(&tile, &job()).unwrap();
    let joint = seam(&tile, 199, 0);
    assert!((0.7..1.3).contains(&joint), "{joint}");
    let refused = model.synthesize(&closing(realisation([0, 0], 201, 136)), &job());
    assert!(refused.unwrap_err().message().contains("204 x 136"));
}

#[test]
fn what_is_made_has_the_moments_of_what_was_modelled() {
    for kind in [Material::Bark, Material::Sponge, Material::Leather] {
        let planes = material(kind, 256);
        let (model, _) = estimate(&planes, &ModelOptions::default(), &job()).unwrap();
        let made = model.synthesize(&realisation([0, 0], 1024, 1024), &job()).unwrap();
        for k in 0..planes.count() {
            let moments = |p: &[f32]| {
                let n = p.len() as f64;
                let mean = p.iter().map(|&v| f64::from(v)).sum::<f64>() / n;
                (mean, (p.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / n).sqrt())
            };
            let (truth, found) = (moments(planes.plane(k)), moments(made.plane(k)));
            println!(
                "{kind:?} plane {k}: mean {:.4} {:.4}, deviation {:.4} {:.4}",
                truth.0, found.0, truth.1, found.1
            );
            assert!((found.0 - truth.0).abs() < 0.05 * truth.0, "{kind:?} {k}: mean {truth:?} {found:?}");
            assert!(
                (found.1 - truth.1).abs() < 0.05 * truth.1,
                "{kind:?} {k}: deviation {truth:?} {found:?}"
            );
        }
    }
}

/// A weave with a period of 12 x 10 texels, with grain.
fn woven(size: Size) -> Planes {
    let mut stream = Stream::new(6, Purpose::Sample, [0]);
    let mut planes = Planes::zeros(size, 2);
    for (i, k) in (0..size.texels()).flat_map(|i| (0..2).map(move |k| (i, k))) {
        let (x, y) = (i % size.width, i / size.width);
        let over = (x / 6 + y / 5) % 2 == 0;
        let grain = 0.06 * (stream.unit() + stream.unit() - 1.0) as f32;
        planes.plane_mut(k)[i] = if over { 0.7 } else { 0.3 } + 0.05 * k as f32 + grain;
    }
    planes
}

/// The mean product of texels one period apart along x, relative to their mean square.
fn repeats(planes: &Planes, period: usize) -> f64 {
    let (size, plane) = (planes.size(), planes.plane(0));
    let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
    let at = |x: usize, y: usize| f64::from(planes.at(0, x, y)) - mean;
    let places = || (0..size.height).flat_map(|y| (0..size.width - period).map(move |x| (x, y)));
    let product: f64 = places().map(|(x, y)| at(x, y) * at(x + period, y)).sum();
    let square: f64 = places().map(|(x, y)| at(x, y).powi(2)).sum();
    product / square
}

#[test]
fn as_many_levels_are_taken_as_resemble_the_texture_most() {
    let options = ModelOptions { candidates: 6, fewer: true, ..ModelOptions::default() };
    let count = |planes: &Planes| {
        let (model, reports) = estimate(planes, &options, &job()).unwrap();
        assert_eq!(model.levels.len(), reports.len());
        let (same, _) = estimate(planes, &ModelOptions { levels: reports.len(), ..plain() }, &job()).unwrap();
        assert_eq!(same, model, "as if that number had been asked for");
        reports.len()
    };
    // A field of one level, and one whose coarse grain only a coarse level can represent.
    let levels = |seed: u64| {
        let fine = planted(1, &[(-1, 0, vec![0.4]), (0, -1, vec![0.3])], Size::new(128, 128), seed);
        let blurred = pyramid::gaussian(&fine, &Kernel::new(2).unwrap(), 4).pop().unwrap();
        let coarse = (0..3).fold(blurred, |planes, _| {
            let size = planes.size();
            pyramid::expand(&planes, &Kernel::new(2).unwrap(), Size::new(2 * size.width, 2 * size.height))
        });
        let mut mixed = fine.clone();
        mixed.as_mut_slice().iter_mut().zip(coarse.as_slice()).for_each(|(v, c)| *v = 0.3 * *v + 6.0 * c);
        (count(&fine), count(&mixed))
    };
    let found: Vec<(usize, usize)> = (0..5).map(levels).collect();
    println!("levels of fields of one, and with coarse grain: {found:?}");
    assert!(found.iter().all(|(fine, mixed)| fine < mixed), "{found:?}");
    assert!(found.iter().map(|(_, mixed)| mixed).sum::<usize>() >= 13, "{found:?}");
}

/// The options of that test for a given number of levels.
fn plain() -> ModelOptions {
    ModelOptions { candidates: 6, ..ModelOptions::default() }
}

#[test]
fn what_repeats_is_kept_by_structure_and_its_grain_by_the_field() {
    let planes = woven(Size::new(120, 100));
    let options = ModelOptions { candidates: 12, ..ModelOptions::default() };
    let used = |s: &Structure| s.codes.iter().filter(|&&code| code != 0).count();
    let tiles = Tiles { texels: &planes, size: Size::new(120, 50) };
    let budget = Budget { bytes: 1500, cost: &used };
    let (model, _) = combine(&planes, tiles, &budget, &options, &job()).unwrap();
    let (plain, _) = estimate(&planes, &options, &job()).unwrap();
    let whole = model.synthesize(&realisation([-300, 77], 480, 300), &job()).unwrap();
    let lost = plain.synthesize(&realisation([-300, 77], 480, 300), &job()).unwrap();
    assert!(repeats(&planes, 12) > 0.8 && repeats(&whole, 12) > 0.8, "{}", repeats(&whole, 12));
    assert!(repeats(&lost, 12) < 0.5, "{}", repeats(&lost, 12));
    // Tiles repeat and their grain does not.
    let same = (0..300).filter(|&x| whole.at(0, x, 9) == whole.at(0, x + 120, 9)).count();
    assert!(same < 30, "{same}");
    let part = model.synthesize(&realisation([-250, 100], 133, 71), &job()).unwrap();
    assert_eq!(part, whole.crop(50, 23, Size::new(133, 71)).unwrap());
    let closed = closing(realisation([31, -9], 240, 200));
    let closed = model.synthesize(&closed, &job()).unwrap();
    let seam = seam(&closed, 239, 0);
    assert!(seam < 2.0, "{seam}");
    let refused = model.synthesize(&closing(realisation([0, 0], 208, 136)), &job());
    assert!(refused.unwrap_err().message().contains("multiples of 120 and"));
    let wrong = Tiles { texels: &planes, size: Size::new(120, 33) };
    assert!(combine(&planes, wrong, &budget, &options, &job()).is_err());
}

/// A surface of dents under a light: its luminance functions, the slopes along x and y times u and v.
fn dented(side: usize) -> ReflectanceField {
    let height = material(Material::Sponge, side);
    let mut planes = Planes::zeros(Size::new(side, side), 6);
    for (i, (x, y)) in (0..side).flat_map(|y| (0..side).map(move |x| (x, y))).enumerate() {
        let at = |x: usize, y: usize| height.at(0, x % side, y % side);
        planes.plane_mut(3)[i] = at(x, y) - at(x + 1, y);
        planes.plane_mut(4)[i] = at(x, y + 1) - at(x, y);
        planes.plane_mut(5)[i] = 0.2 + at(x, y);
    }
    ReflectanceField::new(Basis::Ptm, PlaneLayout::LUMINANCE, Space::Linear, planes).unwrap()
}

/// The correlation of two pictures' first planes.
fn correlation(a: &Planes, b: &Planes) -> f64 {
    let centred = |p: &Planes| {
        let mean = p.plane(0).iter().map(|&v| f64::from(v)).sum::<f64>() / p.plane(0).len() as f64;
        p.plane(0).iter().map(|&v| f64::from(v) - mean).collect::<Vec<f64>>()
    };
    let (a, b) = (centred(a), centred(b));
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt()
}

#[test]
fn models_of_lights_show_one_surface_under_each_of_them() {
    let field = dented(96);
    let options = ModelOptions { levels: 2, candidates: 12, ..ModelOptions::default() };
    let picture = |light| relight(&field, light).planes;
    let model = |lights: &[Direction]| model_lights(&field, lights, &picture, &options, &job());
    // Six lights and six functions: the functions interpolate the pictures that the models make.
    let lights = relume::capture::dome::lights(6);
    let (made, reports) = model(&lights).unwrap();
    assert_eq!(reports.len(), 6);
    let whole = made.synthesize(&realisation([-40, 13], 190, 150), &job()).unwrap();
    let mut pictures = Vec::new();
    for (light, model) in made.fields.models() {
        let picture = model.synthesize(&realisation([-40, 13], 190, 150), &job()).unwrap();
        let relit = relight(&whole, light.unwrap()).planes;
        let error = |(a, b): (&f32, &f32)| (a - b).abs();
        let worst = picture.as_slice().iter().zip(relit.as_slice()).map(error).fold(0.0, f32::max);
        assert!(worst < 1e-3, "{light:?}: {worst}");
        pictures.push((picture, model));
    }
    // The same noise makes the same surface; another seed makes another.
    let truth = |i: usize, j: usize| correlation(&picture(lights[i]), &picture(lights[j]));
    let found = |i: usize, j: usize| correlation(&pictures[i].0, &pictures[j].0);
    for (i, j) in [(0, 1), (0, 2), (2, 5)] {
        println!("lights {i} and {j}: correlation {:.2}, made {:.2}", truth(i, j), found(i, j));
        assert!((truth(i, j) - found(i, j)).abs() < 0.25, "{i} {j}: {} {}", truth(i, j), found(i, j));
    }
    let other = RealisationOptions { seed: 8, ..realisation([-40, 13], 190, 150) };
    let other = pictures[1].1.synthesize(&other, &job()).unwrap();
    assert!(correlation(&pictures[0].0, &other).abs() < 0.1);
    let part = made.synthesize(&realisation([3, 20], 77, 60), &job()).unwrap();
    assert_eq!(part.coefficients(), &whole.coefficients().crop(43, 7, Size::new(77, 60)).unwrap());
    // A ring of lights, or too few of them, do not determine the functions.
    let ring: Vec<Direction> = (0..9).map(|i| Direction::from_angles(0.7, f64::from(i) * 0.7)).collect();
    for lights in [&lights[..5], &ring] {
        assert!(model(lights).unwrap_err().message().contains("do not determine"));
    }
}

#[test]
fn an_unstable_fit_is_caught_and_one_that_keeps_the_moments_is_taken() {
    let wild: Vec<(i32, i32, Vec<f64>)> = vec![(-1, 0, vec![0.55]), (0, -1, vec![0.5])];
    let planes = planted(1, &wild, Size::new(64, 64), 3);
    // Unchecked: two neighbours fitted to the values themselves.
    let set = NeighbourCandidates { near: causal(2), coarse: Vec::new() };
    let statistics = set.statistics(&planes, 1, &job()).unwrap();
    let fitted = posterior(&statistics, &statistics.prior(1.0), &[0, 1]).unwrap();
    let weight = |r: usize| vec![fitted.weights[(r, 0)]];
    let naive = [(-1, 0, weight(0)), (0, -1, weight(1))];
    let deviation = |p: &[f32]| {
        let mean = p.iter().map(|&v| f64::from(v)).sum::<f64>() / p.len() as f64;
        (p.iter().map(|&v| (f64::from(v) - mean).powi(2)).sum::<f64>() / p.len() as f64).sqrt()
    };
    let truth = deviation(planes.plane(0));
    let blown = deviation(planted(1, &naive, Size::new(256, 256), 5).plane(0));
    assert!(blown > 6.0 * truth, "{blown} {truth}");
    // Checked.
    let options =
        ModelOptions { levels: 1, candidates: 2, search: SelectionOrder::Nested, ..ModelOptions::default() };
    let (model, reports) = estimate(&planes, &options, &job()).unwrap();
    println!("unstable fit: {blown:.3e}, not {truth:.3e}; {} passed over", reports[0].unstable);
    assert!(model.levels.iter().all(|level| Stability::of(level).is_stable()));
    // Shrunk, not dropped.
    assert_eq!((model.levels[0].neighbours.len(), reports[0].unstable), (2, 0));
    assert!(reports[0].prior > options.prior);
    // So slow a field needs room: windows of 512 x 512 texels have 0.92 to 1.00 of the deviation, of 2048 x 2048 0.985.
    let made = deviation(model.synthesize(&realisation([0, 0], 2048, 2048), &job()).unwrap().plane(0));
    assert!((made / truth - 1.0).abs() < 0.05, "{made} {truth}");
}

#[test]
fn planes_that_cannot_be_modelled_are_refused() {
    let options = ModelOptions::default();
    let refused = |planes: &Planes, options: &ModelOptions| {
        estimate(planes, options, &job()).unwrap_err().message().to_owned()
    };
    let flat = Planes::from_vec(Size::new(40, 40), 3, vec![0.25; 4800]).unwrap();
    assert!(refused(&flat, &options).contains("the same everywhere"));
    assert!(refused(&material(Material::Bark, 9), &options).contains("smaller than the neighbourhood"));
    let mut holed = material(Material::Bark, 40);
    holed.plane_mut(1)[77] = f32::NAN;
    assert!(refused(&holed, &options).contains("plane 1"));
    for bad in [
        ModelOptions { levels: 0, ..options },
        ModelOptions { factor: 1, ..options },
        ModelOptions { candidates: 401, ..options },
        ModelOptions { prior: f64::NAN, ..options },
    ] {
        assert!(estimate(&material(Material::Bark, 40), &bad, &job()).is_err());
    }
}

#[test]
fn planes_that_repeat_each_other_or_stand_still_are_modelled() {
    let colour = material(Material::Bark, 64);
    let mut planes = Planes::zeros(colour.size(), 4);
    for k in [0, 2] {
        planes.plane_mut(k).copy_from_slice(colour.plane(0));
    }
    planes.plane_mut(1).fill(0.5);
    planes.plane_mut(3).copy_from_slice(colour.plane(2));
    let (model, _) =
        estimate(&planes, &ModelOptions { candidates: 12, ..Default::default() }, &job()).unwrap();
    assert_eq!(model.mixing.own[..3], [true, false, false]);
    let made = model.synthesize(&realisation([5, 5], 50, 40), &job()).unwrap();
    assert!(made.plane(1).iter().all(|&v| v == 0.5));
    let error = made.plane(0).iter().zip(made.plane(2)).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(error < 0.01, "{error}");
}
