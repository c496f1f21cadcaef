//! Every verb opens each of its inputs once: an input may be a pipe, which can be read only once.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use relume::Size;
use relume::procedural::Material;
use rustix::fs::{CWD, FileType, Mode, mknodat};

use crate::support::{done, grains, write_grey, write_material};

/// Far longer than any of the commands takes; a command that opens a pipe twice waits for ever.
const LONGEST: Duration = Duration::from_secs(60);

/// Small inputs of every kind, made by the program where it can.
fn inputs(folder: &Path) {
    let size = Size::new(32, 32);
    write_material(&folder.join("a.png"), Material::Weave, size, 8.0);
    write_material(&folder.join("b.png"), Material::Pebbles, size, 8.0);
    let spot = |x: usize, y: usize| if x < 3 && y < 3 { 255 } else { 0 };
    let mask: Vec<u8> = (0..size.texels()).map(|i| spot(i % 32, i / 32)).collect();
    write_grey(&folder.join("mask.png"), (32, 32), &mask);
    // Without periods or a direction, so that noise takes it.
    write_grey(&folder.join("rough.png"), (64, 64), &grains(64 * 64));
    let square = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    fs::write(folder.join("mesh.obj"), square).unwrap();
    let made: [&[&str]; 5] = [
        &["procedural", "weave", "-o", "maps", "--size", "32"],
        &["capture", "weave", "-o", "shots", "--size", "32", "--lights", "8"],
        &["fit", "shots", "-o", "field.ptm"],
        &["model", "a.png", "-o", "model.rlm", "--levels", "1", "--combine", "never"],
        &["synth", "a.png", "-o", "made.png", "--size", "32", "--block", "8", "--source-map", "map.npy"],
    ];
    made.iter().for_each(|words| drop(done(folder, words)));
    done(
        folder,
        &["synth", "a.png", "-o", "made2.png", "--size", "32", "--block", "8", "--source-map", "map.exr"],
    );
    done(folder, &["roll", "a.png", "-o", "tiles.exr", "--period", "8,0,0,8"]);
}

/// Commands; their words that are files are their inputs.
const COMMANDS: &[&str] = &[
    "info a.png",
    "info field.ptm",
    "info model.rlm",
    "info tiles.exr",
    "analyze a.png",
    "analyze model.rlm --model-size 32",
    "compare a.png made.png",
    "compare a.png model.rlm --model-size 32",
    "compare --texture a.png made.png --source-map map.npy",
    "compare --texture a.png made.png --source-map map.exr",
    "relight field.ptm --light 0,0,1 -o out.png",
    "relight model.rlm --light 0,0,1 -o out.png",
    "relight field.ptm --sweep orbit:3 -o out.gif",
    "render field.ptm --mesh mesh.obj --size 16 -o out.png",
    "relight field.ptm --env b.png -o out.png",
    "render field.ptm --mesh mesh.obj --env b.png --size 16 --samples 1 -o out.png",
    "render a.png --mesh plane --height maps/height.png --bump 1x --size 16 -o out.png",
    "match a.png --to b.png -o out.png",
    "model a.png -o out.rlm --levels 1 --combine never",
    "model maps/height.png -o out.rlm --levels 1 --combine never",
    "roll a.png -o out.exr --period 8,0,0,8 --exclude mask.png --apply b.png --apply-dir applied",
    "synth a.png b.png -o out.png --size 24 --block 8",
    "synth a.png -o out.png --size 32 --block 8 --exclude mask.png --apply b.png --apply-dir applied",
    "synth a.png -o out.png --size 32 --block 8 --guide-source b.png --guide-target made.png",
    "synth a.png -o out.png --size 24 --method auto",
    "synth rough.png -o out.png --size 24 --method noise",
    "synth model.rlm -o out.png --size 24",
    "synth tiles.exr -o out.exr --size 24",
    "fill a.png --mask mask.png -o out.png --exclude mask.png --guide b.png --apply b.png --apply-dir applied",
    "tileable a.png -o out.png --band 4 --exclude mask.png --guide b.png",
    "height field.ptm -o out.png --truth-height maps/height.png --truth-normals maps/normals_gl.png",
    "height a.png --method shape-from-shading --light 0.3,0.2,0.9 --rounds 3 -o out.png",
    "height maps/normals_gl.png --method normal-map -o out.png",
    "capture maps -o out --lights 3 --height maps/height.png --albedo a.png --normal maps/normals_gl.png \
     --roughness mask.png",
];

/// Runs a command and returns its exit status, standard error, and whether it ended at all.
fn run_within(folder: &Path, words: &[String]) -> Option<(bool, String)> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_relume"))
        .current_dir(folder)
        .args(words)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > LONGEST {
            child.kill().unwrap();
            child.wait().unwrap();
            return None;
        }
        thread::sleep(Duration::from_millis(5));
    }
    let output = child.wait_with_output().unwrap();
    Some((output.status.success(), String::from_utf8_lossy(&output.stderr).into_owned()))
}

