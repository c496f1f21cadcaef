use proptest::prelude::*;

use super::super::pyramid::pyramid;
use super::*;
use crate::planes::Planes;
use crate::synthesis::pixel::vectors::squared_distance;
use crate::synthesis::source_map::Texel;

fn noise_planes(size: Size, planes: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, Purpose::Sample, [1]);
    let data = (0..size.texels() * planes).map(|_| stream.below(60) as f32).collect();
    Planes::from_vec(size, planes, data).unwrap()
}

/// The method as described in the paper for one level: plain loops, no vectors.
fn one_level_by_hand(index: &Planes, options: &WeiLevoyOptions) -> Vec<Texel> {
    let (size, radius) = (options.size, options.window as isize / 2);
    let from = index.size();
    let inside = |at: usize, length: usize| at >= radius as usize && at + (radius as usize) < length;
    let places: Vec<(usize, usize)> = (0..from.height)
        .flat_map(|y| (0..from.width).map(move |x| (x, y)))
        .filter(|&(x, y)| inside(x, from.width) && inside(y, from.height))
        .collect();
    let mut out: Vec<(usize, usize)> = Vec::new();
    for y in 0..size.height {
        let mut stream = Stream::new(options.seed, Purpose::ScanlineNoise, [0, y as u64]);
        out.extend((0..size.width).map(|_| places[stream.below(places.len())]));
    }
    for texel in 0..size.texels() {
        let (x, y) = ((texel % size.width) as isize, (texel / size.width) as isize);
        let offsets: Vec<(isize, isize)> = (-radius..=0)
            .flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy)))
            .filter(|&(dx, dy)| dy < 0 || dx < 0)
            .collect();
        let distance = |&(px, py): &(usize, usize)| -> i64 {
            let offsets = offsets.iter().flat_map(|&(dx, dy)| (0..index.count()).map(move |k| (dx, dy, k)));
            let square = |(dx, dy, k): (isize, isize, usize)| {
                let wrapped = (x + dx).rem_euclid(size.width as isize)
                    + (y + dy).rem_euclid(size.height as isize) * size.width as isize;
                let (ox, oy) = out[wrapped as usize];
                let theirs = index.at(k, (px as isize + dx) as usize, (py as isize + dy) as usize);
                (i64::from(index.at(k, ox, oy) as i16) - i64::from(theirs as i16)).pow(2)
            };
            offsets.map(square).sum()
        };
        out[texel] = *places.iter().min_by_key(|place| distance(place)).unwrap();
    }
    out.into_iter().map(|(x, y)| Texel { exemplar: 0, y: y as u32, x: x as u32 }).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(25))]

    #[test]
    fn one_level_with_full_search_is_the_method_by_hand(
        (width, height, seed) in (3usize..19, 3usize..14, any::<u32>()),
        (extra_x, extra_y, planes, half) in (2usize..9, 2usize..7, 1usize..4, 1usize..3),
    ) {
        let window = 2 * half + 1;
        // Every level of 0 to 59 must occur for codes to be the values.
        let mut index = noise_planes(Size::new(window + extra_x, window + extra_y), planes, u64::from(seed));
        index.as_mut_slice()[..4].copy_from_slice(&[0.0, 1.0, 59.0, 2.0]);
        (0..planes).for_each(|k| index.plane_mut(k)[5] = 0.0);
        let size = Size::new(width.max(window), height.max(window));
        let options =
            WeiLevoyOptions { size, window, levels: 1, search: NeighbourSearch::Full, guidance: None, seed: u64::from(seed) };
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let (map, _) = wei_levoy(&exemplars, &options, &Job::default()).unwrap();
        prop_assert_eq!(map.copies(), one_level_by_hand(&index, &options));
    }

    #[test]
    fn a_tree_of_one_leaf_is_the_full_search_and_threads_change_nothing(
        (width, height, seed) in (12usize..30, 12usize..30, any::<u32>()),
        (extra, planes, levels, masked) in (0usize..9, 1usize..4, 1usize..3, any::<bool>()),
    ) {
        let fields = [0, 1].map(|e| noise_planes(Size::new(14 + extra, 16 + e), planes, u64::from(seed) ^ e as u64));
        let masks = fields.each_ref().map(|f| (0..f.size().texels()).map(|i| masked && i == 0).collect::<Vec<_>>());
        let exemplars = [0, 1].map(|e| Exemplar { index: &fields[e], excluded: Some(&masks[e]) });
        let size = Size::new(width, height);
        let with = |search| {
            let options = WeiLevoyOptions { size, window: 5, levels, search, guidance: None, seed: u64::from(seed) };
            wei_levoy(&exemplars, &options, &Job::default()).unwrap()
        };
        let full = with(NeighbourSearch::Full);
        let one = with(NeighbourSearch::Tsvq(1));
        prop_assert_eq!((&full.0, full.1.distance), (&one.0, one.1.distance));
        let tree = with(NeighbourSearch::Tsvq(30));
        for threads in [1, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            prop_assert_eq!(&pool.install(|| with(NeighbourSearch::Tsvq(30))), &tree);
            prop_assert_eq!(&pool.install(|| with(NeighbourSearch::Full)), &full);
        }
        for from in full.0.copies().iter().chain(tree.0.copies()).filter(|_| masked) {
            prop_assert!((from.x, from.y) != (0, 0));
        }
    }
}

