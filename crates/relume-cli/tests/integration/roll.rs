//! `relume roll` and the endless planes of `relume synth` as a user runs them.

use std::fs::{self, File};
use std::path::Path;

use relume::field::{Basis, PlaneLayout};
use relume::format::{ExrDepth, FieldFormat, encode_field, read_field};
use relume::numeric::cells::Cells;
use relume::synthesis::roller::Endless;
use relume::{Job, Planes, ReflectanceField, Size, Space};
use serde_json::Value;

use crate::support::{failed, json, run};

/// A texture with a period of 13 x 11 texels and a little independent noise everywhere.
fn regular(basis: Basis, color: PlaneLayout, space: Space) -> ReflectanceField {
    let size = Size::new(90, 80);
    let count = color.planes(basis.len());
    let mut planes = Planes::zeros(size, count);
    let mut state = 7u32;
    let mut noise = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 16) as f32 / 65536.0
    };
    for (k, plane) in planes.iter_mut().enumerate() {
        for (t, value) in plane.iter_mut().enumerate() {
            let (x, y) = ((t % 90) as f32 / 13.0, (t / 90) as f32 / 11.0);
            let wave = (std::f32::consts::TAU * x).sin() * (std::f32::consts::TAU * y + k as f32).cos();
            *value = 0.5 + 0.3 * wave + 0.05 * noise();
        }
    }
    ReflectanceField::new(basis, color, space, planes).unwrap()
}

fn write(field: &ReflectanceField, format: FieldFormat, path: &Path) {
    fs::write(path, encode_field(field, format, None, &Job::default()).unwrap()).unwrap();
}

fn read(path: &Path) -> ReflectanceField {
    read_field(path, &Job::default()).unwrap().field
}

fn number(value: &Value, key: &str) -> usize {
    value[key].as_u64().unwrap_or_else(|| panic!("{key} of {value}")) as usize
}

#[test]
fn windows_of_tiles_are_the_librarys_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let lrgb = regular(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb);
    write(&lrgb, FieldFormat::Ptm, &folder.join("a.ptm"));
    write(&lrgb, FieldFormat::Exr(ExrDepth::Float), &folder.join("b.exr"));
    let picture = regular(Basis::Constant, PlaneLayout::RGB, Space::Srgb);
    let png = FieldFormat::from_path(Path::new("c.png")).unwrap();
    write(&picture, png, &folder.join("c.png"));
    for (exemplar, tiles, out) in
        [("a.ptm", "ta.ptm", "oa.ptm"), ("b.exr", "tb.exr", "ob.exr"), ("c.png", "tc.png", "oc.png")]
    {
        let report = json(folder, &["roll", exemplar, "-k", "3", "-o", tiles]);
        assert_eq!(report["acceptable"], true, "{report:#}");
        let tile = Size::new(number(&report, "tile_width"), number(&report, "tile_height"));
        assert_eq!((tile.width % 13, tile.height % 11), (0, 0), "whole periods: {tile}");
        let stacked = read(&folder.join(tiles));
        assert_eq!(stacked.size(), Size::new(tile.width, 3 * tile.height));
        run(folder, &["synth", tiles, "--window=-31,1000000,67,45", "--seed", "9", "-o", out]);
        let plane = Endless::new(tile, 3, 9).unwrap();
        let size = Size::new(67, 45);
        let expected = plane.window(stacked.coefficients(), -31, 1_000_000, size, &Job::default()).unwrap();
        assert!(*read(&folder.join(out)).coefficients() == expected, "{out}");
    }
    // A tile set of one kind may be drawn as another file of that kind.
    run(folder, &["synth", "ta.ptm", "--size", "40", "-o", "oa.exr"]);
    assert_eq!(read(&folder.join("oa.exr")).size(), Size::new(40, 40));
}

