//! `relume lights` as a user runs it: on virtual captures with mirror balls, and on real photographs where they are.

use std::fs;
use std::path::{Path, PathBuf};

use relume::Direction;
use relume::capture::lp;

use crate::support::{done, failed, json, refused, write_grey};

/// The mean and largest angle in degrees between light files, which name the same photographs.
fn angles(found: &Path, truth: &Path) -> (f64, f64) {
    let read = |path: &Path| lp::parse(&fs::read(path).unwrap()).unwrap();
    let (found, truth) = (read(found), read(truth));
    assert_eq!(found.len(), truth.len());
    let all: Vec<f64> = found
        .iter()
        .zip(&truth)
        .map(|(a, b)| {
            assert_eq!(a.name, b.name);
            a.light.dot(b.light).clamp(-1.0, 1.0).acos().to_degrees()
        })
        .collect();
    (all.iter().sum::<f64>() / all.len() as f64, all.iter().copied().fold(0.0, f64::max))
}

#[test]
fn the_lamps_of_a_virtual_capture_are_found_by_the_balls_beside_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let shoot = ["capture", "leather", "-o", "photos", "--size", "160", "--lights", "14", "--balls", "2"];
    let balls = json(at, &shoot)["balls"].as_array().unwrap().len();
    let report = json(at, &["lights", "photos", "-o", "found.lp", "--picture", "found.png"]);
    assert_eq!(report["balls"].as_array().unwrap().len(), balls);
    assert_eq!(report["found_balls"], true);
    assert!(at.join("found.png").is_file());
    let (mean, most) = angles(&at.join("found.lp"), &at.join("photos/lights.lp"));
    assert!(mean < 1.5 && most < 4.0, "{mean} {most}");
    let outline = |ball: &serde_json::Value| {
        format!("{},{},{}", ball["x"].as_f64().unwrap(), ball["y"].as_f64().unwrap(), ball["radius"])
    };
    let truth: serde_json::Value =
        serde_json::from_slice(&fs::read(at.join("photos/capture.json")).unwrap()).unwrap();
    let ball = outline(&truth["balls"][0]);
    json(at, &["lights", "photos", "--ball", &ball, "-o", "given.lp"]);
    let (mean, most) = angles(&at.join("given.lp"), &at.join("photos/lights.lp"));
    assert!(mean < 0.8 && most < 2.5, "{mean} {most}");
    // The lamps of a dome are too far away to be placed.
    let text = refused(at, &["lights", "photos", "--positions", "-o", "placed.lp"]);
    assert!(text.contains("too far away"), "{text}");
}

#[test]
fn what_shows_no_lamp_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    done(at, &["capture", "sponge", "-o", "photos", "--size", "80", "--lights", "5", "--balls", "1"]);
    let files = ["photos/light_000.png", "photos/light_001.png"];
    let text = failed(at, &["lights", files[0], files[1], "--ball", "900,10,9", "-o", "x.lp"], 1);
    assert!(text.contains("not inside the photographs"), "{text}");
    let text = refused(at, &["lights", files[0], "--ball", "1,2", "-o", "x.lp"]);
    assert!(text.contains("column, row and radius"), "{text}");
    write_grey(&at.join("black.png"), (128, 80), &[0; 128 * 80]);
    let ball = ["--ball", "104,40,20"];
    let run =
        |more: &[&str], status| failed(at, &[&["lights", "-o", "x.lp"], &ball[..], more].concat(), status);
    let text = run(&["black.png"], 1);
    assert!(text.contains("none of the 1 photographs shows a lamp (black.png has no highlight)"), "{text}");
    write_grey(&at.join("small.png"), (20, 20), &[9; 400]);
    assert!(run(&[files[0], "small.png"], 1).contains("same size"));
    assert!(run(&["photos", "black.png"], 2).contains("folder among files"));
    fs::create_dir(at.join("empty")).unwrap();
    assert!(run(&["empty"], 1).contains("holds no picture"));
}

#[test]
fn photographs_without_a_highlight_are_named_or_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let made =
        json(at, &["capture", "sponge", "-o", "photos", "--size", "80", "--lights", "5", "--balls", "1"]);
    let ball = &made["balls"][0];
    let outline = format!("{},{},{}", ball["x"], ball["y"], ball["radius"]);
    let size = relume::format::read_raster(&at.join("photos/light_000.png"), &relume::Job::default())
        .unwrap()
        .size();
    write_grey(
        &at.join("photos/light_999.png"),
        (size.width as u32, size.height as u32),
        &vec![0; size.texels()],
    );
    let run = ["lights", "photos", "--ball", &outline, "-o", "x.lp"];
    let text = failed(at, &run, 1);
    assert!(text.contains("1 of 6 photographs") && text.contains("light_999.png has no highlight"), "{text}");
    let report = json(at, &[&run[..], &["--skip"]].concat());
    assert_eq!(lp::parse(&fs::read(at.join("x.lp")).unwrap()).unwrap().len(), 5);
    assert!(report["warnings"][0].as_str().unwrap().contains("left out: light_999.png"));
}

/// The folder of real data, if there is one.
fn real() -> Option<PathBuf> {
    let named = std::env::var_os("RELUME_DATA").map(PathBuf::from);
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let found = named.unwrap_or(beside);
    let is_there = found.join("captures/scholar").is_dir();
    if !is_there {
        eprintln!("skipped: no real captures in {}", found.display());
    }
    is_there.then_some(found)
}

#[test]
fn the_lamps_of_real_photographs_are_those_published() {
    let Some(data) = real() else { return };
    let folder = tempfile::tempdir().unwrap();
    let text = fs::read_to_string(data.join("captures/scholar/light_directions.txt")).unwrap();
    let rows: Vec<Vec<f64>> =
        text.lines().map(|line| line.split_whitespace().map(|v| v.parse().unwrap()).collect()).collect();
    for ball in ["LightProbe-1", "LightProbe-2"] {
        let photographs: Vec<String> = (1..=20)
            .map(|i| data.join(format!("captures/scholar/{ball}/Image_{i:02}.JPG")).display().to_string())
            .collect();
        let mut words = vec!["lights", "-o", "found.lp", "--force"];
        words.extend(photographs.iter().map(String::as_str));
        json(folder.path(), &words);
        let found = lp::parse(&fs::read(folder.path().join("found.lp")).unwrap()).unwrap();
        let off = |(i, entry): (usize, &lp::LpEntry)| {
            let truth = Direction::new(rows[0][i], rows[1][i], rows[2][i]).unwrap();
            entry.light.dot(truth).clamp(-1.0, 1.0).acos().to_degrees()
        };
        let mean = found.iter().enumerate().map(off).sum::<f64>() / 20.0;
        assert!(mean < 2.0, "{ball}: {mean} degrees");
    }
}
