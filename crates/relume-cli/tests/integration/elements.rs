//! `relume synth --method elements` as a user runs it.

use std::fs;
use std::path::Path;

use relume::field::{Basis, PlaneLayout};
use relume::format::{FieldFormat, encode_field, read_field};
use relume::numeric::random::{Purpose, Stream};
use relume::{Job, Planes, ReflectanceField, Size, Space};

use crate::support::{failed, grains, json, names, read_png, refused, run, write_grey};

const PERIOD: usize = 48;

/// Two by two stones of shades of their own, with grain, and joints of 6 texels between them.
fn write_stones(path: &Path) {
    let grain = grains(4 * PERIOD * PERIOD);
    let code = |t: usize| {
        let (x, y) = (t % (2 * PERIOD), t / (2 * PERIOD));
        let is_joint = |at: usize| !(3..PERIOD - 3).contains(&(at % PERIOD));
        let stone = [110, 215, 190, 140][x / PERIOD + 2 * (y / PERIOD)];
        (if is_joint(x) || is_joint(y) { 30 } else { stone }) + grain[t] / 16
    };
    let codes: Vec<u8> = (0..grain.len()).map(code).collect();
    write_grey(path, (2 * PERIOD as u32, 2 * PERIOD as u32), &codes);
}

#[test]
fn four_stones_are_laid_whole_with_their_joints() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_stones(&folder.join("stones.png"));
    let laid = ["synth", "stones.png", "--method", "elements", "--size", "144"];
    let report = json(folder, &[&laid[..], &["-o", "wall.png", "--period", "48,48"]].concat());
    assert_eq!(report["elements"]["elements"], 4, "{report:#}");
    assert!(report["elements"]["joint_contrast"].as_f64().unwrap() < 0.2, "{report:#}");
    let ((width, height), codes) = read_png(&folder.join("wall.png"));
    assert_eq!((width, height), (144, 144));
    for cell in 0..9 {
        let (left, top) = (cell % 3 * PERIOD, cell / 3 * PERIOD);
        let inside = |from: usize| {
            let range = from..PERIOD - from;
            let rows = range.clone().flat_map(move |y| range.clone().map(move |x| (x, y)));
            rows.map(|(x, y)| codes[(top + y) * width + left + x]).collect::<Vec<u8>>()
        };
        let stone = inside(4);
        let (least, most) = (stone.iter().min().unwrap(), stone.iter().max().unwrap());
        assert!(most - least < 16, "stone {cell} is of one shade: {least} to {most}");
        let joint = codes[(top + 1) * width + left + 20];
        assert!((30..46).contains(&joint), "cell {cell} begins with a joint: {joint}");
    }
    // The lattice need not be known, and the output may tile.
    let found = json(folder, &[&laid[..], &["-o", "found.png", "--tile"]].concat());
    assert_eq!((&found["elements"]["elements"], &found["tile"]), (&4.into(), &true.into()), "{found:#}");
    assert!(run(folder, &["analyze", "stones.png"]).contains("--method elements"));
}

/// The elements of a texture of functions of light are laid with all of their coefficients.
#[test]
fn stones_of_a_ptm_are_laid_with_all_coefficients() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let size = Size::new(2 * PERIOD, 2 * PERIOD);
    let mut stream = Stream::new(4, Purpose::Sample, [0]);
    let is_joint = |at: usize| !(3..PERIOD - 3).contains(&(at % PERIOD));
    let value = |t: usize| {
        let (plane, x, y) = (t / size.texels(), t % size.width, t % size.texels() / size.width);
        let stone = [0.3, 0.7, 0.5, 0.9][x / PERIOD + 2 * (y / PERIOD)] + 0.01 * plane as f32;
        (if is_joint(x) || is_joint(y) { 0.1 } else { stone }) + 0.05 * stream.unit() as f32
    };
    let planes = Planes::from_vec(size, 9, (0..9 * size.texels()).map(value).collect()).unwrap();
    let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb, planes).unwrap();
    let bytes = encode_field(&field, FieldFormat::Ptm, None, &Job::default()).unwrap();
    fs::write(folder.join("stones.ptm"), bytes).unwrap();
    let laid = [
        "synth",
        "stones.ptm",
        "--method",
        "elements",
        "--size",
        "144",
        "--period",
        "48,48",
        "-o",
        "wall.ptm",
    ];
    assert_eq!(json(folder, &laid)["elements"]["elements"], 4);
    let read = |name: &str| read_field(&folder.join(name), &Job::default()).unwrap().field;
    let (sample, wall) = (read("stones.ptm"), read("wall.ptm"));
    let inside = |field: &ReflectanceField, [column, row]: [usize; 2]| {
        let (left, top) = (column * PERIOD + 4, row * PERIOD + 4);
        field.coefficients().crop(left, top, Size::new(PERIOD - 8, PERIOD - 8)).unwrap()
    };
    let stones = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|cell| inside(&sample, cell));
    let mut shown = [0; 4];
    for cell in (0..9).map(|t| [t % 3, t / 3]) {
        let stone = inside(&wall, cell);
        let which = stones.iter().position(|other| *other == stone);
        shown[which.unwrap_or_else(|| panic!("the stone at {cell:?} is none of the four"))] += 1;
    }
    assert!(shown.iter().all(|&count| count > 0), "{shown:?}");
}

#[test]
fn what_cannot_be_laid_is_said_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_stones(&folder.join("stones.png"));
    write_grey(&folder.join("grains.png"), (64, 64), &grains(64 * 64));
    let lay = |file: &'static str, more: &[&'static str]| {
        [&["synth", file, "--method", "elements", "--size", "100", "-o", "o.png"], more].concat()
    };
    assert!(refused(folder, &lay("grains.png", &[])).contains("no lattice"));
    assert!(refused(folder, &lay("stones.png", &["--tile", "--period", "48,48"])).contains("cannot tile"));
    assert!(refused(folder, &lay("stones.png", &["--period", "4,4"])).contains("too small"));
    assert!(refused(folder, &lay("stones.png", &["--period", "4"])).contains("two numbers"));
    assert!(refused(folder, &lay("stones.png", &["--block", "8"])).contains("--block"));
    assert!(failed(folder, &lay("nothing.png", &[]), 1).contains("nothing.png"));
    assert_eq!(names(folder), ["grains.png", "stones.png"]);
}