/// A texture without periods along an axis becomes oblique tiles, in both kinds of tile sets.
#[test]
fn tiles_are_oblique_where_periods_are() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let lattice = Cells::new([23, 7], [-5, 26]).unwrap();
    let mut planes = Planes::zeros(Size::new(150, 140), 3);
    for (k, plane) in planes.iter_mut().enumerate() {
        for (t, value) in plane.iter_mut().enumerate() {
            let [x, y] = lattice.place([(t % 150) as i64, (t / 150) as i64]).texel;
            *value = ((x * x + 3 * x * y + 5 * y + 7 * k as i64).rem_euclid(31) * 8) as f32 / 255.0;
        }
    }
    let field = ReflectanceField::new(Basis::Constant, PlaneLayout::RGB, Space::Srgb, planes).unwrap();
    write(&field, FieldFormat::from_path(Path::new("a.png")).unwrap(), &folder.join("a.png"));
    write(&field, FieldFormat::Exr(ExrDepth::Half), &folder.join("a.exr"));
    for (exemplar, tiles, out) in [("a.png", "t.png", "o.png"), ("a.exr", "t.exr", "o.exr")] {
        let report = json(folder, &["roll", exemplar, "-k", "2", "-o", tiles]);
        let steps = |key: &str| [0, 1].map(|axis| report["cells"][key][axis].as_i64().unwrap());
        let cells = Cells::new(steps("right"), steps("down")).unwrap();
        assert!(!cells.are_upright() && report["roller"]["first"]["mismatch"] == 0.0, "{report:#}");
        let info = json(folder, &["info", tiles]);
        assert_eq!((&info["tiles"]["cells"], &info["tiles"]["count"]), (&report["cells"], &Value::from(2)));
        run(folder, &["synth", tiles, "--window=-57,1000,90,70", "-o", out]);
        let made = read(&folder.join(out));
        for (x, y) in (10..60).flat_map(|x| (0..40).map(move |y| (x, y))) {
            let here = made.coefficients().at(1, x, y);
            assert_eq!(here, made.coefficients().at(1, x + 23, y + 7), "{out}: ({x}, {y})");
            assert_eq!(here, made.coefficients().at(1, x - 5, y + 26), "{out}: ({x}, {y})");
        }
    }
    let upright = json(folder, &["roll", "a.png", "--upright", "-o", "u.png"]);
    assert_eq!(upright["cells"]["down"][0], 0);
    fs::write(folder.join("t.png.json"), "{\"relumeTiles\": 2, \"cell\": [[9, 9], [0, 9]]}").unwrap();
    assert!(failed(folder, &["synth", "t.png", "--size", "50", "-o", "p.png"], 1).contains("two steps"));
    fs::write(folder.join("t.png.json"), "{\"relumeTiles\": 2, \"cell\": [[9, 1], [0, 9]]}").unwrap();
    assert!(failed(folder, &["info", "t.png"], 1).contains("another size"));
}

/// Tiles, noise and a model written into files of tiles, which hold the same texels as those of rows.
#[test]
fn exr_files_in_tiles_hold_the_same_texels() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let lrgb = regular(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb);
    write(&lrgb, FieldFormat::Exr(ExrDepth::Half), &folder.join("a.exr"));
    spots(folder);
    run(folder, &["roll", "a.exr", "-k", "2", "-o", "t.exr"]);
    run(folder, &["model", "s.png", "-o", "m.rlm"]);
    for (source, method) in [("t.exr", &[][..]), ("s.png", &["--method", "noise"]), ("m.rlm", &[])] {
        let draw = |out: &str, more: &[&str]| {
            let base = ["synth", source, "--window=-17,40,101,75", "--force", "-o", out];
            run(folder, &[&base[..], method, more].concat());
            read(&folder.join(out))
        };
        let rows = draw("rows.exr", &[]);
        for tile in ["16x16", "33x8", "101x75", "256"] {
            let tiled = draw("tiled.exr", &["--exr-tile", tile]);
            assert!(tiled.coefficients() == rows.coefficients(), "{source} in tiles of {tile}");
        }
        let length = |name: &str| fs::metadata(folder.join(name)).unwrap().len();
        assert_ne!(length("rows.exr"), length("tiled.exr"));
    }
    // A tiled file is an exemplar like any other.
    run(folder, &["roll", "tiled.exr", "--force", "-o", "t.exr"]);
}

