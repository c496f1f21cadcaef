//! `relume capture` as a user runs it.

use std::fs;

use crate::support::{failed, json, names, read_png, run, write_grey};

#[test]
fn a_material_becomes_photographs_lights_and_truth() {
    let folder = tempfile::tempdir().unwrap();
    for (format, extension) in [("png", "png"), ("png16", "png"), ("exr", "exr")] {
        let output = format!("out-{format}");
        let arguments =
            ["capture", "weave", "-o", &output, "--lights", "7", "--size", "24x17", "--format", format];
        let report = json(folder.path(), &arguments);
        assert_eq!((&report["width"], &report["lights"]), (&24.into(), &7.into()));
        let output = folder.path().join(output);
        let photographs = (0..7).map(|k| format!("light_{k:03}.{extension}"));
        let expected: Vec<String> = ["capture.json".into()]
            .into_iter()
            .chain(photographs)
            .chain(["lights.lp".into(), "relume-files.json".into(), "truth".into()])
            .collect();
        assert_eq!(names(&output), expected);
        assert_eq!(
            names(&output.join("truth")),
            ["albedo.exr", "height.exr", "normals.exr", "normals_gl.png", "roughness.exr"]
        );
        run(folder.path(), &["fit", output.to_str().unwrap(), "-o", &format!("{format}.exr")]);
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let files = |threads: &str| {
        let arguments =
            ["capture", "sponge", "-o", threads, "--lights", "3", "--size", "40", "--threads", threads];
        run(folder.path(), &arguments);
        let out = folder.path().join(threads);
        let read = |name: String| (fs::read(out.join(&name)).unwrap_or_default(), name);
        let truth = names(&out.join("truth")).into_iter().map(|name| format!("truth/{name}"));
        let all = names(&out).into_iter().chain(truth).filter(|name| name != "capture.json");
        all.map(read).collect::<Vec<_>>()
    };
    assert_eq!(files("1"), files("3"));
}

#[test]
fn the_truth_photographed_again_gives_the_same_photographs() {
    let folder = tempfile::tempdir().unwrap();
    let common = ["--lights", "4"];
    run(folder.path(), &[&["capture", "pebbles", "-o", "first", "--size", "48x30"], &common[..]].concat());
    run(folder.path(), &[&["capture", "first/truth", "-o", "second"], &common[..]].concat());
    for k in 0..4 {
        let [a, b] = ["first", "second"]
            .map(|out| read_png(&folder.path().join(out).join(format!("light_{k:03}.png"))).1);
        // Normals are normalised once more, which may turn the last bit and so a rounding.
        assert!(a.iter().zip(&b).all(|(a, b)| a.abs_diff(*b) <= 1));
        assert!(a.iter().max() > a.iter().min());
    }
}

/// A ridge along x: a light from the top of the picture (y up) brightens its upper side.
#[test]
fn map_files_are_lit_from_where_the_light_file_says() {
    let folder = tempfile::tempdir().unwrap();
    let ridge: Vec<u8> = (0..16 * 16).map(|i: i32| 255 - 30 * (i / 16 - 8).unsigned_abs() as u8).collect();
    write_grey(&folder.path().join("ridge_height.png"), (16, 16), &ridge);
    write_grey(&folder.path().join("ridge_albedo.png"), (16, 16), &[188; 256]);
    run(folder.path(), &["capture", ".", "-o", "out", "--lights", "20", "--height-scale", "8", "--matte"]);
    let lights = fs::read_to_string(folder.path().join("out/lights.lp")).unwrap();
    let mut compared = 0;
    for line in lights.lines().skip(1) {
        let fields: Vec<&str> = line.split(' ').collect();
        let y: f64 = fields[2].parse().unwrap();
        let (_, picture) = read_png(&folder.path().join("out").join(fields[0]));
        let row = |y: usize| u32::from(picture[3 * (16 * y + 8)]);
        if y.abs() > 0.3 {
            assert_eq!(row(5) > row(11), y > 0.0, "{line}: {} {}", row(5), row(11));
            compared += 1;
        }
    }
    assert!(compared > 8);
}

/// A named fault: maps that the dome does not know were ignored in silence.
#[test]
fn maps_that_are_not_used_are_named() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a_height.png", "a_albedo.png", "a_metallic.png", "a_ao.png"] {
        write_grey(&folder.path().join(name), (8, 8), &[128; 64]);
    }
    let report = json(folder.path(), &["capture", ".", "-o", "out", "--lights", "2"]);
    let warnings = report["warnings"].as_array().unwrap();
    assert!(warnings.len() == 1 && warnings[0].as_str().unwrap().contains("a_ao.png"), "{warnings:?}");
    assert!(
        json(folder.path(), &["capture", "weave", "-o", "none", "--size", "16", "--lights", "2"])["warnings"]
            .as_array()
            .unwrap()
            .is_empty()
    );
}

