//! Stones of a sample that is drawn with every texel known to be of a joint or of a stone.

use super::{ElementOptions, lay};
use crate::job::Job;
use crate::numeric::lattice::Lattice;
use crate::numeric::random::{Purpose, Stream};
use crate::planes::Planes;
use crate::size::Size;
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::Exemplar;

/// What a texel shows: a joint, or the stone of a cell.
type TexelTruth = Option<[i64; 2]>;

/// A sample whose stones have shades of their own and grain, with the truth of each texel.
struct Sample {
    planes: Planes,
    shown: Vec<TexelTruth>,
}

/// The stone at a position of running bond, or of square tiles without a shift, with joints of 4 texels around
/// the lines of the lattice.
fn stone(x: f64, y: f64, [width, height]: [f64; 2], shift: f64) -> TexelTruth {
    let row = (y / height).floor();
    let column = ((x - row * shift) / width).floor();
    let (u, v) = (x - row * shift - column * width, y - row * height);
    let inside = u.min(v).min(width - u).min(height - v) >= 2.0;
    inside.then_some([column as i64, row as i64])
}

fn sample(size: Size, cell: [f64; 2], shift: f64, corner: [f64; 2]) -> Sample {
    let mut grain = Stream::new(5, Purpose::Sample, [1]);
    let at = |t: usize| [(t % size.width) as f64 + corner[0], (t / size.width) as f64 + corner[1]];
    let shown: Vec<TexelTruth> =
        (0..size.texels()).map(|t| stone(at(t)[0] + 0.25, at(t)[1] + 0.25, cell, shift)).collect();
    let value = |shown: &TexelTruth| {
        let noise = 0.04 * (grain.unit() as f32 - 0.5);
        let shade = |cell: [i64; 2]| Stream::new(9, Purpose::Sample, cell.map(|c| c as u64)).unit() as f32;
        noise + shown.map_or(0.1, |cell| 0.4 + 0.5 * shade(cell))
    };
    let data = shown.iter().map(value).collect();
    Sample { planes: Planes::from_vec(size, 1, data).unwrap(), shown }
}

/// Lays a sample and checks every texel: in each cell of the output there is one stone, whole, and around it
/// joints. Returns the number of different stones. Texels within `slack` of the border between joint and stone
/// may be either.
fn assert_whole(
    sample: &Sample,
    options: &ElementOptions,
    cell: [f64; 2],
    shift: f64,
    corner: [f64; 2],
    slack: f64,
) -> usize {
    let exemplar = Exemplar { index: &sample.planes, excluded: None };
    let (map, report) = lay(&exemplar, options, &Job::default()).unwrap();
    assert!(report.has_joints() && report.joint_contrast < 0.3, "{report:?}");
    let mut stones = std::collections::BTreeMap::new();
    for (t, copy) in map.copies().iter().enumerate() {
        let (x, y) = (
            (t % options.size.width) as f64 + corner[0] + 0.25,
            (t / options.size.width) as f64 + corner[1] + 0.25,
        );
        let around = [[-slack, -slack], [slack, slack], [-slack, slack], [slack, -slack]];
        let truth: Vec<TexelTruth> = around.iter().map(|[i, j]| stone(x + i, y + j, cell, shift)).collect();
        if truth.iter().any(|shown| *shown != truth[0]) {
            continue;
        }
        let from = sample.shown[map.exemplars()[0].index(copy.x as usize, copy.y as usize)];
        assert_eq!(
            truth[0].is_some(),
            from.is_some(),
            "({x}, {y}) shows {from:?} where {:?} belongs",
            truth[0]
        );
        if let (Some(place), Some(from)) = (truth[0], from) {
            let first = *stones.entry(place).or_insert(from);
            assert_eq!(first, from, "the stone at {place:?} has parts of two");
        }
    }
    let mut kinds: Vec<[i64; 2]> = stones.into_values().collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds.len()
}

fn upright(width: f64, height: f64, shift: f64) -> Option<Lattice> {
    Lattice::new([width, 0.0], [shift, height])
}

#[test]
fn two_by_two_stones_are_laid_whole_in_any_order() {
    let (size, cell) = (Size::new(128, 128), [64.0, 64.0]);
    for corner in [[0.0, 0.0], [1.0, 2.0]] {
        let sample = sample(size, cell, 0.0, corner);
        for (seed, side) in [(0, 192), (1, 256)] {
            let size = Size::new(side, side);
            let options =
                ElementOptions { size, seed, lattice: upright(64.0, 64.0, 0.0), ..Default::default() };
            assert_eq!(assert_whole(&sample, &options, cell, 0.0, corner, 1.5), 4);
        }
    }
}

