//! `relume fill`, `relume tileable` and the pixel methods of `relume synth` as a user runs them.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use relume::format::{Depth, PictureFormat, encode_picture, read_raster};
use relume::{Limits, Picture, Planes, Size, Space};

fn relume(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_relume")).current_dir(folder).args(arguments).output().unwrap()
}

fn made(folder: &Path, arguments: &[&str]) -> Vec<u8> {
    let output = relume(folder, arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// The sentence of a run that must fail as wrong usage and write nothing.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let before = fs::read_dir(folder).unwrap().count();
    let output = relume(folder, arguments);
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert_eq!(fs::read_dir(folder).unwrap().count(), before, "{arguments:?} left something behind");
    text
}

/// Writes a picture of 8-bit samples, `channels` a texel.
fn write_picture(path: &Path, size: Size, channels: usize, code: impl Fn(usize, usize, usize) -> u8) {
    let mut planes = Planes::zeros(size, channels);
    for k in 0..channels {
        for (texel, value) in planes.plane_mut(k).iter_mut().enumerate() {
            *value = f32::from(code(k, texel % size.width, texel / size.width)) / 255.0;
        }
    }
    let picture = Picture { planes, space: Space::Srgb };
    let bytes = encode_picture(&picture, PictureFormat::Png(Depth::Eight)).unwrap();
    fs::write(path, bytes).unwrap();
}

/// The samples of a picture, texel after texel.
fn samples(path: &Path) -> (Size, Vec<u32>) {
    let raster = read_raster(path, &Limits::default()).unwrap();
    let count = raster.size().texels() * raster.channels();
    (raster.size(), (0..count).map(|i| (raster.samples().value(i) * 255.0).round() as u32).collect())
}

const SIZE: Size = Size::new(36, 30);

/// A pattern of period 6 x 5 with three channels, and a blemish under the mask.
fn prepare(folder: &Path) {
    let in_hole = |x: usize, y: usize| (12..21).contains(&x) && (9..15).contains(&y);
    let pattern = |k: usize, x: usize, y: usize| ((x % 6 * 37 + y % 5 * 91 + k * 53) % 251) as u8;
    write_picture(&folder.join("clean.png"), SIZE, 3, pattern);
    let spoilt = |k, x, y| if in_hole(x, y) { 255 } else { pattern(k, x, y) };
    write_picture(&folder.join("spoilt.png"), SIZE, 3, spoilt);
    write_picture(&folder.join("mask.png"), SIZE, 1, |_, x, y| if in_hole(x, y) { 255 } else { 0 });
    write_picture(&folder.join("black.png"), SIZE, 1, |_, _, _| 0);
    write_picture(&folder.join("white.png"), SIZE, 1, |_, _, _| 255);
    write_picture(&folder.join("small.png"), Size::new(5, 5), 1, |_, _, _| 255);
}

#[test]
fn a_blemish_on_a_pattern_goes_without_a_trace() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    let truth = samples(&folder.path().join("clean.png"));
    for method in ["patches", "efros-leung"] {
        for more in [&[][..], &["--tile"][..]] {
            let mut arguments = vec!["fill", "spoilt.png", "--mask", "mask.png", "-o", "out.png", "--force"];
            arguments.extend(["--method", method, "--neighbourhood", "7", "--source-map", "map.npy"]);
            arguments.extend(more);
            made(folder.path(), &arguments);
            assert_eq!(samples(&folder.path().join("out.png")), truth, "{arguments:?}");
            assert!(folder.path().join("map.npy").exists());
        }
    }
}

#[test]
fn a_pattern_is_made_to_tile() {
    let folder = tempfile::tempdir().unwrap();
    // 41 x 33 is no multiple of the period, so the border has to give way somewhere.
    let size = Size::new(41, 33);
    let pattern = |k: usize, x: usize, y: usize| ((x % 6 * 37 + y % 5 * 91 + k * 53) % 251) as u8;
    write_picture(&folder.path().join("a.png"), size, 3, pattern);
    for method in ["patches", "efros-leung"] {
        let arguments =
            ["tileable", "a.png", "-o", "b.png", "--band", "6", "--neighbourhood", "7", "--force"];
        made(folder.path(), &[&arguments[..], &["--method", method]].concat());
        let (made_size, made) = samples(&folder.path().join("b.png"));
        let (_, given) = samples(&folder.path().join("a.png"));
        assert_eq!(made_size, size);
        for (texel, (new, old)) in made.chunks_exact(3).zip(given.chunks_exact(3)).enumerate() {
            let (x, y) = (texel % size.width, texel / size.width);
            let middle = (6..size.width - 6).contains(&x) && (6..size.height - 6).contains(&y);
            assert!(!middle || new == old, "texel ({x}, {y}) is not in the band");
        }
        assert_ne!(made, given);
    }
}

#[test]
fn textures_of_single_texels_are_the_same_at_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    for method in ["efros-leung", "wei-levoy", "patchmatch"] {
        let run = |threads: &str, output: &str| {
            let arguments =
                ["synth", "clean.png", "--method", method, "--neighbourhood", "5", "--size", "60x41"];
            let more = ["--tile", "--threads", threads, "-o", output, "--force", "--json"];
            let levels = if method == "efros-leung" { &[][..] } else { &["--levels", "3"] };
            let said = made(folder.path(), &[&arguments[..], &more, levels].concat());
            assert!(String::from_utf8_lossy(&said).contains(&format!("\"method\": \"{method}\"")));
            fs::read(folder.path().join(output)).unwrap()
        };
        assert_eq!(run("1", "1.png"), run("5", "5.png"));
    }
}

#[test]
fn what_cannot_be_filled_is_said() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    let fill = |mask: &str, more: &[&str]| {
        let arguments = ["fill", "spoilt.png", "-o", "out.png", "--mask", mask];
        refused(folder.path(), &[&arguments[..], more].concat())
    };
    assert!(fill("black.png", &[]).contains("no hole"));
    assert!(fill("white.png", &[]).contains("every texel"));
    let text = fill("small.png", &[]);
    assert!(text.contains("small.png") && text.contains("5 x 5") && text.contains("36 x 30"), "{text}");
    assert!(fill("mask.png", &["--neighbourhood", "8"]).contains("odd"));
    assert!(fill("mask.png", &["--neighbourhood", "31"]).contains("at most 30"));
    assert!(fill("mask.png", &["--source-map", "out.png"]).contains(".npy"));
    assert!(fill("mask.png", &["--exclude", "white.png"]).contains("no place"));
    let band = refused(folder.path(), &["tileable", "clean.png", "-o", "out.png", "--band", "15"]);
    assert!(band.contains("1 to 14"), "{band}");
    let synth = |more: &[&str]| {
        let arguments = ["synth", "clean.png", "-o", "out.png", "--size", "40"];
        refused(folder.path(), &[&arguments[..], more].concat())
    };
    assert!(synth(&["--neighbourhood", "5"]).contains("quilting"));
    assert!(synth(&["--method", "efros-leung", "--levels", "2"]).contains("wei-levoy"));
    assert!(synth(&["--method", "patchmatch", "--rounds", "0"]).contains("at least 1"));
    assert!(synth(&["--method", "patchmatch", "--epsilon", "0"]).contains("efros-leung"));
    assert!(synth(&["--method", "wei-levoy", "--levels", "5"]).contains("fewer levels"));
    assert!(synth(&["--method", "efros-leung", "--neighbourhood", "6"]).contains("odd"));
    assert!(synth(&["--method", "efros-leung", "--neighbourhood", "31"]).contains("window of at most 30"));
}
