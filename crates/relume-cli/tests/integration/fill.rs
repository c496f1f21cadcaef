//! `relume fill`, `relume tileable` and the pixel methods of `relume synth` as a user runs them.

use std::fs;
use std::path::Path;

use relume::format::{Depth, PictureFormat, encode_picture, read_raster};
use relume::{Job, Picture, Planes, Size, Space};

use crate::support::{failed, json, refused, run};

/// Writes a picture of 8-bit samples, with `channels` per texel.
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

/// The samples of a picture, texel by texel.
fn samples(path: &Path) -> (Size, Vec<u32>) {
    let raster = read_raster(path, &Job::default()).unwrap();
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
            run(folder.path(), &arguments);
            assert_eq!(samples(&folder.path().join("out.png")), truth, "{arguments:?}");
            assert!(folder.path().join("map.npy").exists());
        }
    }
}

#[test]
fn registered_images_are_filled_from_the_same_places() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path());
    let at = |name: &str| folder.path().join(name);
    // The number of each texel in its channels, so that a copy reveals its source.
    write_picture(&at("where.png"), SIZE, 3, |k, x, y| [x as u8, y as u8, 0][k]);
    let fill = ["fill", "spoilt.png", "--mask", "mask.png", "-o", "out.png"];
    let band = ["tileable", "spoilt.png", "--band", "7", "-o", "out.png"];
    for (verb, method) in [(&fill[..], "patches"), (&fill, "efros-leung"), (&band, "patches")] {
        let more = ["--apply", "where.png", "--neighbourhood", "7", "--force", "--method", method];
        run(folder.path(), &[verb, &more].concat());
        let (_, new) = samples(&at("out.png"));
        let (_, old) = samples(&at("spoilt.png"));
        let (size, places) = samples(&at("out_where.png"));
        assert_eq!(size, SIZE);
        let mut moved = 0;
        for (texel, place) in places.chunks_exact(3).enumerate() {
            let from = place[1] as usize * SIZE.width + place[0] as usize;
            assert_eq!(new[3 * texel..][..3], old[3 * from..][..3], "{verb:?} texel {texel}");
            moved += usize::from(from != texel);
        }
        assert!(moved > 40, "{verb:?} filled {moved}");
    }
    let text = failed(folder.path(), &[&fill[..], &["--force", "--apply", "small.png"]].concat(), 1);
    assert!(text.contains("small.png") && text.contains("36 x 30"), "{text}");
}