/// Of stones that are alike in shade the lattice need not be known, although two repeats leave it uncertain.
#[test]
fn the_lattice_of_two_by_two_stones_is_found() {
    let (cell, corner) = ([64.0, 64.0], [62.0, 61.0]);
    let mut sample = sample(Size::new(140, 140), cell, 0.0, corner);
    let mut grain = Stream::new(5, Purpose::Sample, [2]);
    for (value, shown) in sample.planes.as_mut_slice().iter_mut().zip(&sample.shown) {
        let shade = shown.map_or(0.1, |[i, j]| 0.6 + 0.05 * ((i + 2 * j) % 4) as f32);
        *value = shade + 0.04 * (grain.unit() as f32 - 0.5);
    }
    let options = ElementOptions { size: Size::new(192, 192), ..ElementOptions::default() };
    assert_eq!(assert_whole(&sample, &options, cell, 0.0, corner, 2.5), 4);
}

#[test]
fn stones_cut_by_the_sample_are_left_out() {
    let (size, cell, corner) = (Size::new(150, 140), [50.0, 44.0], [20.0, 9.0]);
    let sample = sample(size, cell, 0.0, corner);
    let options =
        ElementOptions { size: Size::new(200, 200), lattice: upright(50.0, 44.0, 0.0), ..Default::default() };
    assert_eq!(assert_whole(&sample, &options, cell, 0.0, corner, 1.5), 4);
}

#[test]
fn bricks_in_running_bond_are_laid_whole() {
    let (size, cell, corner) = (Size::new(160, 120), [60.0, 24.0], [7.0, 5.0]);
    let sample = sample(size, cell, 30.0, corner);
    let size = Size::new(240, 192);
    let options = ElementOptions { size, lattice: upright(60.0, 24.0, 30.0), ..Default::default() };
    assert!(assert_whole(&sample, &options, cell, 30.0, corner, 1.5) >= 6);
    // Twice the height closes on itself.
    let tiling = ElementOptions { boundary: Boundary::Torus, ..options };
    assert!(assert_whole(&sample, &tiling, cell, 30.0, corner, 1.5) >= 6);
}

/// Were cut across: of two or three boards that differ little, the variance is small by chance in places other than
/// joints. The joints of this sample have one colour.
#[test]
fn planks_of_which_few_are_shown_are_laid_whole() {
    let (size, cell, shift, corner) = (Size::new(200, 128), [150.0, 32.0], 50.0, [20.0, 7.0]);
    let mut sample = sample(size, cell, shift, corner);
    let mut grain = Stream::new(5, Purpose::Sample, [3]);
    for (t, (value, shown)) in sample.planes.as_mut_slice().iter_mut().zip(&sample.shown).enumerate() {
        let noise = 0.04 * (grain.unit() as f32 - 0.5);
        let Some(board) = shown else {
            *value = 0.25 + noise;
            continue;
        };
        // Streaks along the board, of its own.
        let mut own = Stream::new(7, Purpose::Sample, board.map(|c| c as u64));
        let [shade, phase, bend] = [own.unit() as f32, own.unit() as f32, own.unit() as f32];
        let (x, y) = ((t % size.width) as f32, (t / size.width) as f32);
        let streak = (6.0 * phase + 0.45 * y + 2.0 * bend * (0.03 * x).sin()).sin();
        *value = 0.55 + 0.08 * (shade - 0.5) + 0.06 * streak + noise;
    }
    let options = ElementOptions {
        size: Size::new(300, 160),
        lattice: upright(150.0, 32.0, 50.0),
        ..Default::default()
    };
    assert_eq!(assert_whole(&sample, &options, cell, shift, corner, 1.5), 1);
}

#[test]
fn what_cannot_be_laid_is_refused_in_words() {
    let sample = sample(Size::new(100, 100), [64.0, 64.0], 0.0, [30.0, 30.0]);
    let exemplar = Exemplar { index: &sample.planes, excluded: None };
    let says = |options: ElementOptions, words: &str| {
        let error = lay(&exemplar, &options, &Job::default()).unwrap_err();
        assert!(error.message().contains(words), "{error}");
    };
    let known = ElementOptions { lattice: upright(64.0, 64.0, 0.0), ..ElementOptions::default() };
    says(
        ElementOptions { boundary: Boundary::Torus, size: Size::new(200, 192), ..known.clone() },
        "whole periods",
    );
    says(ElementOptions { lattice: upright(120.0, 120.0, 0.0), ..known.clone() }, "no element whole");
    says(ElementOptions { lattice: upright(6.0, 6.0, 0.0), ..known.clone() }, "too small");
    says(ElementOptions { size: Size::new(0, 4), ..known }, "at least 1");
    let noise: Vec<f32> = (0..10_000).map(|t| Stream::new(t, Purpose::Sample, [0]).unit() as f32).collect();
    let noise = Planes::from_vec(Size::new(100, 100), 1, noise).unwrap();
    let exemplar = Exemplar { index: &noise, excluded: None };
    let error = lay(&exemplar, &ElementOptions::default(), &Job::default()).unwrap_err();
    assert!(error.message().contains("no lattice"), "{error}");
}
