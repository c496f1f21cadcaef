//! `relume fit --test`: photographs that took no part are developed as those of the fit, within the mask and under near lamps.

use std::fs;
use std::path::Path;

use relume::format::{Depth, PictureFormat, encode_picture, read_raster};
use relume::{Job, Space};
use serde_json::Value;

use crate::support::{done, failed, json, write_grey};

const SIDE: u32 = 48;
const LIGHTS: usize = 24;

fn capture() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let shoot =
        ["capture", "pebbles", "-o", "p", "--size", "48", "--lights", "24", "--format", "png16", "--matte"];
    done(folder.path(), &shoot);
    fs::remove_file(folder.path().join("p/relume-files.json")).unwrap();
    let lines = fs::read_to_string(folder.path().join("p/lights.lp")).unwrap();
    let lines: Vec<&str> = lines.lines().skip(1).collect();
    for (name, odd) in [("even.lp", 0), ("odd.lp", 1)] {
        let half: Vec<&str> = lines.iter().skip(odd).step_by(2).copied().collect();
        let text = format!("{}\n{}\n", half.len(), half.join("\n"));
        fs::write(folder.path().join("p").join(name), text).unwrap();
    }
    folder
}

/// A round mask, a card that is darker at its left, and the strengths of the lamps.
fn write_helpers(at: &Path) {
    let side = SIDE as i32;
    let place = |i: i32| (i % side - side / 2, i / side - side / 2);
    let round = |i: i32| if place(i).0.pow(2) + place(i).1.pow(2) < 200 { 255 } else { 0 };
    let codes: Vec<u8> = (0..side * side).map(round).collect();
    write_grey(&at.join("mask.png"), (SIDE, SIDE), &codes);
    fs::create_dir(at.join("cards")).unwrap();
    for k in 0..LIGHTS {
        let codes: Vec<u8> = (0..side * side).map(|i| (150 + i % side) as u8 + k as u8).collect();
        write_grey(&at.join(format!("cards/{k:02}.png")), (SIDE, SIDE), &codes);
    }
    let strength: String = (0..LIGHTS).map(|i| format!("{}\n", 1.0 + 0.03 * i as f64)).collect();
    fs::write(at.join("strength.txt"), strength).unwrap();
}

fn psnr(light: &Value) -> f64 {
    light["psnr_db"].as_f64().unwrap()
}

/// A fault: the mask, intensities, exposures, shifts, the grey patch and near lamps of the fit were not those of the test.
#[test]
fn a_test_of_the_fitted_photographs_gives_the_figures_of_the_fit() {
    let folder = capture();
    let at = folder.path();
    write_helpers(at);
    for options in [
        &[][..],
        &["--mask", "mask.png"],
        &["--mask", "mask.png", "--crop", "4,6,40,36", "--reduce", "2"],
        &["--intensities", "strength.txt", "--grey", "3,3,9,9"],
        &["--equalize", "--align"],
        &["--white-card", "cards", "--ambient-frame", "p/light_023.png"],
        &["--input-space", "auto"],
        &["--surface-mm", "100", "--lamp-mm", "90"],
        &["--surface-mm", "100", "--lamp-mm", "90", "--crop", "4,6,40,36", "--mask", "mask.png"],
        &["--mask", "mask.png", "--robust", "trimmed"],
    ] {
        let fit =
            ["fit", "p/lights.lp", "-o", "t.ptm", "--force", "--report", "r.html", "--report-texels", "all"];
        let report = json(at, &[&fit[..], &["--test", "p/lights.lp"], options].concat());
        assert_eq!(report["test_psnr_db"], report["quality"]["psnr_db"], "{options:?}");
        let lights = |of: &Value| of["lights"].as_array().unwrap().iter().map(psnr).collect::<Vec<f64>>();
        let (tested, fitted) = (lights(&report["test"]), lights(&report["report"]));
        for (a, b) in tested.iter().zip(&fitted).filter(|(a, _)| **a < 45.0) {
            assert!((a - b).abs() < 0.3, "{options:?}: {a} {b}");
        }
        assert_eq!(report["test"]["development"]["fitted_photographs"], 24);
        assert_eq!(report["test"]["development"]["not_applied"], serde_json::json!([]));
        assert_eq!(report["test"]["texels"], report["report"]["texels_measured"], "{options:?}");
    }
}

