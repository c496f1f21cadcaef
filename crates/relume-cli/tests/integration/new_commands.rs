//! The commands that `relume new` prints and records, and the warnings of its steps.

use std::fs;
use std::process::Command;

use relume::format::{Depth, PictureFormat, encode_picture, read_raster};
use relume::{Job, Space};
use serde_json::Value;

use crate::support::{done, failed, json, refused, write_grey};

/// Photographs with a mirror ball in a folder whose name has a space and a quote, without a light file.
fn photographs() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let shoot = ["capture", "leather", "-o", "it's a coin", "--size", "64", "--lights", "18", "--balls", "1"];
    let ball = json(at, &shoot)["balls"][0].clone();
    // The record of the folder stays, and holds the light file that was there.
    for file in ["lights.lp", "capture.json"] {
        fs::remove_file(at.join("it's a coin").join(file)).unwrap();
    }
    fs::remove_dir_all(at.join("it's a coin/truth")).unwrap();
    (folder, format!("{},{},{}", ball["x"], ball["y"], ball["radius"]))
}

/// A fault: with mirror balls, the fit that was recorded found no light file, and paths were not quoted.
#[cfg(unix)]
#[test]
fn the_commands_of_new_run_as_they_are_pasted() {
    let (folder, ball) = photographs();
    let at = folder.path();
    done(at, &["new", "it's a coin", "-o", "my coin", "--ball", &ball, "--crop", "0,0,64,64"]);
    let facts: Value = serde_json::from_slice(&fs::read(at.join("my coin/new.json")).unwrap()).unwrap();
    let texture = fs::read(at.join("my coin/texture.ptm")).unwrap();
    fs::remove_dir_all(at.join("my coin")).unwrap();
    fs::create_dir(at.join("my coin")).unwrap();
    let commands = facts["commands"].as_array().unwrap();
    assert!(commands[0].as_str().unwrap().starts_with("relume lights 'it'\\''s a coin' -o "), "{commands:?}");
    for command in commands {
        let typed = command.as_str().unwrap().replacen("relume", env!("CARGO_BIN_EXE_relume"), 1);
        let output = Command::new("sh").current_dir(at).args(["-c", &typed]).output().unwrap();
        assert!(output.status.success(), "{typed}: {}", String::from_utf8_lossy(&output.stderr));
    }
    assert!(at.join("my coin/height.exr").is_file());
    assert_eq!(fs::read(at.join("my coin/texture.ptm")).unwrap(), texture);
    // Now that there is a light file, another is named.
    let again = json(at, &["new", "it's a coin", "-o", "again", "--ball", &ball, "--crop", "0,0,64,64"]);
    assert!(again["commands"][0].as_str().unwrap().contains("/lights_1.lp'"), "{}", again["commands"]);
}

#[test]
fn a_ball_that_is_none_and_black_photographs_are_said() {
    let (folder, ball) = photographs();
    let at = folder.path();
    let found = json(at, &["lights", "it's a coin", "-o", "one.lp", "--ball", &ball]);
    assert_eq!(found["warnings"].as_array().unwrap().len(), 0, "{found}");
    let wrong = json(at, &["lights", "it's a coin", "-o", "two.lp", "--ball", &ball, "--ball", "20,20,12"]);
    let said = wrong["warnings"].to_string();
    assert!(said.contains("one of them may be no mirror ball"), "{said}");

    fs::create_dir(at.join("black")).unwrap();
    for name in ["a.png", "b.png", "c.png"] {
        write_grey(&at.join("black").join(name), (16, 16), &[0; 256]);
    }
    fs::write(at.join("black/l.lp"), "3\na.png 0 0 1\nb.png 1 0 1\nc.png 0 1 1\n").unwrap();
    let sentence = failed(at, &["height", "black", "-o", "h.exr"], 1);
    assert!(sentence.contains("all photographs are black"), "{sentence}");
}

#[test]
fn a_ball_given_twice_is_refused() {
    let (folder, ball) = photographs();
    let at = folder.path();
    for verb in [&["new", "it's a coin", "-o", "n"][..], &["lights", "it's a coin", "-o", "x.lp"]] {
        let text = refused(at, &[verb, &["--ball", &ball, "--ball", &ball]].concat());
        assert!(text.contains("is given twice"), "{text}");
    }
}

/// A fault: what the fit warned of was dropped, and a frame of half the exposure was in the report alone.
#[test]
fn the_warnings_of_the_fit_are_those_of_new() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    done(at, &["capture", "leather", "-o", "p", "--size", "64", "--lights", "24"]);
    fs::remove_file(at.join("p/relume-files.json")).unwrap();
    let path = at.join("p/light_003.png");
    let mut picture = read_raster(&path, &Job::default()).unwrap().to_picture(Space::Linear);
    picture.planes.as_mut_slice().iter_mut().for_each(|v| *v *= 0.25);
    fs::write(path, encode_picture(&picture, PictureFormat::Png(Depth::Eight)).unwrap()).unwrap();
    let report = json(at, &["new", "p/lights.lp", "-o", "n", "--surface-mm", "100", "--lamp-mm", "400"]);
    let said: Vec<&str> = report["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    let of_frame = said.iter().filter(|w| w.contains("light_003.png") && w.contains("another exposure"));
    assert_eq!(of_frame.count(), 1, "{said:?}");
}