/// One level by candidates, as Tong et al. describe it: plain loops, no tables.
fn coherent_by_hand(
    samples: &ScanSamples,
    canvas: &PixelCanvas,
    texel: usize,
    count: usize,
) -> Option<(u64, usize)> {
    let (x, y) = canvas.place(texel);
    let causal = (-2..=0).flat_map(|dy| (-2..=2).map(move |dx| (dx, dy))).filter(|at| at.1 < 0 || at.0 < 0);
    let mut nearest = None;
    let mut query = Vec::new();
    ScanNeighbourhood::new(5, false, 0).of_output(canvas, None, texel, &mut query);
    for (dx, dy) in causal {
        let from = canvas.source(canvas.beside((x, y), dx, dy).unwrap());
        let continued = from.moved(-dx, -dy);
        let Some(own) = samples.places.iter().position(|place| Some(*place) == continued) else { continue };
        let alike = |n: usize| squared_distance(samples.vectors.row(own), samples.vectors.row(n));
        let mut set: Vec<usize> = (0..samples.places.len()).collect();
        set.sort_by_key(|&n| (n != own, alike(n), n));
        for &n in &set[..count.min(set.len())] {
            let found = (squared_distance(&query, samples.vectors.row(n)), n);
            nearest = Some(nearest.map_or(found, |nearest: (u64, usize)| nearest.min(found)));
        }
    }
    nearest
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn candidates_are_the_continuations_and_those_most_like_them(
        (width, height, seed) in (5usize..14, 5usize..12, any::<u64>()),
        (extra, planes, count) in (0usize..6, 1usize..4, 1usize..6),
    ) {
        let index = noise_planes(Size::new(7 + extra, 8), planes, seed);
        let exemplars = [Exemplar { index: &index, excluded: None }];
        let job = Job::default();
        let level = &pyramid(&exemplars, 1, 5, &job).unwrap()[0];
        let neighbourhood = ScanNeighbourhood::new(5, false, 0);
        let samples = ScanSamples::new(&neighbourhood, level, None, &job).unwrap();
        let causal = neighbourhood.causal();
        let draws = Draws { seed, level: 0 };
        let search =
            Coherence::new(&samples, &causal, &[index.size()], (count, 0), draws, &job).unwrap();
        let canvas = noise(level, &samples, Size::new(width, height), draws, &job).unwrap();
        let mut query = Vec::new();
        for texel in 0..width * height {
            neighbourhood.of_output(&canvas, None, texel, &mut query);
            let (number, distance) = search.near(&query, Here { canvas: &canvas, coarser: None, texel });
            if let Some(truth) = coherent_by_hand(&samples, &canvas, texel, count) {
                prop_assert_eq!((distance, number), truth);
            }
        }
    }

    #[test]
    fn few_candidates_give_copies_that_do_not_depend_on_threads(
        (width, height, seed) in (10usize..20, 10usize..20, any::<u64>()),
        (planes, levels, count) in (1usize..4, 1usize..3, 1usize..9),
    ) {
        let index = noise_planes(Size::new(14, 13), planes, seed);
        let exemplars = [Exemplar { index: &index, excluded: None }];
        for codewords in [0, 7] {
            let search = NeighbourSearch::Coherence { candidates: count, codewords };
            let options = WeiLevoyOptions { size: Size::new(width, height), window: 5, levels, search, guidance: None, seed };
            let make = || wei_levoy(&exemplars, &options, &Job::default()).unwrap();
            let truth = make();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
            prop_assert_eq!(&pool.install(make), &truth);
            prop_assert!(truth.0.copies().iter().all(|from| from.x < 14 && from.y < 13));
        }
    }
}

#[test]
fn the_full_search_finds_the_first_of_the_nearest() {
    let mut stream = Stream::new(2, Purpose::Sample, [0]);
    let mut vectors = super::super::vectors::Vectors::with_capacity(70, 9000);
    (0..9000).for_each(|_| vectors.push(&std::array::from_fn::<i16, 70, _>(|_| stream.below(3) as i16)));
    for n in [0, 5, 4095, 4096, 8999] {
        let query = vectors.row(n).to_vec();
        let distances = (0..9000).map(|i| (squared_distance(vectors.row(i), &query), i));
        let (distance, number) = distances.min().unwrap();
        assert_eq!(Full { vectors: &vectors }.nearest(&query), (number, distance));
    }
}

#[test]
fn meaningless_options_are_refused() {
    let good = WeiLevoyOptions::default();
    assert!(good.validate().is_ok());
    let bad = [
        WeiLevoyOptions { window: 4, ..good.clone() },
        WeiLevoyOptions { levels: 0, ..good.clone() },
        WeiLevoyOptions { levels: 17, ..good.clone() },
        WeiLevoyOptions { search: NeighbourSearch::Tsvq(0), ..good.clone() },
        WeiLevoyOptions {
            search: NeighbourSearch::Coherence { candidates: 0, codewords: 9 },
            ..good.clone()
        },
        WeiLevoyOptions { size: Size::new(300, 31), ..good.clone() },
        WeiLevoyOptions { size: Size::new(0, 31), levels: 1, ..good },
    ];
    for options in bad {
        assert!(options.validate().is_err(), "{options:?}");
    }
}
