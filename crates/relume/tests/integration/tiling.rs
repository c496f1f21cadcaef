//! Textures that are to tile do, by every method and verb, at sizes of every kind.

use relume::numeric::random::{Purpose, Stream};
use relume::synthesis::fill::{FillMethod, FillOptions, tileable};
use relume::synthesis::pixel::{EfrosLeungOptions, NeighbourSearch, PatchMatchOptions, WeiLevoyOptions};
use relume::synthesis::{BlockOptions, Boundary, Exemplar, SourceMap};
use relume::workflow::Plan;
use relume::workflow::tiling::MeasuredTiling;
use relume::{Job, Planes, Size};

/// Smooth random spots, two planes: noise averaged three times over squares of 7 texels, so that a jump of one
/// texel is seen.
fn spots(size: Size, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, Purpose::Sample, [0]);
    let data = (0..2 * size.texels()).map(|_| stream.unit() as f32).collect();
    let mut planes = Planes::from_vec(size, 2, data).unwrap();
    for _ in 0..3 {
        let before = planes.clone();
        for (k, plane) in planes.iter_mut().enumerate() {
            for (t, value) in plane.iter_mut().enumerate() {
                let (x, y) = (t % size.width, t / size.width);
                let near = |at: usize, by: usize, length: usize| (at + length + by - 3) % length;
                let sum: f32 = (0..49)
                    .map(|i| before.at(k, near(x, i % 7, size.width), near(y, i / 7, size.height)))
                    .sum();
                *value = sum / 49.0;
            }
        }
    }
    planes
}

/// Sizes that halve evenly, and those that do not: odd at the first or at later levels, primes among them.
const SIZES: [(usize, usize); 6] = [(128, 96), (129, 128), (97, 113), (96, 97), (101, 127), (100, 122)];

fn plans(size: Size) -> Vec<Plan> {
    let boundary = Boundary::Torus;
    vec![
        Plan::PatchMatch(PatchMatchOptions { size, seed: 1, ..PatchMatchOptions::default() }),
        Plan::WeiLevoy(
            WeiLevoyOptions {
                size,
                search: NeighbourSearch::Coherence { candidates: 1, codewords: 0 },
                ..WeiLevoyOptions::default()
            },
            boundary,
        ),
        Plan::Quilting(BlockOptions { size, block: 24, overlap: 8, boundary, ..BlockOptions::default() }),
    ]
}

fn measured(map: &SourceMap, index: &Planes) -> MeasuredTiling {
    MeasuredTiling::measure(map, &[index], &Job::default()).unwrap()
}

/// The optimisation by patches once began each level with the doubled coarser one, of which it dropped the last
/// column where sides did not halve evenly: the borders of 129, 97 and 241 texels showed.
#[test]
fn every_method_closes_at_sizes_that_do_not_halve_evenly() {
    let index = spots(Size::new(90, 84), 3);
    let exemplars = [Exemplar { index: &index, excluded: None }];
    for (width, height) in SIZES {
        for plan in plans(Size::new(width, height)) {
            let made = plan.run(&exemplars, &Job::default()).unwrap();
            let tiling = measured(&made.map, &index);
            assert!(!tiling.shows, "{:?} at {width} x {height}: {tiling:?}", plan.method());
        }
    }
}

#[test]
fn growth_from_a_seed_closes_at_sizes_that_do_not_halve_evenly() {
    let index = spots(Size::new(60, 57), 4);
    let exemplars = [Exemplar { index: &index, excluded: None }];
    for (width, height) in [(61, 64), (64, 61)] {
        let options = EfrosLeungOptions {
            size: Size::new(width, height),
            boundary: Boundary::Torus,
            ..EfrosLeungOptions::default()
        };
        let made = Plan::EfrosLeung(options).run(&exemplars, &Job::default()).unwrap();
        assert!(!measured(&made.map, &index).shows, "{width} x {height}: {:?}", measured(&made.map, &index));
    }
}

/// A texture made to tile keeps its middle, and its borders, which jump before, do not show.
#[test]
fn textures_made_to_tile_close_at_sizes_that_do_not_halve_evenly() {
    for (width, height) in SIZES {
        let size = Size::new(width, height);
        let whole = spots(Size::new(width + 40, height + 40), 5);
        let data = (0..2 * size.texels()).map(|i| {
            let (k, t) = (i / size.texels(), i % size.texels());
            whole.at(k, t % width, t / width)
        });
        let index = Planes::from_vec(size, 2, data.collect()).unwrap();
        let exemplar = Exemplar { index: &index, excluded: None };
        let options = FillOptions { method: FillMethod::Bridges, ..FillOptions::default() };
        let (map, growth) = tileable(exemplar, 12, &options, &Job::default()).unwrap();
        assert!(growth.texels > 0);
        for (t, from) in map.copies().iter().enumerate() {
            let (x, y) = (t % width, t / width);
            let is_middle = (12..width - 12).contains(&x) && (12..height - 12).contains(&y);
            assert!(!is_middle || (from.x as usize, from.y as usize) == (x, y), "({x}, {y})");
        }
        assert!(!measured(&map, &index).shows, "{size}: {:?}", measured(&map, &index));
    }
}

/// What the verbs say of their result is measured on it: a texture that only claims to tile is found out.
#[test]
fn a_border_that_jumps_is_measured() {
    let whole = spots(Size::new(130, 130), 6);
    let exemplars = [Exemplar { index: &whole, excluded: None }];
    let options = BlockOptions { size: Size::new(80, 80), block: 24, overlap: 8, ..BlockOptions::default() };
    let open = Plan::Quilting(options).run(&exemplars, &Job::default()).unwrap();
    assert!(measured(&open.map, &whole).shows);
}

/// A hundredth of the exemplar marked as excluded once left no patch at the coarser levels, and was refused.
#[test]
fn small_marks_do_not_end_the_optimisation_by_patches() {
    let index = spots(Size::new(128, 128), 7);
    let mask: Vec<bool> = (0..128 * 128).map(|t| t % 128 % 32 < 3 && t / 128 % 32 < 3).collect();
    let exemplars = [Exemplar { index: &index, excluded: Some(&mask) }];
    let options = PatchMatchOptions { size: Size::new(96, 97), ..PatchMatchOptions::default() };
    let made = Plan::PatchMatch(options).run(&exemplars, &Job::default()).unwrap();
    assert!(made.map.copies().iter().all(|from| !mask[from.y as usize * 128 + from.x as usize]));
    assert!(!measured(&made.map, &index).shows);
    // Where only a corner may be copied, there are as many levels as have room for patches.
    let corner: Vec<bool> = (0..128 * 128).map(|t| t % 128 >= 40 || t / 128 >= 40).collect();
    let exemplars = [Exemplar { index: &index, excluded: Some(&corner) }];
    let options = PatchMatchOptions { size: Size::new(96, 97), ..PatchMatchOptions::default() };
    let made = Plan::PatchMatch(options).run(&exemplars, &Job::default()).unwrap();
    assert!(made.map.copies().iter().all(|from| from.x < 40 && from.y < 40));
}