#[test]
fn masks_are_kept_out_of_tiles_and_registered_images_follow() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let picture = regular(Basis::Constant, PlaneLayout::RGB, Space::Srgb);
    let size = picture.size();
    let png = |name: &str| FieldFormat::from_path(Path::new(name)).unwrap();
    write(&picture, png("c.png"), &folder.join("c.png"));
    let texels = |value: fn(usize, usize, usize) -> f32, channels: usize| {
        let color = if channels == 1 { PlaneLayout::LUMINANCE } else { PlaneLayout::RGB };
        let mut planes = Planes::zeros(size, channels);
        for (k, plane) in planes.iter_mut().enumerate() {
            plane.iter_mut().enumerate().for_each(|(t, v)| *v = value(k, t % 90, t / 90));
        }
        ReflectanceField::new(Basis::Constant, color, Space::Srgb, planes).unwrap()
    };
    let excluded = |x: usize, y: usize| (x, y) == (40, 30);
    write(&texels(|_, x, y| f32::from(u8::from((x, y) == (40, 30))), 1), png("m.png"), &folder.join("m.png"));
    write(&texels(|k, x, y| [x, y, 0][k] as f32 / 255.0, 3), png("w.png"), &folder.join("w.png"));
    let roll = ["roll", "c.png", "-k", "2", "-o", "t.png", "--apply", "w.png", "--source-map", "map.npy"];
    let report = json(folder, &[&roll[..], &["--exclude", "m.png"]].concat());
    let (tiles, places) = (read(&folder.join("t.png")), read(&folder.join("t_w.png")));
    let tile = Size::new(number(&report, "tile_width"), number(&report, "tile_height"));
    assert_eq!(tiles.size(), Size::new(tile.width, 2 * tile.height));
    assert!(folder.join("map.npy").is_file() && folder.join("t_w.png.json").is_file());
    let original = read(&folder.join("c.png"));
    for (x, y) in (0..2 * tile.height).flat_map(|y| (0..tile.width).map(move |x| (x, y))) {
        let from = [0, 1].map(|k| (places.coefficients().at(k, x, y) * 255.0).round() as usize);
        assert!(!excluded(from[0], from[1]), "({x}, {y})");
        for k in 0..3 {
            let copied = original.coefficients().at(k, from[0], from[1]);
            assert_eq!(tiles.coefficients().at(k, x, y), copied, "({x}, {y})");
        }
    }
    // The images of a tile set are a tile set as well.
    run(folder, &["synth", "t_w.png", "--size", "70", "-o", "o.png"]);
}

#[test]
fn outputs_do_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(
        &regular(Basis::Ptm, PlaneLayout::RGB, Space::Linear),
        FieldFormat::Exr(ExrDepth::Half),
        &folder.join("a.exr"),
    );
    for threads in ["1", "3"] {
        let name = |what: &str| format!("{what}{threads}.exr");
        run(folder, &["roll", "a.exr", "-k", "4", "--threads", threads, "-o", &name("t")]);
        run(folder, &["synth", &name("t"), "--size", "100x70", "--threads", threads, "-o", &name("o")]);
    }
    for what in ["t", "o"] {
        let bytes = |threads: &str| fs::read(folder.join(format!("{what}{threads}.exr"))).unwrap();
        assert!(bytes("1") == bytes("3"), "{what}");
    }
}

