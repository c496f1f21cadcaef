use proptest::prelude::*;

use super::super::pyramid::pyramid;
use super::*;
use crate::planes::Planes;

fn noise(size: Size, planes: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, Purpose::Sample, [1]);
    let data = (0..size.texels() * planes).map(|_| stream.below(60) as f32).collect();
    Planes::from_vec(size, planes, data).unwrap()
}

/// A round that ignores how often patches are used.
fn how(search: PatchSearch, key: u64) -> Improvement {
    Improvement { search, uniformity: 0.0, key }
}

/// Random patches side by side, and their matches.
fn begin(canvas: &mut PixelCanvas, patches: &ExemplarPatches<'_>, seed: u64) -> Matching {
    let size = canvas.size();
    let sources = random_patches(size, patches, seed, 0);
    for (texel, source) in sources.iter().enumerate() {
        canvas.put(texel, *source, &patches.level().exemplars);
    }
    let corner = |(x, y)| patches.around(sources[size.index(x, y)]).unwrap();
    Matching::new(size, Matching::middles(size).map(corner).collect())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(25))]

    #[test]
    fn threads_change_nothing_and_excluded_texels_are_not_copied(
        (width, height, seed) in (14usize..40, 14usize..40, any::<u64>()),
        (extra, planes, half, masked) in (0usize..9, 1usize..4, 1usize..3, any::<bool>()),
    ) {
        let fields = [0, 1].map(|e| noise(Size::new(14 + extra, 16 + e), planes, seed ^ e as u64));
        let masks = fields.each_ref().map(|f| (0..f.size().texels()).map(|i| masked && i == 0).collect::<Vec<_>>());
        let exemplars = [0, 1].map(|e| Exemplar { index: &fields[e], excluded: Some(&masks[e]) });
        let options = PatchMatchOptions {
            size: Size::new(width, height),
            window: 2 * half + 1,
            levels: 2,
            seed,
            ..PatchMatchOptions::default()
        };
        let make = || patch_match(&exemplars, &options, &Job::default()).unwrap();
        let truth = make();
        for threads in [1, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            prop_assert_eq!(&pool.install(make), &truth);
        }
        for from in truth.0.copies() {
            let size = fields[from.exemplar as usize].size();
            prop_assert!((from.x as usize) < size.width && (from.y as usize) < size.height);
            prop_assert!(!masked || (from.x, from.y) != (0, 0));
        }
    }

    #[test]
    fn improved_matches_are_never_worse_and_never_better_than_the_full_search(
        (width, height, seed) in (9usize..30, 9usize..30, any::<u64>()),
        (planes, half) in (1usize..4, 1usize..4),
    ) {
        let index = noise(Size::new(23, 21), planes, seed);
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let job = Job::default();
        let level = &pyramid(&exemplars, 1, 3, &job).unwrap()[0];
        let patches = ExemplarPatches::new(level, 2 * half + 1, &job).unwrap();
        let size = Size::new(width, height);
        let mut canvas = PixelCanvas::new(size, planes, Boundary::Torus, &job).unwrap();
        let mut matching = begin(&mut canvas, &patches, seed);
        let mut full = matching.clone();
        full.improve(&canvas, &patches, how(PatchSearch::Full, 0), &Job::default()).unwrap();
        for (middle, least) in Matching::middles(size).zip(full.matches()) {
            let truth = patches.iter().map(|corner| plain::distance(&canvas, &patches, middle, corner)).min();
            prop_assert_eq!(Some(least.distance), truth);
        }
        let mut before = vec![u64::MAX; matching.matches().len()];
        for round in 0..4 {
            matching.improve(&canvas, &patches, how(PatchSearch::Propagation, round), &Job::default()).unwrap();
            for (middle, found) in Matching::middles(size).zip(matching.matches()) {
                prop_assert_eq!(found.distance, plain::distance(&canvas, &patches, middle, found.corner));
            }
            let now: Vec<u64> = matching.matches().iter().map(|found| found.distance).collect();
            prop_assert!(now.iter().zip(&before).all(|(now, before)| now <= before));
            prop_assert!(now.iter().zip(full.matches()).all(|(now, least)| *now >= least.distance));
            before = now;
        }
    }

    #[test]
    fn votes_and_distances_are_those_of_the_plain_loops(
        (width, height, seed) in (9usize..30, 9usize..24, any::<u64>()),
        (planes, half, spread) in (1usize..19, 1usize..5, 1usize..4000),
    ) {
        let window = 2 * half + 1;
        let mut fields = [noise(Size::new(23, 21), planes, seed), noise(Size::new(12, 30), planes, seed ^ 1)];
        // Few values give ties, many give large codes.
        fields.iter_mut().for_each(|f| f.as_mut_slice().iter_mut().for_each(|v| *v = (*v * 977.0) % spread as f32));
        let exemplars = fields.each_ref().map(|index| Exemplar { index, excluded: None });
        let job = Job::default();
        let level = &pyramid(&exemplars, 1, 3, &job).unwrap()[0];
        let patches = ExemplarPatches::new(level, window, &job).unwrap();
        let size = Size::new(width, height);
        let mut canvas = PixelCanvas::new(size, planes, Boundary::Torus, &job).unwrap();
        let mut matching = begin(&mut canvas, &patches, seed);
        matching.improve(&canvas, &patches, how(PatchSearch::Propagation, seed), &Job::default()).unwrap();
        for (n, middle) in Matching::middles(size).enumerate() {
            let corner = patches.nth(n * 7 % patches.count());
            let truth = plain::distance(&canvas, &patches, middle, corner);
            let mut patch = Vec::new();
            patches.of_output(&canvas, middle, &mut patch);
            for limit in [truth, truth + 1, u64::MAX] {
                let kept = (truth < limit).then_some(truth);
                prop_assert_eq!(patches.distance(&patch, corner, limit, patches::portable), kept);
                #[cfg(target_arch = "x86_64")]
                if let Some(simd) = pulp::x86::V3::try_new() {
                    let squares = |sums: &mut _, a: &[_], b: &[_], length| patches::avx2(simd, sums, a, b, length);
                    prop_assert_eq!(patches.distance(&patch, corner, limit, squares), kept);
                }
            }
        }
        for squared in [false, true] {
            let weights = votes::weights(&matching, &patches, squared);
            let truth: Vec<Texel> = (0..size.texels())
                .map(|texel| plain::elect(&canvas, &patches, &matching, &weights, texel))
                .collect();
            votes::cast(&mut canvas, &patches, &matching, &weights, None);
            prop_assert!((0..size.texels()).all(|texel| canvas.source(texel) == truth[texel]));
        }
    }
}