/// A fault: the texels outside a mask counted as exact, for the fit and for a test.
#[test]
fn functions_are_measured_and_tested_within_the_mask() {
    let folder = capture();
    let at = folder.path();
    // Every other column, so that what is inside is like the whole.
    let codes: Vec<u8> = (0..SIDE * SIDE).map(|i| if i % 2 == 0 { 255 } else { 0 }).collect();
    write_grey(&at.join("columns.png"), (SIDE, SIDE), &codes);
    let fit = ["fit", "p/even.lp", "-o", "t.exr", "--force", "--test", "p/odd.lp", "--basis"];
    let db = |of: &Value| of.as_f64().unwrap();
    for basis in ["learned", "rbf", "linear"] {
        let whole = json(at, &[&fit[..], &[basis]].concat());
        let masked = json(at, &[&fit[..], &[basis, "--mask", "columns.png"]].concat());
        let report = &masked["report"];
        assert_eq!((&report["texels"], &report["texels_inside"]), (&2304.into(), &1152.into()));
        assert_eq!(masked["test"]["texels"], 1152);
        let measured = report["texels_measured"].as_u64().unwrap();
        assert_eq!(measured, if basis == "learned" { 576 } else { 1152 });
        // Black columns would add 3 dB.
        let (inside, all) = (db(&masked["test_psnr_db"]), db(&whole["test_psnr_db"]));
        assert!((inside - all).abs() < 1.0, "{basis}: {inside} {all}");
        if basis == "linear" {
            let (inside, all) = (db(&report["error"]["psnr_db"]), db(&whole["report"]["error"]["psnr_db"]));
            assert!((inside - all).abs() < 1.0, "{inside} {all}");
        }
    }
}

#[test]
fn exposures_and_shifts_of_photographs_that_were_not_fitted_are_found_and_what_is_not_known_is_said() {
    let folder = capture();
    let at = folder.path();
    write_helpers(at);
    let run = |options: &[&str]| {
        let fit = ["fit", "p/even.lp", "-o", "t.ptm", "--force", "--basis", "ptm", "--test", "p/odd.lp"];
        json(at, &[&fit[..], options].concat())
    };
    let db = |report: &Value| report["test_psnr_db"].as_f64().unwrap();
    let right = db(&run(&[]));
    // Every third photograph at a fifth of its exposure.
    for i in (0..LIGHTS).step_by(3) {
        let path = at.join(format!("p/light_{i:03}.png"));
        let mut picture = read_raster(&path, &Job::default()).unwrap().to_picture(Space::Linear);
        picture.planes.as_mut_slice().iter_mut().for_each(|v| *v *= 0.2);
        fs::write(path, encode_picture(&picture, PictureFormat::Png(Depth::Sixteen)).unwrap()).unwrap();
    }
    let (wrong, found) = (run(&[]), run(&["--equalize", "--align"]));
    assert!(db(&wrong) < right - 3.0 && db(&found) > right - 1.5, "{right} {} {}", db(&wrong), db(&found));
    assert_eq!(found["test"]["development"]["not_applied"], serde_json::json!([]));
    assert_eq!(found["test"]["development"]["gains"].as_array().unwrap().len(), 12);
    let strength: String = (0..12).map(|i| format!("{}\n", 1.0 + 0.1 * f64::from(i))).collect();
    fs::write(at.join("twelve.txt"), strength).unwrap();
    let unknown = run(&["--intensities", "twelve.txt"]);
    assert_eq!(unknown["test"]["development"]["not_applied"], serde_json::json!(["--intensities"]));
    let said = unknown["warnings"].to_string();
    assert!(said.contains("12 of 12 photographs of the test") && said.contains("--intensities"), "{said}");
}

#[test]
fn a_test_of_photographs_of_another_size_is_refused() {
    let folder = capture();
    let at = folder.path();
    done(at, &["capture", "pebbles", "-o", "other", "--size", "40", "--lights", "6"]);
    let text = failed(at, &["fit", "p/lights.lp", "-o", "t.ptm", "--test", "other"], 1);
    assert!(
        text.contains("photographs of the test are 40 x 40 pixels and those of the fit 48 x 48"),
        "{text}"
    );
}

/// A fault: `fit` wanted a mask of the photographs, `height` and `new` one of what is left of them.
#[test]
fn every_verb_takes_a_mask_of_the_photographs_or_of_what_is_left_of_them() {
    let folder = capture();
    let at = folder.path();
    write_helpers(at);
    let part = ["--crop", "4,6,40,36", "--reduce", "2"];
    let codes: Vec<u8> = (0..20 * 18).map(|i| if i % 20 < 9 { 255 } else { 0 }).collect();
    write_grey(&at.join("part.png"), (20, 18), &codes);
    write_grey(&at.join("other.png"), (40, 36), &[255; 40 * 36]);
    write_grey(&at.join("black.png"), (SIDE, SIDE), &[0; (SIDE * SIDE) as usize]);
    for verb in [
        &["fit", "p/lights.lp", "-o", "t.ptm", "--force"][..],
        &["height", "p/lights.lp", "-o", "h.exr", "--force"],
        &["new", "p/lights.lp", "-o", "n", "--force"],
    ] {
        for mask in ["mask.png", "part.png"] {
            done(at, &[verb, &part[..], &["--mask", mask]].concat());
        }
        let text = failed(at, &[verb, &part[..], &["--mask", "other.png"]].concat(), 1);
        assert!(text.contains("48 x 48 of the photographs, or the 20 x 18 that are left"), "{text}");
        assert!(failed(at, &[verb, &["--mask", "black.png"]].concat(), 1).contains("leaves no texel"));
    }
    let commands = json(at, &["new", "p/lights.lp", "-o", "n", "--force", "--mask", "mask.png"]);
    let fits =
        commands["commands"].as_array().unwrap().iter().filter(|c| c.as_str().unwrap().contains(" fit "));
    assert!(
        fits.clone().count() > 0 && fits.clone().all(|c| c.as_str().unwrap().contains("--mask mask.png"))
    );
}