#[test]
fn a_pattern_is_made_to_tile() {
    let folder = tempfile::tempdir().unwrap();
    // 41 x 33 is not a multiple of the period, so the border has to give way somewhere.
    let size = Size::new(41, 33);
    let pattern = |k: usize, x: usize, y: usize| ((x % 6 * 37 + y % 5 * 91 + k * 53) % 251) as u8;
    write_picture(&folder.path().join("a.png"), size, 3, pattern);
    for method in ["patches", "efros-leung"] {
        let arguments =
            ["tileable", "a.png", "-o", "b.png", "--band", "6", "--neighbourhood", "7", "--force"];
        run(folder.path(), &[&arguments[..], &["--method", method]].concat());
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
    let ways: [(&str, &[&str], bool); 7] = [
        ("efros-leung", &[], false),
        ("efros-leung", &["--tile"], true),
        ("wei-levoy", &["--levels", "3"], false),
        ("wei-levoy", &["--levels", "3", "--coherence", "1"], false),
        ("wei-levoy", &["--levels", "3", "--tile"], true),
        ("wei-levoy", &["--levels", "2", "--coherence", "3", "--codewords", "9"], false),
        ("patchmatch", &["--levels", "3"], true),
    ];
    for (method, special, tiles) in ways {
        let textured = |threads: &str, output: &str| {
            let arguments =
                ["synth", "clean.png", "--method", method, "--neighbourhood", "5", "--size", "60x41"];
            let more = ["--threads", threads, "-o", output, "--force"];
            let said = json(folder.path(), &[&arguments[..], &more, special].concat());
            assert_eq!((said["method"].as_str(), said["tile"].as_bool()), (Some(method), Some(tiles)));
            assert_eq!(said["wrap"]["shows"].is_boolean(), tiles, "what is said of tiling is measured");
            fs::read(folder.path().join(output)).unwrap()
        };
        assert_eq!(textured("1", "1.png"), textured("5", "5.png"));
    }
}

#[test]
fn outputs_follow_their_guide() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // Two halves of the same noise that only the guide distinguishes.
    let size = Size::new(64, 40);
    let noise = |x: usize, y: usize| ((x * 7919 + y * 104_729 + x * y * 31) % 97) as u8;
    write_picture(&at("a.png"), size, 3, |k, x, y| [x as u8, 0, noise(x, y)][k]);
    write_picture(&at("noise.png"), size, 1, |_, x, y| noise(x, y));
    write_picture(&at("from.png"), size, 1, |_, x, _| if x < 32 { 0 } else { 255 });
    let target = |x: usize, y: usize| (x as i32 - 30).pow(2) + (y as i32 - 24).pow(2) < 18 * 18;
    write_picture(&at("to.png"), Size::new(60, 48), 1, |_, x, y| if target(x, y) { 255 } else { 0 });
    let ways: [&[&str]; 4] = [
        &["--block", "8"],
        &["--method", "efros-leung", "--neighbourhood", "7"],
        &["--method", "wei-levoy", "--levels", "2"],
        &["--method", "patchmatch", "--levels", "3"],
    ];
    for way in ways {
        let arguments =
            ["synth", "noise.png", "-o", "o.png", "--size", "60x48", "--apply", "a.png", "--force"];
        let followed = |guide: &[&str]| {
            run(folder.path(), &[&arguments[..], way, guide].concat());
            let (_, places) = samples(&at("o_a.png"));
            let agrees = |(i, place): (usize, &[u32])| (place[0] >= 32) == target(i % 60, i / 60);
            places.chunks_exact(3).enumerate().filter(|one| agrees(*one)).count() as f64 / (60.0 * 48.0)
        };
        let guided =
            followed(&["--guide-source", "from.png", "--guide-target", "to.png", "--guide-weight", "4"]);
        let free = followed(&[]);
        assert!(guided > 0.85 && free < 0.75, "{way:?}: {guided} guided, {free} free");
    }
    let synth = |more: &[&str]| {
        let arguments = ["synth", "noise.png", "-o", "new.png", "--guide-source", "from.png"];
        refused(folder.path(), &[&arguments[..], more].concat())
    };
    let text = synth(&["--size", "50", "--guide-target", "to.png", "--block", "8"]);
    assert!(text.contains("60 x 48") && text.contains("50 x 50"), "{text}");
    assert!(synth(&["--size", "60x48", "--block", "8"]).contains("--guide-target"));
    let to = ["--size", "60x48", "--guide-target", "to.png"];
    assert!(synth(&[&to[..], &["--method", "noise"]].concat()).contains("--guide-source has no meaning"));
    assert!(synth(&[&to[..], &["--block", "8", "--guide-weight", "0"]].concat()).contains("from 0.000001"));
}