fn remove_outputs(folder: &Path) {
    for name in ["out.png", "out.gif", "out.rlm", "out.exr"] {
        let _ = fs::remove_file(folder.join(name));
    }
    let _ = fs::remove_dir_all(folder.join("out"));
    let _ = fs::remove_dir_all(folder.join("applied"));
    fs::create_dir(folder.join("applied")).unwrap();
}

#[test]
fn no_verb_opens_a_file_twice() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    inputs(folder);
    let mut piped = 0;
    for command in COMMANDS {
        let words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
        remove_outputs(folder);
        let is_input = |at: &usize| folder.join(&words[*at]).is_file();
        for at in (1..words.len()).filter(is_input).collect::<Vec<_>>() {
            remove_outputs(folder);
            let pipe = folder.join("pipe.png");
            let _ = fs::remove_file(&pipe);
            mknodat(CWD, &pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
            let bytes = fs::read(folder.join(&words[at])).unwrap();
            let end = pipe.clone();
            // It remains if a command never opens the pipe, which fails the test below.
            let writer = thread::spawn(move || fs::write(end, bytes));
            let mut with_pipe = words.clone();
            with_pipe[at] = "pipe.png".to_owned();
            let outcome = run_within(folder, &with_pipe);
            let Some((true, _)) = outcome else {
                panic!("{command} with a pipe for {}: {outcome:?} (none: it did not end)", words[at]);
            };
            writer.join().unwrap().unwrap();
            piped += 1;
        }
    }
    assert!(piped > 45, "only {piped} inputs were pipes");
}

/// A copy of a folder in which the files that end in `.png` are pipes, each with a writer that writes once.
fn piped_copy(from: &Path, to: &Path) -> Vec<thread::JoinHandle<std::io::Result<()>>> {
    fs::create_dir(to).unwrap();
    let mut writers = Vec::new();
    for entry in fs::read_dir(from).unwrap().flatten().filter(|entry| entry.path().is_file()) {
        let (path, name) = (entry.path(), entry.file_name());
        if path.extension().is_some_and(|ending| ending == "png") {
            let (end, bytes) = (to.join(name), fs::read(path).unwrap());
            mknodat(CWD, &end, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
            writers.push(thread::spawn(move || fs::write(end, bytes)));
        } else if path.extension().is_some_and(|ending| ending == "lp") {
            fs::copy(path, to.join(name)).unwrap();
        }
    }
    writers
}

/// Seen: photometric stereo read its first photograph twice.
#[test]
fn no_photograph_is_opened_twice() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, &["capture", "weave", "-o", "shots", "--size", "32", "--lights", "8"]);
    for command in [
        "fit pipes -o out.ptm",
        "fit pipes -o out.exr --color rgb --leave-one-out --crop 4,4,20,20",
        "height pipes -o out.exr",
        "height pipes/lights.lp -o out.png --estimator least-squares --ambient",
    ] {
        let writers = piped_copy(&folder.join("shots"), &folder.join("pipes"));
        assert_eq!(writers.len(), 8);
        let words: Vec<String> = command.split(' ').chain(["--force"]).map(str::to_owned).collect();
        let outcome = run_within(folder, &words);
        assert!(matches!(outcome, Some((true, _))), "{command}: {outcome:?} (none: it did not end)");
        writers.into_iter().for_each(|writer| writer.join().unwrap().unwrap());
        fs::remove_dir_all(folder.join("pipes")).unwrap();
    }
}

/// Seen: analysis, every method, every comparison and the picture on the page each read the exemplar again.
#[test]
fn a_gallery_opens_each_exemplar_once() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("in")).unwrap();
    for (name, material) in [("a.png", Material::Weave), ("b.png", Material::Pebbles)] {
        write_material(&folder.join("in").join(name), material, Size::new(32, 32), 8.0);
    }
    let writers = piped_copy(&folder.join("in"), &folder.join("pipes"));
    assert_eq!(writers.len(), 2);
    let words = ["gallery", "pipes", "-o", "out", "--methods", "quilting,efros-leung", "--size", "24"];
    let outcome = run_within(folder, &words.map(str::to_owned));
    assert!(matches!(outcome, Some((true, _))), "{outcome:?} (none: it did not end)");
    writers.into_iter().for_each(|writer| writer.join().unwrap().unwrap());
    for texture in
        ["a.png/quilting.png", "a.png/efros-leung.png", "b.png/quilting.png", "b.png/efros-leung.png"]
    {
        assert!(folder.join("out").join(texture).is_file(), "{texture}");
    }
}

/// A named fault: a pipe without a writer was waited for in silence, for ever.
#[test]
fn a_pipe_without_a_writer_is_named_and_can_be_interrupted() {
    let folder = tempfile::tempdir().unwrap();
    mknodat(CWD, folder.path().join("pipe.png"), FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
    let mut child = Command::new(env!("CARGO_BIN_EXE_relume"))
        .current_dir(folder.path())
        .args(["info", "pipe.png"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut line = String::new();
    BufReader::new(child.stderr.take().unwrap()).read_line(&mut line).unwrap();
    assert_eq!(line, "relume: waiting for data from pipe.png\n");
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
}
