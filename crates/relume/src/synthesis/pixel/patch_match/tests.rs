use proptest::prelude::*;

use super::*;
use crate::planes::Planes;

fn noise(size: Size, planes: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, 1);
    let data = (0..size.texels() * planes).map(|_| stream.below(60) as f32).collect();
    Planes::from_vec(size, planes, data).unwrap()
}

/// A round that does not care how often patches are used.
fn how(search: PatchSearch, seed: u64) -> Improvement {
    Improvement { search, uniformity: 0.0, seed }
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
        let make = || patch_match(&exemplars, &options, &Limits::default(), &()).unwrap();
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
        let limits = Limits::default();
        let level = &pyramid(&exemplars, 1, 3, &limits).unwrap()[0];
        let patches = Patches::new(level, 2 * half + 1, &limits).unwrap();
        let size = Size::new(width, height);
        let mut lattice = Lattice::new(size, planes, Boundary::Torus, &limits).unwrap();
        let mut matching = begin(&mut lattice, level, &patches, None, seed);
        let mut full = matching.clone();
        full.improve(&lattice, &patches, how(PatchSearch::Full, 0));
        let mut before = vec![u64::MAX; matching.count()];
        for round in 0..4 {
            matching.improve(&lattice, &patches, how(PatchSearch::Propagation, round));
            let now: Vec<u64> = matching.distances().collect();
            prop_assert!(now.iter().zip(&before).all(|(now, before)| now <= before));
            prop_assert!(now.iter().zip(full.distances()).all(|(now, least)| *now >= least));
            before = now;
        }
    }
}

#[test]
fn patches_of_the_exemplar_itself_are_found_by_propagation() {
    // On a torus of the exemplar's own content almost every patch has a match of distance zero.
    let index = noise(Size::new(64, 64), 3, 7);
    let exemplars = [Exemplar { index: &index, excluded: None }];
    let limits = Limits::default();
    let level = &pyramid(&exemplars, 1, 7, &limits).unwrap()[0];
    let patches = Patches::new(level, 7, &limits).unwrap();
    let mut lattice = Lattice::new(Size::new(64, 64), 3, Boundary::Torus, &limits).unwrap();
    let mut matching = begin(&mut lattice, level, &patches, None, 3);
    for texel in 0..64 * 64 {
        lattice.put(
            texel,
            Texel { exemplar: 0, y: (texel / 64) as u32, x: (texel % 64) as u32 },
            &level.exemplars,
        );
    }
    for round in 0..20 {
        matching.improve(&lattice, &patches, how(PatchSearch::Propagation, round));
    }
    let exact = matching.distances().filter(|distance| *distance == 0).count();
    // Those that cross the border, at most 4 of 32 cells either way, have none.
    assert!(exact >= 28 * 28, "{exact} of {}", matching.count());
}

#[test]
fn a_texel_wanted_by_all_is_taken_and_else_the_one_nearest_to_the_mean() {
    let index = Planes::from_vec(Size::new(9, 9), 1, (0..81).map(|i| (i * i % 83) as f32).collect()).unwrap();
    let exemplars = [Exemplar { index: &index, excluded: None }];
    let limits = Limits::default();
    let level = &pyramid(&exemplars, 1, 3, &limits).unwrap()[0];
    let patches = Patches::new(level, 3, &limits).unwrap();
    let size = Size::new(6, 4);
    let mut lattice = Lattice::new(size, 1, Boundary::Torus, &limits).unwrap();
    let numbers: Vec<u32> = (0..6).map(|cell| (cell * 17 + 3) % patches.count() as u32).collect();
    let matching = Matching::new(size, numbers);
    (0..24).for_each(|texel| lattice.put(texel, Texel::default(), &level.exemplars));
    votes::cast(&mut lattice, level, &patches, &matching);
    let value = |t: Texel| f64::from(index.at(0, t.x as usize, t.y as usize));
    for texel in 0..24usize {
        let mut wanted = Vec::new();
        for (cell, (mx, my)) in Matching::middles(size).enumerate() {
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                let under = ((mx as isize + dx).rem_euclid(6), (my as isize + dy).rem_euclid(4));
                if under == ((texel % 6) as isize, (texel / 6) as isize) {
                    wanted.push(patches.place(matching.at((mx, my))).moved(dx, dy).unwrap());
                    assert!(cell < 6);
                }
            }
        }
        let mean = wanted.iter().map(|t| value(*t)).sum::<f64>() / wanted.len() as f64;
        let least = wanted.iter().map(|t| (value(*t) - mean).abs()).fold(f64::INFINITY, f64::min);
        assert!(wanted.contains(&lattice.source(texel)));
        assert!(((value(lattice.source(texel)) - mean).abs() - least).abs() < 1e-9);
    }
}

#[test]
fn uniformity_spreads_the_use_of_the_exemplar() {
    let mut index = noise(Size::new(48, 48), 1, 4);
    // Rows of the upper half hold one value each, so that they match one another well.
    index.as_mut_slice()[..24 * 48].iter_mut().enumerate().for_each(|(i, v)| *v = (i / 48) as f32);
    let exemplars = [Exemplar { index: &index, excluded: None }];
    // The sum of squared counts of blocks of 8 x 8: the least where all are used alike.
    let unevenness = |uniformity| {
        let options =
            PatchMatchOptions { size: Size::new(96, 96), levels: 2, uniformity, ..Default::default() };
        let (map, _) = patch_match(&exemplars, &options, &Limits::default(), &()).unwrap();
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
        PatchMatchOptions { size: Size::new(300, 31), ..good },
    ];
    assert!(bad.iter().all(|options| options.validate().is_err()));
}