/// The colour of a metal is that of its highlight; away from it a metal without surroundings is dark.
#[test]
fn a_metallic_map_changes_the_photographs() {
    let folder = tempfile::tempdir().unwrap();
    for (name, code) in [("height", 9), ("albedo", 200), ("rough", 100), ("metalness", 255)] {
        write_grey(&folder.path().join(format!("{name}.png")), (8, 8), &[code; 64]);
    }
    let common = ["--lights", "5", "--ambient", "0"];
    run(folder.path(), &[&["capture", ".", "-o", "metal"], &common[..]].concat());
    let files = ["--height", "height.png", "--albedo", "albedo.png", "--roughness", "rough.png"];
    run(folder.path(), &[&["capture", "-o", "plain"], &files[..], &common[..]].concat());
    let code = |out: &str, k: usize| read_png(&folder.path().join(format!("{out}/light_00{k}.png"))).1[0];
    let (metal, plain) = (code("metal", 4), code("plain", 4));
    assert!(metal > 0 && 2 * metal < plain, "{metal} {plain}");
    assert!(folder.path().join("metal/truth/metallic.exr").exists());
    assert!(!folder.path().join("plain/truth/metallic.exr").exists());
}

#[test]
fn what_cannot_be_photographed_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    assert!(failed(at, &["capture", "spunge", "-o", "out"], 2).contains("spunge"));
    assert!(failed(at, &["capture", "sponge", "-o", "out", "--ambient", "nan"], 2).contains("ambient"));
    assert!(failed(at, &["capture", "sponge", "-o", "out", "--feature", "0"], 2).contains("feature"));
    assert!(failed(at, &["capture", "sponge", "-o", "out", "--lights", "0"], 2).contains("lights"));
    assert!(failed(at, &["capture", "sponge", "-o", "out", "--normal-y", "up"], 2).contains("--normal-y"));
    assert!(failed(at, &["capture", "sponge", "-o", "out", "--memory", "0.001"], 1).contains("GiB"));
    assert!(failed(at, &["capture", ".", "-o", "out"], 2).contains("height"));
    write_grey(&at.join("height.png"), (4, 4), &[7; 16]);
    assert!(failed(at, &["capture", ".", "-o", "out"], 2).contains("albedo"));
    write_grey(&at.join("color.png"), (4, 3), &[7; 12]);
    let sizes = failed(at, &["capture", ".", "-o", "out"], 1);
    assert!(sizes.contains("color.png") && sizes.contains("height.png"), "{sizes}");
    fs::write(at.join("color.png"), "no picture").unwrap();
    assert!(failed(at, &["capture", ".", "-o", "out"], 1).contains("color.png"));
    write_grey(&at.join("color.png"), (4, 4), &[7; 16]);
    assert!(failed(at, &["capture", ".", "-o", "out", "--size", "9"], 2).contains("--size"));
    assert!(failed(at, &["capture", ".", "-o", "."], 2).contains("not empty"));
    assert!(failed(at, &["capture", ".", "-o", "out", "--height-scale", "inf"], 2).contains("finite"));
}
