//! The outputs of a command appear together or not at all, and outputs that cannot be written are refused
//! first.

use std::fs;
use std::path::Path;

use relume::Size;
use relume::procedural::Material;

use crate::support::{done, failed, json, names, refused, run, write_grey, write_material};

/// A folder with a picture of 24 x 24 texels.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("a.png"), Material::Pebbles, Size::new(24, 24), 8.0);
    folder
}

fn text(path: &Path) -> String {
    String::from_utf8_lossy(&fs::read(path).unwrap()).into_owned()
}

const SYNTH: [&str; 7] = ["synth", "a.png", "--size", "20", "--block", "8", "-o"];

#[test]
fn missing_folders_of_outputs_are_made_and_go_again_on_failure() {
    let folder = folder();
    let at = folder.path();
    run(at, &[&SYNTH[..], &["deep/er/o.png", "--source-map", "maps/m.npy"]].concat());
    assert!(at.join("deep/er/o.png").is_file() && at.join("maps/m.npy").is_file());
    assert_eq!((names(&at.join("deep/er")).len(), names(&at.join("maps")).len()), (1, 1));
    // The exemplar is smaller than a block: found after the outputs were claimed.
    failed(at, &["synth", "a.png", "--size", "20", "--block", "80", "-o", "new/er/o.png"], 2);
    assert!(!at.join("new").exists());
    run(at, &["capture", "sponge", "-o", "no/such/out", "--lights", "3", "--size", "16"]);
    assert!(at.join("no/such/out/lights.lp").is_file());
    failed(at, &["capture", "sponge", "-o", "nor/such/out", "--ambient", "7"], 2);
    assert!(!at.join("nor").exists());
}

#[test]
fn what_cannot_be_written_is_refused_before_the_work() {
    let folder = folder();
    let at = folder.path();
    fs::create_dir(at.join("there")).unwrap();
    let to = |output: &str| refused(at, &[&SYNTH[..], &[output]].concat());
    assert!(to("a.png/o.png").contains("is not a folder"));
    assert!(to("there").contains("is a folder"));
    assert!(to("./a.png").contains("exists already") || to("./a.png").contains("input"));
    assert!(to("/dev/null").contains("device"));
    assert!(to("/dev/stdout").contains("device"));
    let twice = refused(at, &[&SYNTH[..], &["o.npy.png", "--report", "there/../o.npy.png"]].concat());
    assert!(twice.contains("named for two outputs"), "{twice}");
    let input = refused(at, &["relight", "a.png", "--light", "0,0,1", "-o", "there/../a.png", "--force"]);
    assert!(input.contains("is an input"), "{input}");
    assert!(refused(at, &["capture", "sponge", "-o", "a.png/out"]).contains("is not a folder"));
    let own = refused(at, &["gallery", ".", "-o", "there/..", "--force"]);
    assert!(own.contains("is an input"), "{own}");
    let kind = refused(at, &["match", "a.png", "--to", "a.png", "-o", "o.xyz"]);
    assert!(kind.contains("o.xyz"), "{kind}");
    let kind = refused(at, &["height", "a.png", "-o", "h.exr", "--normals", "n.xyz"]);
    assert!(kind.contains("n.xyz"), "{kind}");
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_refused_before_the_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let closed = folder.path().join("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    // Root writes anywhere.
    if fs::write(closed.join("probe"), "").is_err() {
        let text = failed(folder.path(), &[&SYNTH[..], &["closed/o.png"]].concat(), 1);
        assert!(text.contains("closed/o.png") && text.contains("Permission denied"), "{text}");
    }
}

#[test]
fn when_one_output_is_refused_no_other_is_touched() {
    let folder = folder();
    let at = folder.path();
    fs::write(at.join("o.png"), "old").unwrap();
    fs::create_dir_all(at.join("m.npy/full")).unwrap();
    let text = refused(at, &[&SYNTH[..], &["o.png", "--source-map", "m.npy", "--force"]].concat());
    assert!(text.contains("m.npy") && self::text(&at.join("o.png")) == "old", "{text}");
}

#[test]
fn a_folder_is_replaced_whole_and_other_files_stay() {
    let folder = folder();
    let at = folder.path();
    let capture = |out: &str, lights: &str, more: &[&str]| {
        let command = ["capture", "sponge", "-o", out, "--size", "16", "--lights", lights];
        done(at, &[&command[..], more].concat());
    };
    capture("out", "9", &[]);
    fs::write(at.join("out/notes.txt"), "mine").unwrap();
    fs::write(at.join("out/truth/notes.txt"), "mine").unwrap();
    capture("out", "8", &["--force"]);
    let left = names(&at.join("out"));
    assert!(left.contains(&"light_007.png".to_owned()) && !left.contains(&"light_008.png".to_owned()));
    assert_eq!(text(&at.join("out/notes.txt")) + &text(&at.join("out/truth/notes.txt")), "minemine");
    assert_eq!(names(at), ["a.png", "out"]);
    // The current folder cannot be exchanged; its entries are.
    let inside = at.join("out");
    done(&inside, &["capture", "sponge", "-o", ".", "--size", "16", "--lights", "7", "--force"]);
    let left = names(&inside);
    assert!(!left.contains(&"light_007.png".to_owned()) && left.contains(&"light_006.png".to_owned()));
    assert_eq!(text(&inside.join("notes.txt")) + &text(&inside.join("truth/notes.txt")), "minemine");
    run(at, &["fit", "out", "-o", "f.ptm", "--report-texels", "9"]);
    // The blocking file is not touched.
    fs::create_dir(at.join("other")).unwrap();
    fs::create_dir(at.join("other/lights.lp")).unwrap();
    let command = ["capture", "sponge", "-o", "other", "--size", "16", "--lights", "3", "--force"];
    let text = refused(at, &command);
    assert!(text.contains("lights.lp") && text.contains("in the way"), "{text}");
    assert_eq!(names(&at.join("other")), ["lights.lp"]);
}

#[test]
fn two_runs_into_one_new_folder_do_not_both_succeed() {
    let folder = tempfile::tempdir().unwrap();
    let start = |seed: &str| {
        std::process::Command::new(env!("CARGO_BIN_EXE_relume"))
            .current_dir(folder.path())
            .args(["capture", "sponge", "-o", "out", "--size", "32", "--lights", "12", "--seed", seed])
            .stderr(std::process::Stdio::piped())
            .stdout(std::process::Stdio::null())
            .spawn()
            .unwrap()
    };
    let runs = [start("1"), start("2")].map(|run| run.wait_with_output().unwrap());
    let lost: Vec<_> = runs.iter().filter(|run| !run.status.success()).collect();
    assert_eq!(lost.len(), 1, "one run loses");
    assert_eq!(lost[0].status.code(), Some(2), "{}", String::from_utf8_lossy(&lost[0].stderr));
    assert_eq!(names(folder.path()), ["out"]);
    run(folder.path(), &["fit", "out", "-o", "f.ptm", "--report-texels", "9"]);
}

#[test]
fn a_capture_mixed_of_two_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for (out, lights) in [("one", "8"), ("two", "9")] {
        run(at, &["capture", "sponge", "-o", out, "--size", "16", "--lights", lights]);
    }
    let fit = ["fit", "one", "-o", "f.ptm", "--report-texels", "9"];
    let original = fs::read(at.join("one/light_005.png")).unwrap();
    fs::copy(at.join("two/light_005.png"), at.join("one/light_005.png")).unwrap();
    for verb in [&fit[..], &["height", "one", "-o", "h.exr"]] {
        let text = failed(at, verb, 1);
        assert!(text.contains("light_005.png") && text.contains("not of this capture"), "{text}");
    }
    fs::write(at.join("one/light_005.png"), original).unwrap();
    fs::copy(at.join("two/lights.lp"), at.join("three.lp")).unwrap();
    let lights = fs::read_to_string(at.join("one/lights.lp")).unwrap();
    fs::write(at.join("one/lights.lp"), lights.replacen('0', "1", 9)).unwrap();
    let text = failed(at, &fit, 1);
    assert!(text.contains("lights.lp"), "{text}");
    fs::write(at.join("one/lights.lp"), &lights).unwrap();
    fs::write(at.join("one/relume-files.json"), "{\"files\": [").unwrap();
    assert!(failed(at, &fit, 1).contains("damaged"));
    fs::remove_file(at.join("one/relume-files.json")).unwrap();
    run(at, &fit);
}

