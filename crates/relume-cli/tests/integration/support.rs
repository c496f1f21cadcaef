//! Running the program in tests, and exemplars shared by several of them.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;
use std::process::{Command, Output};

use relume::format::{Depth, PictureFormat, encode_picture};
use relume::procedural::{Material, MaterialOptions};
use relume::{Job, Picture, Size, Space};
use serde_json::Value;

pub fn relume(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relume")).current_dir(folder).args(arguments).output().unwrap()
}

/// A run that must succeed.
pub fn done(folder: &Path, arguments: &[&str]) -> Output {
    let output = relume(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Standard output of a run that must succeed.
pub fn run(folder: &Path, arguments: &[&str]) -> String {
    String::from_utf8(done(folder, arguments).stdout).unwrap()
}

/// The report of a run with `--json` that must succeed.
pub fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_slice(&done(folder, &[arguments, &["--json"]].concat()).stdout).unwrap()
}

/// The sentence on standard error of a run that must fail with `status` and leave nothing behind.
pub fn failed(folder: &Path, arguments: &[&str], status: i32) -> String {
    let before = fs::read_dir(folder).unwrap().count();
    let output = relume(folder, arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {text}");
    assert!(text.lines().count() == 1 || text.contains("try '--help'"), "{arguments:?}: {text}");
    assert_eq!(fs::read_dir(folder).unwrap().count(), before, "{arguments:?} left something behind");
    text
}

/// The sentence of a run that must fail as wrong usage.
pub fn refused(folder: &Path, arguments: &[&str]) -> String {
    failed(folder, arguments, 2)
}

/// The most resident memory of a running process so far; none once it has ended.
pub fn high_water_mark_kib(process: u32) -> Option<u64> {
    let status = fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse().ok()
}

/// The sorted names of what a folder holds.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Writes the colours of a built-in material with features of `feature` texels.
pub fn write_material(path: &Path, material: Material, size: Size, feature: f64) {
    let options = MaterialOptions { size, feature, ..MaterialOptions::default() };
    let maps = material.make(&options, &Job::default()).unwrap();
    let picture = Picture { planes: maps.albedo, space: Space::Linear };
    fs::write(path, encode_picture(&picture, PictureFormat::Png(Depth::Eight)).unwrap()).unwrap();
}

/// Writes a grey picture of 8 bits.
pub fn write_grey(path: &Path, (width, height): (u32, u32), codes: &[u8]) {
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.write_header().unwrap().write_image_data(codes).unwrap();
}

/// Codes without periods or a direction (a congruential generator; Knuth and Lewis).
pub fn grains(count: usize) -> Vec<u8> {
    let mut state = 1u32;
    let mut code = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    (0..count).map(|_| code()).collect()
}

/// The size of a PNG, and its samples as stored.
pub fn read_png(path: &Path) -> ((usize, usize), Vec<u8>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let mut samples = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut samples).unwrap();
    samples.truncate(info.buffer_size());
    ((info.width as usize, info.height as usize), samples)
}
