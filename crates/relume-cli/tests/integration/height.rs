//! `relume height` as a user runs it.

use relume::Job;
use relume::format::read_height;

use crate::support::{failed, json};

/// A folder with a virtual capture of marble, its fit, and the ground truth.
fn folder_with_capture() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let capture = ["capture", "marble", "-o", "photos", "--size", "64", "--feature", "24", "--lights", "24"];
    json(folder.path(), &capture);
    json(folder.path(), &["fit", "photos", "-o", "field.ptm"]);
    folder
}

const TRUTH: [&str; 4] =
    ["--truth-height", "photos/truth/height.exr", "--truth-normals", "photos/truth/normals_gl.png"];

#[test]
fn every_method_finds_the_relief_of_a_virtual_capture_as_well_as_it_can() {
    let folder = folder_with_capture();
    let run = |input: &str, more: &[&str]| {
        let args =
            [&["height", input, "-o", "h.exr", "--border", "periodic", "--force"], more, &TRUTH].concat();
        let report = json(folder.path(), &args);
        let correlation = report["height_error"]["correlation"].as_f64().unwrap();
        (correlation, report["normal_error"]["mean_deg"].as_f64().unwrap())
    };
    let (stereo, angle) = run("photos", &["--normals", "n.exr", "--albedo-map", "a.png"]);
    assert!(stereo > 0.98 && angle < 4.0, "stereo {stereo} {angle}");
    let (exact, zero) = run("photos/truth/normals.exr", &["--method", "normal-map"]);
    assert!(exact > 0.99 && zero < 0.01, "normal map {exact} {zero}");
    let (again, _) = run("n.exr", &["--method", "normal-map"]);
    assert!((again - stereo).abs() < 1e-4);
    let (ptm, ptm_angle) = run("field.ptm", &[]);
    assert!(ptm > 0.8 && ptm_angle > angle, "ptm {ptm} {ptm_angle}");
    let (shading, _) = run("photos", &["--method", "shape-from-shading"]);
    assert!(shading > 0.2 && shading < stereo, "shading {shading}");
    assert!(folder.path().join("a.png").is_file());
}

#[test]
fn heights_are_written_in_the_unit_that_is_known() {
    let folder = folder_with_capture();
    let heights = |out: &str, more: &[&str]| {
        json(folder.path(), &[&["height", "photos", "-o", out], more].concat());
        read_height(&folder.path().join(out), &Job::default()).unwrap()
    };
    let texels = heights("a.exr", &["--threads", "1"]);
    let mm = heights("b.exr", &["--pixel-mm", "0.25"]);
    let codes = heights("c.png", &["--pixel-mm", "0.25"]);
    assert_eq!(texels.scale.unwrap().mm_per_texel, None);
    assert_eq!(mm.scale.unwrap().mm_per_texel, Some(0.25));
    assert!((mm.samples.range(0).1 - 0.25 * texels.samples.range(0).1).abs() < 1e-5);
    for (i, truth) in texels.texels(f64::NAN).as_slice().iter().enumerate() {
        assert!((mm.texels(f64::NAN).as_slice()[i] - truth).abs() < 1e-4);
        assert!((codes.texels(f64::NAN).as_slice()[i] - truth).abs() < 1e-3);
    }
}

#[test]
fn what_has_no_height_is_refused_in_one_sentence() {
    let folder = folder_with_capture();
    for (args, status, word) in [
        (&["height", "photos/light_000.png", "-o", "x.exr"][..], 2, "shape-from-shading"),
        (&["height", "photos/light_003.png", "--method", "shape-from-shading", "-o", "x.exr"], 2, "--light"),
        (&["height", "photos", "-o", "x.jpg"], 2, ".exr"),
        (&["height", "photos", "-o", "x.exr", "--pixel-mm", "0"], 2, "pixel-mm"),
        (&["height", "photos", "-o", "x.exr", "--truth-height", "nothing.exr"], 1, "nothing.exr"),
        (
            &["height", "photos", "-o", "x.exr", "--method", "shape-from-shading", "--photograph", "99"],
            2,
            "24",
        ),
        (&["height", "field.ptm", "-o", "x.exr", "--method", "normal-map"], 1, "field.ptm"),
        (&["height", "photos", "-o", "x.exr", "--memory", "0.00001"], 1, "GiB"),
        (
            &[
                "height",
                "photos/truth/normals.exr",
                "--method",
                "normal-map",
                "-o",
                "x.exr",
                "--albedo-map",
                "a.png",
            ],
            2,
            "finds no albedo",
        ),
    ] {
        let text = failed(folder.path(), args, status);
        assert!(text.contains(word), "{args:?}: {text}");
    }
}