/// A fault: where too few photographs were left, nothing was trimmed, and the report said it had been.
#[test]
fn a_trimmed_fit_says_what_it_left_out_or_that_it_cannot() {
    let folder = capture();
    let at = folder.path();
    let trimmed = |basis: &str| {
        ["fit", "p/lights.lp", "-o", "t.exr", "--force", "--robust", "trimmed", "--basis", basis]
            .map(str::to_owned)
    };
    let run = |basis: &str| json(at, &trimmed(basis).each_ref().map(String::as_str));
    let report = &run("linear")["report"]["texel_fit"];
    assert_eq!((&report["darkest_left_out"], &report["brightest_left_out"]), (&6.into(), &2.into()));
    assert_eq!((&report["refitted"], &report["kept"]), (&(48 * 48).into(), &0.into()));
    let text = failed(at, &trimmed("zernike").each_ref().map(String::as_str), 1);
    assert!(text.contains("leaves 16 of 24 photographs") && text.contains("21 functions"), "{text}");
    let many = run("sh16");
    let kept = many["report"]["texel_fit"]["kept"].as_u64().unwrap();
    assert!(kept > 100, "{kept}");
    assert!(many["warnings"].to_string().contains(&format!("trimmed: at {kept} of 2304 texels")));
}

/// A fault: with as many functions as photographs, no ridge was chosen and none predicted from the others, in silence.
#[test]
fn what_a_fit_cannot_choose_or_predict_is_said() {
    let folder = capture();
    let at = folder.path();
    let lines = fs::read_to_string(at.join("p/lights.lp")).unwrap();
    let some: Vec<&str> = lines.lines().skip(1).take(16).collect();
    fs::write(at.join("p/some.lp"), format!("16\n{}\n", some.join("\n"))).unwrap();
    let fit = |more: &[&str]| {
        json(at, &[&["fit", "p/some.lp", "-o", "s.exr", "--force", "--basis"], more].concat())["warnings"]
            .to_string()
    };
    assert!(fit(&["hsh16", "--ridge", "auto"]).contains("no ridge was chosen"));
    let weighted = fit(&["hsh16", "--ridge", "0.01", "--leave-one-out"]);
    assert!(
        weighted.contains("not predicted from the others") && !weighted.contains("passes through"),
        "{weighted}"
    );
    assert!(fit(&["shapes", "--leave-one-out"]).contains("sum of radial basis functions alone"));
    assert!(!fit(&["hsh9", "--ridge", "auto", "--leave-one-out"]).contains("predicted from"));
    let trimmed =
        ["fit", "p/some.lp", "-o", "t.exr", "--basis", "hsh16", "--ridge", "auto", "--robust", "trimmed"];
    assert!(failed(at, &trimmed, 1).contains("16 functions"));
}

/// A fault: `--lamp-mm` was taken in silence where functions have one light for all texels, and where the light file has
/// positions.
#[test]
fn a_distance_of_lamps_without_its_full_effect_is_said() {
    let folder = capture();
    let at = folder.path();
    let fit = ["fit", "p/even.lp", "-o", "t.exr", "--surface-mm", "100", "--lamp-mm", "90", "--force"];
    for basis in ["learned", "rbf"] {
        let report = json(at, &[&fit[..], &["--basis", basis]].concat());
        assert!(report["warnings"].to_string().contains("from the middle of the surface"), "{basis}");
    }
    let lines = fs::read_to_string(at.join("p/even.lp")).unwrap();
    let placed = lines.lines().skip(1).map(|line| {
        let mut words = line.split(' ');
        let name = words.next().unwrap();
        let place: Vec<String> = words.map(|w| (80.0 * w.parse::<f64>().unwrap()).to_string()).collect();
        format!("{name} {}\n", place.join(" "))
    });
    fs::write(at.join("p/placed.lp"), format!("12\n{}", placed.collect::<String>())).unwrap();
    let both = json(at, &["fit", "p/placed.lp", "-o", "t.ptm", "--surface-mm", "100", "--lamp-mm", "90"]);
    assert!(
        both["warnings"].to_string().contains("puts their lamps at another distance"),
        "{}",
        both["warnings"]
    );
    let placed = json(at, &["fit", "p/placed.lp", "-o", "u.ptm", "--surface-mm", "100"]);
    assert!(!placed["warnings"].to_string().contains("another distance"), "{}", placed["warnings"]);
}
