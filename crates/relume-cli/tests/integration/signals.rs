//! Interrupts end any verb within a second, and nothing is left behind.

#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use relume::Size;
use relume::procedural::Material;

use crate::support::{done, grains, names, run, write_grey, write_material};

fn start(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_relume"))
        .current_dir(folder)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

fn has_temporary(folder: &Path) -> bool {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.into_iter().any(|entry| entry.file_name().to_string_lossy().starts_with(".relume-"))
}

/// Waits until the work has begun; `folder` is where a run writes.
fn wait_for_temporary(child: &mut Child, folder: &Path, command: &[&str]) {
    let started = Instant::now();
    while !has_temporary(folder) {
        assert!(child.try_wait().unwrap().is_none(), "{command:?} ended before the signal");
        assert!(started.elapsed() < Duration::from_secs(60), "the work never began");
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(Duration::from_millis(60));
}

/// An exemplar, a field, a model and tiles.
fn with_inputs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("in")).unwrap();
    write_material(&at.join("in/a.png"), Material::Marble, Size::new(128, 128), 40.0);
    write_material(&at.join("big.png"), Material::Marble, Size::new(256, 256), 40.0);
    // Without periods or a direction, so that noise takes it.
    write_grey(&at.join("n.png"), (128, 128), &grains(128 * 128));
    run(at, &["roll", "in/a.png", "-o", "t.png"]);
    run(at, &["model", "in/a.png", "-o", "m.rlm", "--levels", "2", "--combine", "never"]);
    run(at, &["capture", "sponge", "-o", "c", "--size", "256", "--lights", "30"]);
    run(at, &["fit", "c", "-o", "f.ptm"]);
    folder
}

#[test]
fn every_long_verb_is_interrupted_within_a_second_and_leaves_nothing() {
    let folder = with_inputs();
    let at = folder.path();
    let before = names(at);
    let commands = [
        "capture sponge -o out --size 512 --lights 400",
        "capture weave -o out --size 256 --views bonn",
        "capture weave -o new/o.zip --size 256 --pairs 100000",
        "demo -o out",
        "gallery in -o out --size 512",
        "synth n.png -o new/o.png --method noise --size 9000x60000",
        "synth t.png -o new/o.png --size 30000x60000",
        "synth m.rlm -o new/o.png --size 9000x9000",
        "synth in/a.png -o new/o.png --size 2048 --method auto --tries 20",
        "tileable big.png -o new/o.png --band 60 --method efros-leung --neighbourhood 15",
        "model big.png -o new/o.rlm --levels auto --search backward --candidates 60 --combine never",
        "render f.ptm -o new/o.png --size 3000 --samples 16",
        "height c -o new/o.exr --method shape-from-shading --rounds 10000",
        "relight f.ptm --sweep orbit:4000 -o out",
        "render f.ptm --turntable 4000 -o out",
    ];
    for (number, command) in commands.iter().enumerate() {
        let command: Vec<&str> = command.split(' ').collect();
        let (name, status) = [("-INT", 130), ("-TERM", 143)][number % 2];
        let mut child = start(at, &command);
        let within = if command.contains(&"out") { at.to_owned() } else { at.join("new") };
        wait_for_temporary(&mut child, &within, &command);
        signal(&child, name);
        let sent = Instant::now();
        let output = child.wait_with_output().unwrap();
        let took = sent.elapsed();
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{command:?}: {text}");
        assert!(took < Duration::from_secs(1), "{command:?} took {took:?}");
        assert_eq!(names(at), before, "{command:?} left something behind");
    }
}

#[test]
fn what_a_kill_left_is_removed_by_the_next_run_and_never_what_lives() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let capture = ["capture", "sponge", "-o", "out", "--size", "512", "--lights", "400"];
    let mut killed = start(at, &capture);
    wait_for_temporary(&mut killed, at, &capture);
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(has_temporary(at), "a kill cannot be caught");
    let mut living = start(at, &["capture", "weave", "-o", "living", "--size", "512", "--lights", "400"]);
    std::thread::sleep(Duration::from_millis(300));
    done(at, &["capture", "sponge", "-o", "small", "--size", "16", "--lights", "3"]);
    let temporaries = || {
        let entries = fs::read_dir(at).unwrap().flatten();
        entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(".relume-")).count()
    };
    assert_eq!(temporaries(), 1, "the living one stays, the other goes");
    signal(&living, "-TERM");
    assert_eq!(living.wait().unwrap().code(), Some(143));
    assert_eq!(temporaries(), 0);
}

#[test]
fn a_limit_on_file_sizes_ends_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_material(&at.join("a.png"), Material::Pebbles, Size::new(64, 64), 8.0);
    let relume = env!("CARGO_BIN_EXE_relume");
    let script = format!("ulimit -f 8; exec {relume} synth a.png -o o.png --size 256");
    let output = Command::new("bash").current_dir(at).args(["-c", &script]).output().unwrap();
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("o.png") && text.contains("File too large"), "{text}");
    assert_eq!(fs::read_dir(at).unwrap().count(), 1);
}

#[test]
fn a_closed_pipe_is_a_failure_where_output_was_cut() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_material(&at.join("a.png"), Material::Pebbles, Size::new(64, 64), 8.0);
    let relume = env!("CARGO_BIN_EXE_relume");
    let script = format!("{relume} synth a.png -o - --size 256 | head -c 10 > cut; echo ${{PIPESTATUS[0]}}");
    let output = Command::new("bash").current_dir(at).args(["-c", &script]).output().unwrap();
    let (said, text) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.trim(), "1", "{text}");
    assert!(text.contains("standard output"), "{text}");
    assert_eq!(fs::read(at.join("cut")).unwrap().len(), 10);
}