#[test]
fn what_cannot_be_done_is_said_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let picture = regular(Basis::Constant, PlaneLayout::RGB, Space::Srgb);
    write(&picture, FieldFormat::from_path(Path::new("c.png")).unwrap(), &folder.join("c.png"));
    let says = |arguments: &[&str], words: &str| {
        let text = failed(folder, arguments, 2);
        assert!(text.contains(words), "{arguments:?}: {text}");
    };
    says(&["roll", "c.png", "-o", "-"], "name one");
    says(&["roll", "c.png", "-o", "t.jpg"], "share a border");
    says(&["roll", "c.png", "-k", "0", "-o", "t.png"], "choose 1");
    says(&["roll", "c.png", "-k", "40", "-o", "t.png"], "fewer tiles");
    says(&["roll", "c.png", "--period", "0,3", "-o", "t.png"], "one line");
    says(&["synth", "c.png", "--window", "0,0,9,9", "-o", "o.png"], "relume roll");
    says(&["synth", "c.png", "-o", "o.png"], "--size");
    says(&["synth", "c.png", "--method", "noise", "--size", "50", "-o", "o.png"], "repeats");
    run(folder, &["roll", "c.png", "-o", "t.png"]);
    says(&["roll", "c.png", "-o", "t.png"], "--force");
    says(&["synth", "t.png", "--size", "50", "--tile", "-o", "o.png"], "--tile");
    says(&["synth", "t.png", "--size", "50", "-o", "o.tif"], ".png");
    says(&["synth", "t.png", "--size", "50", "--triangle", "9", "-o", "o.png"], "--triangle");
    says(&["synth", "t.png", "--size", "50", "--method", "noise", "-o", "o.png"], "set of tiles");
    for strange in ["--block", "--tolerance", "--feather", "--levels", "--coherence"] {
        says(&["synth", "t.png", "--size", "50", strange, "4", "-o", "o.png"], strange);
    }
    says(&["synth", "t.png", "--window", "1,2,0,5", "-o", "o.png"], "--window");
    says(&["synth", "t.png", "--size", "50", "--exr-tile", "8", "-o", "o.png"], ".exr");
    says(&["synth", "t.png", "--size", "50", "--exr-tile", "20000", "-o", "o.exr"], "256x256");
    says(&["synth", "c.png", "--size", "50", "--exr-tile", "8", "-o", "o.exr"], "--exr-tile");
    let long = ["synth", "t.png", "--size", "1000000x5", "-o", "o.png"];
    assert!(failed(folder, &long, 1).contains("longest side"));
    fs::write(folder.join("t.png.json"), "{\"relumeTiles\": 7}").unwrap();
    assert!(failed(folder, &["synth", "t.png", "--size", "50", "-o", "o.png"], 1).contains("7 tiles"));
    fs::write(folder.join("t.png.json"), "{\"relumeTiles\": \"many\"}").unwrap();
    assert!(failed(folder, &["synth", "t.png", "--size", "50", "-o", "o.png"], 1).contains("many"));
}

/// A picture of unrelated spots.
fn spots(folder: &Path) {
    let mut state = 3u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let mut encoder = png::Encoder::new(File::create(folder.join("s.png")).unwrap(), 64, 60);
    encoder.set_color(png::ColorType::Rgb);
    let samples: Vec<u8> = (0..64 * 60 * 3).map(|_| next()).collect();
    encoder.write_header().unwrap().write_image_data(&samples).unwrap();
}

#[test]
fn noise_is_identical_however_it_is_cut() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    spots(folder);
    let draw = |window: &str, out: &str| {
        run(
            folder,
            &["synth", "s.png", "--method", "noise", &format!("--window={window}"), "--seed", "4", "-o", out],
        );
        read(&folder.join(out)).coefficients().clone()
    };
    let whole = draw("-20,-9,90,150", "a.png");
    let part = draw("11,57,40,71", "b.png");
    assert!(whole.crop(31, 66, part.size()).unwrap() == part);
    let other = draw("-20,-9,90,150", "c.exr");
    assert_eq!(other.size(), Size::new(90, 150));
}
