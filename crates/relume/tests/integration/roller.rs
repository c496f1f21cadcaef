//! The Roller: the promises of a tile set.

use proptest::prelude::*;
use relume::numeric::cells::Cells;
use relume::numeric::lattice::Lattice;
use relume::numeric::periods::Pattern;
use relume::numeric::random::{Purpose, Stream};
use relume::synthesis::roller::{Endless, Rolled, RollerOptions, lay, roll};
use relume::synthesis::{Boundary, Exemplar, gather};
use relume::{Job, Limits, Picture, Planes, ReflectanceField, Size, Space};

fn noise(size: Size, planes: usize, seed: u64) -> Planes {
    let mut stream = Stream::new(seed, Purpose::Sample, [0]);
    let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
    Planes::from_vec(size, planes, data).unwrap()
}

fn make(index: &Planes, options: &RollerOptions) -> Rolled {
    roll(&Exemplar { index, excluded: None }, options, &Job::default()).unwrap()
}

/// The tiles of a picture as planes, one below the other.
fn stacked(rolled: &Rolled, index: &Planes) -> Planes {
    let field = ReflectanceField::from_picture(Picture { planes: index.clone(), space: Space::Linear });
    gather(rolled.tiles.map(), &[&field], &Job::default()).unwrap().coefficients().clone()
}

#[test]
fn a_texture_that_repeats_exactly_goes_on_exactly() {
    for (period, seed) in [(Size::new(13, 9), 1), (Size::new(7, 16), 2), (Size::new(20, 20), 3)] {
        let index = noise(period, 3, seed).repeated(16, 12).crop(2, 1, Size::new(100, 90)).unwrap();
        let rolled = make(&index, &RollerOptions { tiles: 4, ..RollerOptions::default() });
        let tile = rolled.tiles.tile();
        assert_eq!((tile.width % period.width, tile.height % period.height), (0, 0), "{tile}");
        assert!(
            rolled.report.whole_periods && rolled.report.first.unwrap().mismatch == 0.0,
            "{:?}",
            rolled.report
        );
        assert!(rolled.report.is_acceptable());
        let plane = Endless::new(tile, 4, 5).unwrap();
        let tiles = stacked(&rolled, &index);
        let window = plane.window(&tiles, -37, 211, Size::new(150, 140), &Job::default()).unwrap();
        let (right, down) = (period.width, period.height);
        for (x, y) in (0..150 - right).flat_map(|x| (0..140 - down).map(move |y| (x, y))) {
            for k in 0..3 {
                let here = window.at(k, x, y);
                assert_eq!((window.at(k, x + right, y), window.at(k, x, y + down)), (here, here));
            }
        }
    }
}

#[test]
fn oblique_periods_are_found_and_kept() {
    // A lattice like a checkerboard: rows shift by half a period, so whole periods along the axes are twice
    // as long as along the diagonals.
    let size = Size::new(140, 130);
    let (wide, high) = (18.0, 14.0);
    let value = |t: usize| {
        let (x, y) = ((t % 140) as f32, (t / 140) as f32);
        let (u, v) = (x / wide + y / high, x / wide - y / high);
        let tau = std::f32::consts::TAU;
        (0.5 * tau * u).sin() + 0.9 * (0.5 * tau * v).cos() + 0.3 * (tau * u).cos()
    };
    let index = Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap();
    let rolled = make(&index, &RollerOptions { tiles: 2, ..RollerOptions::default() });
    assert!(matches!(rolled.report.periods.pattern, Pattern::Lattice(_)), "{:?}", rolled.report.periods);
    let tile = rolled.tiles.tile();
    assert_eq!((tile.width % 18, tile.height % 14), (0, 0), "{tile}");
    assert!(rolled.report.first.unwrap().mismatch < 1e-3);
}

/// Noise that repeats in equal cells.
fn cellular(cells: &Cells, size: Size, planes: usize, seed: u64) -> Planes {
    let one = noise(cells.bounds(), planes, seed);
    let value = |k: usize, t: usize| {
        let place = cells.place([(t % size.width) as i64, (t / size.width) as i64]);
        one.plane(k)[cells.index(place.texel)]
    };
    let data = (0..planes).flat_map(|k| (0..size.texels()).map(move |t| (k, t)));
    Planes::from_vec(size, planes, data.map(|(k, t)| value(k, t)).collect()).unwrap()
}

