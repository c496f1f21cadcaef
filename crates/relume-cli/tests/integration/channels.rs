//! Opacity, masks and colour profiles as a user meets them: nothing is dropped or converted without a word.

use std::fs::{self, File};
use std::path::Path;

use relume::format::decode_field;
use relume::{Job, Size};
use serde_json::Value;

use crate::support::{json, run};

const SIZE: Size = Size::new(48, 40);
/// Of the transparent texels, and of no others.
const HIDDEN: [u8; 3] = [250, 0, 250];

fn write_rgba(path: &Path, texel: impl Fn(usize, usize) -> [u8; 4]) {
    let mut encoder = png::Encoder::new(File::create(path).unwrap(), SIZE.width as u32, SIZE.height as u32);
    encoder.set_color(png::ColorType::Rgba);
    let texels = (0..SIZE.texels()).flat_map(|i| texel(i % SIZE.width, i / SIZE.width));
    encoder.write_header().unwrap().write_image_data(&texels.collect::<Vec<u8>>()).unwrap();
}

/// A pattern whose right part is transparent and whose left part is partly so.
fn leaf(x: usize, y: usize) -> [u8; 4] {
    if x >= 36 {
        return [HIDDEN[0], HIDDEN[1], HIDDEN[2], 0];
    }
    let value = (x % 6 * 37 + y % 5 * 31) as u8;
    [value, 255 - value, 90, if x.is_multiple_of(6) { 128 } else { 255 }]
}

fn opaque(x: usize, y: usize) -> [u8; 4] {
    let [r, g, b, _] = leaf(x % 36, y);
    [r, g, b, 255]
}

fn warnings(report: &Value) -> Vec<String> {
    report["warnings"].as_array().unwrap().iter().map(|w| w.as_str().unwrap().to_owned()).collect()
}

/// The texels of a written picture with their opacity.
fn texels(path: &Path) -> Vec<[u8; 4]> {
    let file = decode_field(&fs::read(path).unwrap(), &Job::default()).unwrap();
    let planes = file.field.coefficients();
    let code = |value: f32| (value * 255.0).round() as u8;
    let alpha = |i: usize| file.opacity.as_ref().map_or(255, |opacity| code(opacity.plane(0)[i]));
    let texel = |i| [0, 1, 2].map(|c: usize| code(planes.plane(c)[i]));
    (0..planes.size().texels()).map(|i| [texel(i)[0], texel(i)[1], texel(i)[2], alpha(i)]).collect()
}

#[test]
fn transparent_texels_are_not_copied_and_the_output_keeps_the_opacity() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_rgba(&at("leaf.png"), leaf);
    let known: Vec<[u8; 4]> = (0..36 * 40).map(|i| leaf(i % 36, i / 36)).collect();
    for arguments in [
        &["synth", "leaf.png", "-o", "out.png", "--size", "50x44", "--block", "12"][..],
        &["synth", "leaf.png", "-o", "out.png", "--size", "30", "--method", "efros-leung"],
        &["synth", "leaf.png", "-o", "out.tif", "--size", "50x44", "--block", "12"],
        &["roll", "leaf.png", "-o", "out.png", "--period", "6,5", "--overlap", "3"],
    ] {
        let report = json(folder.path(), &[arguments, &["--force"]].concat());
        let found = warnings(&report);
        assert!(found.iter().any(|w| w.contains("leaf.png: 480 texels are transparent")), "{found:?}");
        assert!(found.iter().any(|w| w.contains("240 texels are partly transparent")), "{found:?}");
        let made = texels(&at(arguments[3]));
        assert!(made.iter().all(|texel| known.contains(texel)), "{arguments:?}");
        assert!(made.iter().any(|texel| texel[3] == 128), "{arguments:?}");
    }
}

#[test]
fn an_opaque_alpha_stays_without_any_word() {
    let folder = tempfile::tempdir().unwrap();
    write_rgba(&folder.path().join("opaque.png"), opaque);
    let report =
        json(folder.path(), &["synth", "opaque.png", "-o", "out.png", "--size", "50", "--block", "12"]);
    assert!(warnings(&report).is_empty(), "{report}");
}

#[test]
fn images_of_apply_keep_their_opacity_and_a_format_without_one_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    write_rgba(&at("plain.png"), opaque);
    write_rgba(&at("cover.png"), |x, y| [x as u8, y as u8, 0, (x * 5) as u8]);
    let arguments = ["synth", "plain.png", "-o", "out.jpg", "--size", "30", "--block", "12"];
    let report = json(folder.path(), &[&arguments[..], &["--apply", "cover.png"]].concat());
    assert!(warnings(&report).is_empty(), "{report}");
    for [x, y, _, alpha] in texels(&at("out_cover.png")) {
        assert!(usize::from(y) < SIZE.height && alpha == x * 5);
    }
    write_rgba(&at("leaf.png"), leaf);
    let report =
        json(folder.path(), &["synth", "leaf.png", "-o", "leaf.jpg", "--size", "30", "--block", "12"]);
    let found = warnings(&report);
    assert!(found.iter().any(|w| w.contains("leaf.jpg: this format holds no opacity")), "{found:?}");
}

#[test]
fn a_hole_may_be_painted_in_the_opacity_of_its_mask() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let in_hole = |x: usize, y: usize| (12..20).contains(&x) && (9..15).contains(&y);
    write_rgba(&at("spoilt.png"), |x, y| if in_hole(x, y) { [1, 2, 3, 255] } else { opaque(x, y) });
    write_rgba(&at("strokes.png"), |x, y| [0, 0, 0, if in_hole(x, y) { 255 } else { 0 }]);
    run(folder.path(), &["fill", "spoilt.png", "--mask", "strokes.png", "-o", "out.png"]);
    assert!(!texels(&at("out.png")).contains(&[1, 2, 3, 255]));
}

#[test]
fn verbs_without_use_for_opacity_say_so_once() {
    let folder = tempfile::tempdir().unwrap();
    write_rgba(&folder.path().join("leaf.png"), leaf);
    for arguments in [
        &["compare", "leaf.png", "leaf.png"][..],
        &["analyze", "leaf.png"],
        &["relight", "leaf.png", "-o", "lit.png", "--light", "0,0,1"],
        &["model", "leaf.png", "-o", "leaf.rlm", "--levels", "1"],
        &["match", "leaf.png", "--to", "leaf.png", "-o", "matched.png"],
    ] {
        let found = warnings(&json(folder.path(), arguments));
        let about =
            found.iter().filter(|w| w.contains("leaf.png: its opacity (alpha) is not used here")).count();
        assert_eq!(about, 1, "{arguments:?}: {found:?}");
    }
}