#[test]
fn tiles_and_the_json_beside_them_belong_together() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_material(&at.join("a.png"), Material::Weave, Size::new(64, 64), 16.0);
    run(at, &["roll", "a.png", "-o", "t.png"]);
    run(at, &["roll", "a.png", "-o", "u.png", "-k", "2"]);
    assert_eq!(json(at, &["info", "t.png"])["tiles"]["count"], 1);
    fs::copy(at.join("u.png.json"), at.join("t.png.json")).unwrap();
    let synth = ["synth", "t.png", "--size", "30", "-o", "o.png"];
    let text = failed(at, &synth, 1);
    assert!(text.contains("t.png") && text.contains("belongs to a file of"), "{text}");
    for damaged in ["", "{\"relumeTiles\": 2", "{\"relumeTiles\": 2, \"file\": 3}", "\u{0}\u{0}"] {
        fs::write(at.join("t.png.json"), damaged).unwrap();
        let text = failed(at, &synth, 1);
        assert!(text.contains("t.png.json"), "{damaged}: {text}");
    }
    // The file of another program says nothing about tiles.
    fs::write(at.join("t.png.json"), "{\"camera\": \"a\"}").unwrap();
    run(at, &["synth", "t.png", "--size", "20", "--block", "8", "-o", "o.png"]);
}

#[test]
fn a_source_map_of_another_texture_is_refused() {
    let folder = folder();
    let at = folder.path();
    run(at, &[&SYNTH[..], &["o.png", "--source-map", "m.npy"]].concat());
    run(at, &["synth", "a.png", "--size", "22", "--block", "8", "-o", "p.png", "--source-map", "n.npy"]);
    let compare = |other: &str, map: &str| {
        ["compare", "--texture", "a.png", other, "--source-map", map].map(str::to_owned)
    };
    let words = |words: [String; 6]| words.to_vec();
    let (right, wrong) = (words(compare("o.png", "m.npy")), words(compare("o.png", "n.npy")));
    run(at, &right.iter().map(String::as_str).collect::<Vec<_>>());
    failed(at, &wrong.iter().map(String::as_str).collect::<Vec<_>>(), 2);
    write_grey(&at.join("small.png"), (9, 9), &[9; 81]);
    let text = failed(at, &["compare", "--texture", "small.png", "o.png", "--source-map", "m.npy"], 1);
    assert!(text.contains("not of this exemplar"), "{text}");
}