/// No axis has a period within the exemplar, so no rectangle repeats; oblique cells do.
#[test]
fn oblique_periods_that_meet_no_axis_go_on_exactly() {
    for (right, down, seed) in [([23, 7], [-5, 26], 1), ([19, -4], [6, 22], 2), ([13, 5], [-8, 17], 3)] {
        let index = cellular(&Cells::new(right, down).unwrap(), Size::new(160, 150), 3, seed);
        for tiles in [1, 2, 4] {
            let upright = RollerOptions { tiles, ..RollerOptions::default() };
            let options = RollerOptions { oblique: true, ..upright.clone() };
            let rolled = make(&index, &options);
            let cells = *rolled.tiles.cells();
            assert!(
                !cells.are_upright() && rolled.report.first.unwrap().mismatch == 0.0,
                "{cells:?}: {:?}",
                rolled.report
            );
            assert!(make(&index, &upright).report.first.unwrap().mismatch > 0.2, "no rectangle repeats");
            let plane = Endless::of(cells, tiles, 5).unwrap();
            let made = stacked(&rolled, &index);
            let window = plane.window(&made, -90, 211, Size::new(120, 110), &Job::default()).unwrap();
            for [dx, dy] in [right, down] {
                for (x, y) in (30..90).flat_map(|x| (30..80).map(move |y| (x, y))) {
                    let there = ((x as i64 + dx) as usize, (y as i64 + dy) as usize);
                    for k in 0..2 {
                        assert_eq!(window.at(k, x, y), window.at(k, there.0, there.1), "{right:?}, {tiles}");
                    }
                }
            }
        }
    }
}

/// Was accepted as whole: (90, -1) is a period of (15, 3) and (0, 19), but in fine detail one texel is enough
/// to break it.
#[test]
fn a_rectangle_one_texel_off_its_periods_is_not_whole() {
    let index = cellular(&Cells::new([15, 3], [0, 19]).unwrap(), Size::new(110, 100), 2, 1);
    let options = RollerOptions { overlap: Some(1), oblique: true, ..RollerOptions::default() };
    let report = make(&index, &options).report;
    assert!(
        !report.first.unwrap().region.cells.are_upright() && report.first.unwrap().mismatch == 0.0,
        "{report:?}"
    );
}