#[test]
fn patches_of_the_exemplar_itself_are_found_by_propagation() {
    // On a torus with the content of the exemplar itself almost every patch has a match of distance zero.
    let index = noise(Size::new(64, 64), 3, 7);
    let exemplars = [Exemplar { index: &index, excluded: None }];
    let job = Job::default();
    let level = &pyramid(&exemplars, 1, 7, &job).unwrap()[0];
    let patches = ExemplarPatches::new(level, 7, &job).unwrap();
    let mut canvas = PixelCanvas::new(Size::new(64, 64), 3, Boundary::Torus, &job).unwrap();
    let mut matching = begin(&mut canvas, &patches, 3);
    for texel in 0..64 * 64 {
        canvas.put(
            texel,
            Texel { exemplar: 0, y: (texel / 64) as u32, x: (texel % 64) as u32 },
            &level.exemplars,
        );
    }
    for round in 0..20 {
        matching.improve(&canvas, &patches, how(PatchSearch::Propagation, round), &Job::default()).unwrap();
    }
    let exact = matching.matches().iter().filter(|found| found.distance == 0).count();
    // Those that cross the border, at most 4 of 32 cells either way, have none.
    assert!(exact >= 28 * 28, "{exact} of {}", matching.matches().len());
}

#[test]
fn uniformity_spreads_the_use_of_the_exemplar() {
    let mut index = noise(Size::new(48, 48), 1, 4);
    // Rows of the upper half hold one value each, so that they match one another well.
    index.as_mut_slice()[..24 * 48].iter_mut().enumerate().for_each(|(i, v)| *v = (i / 48) as f32);
    let exemplars = [Exemplar { index: &index, excluded: None }];
    // The sum of squared counts of blocks of 8 x 8: minimal if all are used equally.
    let unevenness = |uniformity| {
        let options = PatchMatchOptions {
            size: Size::new(96, 96),
            window: 7,
            levels: 2,
            rounds: 3,
            uniformity,
            ..Default::default()
        };
        let (map, _) = patch_match(&exemplars, &options, &Job::default()).unwrap();
        let mut counts = [0usize; 36];
        map.copies().iter().for_each(|from| counts[(from.y / 8 * 6 + from.x / 8) as usize] += 1);
        counts.into_iter().map(|count| count * count).sum::<usize>()
    };
    let (without, with) = (unevenness(0.0), unevenness(1.0));
    assert!(10 * with < 9 * without, "{without} without, {with} with");
}

#[test]
fn meaningless_options_are_refused() {
    let good = PatchMatchOptions::default();
    assert!(good.validate().is_ok());
    let bad = [
        PatchMatchOptions { window: 4, ..good.clone() },
        PatchMatchOptions { levels: 0, ..good.clone() },
        PatchMatchOptions { rounds: 0, ..good.clone() },
        PatchMatchOptions { uniformity: f64::NAN, ..good.clone() },
        PatchMatchOptions { size: Size::new(300, 8), ..good },
    ];
    assert!(bad.iter().all(|options| options.validate().is_err()));
    let index = noise(Size::new(40, 70), 1, 1);
    let exemplars = [Exemplar { index: &index, excluded: None }];
    let levels = |size, window| {
        let options = PatchMatchOptions { size, window, ..Default::default() };
        options.fitting_levels(&exemplars)
    };
    assert_eq!(levels(Size::new(90, 90), 9), 3, "the exemplar is 10 texels wide at the third");
    assert_eq!(levels(Size::new(19, 90), 9), 2);
    assert_eq!(levels(Size::new(90, 90), 41), 1);
}
