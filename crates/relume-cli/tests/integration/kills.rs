//! Outputs are whole or not there, whenever a run is killed.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use relume::Size;
use relume::procedural::Material;

use crate::support::{done, run, write_material};

/// Kills of each command, at moments spread at random over the time that it takes.
const KILLS: u32 = 50;

/// Commands that write to `out`: a file, several files, and folders.
const COMMANDS: [&str; 10] = [
    "fit c -o out/f.ptm",
    "convert f.ptm -o out/f.rti",
    "convert f.ptm -o out/web --web deepzoom",
    "convert f.ptm -o out/older --web multires",
    "relight f.ptm --sweep orbit:6 -o out/sweep",
    "synth a.png -o out/o.png --size 96 --apply b.png --source-map out/m.npy",
    "capture sponge -o out/c --size 32 --lights 9",
    "maps p -o out/maps --preset unity --materialx",
    "share f.ptm -o out/page",
    "render f.ptm -o out/x.png --size 48",
];

/// All files below a folder with their bytes, but for those of runs that have not ended.
fn tree(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut open = vec![folder.to_path_buf()];
    while let Some(at) = open.pop() {
        for path in fs::read_dir(at).unwrap().map(|entry| entry.unwrap().path()) {
            if path.file_name().unwrap().to_string_lossy().starts_with(".relume-") {
                continue;
            }
            match path.is_dir() {
                true => open.push(path),
                false => {
                    let name = path.strip_prefix(folder).unwrap().to_string_lossy().into_owned();
                    files.insert(name, fs::read(&path).unwrap());
                }
            }
        }
    }
    files
}

/// Whether anything of a run that has not ended is there.
fn has_leftovers(folder: &Path) -> bool {
    fs::read_dir(folder)
        .unwrap()
        .any(|entry| entry.unwrap().file_name().to_string_lossy().starts_with(".relume-"))
}

#[test]
fn fifty_kills_of_each_command_leave_whole_outputs_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_material(&at.join("a.png"), Material::Marble, Size::new(64, 64), 20.0);
    write_material(&at.join("b.png"), Material::Weave, Size::new(64, 64), 20.0);
    run(at, &["capture", "sponge", "-o", "c", "--size", "40", "--lights", "12"]);
    run(at, &["fit", "c", "-o", "f.ptm"]);
    run(at, &["procedural", "leather", "-o", "p", "--size", "32"]);
    let mut state = 1u32;
    for command in COMMANDS {
        let words: Vec<&str> = command.split(' ').collect();
        let out = at.join("out");
        fs::create_dir(&out).unwrap();
        let started = Instant::now();
        done(at, &words);
        let took = started.elapsed();
        let whole = tree(&out);
        let (mut cut_short, mut left) = (0, 0);
        for _ in 0..KILLS {
            fs::remove_dir_all(&out).unwrap();
            fs::create_dir(&out).unwrap();
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let share = f64::from(state >> 8) / f64::from(1 << 24);
            let mut child = Command::new(env!("CARGO_BIN_EXE_relume"))
                .current_dir(at)
                .args(&words)
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .spawn()
                .unwrap();
            std::thread::sleep(Duration::from_secs_f64(1.05 * share * took.as_secs_f64()));
            child.kill().unwrap();
            let ended = child.wait().unwrap().success();
            let found = tree(&out);
            cut_short += u32::from(!ended);
            left += u32::from(!found.is_empty());
            for (name, bytes) in &found {
                assert!(whole.get(name) == Some(bytes), "{command}: {name} is not whole");
            }
            assert!(!ended || found.len() == whole.len(), "{command} ended without all of its files");
            // A folder appears at once with all of its files.
            let is_folder = whole.keys().all(|name| name.contains('/'));
            assert!(
                !is_folder || found.is_empty() || found.len() == whole.len(),
                "{command}: {:?}",
                found.keys()
            );
        }
        assert!(cut_short > 5, "{command}: {cut_short} of {KILLS} runs were killed, {left} left something");
        done(at, &[&words[..], &["--force"]].concat());
        assert!(tree(&out) == whole && !has_leftovers(&out), "{command}: after the kills");
        fs::remove_dir_all(&out).unwrap();
    }
    assert!(!has_leftovers(at));
}