/// A lattice between whole texels: cells follow it to less than one texel, where rectangles are off by
/// several.
#[test]
fn cells_lean_where_that_follows_the_periods_better() {
    let lattice = Lattice::new([23.4, 7.3], [-5.6, 26.1]).unwrap();
    let size = Size::new(200, 190);
    let tau = std::f64::consts::TAU;
    let value = |t: usize| {
        let [i, j] = lattice.coordinates([(t % 200) as f64, (t / 200) as f64]);
        let waves = (tau * i).sin() + (tau * j).cos() + 0.7 * (tau * (i + 2.0 * j)).sin();
        (waves + 0.5 * (tau * (2.0 * i - j) + 1.0).cos()) as f32
    };
    let index = Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap();
    let (upright, oblique) =
        (RollerOptions::default(), RollerOptions { oblique: true, ..Default::default() });
    let (upright, oblique) = (make(&index, &upright).report, make(&index, &oblique).report);
    assert!(
        oblique.first.unwrap().mismatch < 0.25 * upright.first.unwrap().mismatch,
        "{} against {}",
        oblique.first.unwrap().mismatch,
        upright.first.unwrap().mismatch
    );
    assert!(
        oblique.is_acceptable()
            && oblique.whole_periods
            && oblique.first.unwrap().region.cells.texels() > 9000
    );
    // Where a rectangle repeats, nothing is oblique.
    let straight = noise(Size::new(13, 9), 2, 1).repeated(8, 9);
    let report = make(&straight, &RollerOptions { oblique: true, ..Default::default() }).report;
    assert!(report.first.unwrap().region.cells.are_upright(), "{report:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Oblique tiles: copies from inside the exemplar, one border, the same at any number of threads. The
    /// cells are small enough for some vectors of their lattice to be steps of tiles.
    #[test]
    fn any_leaning_tile_may_lie_beside_any(
        (width, height, s, t) in (11i64..17, 11i64..17, -4i64..5, -4i64..5),
        (tiles, overlap, seed) in (1usize..4, 1usize..5, any::<u64>()),
    ) {
        let lattice = Cells::new([width, t], [s, height]).unwrap();
        let index = cellular(&lattice, Size::new(130, 120), 2, seed);
        let real = |step: [i64; 2]| step.map(|c| c as f64);
        let pattern = Lattice::new(real(lattice.right()), real(lattice.down())).map(Pattern::Lattice);
        let options = RollerOptions {
            tiles,
            overlap: Some(overlap),
            least_offset: 0.02,
            pattern,
            oblique: true,
            ..RollerOptions::default()
        };
        let rolled = make(&index, &options);
        let (cells, first) = (*rolled.tiles.cells(), rolled.tiles.sources(0));
        prop_assert!(rolled.report.first.unwrap().mismatch < 1e-9, "{:?}", rolled.report);
        for number in 0..tiles {
            for (place, source) in cells.rectangle().zip(rolled.tiles.sources(number)) {
                prop_assert!((source.x as usize) < 130 && (source.y as usize) < 120);
                let is_inner = cells.depth(place).is_some_and(|depth| depth > 0);
                prop_assert!(is_inner || *source == first[cells.index(place)], "{:?}", place);
            }
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        prop_assert_eq!(&pool.install(|| make(&index, &options)), &rolled);
    }

    /// Tiles of anything: copies from inside the exemplar, one border, nothing excluded, the same at
    /// any number of threads.
    #[test]
    fn any_tile_may_lie_beside_any(
        (width, height, planes, seed) in (40usize..70, 40usize..70, 1usize..4, any::<u64>()),
        (tiles, overlap, masked) in (1usize..5, 1usize..5, any::<bool>()),
    ) {
        let size = Size::new(width, height);
        let index = noise(size, planes, seed);
        let mask: Vec<bool> = (0..size.texels()).map(|t| t % width < 3 && t / width < 4).collect();
        let exemplar = Exemplar { index: &index, excluded: masked.then_some(&mask) };
        let options = RollerOptions {
            tiles,
            overlap: Some(overlap),
            least_offset: 0.05,
            pattern: Some(Pattern::None),
            ..RollerOptions::default()
        };
        let rolled = roll(&exemplar, &options, &Job::default()).unwrap();
        let tile = rolled.tiles.tile();
        prop_assert_eq!(rolled.tiles.count(), tiles);
        let first = rolled.tiles.sources(0);
        for number in 0..tiles {
            let sources = rolled.tiles.sources(number);
            for (t, source) in sources.iter().enumerate() {
                let (x, y) = (t % tile.width, t / tile.width);
                prop_assert!((source.x as usize) < width && (source.y as usize) < height);
                prop_assert!(!masked || !mask[size.index(source.x as usize, source.y as usize)]);
                let depth = x.min(y).min(tile.width - 1 - x).min(tile.height - 1 - y);
                prop_assert!(depth > 0 || *source == first[t], "tile {} at ({}, {})", number, x, y);
            }
            prop_assert!(number == 0 || sources != first);
        }
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let again = pool.install(|| roll(&exemplar, &options, &Job::default()).unwrap());
            prop_assert_eq!(&again, &rolled);
        }
    }
}

#[test]
fn what_has_no_room_or_no_meaning_is_refused() {
    let index = noise(Size::new(30, 24), 2, 1);
    let says = |options: RollerOptions, words: &str| {
        let exemplar = Exemplar { index: &index, excluded: None };
        let error = roll(&exemplar, &options, &Job::default()).unwrap_err();
        assert!(error.message().contains(words), "{error}");
    };
    says(RollerOptions { tiles: 9, overlap: Some(4), ..RollerOptions::default() }, "fewer tiles");
    says(RollerOptions { overlap: Some(28), ..RollerOptions::default() }, "smaller overlap");
    says(RollerOptions { tiles: 3, least_offset: 1.0, ..RollerOptions::default() }, "has room for");
    let all = vec![true; 30 * 24];
    let exemplar = Exemplar { index: &index, excluded: Some(&all) };
    let error = roll(&exemplar, &RollerOptions::default(), &Job::default()).unwrap_err();
    assert!(error.message().contains("mask"), "{error}");
    let tight = Job::new(Limits { max_bytes: 1000, ..Limits::default() });
    assert!(roll(&Exemplar { index: &index, excluded: None }, &RollerOptions::default(), &tight).is_err());
    for tiny in [Size::new(1, 1), Size::new(2, 1), Size::new(3, 3)] {
        let index = noise(tiny, 1, 2);
        let made =
            roll(&Exemplar { index: &index, excluded: None }, &RollerOptions::default(), &Job::default());
        assert!(made.is_err(), "{tiny} leaves no room for an overlap of two and a tile larger than it");
    }
}

/// Given periods were followed to a fifth of their length, and where none fitted, others were used.
#[test]
fn given_periods_are_followed_to_the_texel_or_refused() {
    let index = noise(Size::new(120, 110), 1, 3);
    let exemplar = Exemplar { index: &index, excluded: None };
    let with = |a: [f64; 2], b: [f64; 2], oblique: bool| {
        let pattern = Lattice::new(a, b).map(Pattern::Lattice);
        let options = RollerOptions { pattern, oblique, overlap: Some(4), ..RollerOptions::default() };
        roll(&exemplar, &options, &Job::default())
    };
    for (w, h) in [(24.0, 31.0), (17.3, 20.6), (100.0, 90.0)] {
        let made = with([w, 0.0], [0.0, h], false).unwrap();
        let tile = made.tiles.tile();
        for (side, period) in [(tile.width, w), (tile.height, h)] {
            let periods = (side as f64 / period).round().max(1.0);
            assert!((side as f64 - periods * period).abs() <= 0.71, "{tile} for periods of {w} and {h}");
        }
        assert!(made.report.whole_periods);
    }
    // One period, where there is no room for two.
    let pattern = Lattice::new([62.0, 0.0], [0.0, 57.0]).map(Pattern::Lattice);
    let options = RollerOptions { pattern, tiles: 1, overlap: Some(4), ..RollerOptions::default() };
    let made = roll(&exemplar, &options, &Job::default()).unwrap();
    assert_eq!(made.tiles.tile(), Size::new(62, 57));
    // No multiple of these lies within a texel of an axis.
    let slanted = ([40.0, 7.0], [-7.0, 40.0]);
    let error = with(slanted.0, slanted.1, false).unwrap_err();
    assert!(error.message().contains("no rectangle") && error.message().contains("(40, 7)"), "{error}");
    let cells = *with(slanted.0, slanted.1, true).unwrap().tiles.cells();
    let lattice = Lattice::new(slanted.0, slanted.1).unwrap();
    for step in [cells.right(), cells.down()].map(|step| step.map(|c| c as f64)) {
        let near = lattice.nearest(step);
        assert!((near[0] - step[0]).hypot(near[1] - step[1]) < 1e-9, "{cells:?}");
    }
    let error = with([200.0, 0.0], [0.0, 20.0], true).unwrap_err();
    assert!(error.message().contains("larger exemplar"), "{error}");
}

/// Sixteen tiles of a texture that does not repeat once had one border, which returned in every cell and showed
/// as rows of copies.
#[test]
fn the_borders_of_many_tiles_of_a_texture_that_does_not_repeat_vary() {
    let index = noise(Size::new(160, 150), 2, 6);
    let shared = RollerOptions { tiles: 18, pattern: Some(Pattern::None), ..RollerOptions::default() };
    let varied = RollerOptions { vary: true, ..shared.clone() };
    assert!(make(&index, &shared).report.common > 0.2);
    let rolled = make(&index, &varied);
    assert!(rolled.report.common < 0.01 && rolled.report.first.is_none(), "{:?}", rolled.report);
    let (tiles, corners) = (&rolled.tiles, rolled.tiles.corners());
    assert_eq!((tiles.count(), corners.count()), (18, 2));
    // Tiles that agree in the corners of an edge agree in the texels along it.
    let Size { width, height } = tiles.tile();
    let edge = |tile: usize, edge: usize| -> Vec<relume::synthesis::Texel> {
        let at = |x: usize, y: usize| tiles.sources(tile)[y * width + x];
        match edge {
            0 => (0..width).map(|x| at(x, 0)).collect(),
            1 => (0..width).map(|x| at(x, height - 1)).collect(),
            2 => (0..height).map(|y| at(0, y)).collect(),
            _ => (0..height).map(|y| at(width - 1, y)).collect(),
        }
    };
    const ENDS: [[usize; 2]; 4] = [[0, 1], [2, 3], [0, 2], [1, 3]];
    for (a, b) in (0..18).flat_map(|a| (0..18).map(move |b| (a, b))) {
        for (number, ends) in ENDS.into_iter().enumerate() {
            let [ours, theirs] = [a, b].map(|tile| ends.map(|end| corners.corners(tile)[end]));
            assert_eq!(
                ours == theirs,
                edge(a, number) == edge(b, number),
                "tiles {a} and {b}, edge {number}"
            );
        }
    }
}

/// The plane of tiles with coloured corners closes on whole tiles, as any other.
#[test]
fn tiles_whose_borders_vary_close_on_a_torus() {
    let index = noise(Size::new(160, 150), 1, 8);
    let options =
        RollerOptions { tiles: 16, pattern: Some(Pattern::None), vary: true, ..RollerOptions::default() };
    let tiles = make(&index, &options).tiles;
    let Size { width, height } = tiles.tile();
    let torus = lay(&tiles, Size::new(3 * width, 2 * height), Boundary::Torus, 3, &Job::default()).unwrap();
    let number = |column: usize, row: usize| {
        let copied = |tile: &usize| {
            (0..width).all(|x| {
                let there = torus.copies()[(row * height + height / 2) * 3 * width + column * width + x];
                tiles.sources(*tile)[height / 2 * width + x] == there
            })
        };
        (0..16).find(copied).expect("a cell shows a tile")
    };
    for (column, row) in (0..3).flat_map(|column| (0..2).map(move |row| (column, row))) {
        let here = tiles.corners().corners(number(column, row));
        let right = tiles.corners().corners(number((column + 1) % 3, row));
        let below = tiles.corners().corners(number(column, (row + 1) % 2));
        assert_eq!(([here[1], here[3]], [here[2], here[3]]), ([right[0], right[2]], [below[0], below[1]]));
    }
}