#[test]
fn holes_and_bands_follow_their_guide() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    // A stripe of the same noise that only the guide distinguishes; it moves the border of the stripe in the
    // hole.
    let size = Size::new(56, 40);
    let in_hole = |x: usize, y: usize| (16..40).contains(&x) && (9..31).contains(&y);
    let stripe = |x: usize| (14..42).contains(&x);
    let asked = |x: usize, y: usize| stripe(x) && !(in_hole(x, y) && x < 24);
    write_picture(&at("noise.png"), size, 1, |_, x, y| ((x * 7919 + y * 104_729 + x * y * 31) % 97) as u8);
    write_picture(&at("where.png"), size, 3, |k, x, y| [x as u8, y as u8, 0][k]);
    write_picture(&at("mask.png"), size, 1, |_, x, y| if in_hole(x, y) { 255 } else { 0 });
    write_picture(&at("guide.png"), size, 1, |_, x, y| if asked(x, y) { 255 } else { 0 });
    write_picture(&at("small.png"), Size::new(5, 5), 1, |_, _, _| 255);
    let fill = ["fill", "noise.png", "--mask", "mask.png"];
    for (verb, guided_at_least) in [(&fill[..], 0.85), (&["tileable", "noise.png", "--band", "9"], 0.8)] {
        for method in ["patches", "efros-leung"] {
            let arguments = ["-o", "o.png", "--apply", "where.png", "--force", "--neighbourhood", "7"];
            let followed = |guide: &[&str]| {
                run(folder.path(), &[verb, &arguments, &["--method", method], guide].concat());
                let (_, places) = samples(&at("o_where.png"));
                let moved = places.chunks_exact(3).enumerate().map(|(i, place)| (i % 56, i / 56, place));
                let moved = moved.filter(|(x, y, from)| (*x as u32, *y as u32) != (from[0], from[1]));
                let agree =
                    moved.map(|(x, y, from)| asked(x, y) == stripe(from[0] as usize)).collect::<Vec<bool>>();
                agree.iter().filter(|agree| **agree).count() as f64 / agree.len() as f64
            };
            let (guided, free) = (followed(&["--guide", "guide.png", "--guide-weight", "4"]), followed(&[]));
            assert!(
                guided > guided_at_least && free < 0.75,
                "{verb:?} {method}: {guided} guided, {free} free"
            );
        }
    }
    let failed = |more: &[&str]| refused(folder.path(), &[&fill[..], &["-o", "new.png"], more].concat());
    let text = failed(&["--guide", "small.png"]);
    assert!(text.contains("small.png") && text.contains("5 x 5") && text.contains("56 x 40"), "{text}");
    assert!(failed(&["--guide", "guide.png", "--guide-weight", "0"]).contains("from 0.000001"));
    assert!(failed(&["--guide-weight", "2"]).contains("--guide"));
    assert!(failed(&["--guide", "guide.png", "--source-map", "guide.png"]).contains("guide.png"));
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
    let other_size = ["fill", "spoilt.png", "-o", "out.png", "--mask", "small.png"];
    let text = failed(folder.path(), &other_size, 1);
    assert!(text.contains("small.png") && text.contains("5 x 5") && text.contains("36 x 30"), "{text}");
    assert!(fill("mask.png", &["--neighbourhood", "8"]).contains("odd"));
    assert!(fill("mask.png", &["--neighbourhood", "31"]).contains("at most 29"));
    assert!(fill("mask.png", &["--source-map", "out.png"]).contains("two outputs"));
    assert!(fill("mask.png", &["--source-map", "map.txt"]).contains(".npy"));
    assert!(fill("mask.png", &["--exclude", "white.png"]).contains("no place"));
    let band = refused(folder.path(), &["tileable", "clean.png", "-o", "out.png", "--band", "15"]);
    assert!(band.contains("1 to 14"), "{band}");
    assert!(fill("mask.png", &["--method", "patchmatch"]).contains("textures that tile"));
    assert!(fill("mask.png", &["--method", "patchmatch", "--tile", "--epsilon", "1"]).contains("--epsilon"));
    let synth = |more: &[&str]| {
        let arguments = ["synth", "clean.png", "-o", "out.png", "--size", "40"];
        refused(folder.path(), &[&arguments[..], more].concat())
    };
    assert!(synth(&["--neighbourhood", "5"]).contains("quilting"));
    assert!(synth(&["--method", "efros-leung", "--levels", "2"]).contains("wei-levoy"));
    assert!(synth(&["--method", "wei-levoy", "--coherence", "0"]).contains("choose 1 to 256"));
    assert!(synth(&["--method", "patchmatch", "--block", "8"]).contains("quilting"));
    assert!(synth(&["--method", "patchmatch", "--rounds", "0"]).contains("1 to 1000"));
    assert!(synth(&["--method", "patchmatch", "--epsilon", "0"]).contains("efros-leung"));
    assert!(synth(&["--method", "wei-levoy", "--levels", "5"]).contains("fewer levels"));
    assert!(synth(&["--method", "efros-leung", "--neighbourhood", "6"]).contains("odd"));
    assert!(synth(&["--method", "efros-leung", "--neighbourhood", "31"]).contains("window of at most 29"));
}
