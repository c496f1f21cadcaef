//! `relume procedural` as a user runs it.

use std::fs;

use relume::format::{decode_raster, read_height};
use relume::{Job, Samples, Size};

use crate::support::{json, refused};

#[test]
fn every_material_becomes_maps_whose_heights_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["sponge", "weave", "pebbles", "leather", "bark", "marble", "wood", "clouds", "fire"] {
        let args = ["procedural", name, "-o", name, "--size", "40x30", "--feature", "12", "--tile"];
        let report = json(folder.path(), &args);
        let at = folder.path().join(name);
        for file in ["albedo.png", "roughness.png", "normals_gl.png", "material.json"] {
            assert!(at.join(file).is_file(), "{name}: {file}");
        }
        let heights = read_height(&at.join("height.png"), &Job::default()).unwrap();
        assert_eq!(heights.samples.size(), Size::new(40, 30));
        let (low, high) = heights.texels(f64::NAN).range(0);
        for (found, told) in [(low, "lowest"), (high, "highest")] {
            let told = report["height_texels"][told].as_f64().unwrap();
            assert!((f64::from(found) - told).abs() < 1e-5, "{name}: {found} and {told}");
        }
    }
}

#[test]
fn the_maps_photographed_have_the_height_of_the_material() {
    let folder = tempfile::tempdir().unwrap();
    json(folder.path(), &["procedural", "wood", "-o", "wood", "--size", "32", "--feature", "16", "--tile"]);
    let photographed = |source: &str, more: &[&str]| {
        let args = ["capture", source, "-o", "out", "--lights", "2", "--force"];
        let report = json(folder.path(), &[&args[..], more].concat());
        ["lowest", "highest"].map(|k| report["truth"]["height_texels"][k].as_f64().unwrap())
    };
    // A folder of that name is there too: the bare name means the material.
    let built_in = photographed("wood", &["--size", "32", "--feature", "16"]);
    let from_maps = photographed("./wood", &[]);
    assert!(from_maps.iter().zip(built_in).all(|(a, b)| (a - b).abs() < 1e-4), "{from_maps:?} {built_in:?}");
    let scaled = photographed("./wood", &["--height-scale", "3"]);
    assert!(scaled[0] == 0.0 && (scaled[1] - 3.0).abs() < 1e-6, "{scaled:?}");
}

#[test]
fn slices_and_seeds_change_the_picture_and_wrong_parameters_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let albedo = |more: &[&str]| {
        let args = ["procedural", "marble", "-o", "m", "--size", "24", "--feature", "9", "--force"];
        json(folder.path(), &[&args[..], more].concat());
        let bytes = fs::read(folder.path().join("m/albedo.png")).unwrap();
        match decode_raster(&bytes, &Job::default()).unwrap().samples() {
            Samples::U8(codes) => codes.clone(),
            _ => panic!("expected 8 bits"),
        }
    };
    let first = albedo(&[]);
    assert_eq!(first, albedo(&["--threads", "1"]));
    for more in
        [&["--z", "-0.5"][..], &["--seed", "4"], &["--power", "2"], &["--turbulence", "3"], &["--tile"]]
    {
        assert_ne!(first, albedo(more), "{more:?}");
    }
    // One period of the depth later the slice is the same.
    assert_eq!(albedo(&["--z-period", "2", "--z", "0.25"]), albedo(&["--z-period", "2", "--z", "2.25"]));
    for (args, word) in [
        (&["procedural", "granite", "-o", "x"][..], "marble"),
        (&["procedural", "fire", "-o", "x", "--z", "1"], "'z'"),
        (&["procedural", "marble", "-o", "x", "--octaves", "13"], "octaves"),
        (&["procedural", "wood", "-o", "x", "--feature", "0"], "feature"),
    ] {
        let text = refused(folder.path(), args);
        assert!(text.contains(word), "{args:?}: {text}");
    }
}
