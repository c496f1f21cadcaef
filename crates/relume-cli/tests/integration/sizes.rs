//! Sizes that are not given fit the exemplar.

use std::fs;
use std::path::Path;

use relume::Size;
use relume::procedural::Material;

use crate::support::{done, json, refused, relume, run, write_grey, write_material};

/// A former fault: blocks of 32 did not fit exemplars of 31 and 16 texels, four levels none of 32.
#[test]
fn defaults_fit_any_exemplar_of_eight_texels_and_more() {
    let folder = tempfile::tempdir().unwrap();
    for side in [8, 9, 16, 31, 32, 33] {
        write_material(&folder.path().join("o.png"), Material::Pebbles, Size::new(side, side + 1), 6.0);
        for method in ["quilting", "efros-leung", "wei-levoy", "patchmatch"] {
            let synth =
                ["synth", "o.png", "-o", "made.png", "--force", "--size", "35x41", "--method", method];
            for tile in [&[][..], &["--tile"]] {
                let found = json(folder.path(), &[&synth[..], tile].concat());
                assert!(
                    !found["advised"]["chosen"].as_array().unwrap().is_empty(),
                    "{side} {method}: {found}"
                );
            }
        }
        let mut holes = vec![0; side * (side + 1)];
        holes[side / 2] = 255;
        write_grey(&folder.path().join("mask.png"), (side as u32, side as u32 + 1), &holes);
        done(folder.path(), &["fill", "o.png", "--mask", "mask.png", "-o", "filled.png", "--force"]);
        done(folder.path(), &["tileable", "o.png", "-o", "tile.png", "--force"]);
        for method in ["auto", "roller"] {
            says_what_is_needed(folder.path(), method);
        }
    }
}

/// The texture is made, or one sentence names the sides needed.
fn says_what_is_needed(folder: &Path, method: &str) {
    let output =
        relume(folder, &["synth", "o.png", "-o", "made.png", "--force", "--size", "48", "--method", method]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success() || text.contains("at least") || text.contains("choose"),
        "{method}: {text}"
    );
}

/// A former fault: blocks of 32 whatever the size of the exemplar and of its features.
#[test]
fn blocks_are_those_that_the_analysis_suggests_first() {
    let folder = tempfile::tempdir().unwrap();
    for (material, side) in [(Material::Sponge, 96), (Material::Weave, 180), (Material::Leather, 128)] {
        write_material(&folder.path().join("o.png"), material, Size::new(side, side), 12.0);
        let advice = &json(folder.path(), &["analyze", "o.png"])["advice"]["ways"][0];
        let found = json(folder.path(), &["synth", "o.png", "-o", "made.png", "--force", "--size", "200"]);
        assert_eq!((&found["block"], &found["overlap"]), (&advice["block"], &advice["overlap"]), "{found}");
    }
}

#[test]
fn what_was_chosen_is_reported_and_a_small_sample_gets_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("o.png"), Material::Pebbles, Size::new(128, 128), 8.0);
    let text = run(folder.path(), &["synth", "o.png", "-o", "a.png", "--size", "160"]);
    assert!(text.contains("block and overlap fitted to features of "), "{text}");
    let given = json(folder.path(), &["synth", "o.png", "-o", "b.png", "--size", "160", "--block", "20"]);
    assert!(given.get("advised").is_none(), "{given}");
    // A former fault: a sample of 32 texels was repeated without a word.
    write_material(&folder.path().join("small.png"), Material::Pebbles, Size::new(32, 32), 16.0);
    let output = done(folder.path(), &["synth", "small.png", "-o", "c.png", "--size", "160"]);
    let all = [output.stdout, output.stderr].concat();
    assert!(String::from_utf8_lossy(&all).contains("only a few features"));
}

/// A former fault: a weave of 30.8 texels cracked across a tile of 512 texels without a word.
#[test]
fn tiles_that_hold_no_whole_periods_name_a_size_that_does() {
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), &["procedural", "weave", "-o", "weave", "--size", "256", "--feature", "28"]);
    let warned = |more: &[&str]| {
        let synth = [&["synth", "weave/albedo.png", "-o", "tile.png", "--force"], more].concat();
        json(folder.path(), &synth)["warnings"]
            .to_string()
            .contains("does not repeat a whole number of times")
    };
    assert!(warned(&["--size", "200", "--tile"]));
    assert!(!warned(&["--size", "215", "--tile"]) && !warned(&["--size", "200"]));
}

#[test]
fn sizes_stay_within_masks_and_outputs() {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("o.png"), Material::Pebbles, Size::new(96, 96), 12.0);
    // Only a corner of 20 texels may be used.
    let mask: Vec<u8> = (0..96 * 96).map(|i| if i % 96 < 20 && i / 96 < 20 { 0 } else { 255 }).collect();
    write_grey(&folder.path().join("mask.png"), (96, 96), &mask);
    for method in ["quilting", "efros-leung"] {
        let synth = ["synth", "o.png", "-o", "m.png", "--size", "50", "--force", "--exclude", "mask.png"];
        done(folder.path(), &[&synth[..], &["--method", method]].concat());
    }
    for side in ["8", "20", "33"] {
        let synth = ["synth", "o.png", "-o", "t.png", "--size", side, "--force", "--tile"];
        done(folder.path(), &synth);
        done(folder.path(), &[&synth[..], &["--overlap", "2", "--feather", "2"]].concat());
    }
    let text = refused(folder.path(), &["synth", "o.png", "-o", "n.png", "--size", "64", "--feather", "60"]);
    assert!(text.contains("feathered by 60"), "{text}");
    assert!(!fs::exists(folder.path().join("n.png")).unwrap());
}
