//! `relume synth --method auto` and `--method roller` as a user runs them.

use std::fs;

use relume::Size;
use relume::procedural::Material;
use serde_json::Value;

use crate::support::{done, json, read_png, refused, run, write_material};

/// A folder with pictures of a weave and of pebbles.
fn with_exemplars() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, material) in [("weave.png", Material::Weave), ("pebbles.png", Material::Pebbles)] {
        write_material(&folder.path().join(name), material, Size::new(96, 80), 12.0);
    }
    folder
}

#[test]
fn the_nearest_try_is_kept_and_its_options_make_it_again() {
    let folder = with_exemplars();
    for name in ["weave.png", "pebbles.png"] {
        let synth = ["synth", name, "-o", "auto.png", "--size", "128x112", "--force"];
        let found = json(folder.path(), &[&synth[..], &["--method", "auto"]].concat());
        let tries = found["auto"]["tries"].as_array().unwrap();
        let kept = found["auto"]["kept"].as_u64().unwrap() as usize;
        let distance = |one: &Value| one["appearance"]["distance"].as_f64().unwrap();
        let is_copy = |one: &Value| one["largest_piece"].as_f64().unwrap() > 0.5;
        // Each copy among the first seven is made again.
        let copies = tries[..7].iter().filter(|one| is_copy(one)).count();
        assert!(tries.len() == 7 + copies && tries.iter().any(|one| !is_copy(one)), "{found}");
        assert!(!is_copy(&tries[kept]));
        let others = tries.iter().filter(|one| !is_copy(one));
        assert!(others.map(distance).all(|d| d >= distance(&tries[kept])), "{found}");
        let made = fs::read(folder.path().join("auto.png")).unwrap();
        let options: Vec<&str> = found["auto"]["options"].as_str().unwrap().split(' ').collect();
        json(folder.path(), &[&synth[..], &options].concat());
        assert_eq!(fs::read(folder.path().join("auto.png")).unwrap(), made, "{options:?}");
        // Analysis gives the same advice.
        let analysis = json(folder.path(), &["analyze", name]);
        assert_eq!(analysis["advice"], found["auto"]["advice"]);
    }
}

/// A former riddle: the star stood at a figure that was not the smallest, and nothing said why.
#[test]
fn why_nearer_tries_are_not_kept_is_said() {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("clouds.png"), Material::Clouds, Size::new(64, 64), 12.0);
    let mut said = Vec::new();
    for seed in ["1", "2", "3"] {
        let synth =
            ["synth", "clouds.png", "-o", "o.png", "--size", "128x112", "--method", "auto", "--seed", seed];
        let text = run(folder.path(), &[&synth[..], &["--force"]].concat());
        let found = json(folder.path(), &[&synth[..], &["--force"]].concat());
        let tries = found["auto"]["tries"].as_array().unwrap();
        let distance = |one: &Value| one["appearance"]["distance"].as_f64().unwrap();
        let kept = distance(&tries[found["auto"]["kept"].as_u64().unwrap() as usize]);
        let is_nearer = tries.iter().any(|one| distance(one) < kept);
        assert_eq!(text.contains("nearer ones were not kept: they copy"), is_nearer, "{text}");
        said.push(is_nearer);
    }
    assert!(said.contains(&true) && said.contains(&false), "{said:?}");
}

#[test]
fn all_of_several_exemplars_are_analysed() {
    let folder = with_exemplars();
    let synth = ["synth", "pebbles.png", "weave.png", "-o", "o.png", "--size", "100", "--method", "auto"];
    let found = json(folder.path(), &[&synth[..], &["--tries", "3"]].concat());
    let alone = |name| json(folder.path(), &["analyze", name]);
    let (pebbles, weave) = (alone("pebbles.png"), alone("weave.png"));
    let analyses = found["auto"]["analyses"].as_array().unwrap();
    assert_eq!(
        analyses.iter().map(|one| &one["periods"]).collect::<Vec<_>>(),
        [&pebbles["periods"], &weave["periods"]]
    );
    let advice = &found["auto"]["advice"];
    assert_eq!(advice["kind"], weave["advice"]["kind"]);
    let reason = advice["reason"].as_str().unwrap();
    assert!(reason.contains("exemplar 1: ") && reason.contains("exemplar 2: regular"), "{reason}");
    assert!(!advice["ways"].to_string().contains("roller"), "tiles are made of one exemplar: {advice}");
}

#[test]
fn the_choice_does_not_depend_on_threads() {
    let folder = with_exemplars();
    let made = |threads: &str| {
        let synth = ["synth", "pebbles.png", "-o", "o.png", "--size", "100", "--method", "auto", "--force"];
        let all = [&synth[..], &["--source-map", "map.npy", "--threads", threads, "--tries", "3"]].concat();
        done(folder.path(), &all);
        ["o.png", "map.npy"].map(|name| fs::read(folder.path().join(name)).unwrap())
    };
    assert_eq!(made("1"), made("3"));
}

#[test]
fn blocks_that_are_asked_for_are_all_that_is_tried() {
    let folder = with_exemplars();
    let synth =
        ["synth", "weave.png", "-o", "o.png", "--size", "100", "--method", "auto", "--tile", "--force"];
    let options = |more: &[&str]| -> Vec<String> {
        let found = json(folder.path(), &[&synth[..], more].concat());
        let tries = found["auto"]["tries"].as_array().unwrap().clone();
        tries.iter().map(|one| one["options"].as_str().unwrap().to_owned()).collect()
    };
    let asked = options(&["--block", "20", "--seed", "5", "--tries", "2"]);
    assert_eq!(asked[0], "--block 20 --overlap 3 --seed 5");
    assert!(asked[1].starts_with("--block 20 --overlap 3 --seed "), "{asked:?}");
    // A former fault: the tries of seed 5 were those of seed 6 except for the first.
    let beside = options(&["--block", "20", "--seed", "6", "--tries", "2"]);
    assert!(asked.iter().all(|one| !beside.contains(one)), "{asked:?} {beside:?}");
    let overlapped = options(&["--overlap", "4"]);
    assert!(
        overlapped.iter().all(|one| one.starts_with("--block") && one.contains("--overlap 4 ")),
        "{overlapped:?}"
    );
    assert!(options(&[]).iter().any(|one| one.contains("roller")));
    // A single try is used unmeasured.
    let one = json(folder.path(), &[&synth[..], &["--tries", "1"]].concat());
    assert_eq!(one["auto"]["tries"][0]["appearance"], Value::Null);
}

/// Also where a copy was made again: its seed is printed like any other.
#[test]
fn printed_options_make_the_texture_that_was_kept() {
    let folder = with_exemplars();
    for seed in ["0", "1"] {
        let synth = ["synth", "pebbles.png", "--size", "90", "--force", "--tile"];
        let auto = ["-o", "auto.png", "--method", "auto", "--tries", "3", "--seed", seed];
        let found = json(folder.path(), &[&synth[..], &auto].concat());
        let options = found["auto"]["options"].as_str().unwrap();
        let again: Vec<&str> = ["-o", "again.png"].into_iter().chain(options.split(' ')).collect();
        done(folder.path(), &[&synth[..], &again].concat());
        let [auto, again] = ["auto.png", "again.png"].map(|name| fs::read(folder.path().join(name)).unwrap());
        assert!(auto == again, "{options}");
    }
}

/// A former fault: all tries were made at the full size, 138 s for 2048 x 2048.
#[test]
fn large_outputs_are_chosen_at_a_small_size_and_made_once() {
    let folder = with_exemplars();
    let synth = ["synth", "weave.png", "--size", "500x90", "--force"];
    let found = json(folder.path(), &[&synth[..], &["-o", "auto.png", "--method", "auto"]].concat());
    assert_eq!((&found["width"], &found["height"]), (&500.into(), &90.into()));
    let auto = &found["auto"];
    assert_eq!((&auto["trial_width"], &auto["trial_height"]), (&256.into(), &90.into()));
    let options = auto["options"].as_str().unwrap();
    done(
        folder.path(),
        &[&synth[..], &["-o", "again.png"], &options.split(' ').collect::<Vec<_>>()].concat(),
    );
    let [auto, again] = ["auto.png", "again.png"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(auto == again, "{options}");
}

/// A former fault: the choice did not see colours.
#[test]
fn the_choice_weighs_colours() {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("o.png"), Material::Marble, Size::new(128, 128), 40.0);
    let found = json(folder.path(), &["synth", "o.png", "-o", "a.png", "--size", "200", "--method", "auto"]);
    let tries = found["auto"]["tries"].as_array().unwrap();
    let kept = &tries[found["auto"]["kept"].as_u64().unwrap() as usize]["appearance"];
    let parts = ["patches", "colours", "detail", "direction", "order", "repetition"];
    let worst = |one: &Value| parts.iter().map(|part| one[part].as_f64().unwrap()).fold(0.0, f64::max);
    // The worst part decides: nothing that was tried is better by it than what was kept, but for a little.
    for one in tries.iter().filter(|one| one["largest_piece"].as_f64().is_some_and(|piece| piece <= 0.5)) {
        assert!(worst(kept) < 1.35 * worst(&one["appearance"]), "{found}");
    }
}

/// A former fault: a fire, dark above and bright below, was laid in patches of light and dark.
#[test]
fn a_material_that_changes_from_side_to_side_is_followed() {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("fire.png"), Material::Fire, Size::new(64, 64), 12.0);
    let synth = ["synth", "fire.png", "--size", "96", "--force"];
    let auto = ["-o", "auto.png", "--method", "auto", "--tries", "2"];
    let found = json(folder.path(), &[&synth[..], &auto].concat());
    let options = found["auto"]["options"].as_str().unwrap();
    assert!(found["auto"]["follows_trend"] == true && options.ends_with("--follow-trend"), "{found}");
    let again: Vec<&str> = ["-o", "again.png"].into_iter().chain(options.split(' ')).collect();
    done(folder.path(), &[&synth[..], &again].concat());
    let [auto, again] = ["auto.png", "again.png"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(auto == again, "{options}");
    // Three bands are as bright as those of the exemplar, stretched.
    let bands = |name: &str| {
        let (_, codes) = read_png(&folder.path().join(name));
        let band = codes.len() / 3;
        [0, 1, 2].map(|n| {
            let sum: f64 = codes[n * band..][..band].iter().map(|&code| f64::from(code)).sum();
            3.0 * sum / codes.len() as f64
        })
    };
    let (own, made) = (bands("fire.png"), bands("auto.png"));
    let range = own.iter().fold(0.0f64, |most, a| own.iter().fold(most, |most, b| most.max(a - b)));
    assert!(own.iter().zip(&made).all(|(a, b)| (a - b).abs() < 0.35 * range), "{own:?} {made:?}");
    let tile = json(
        folder.path(),
        &[&synth[..], &["-o", "auto.png", "--method", "auto", "--tries", "2", "--tile"]].concat(),
    );
    assert_eq!(tile["auto"]["follows_trend"], false);
    let more = |options: &[&str]| {
        refused(folder.path(), &[&synth[..], &["-o", "no.png", "--follow-trend"], options].concat())
    };
    assert!(more(&["--tile"]).contains("tiles"));
    assert!(more(&["--method", "roller"]).contains("--follow-trend does not apply"));
    let model = json(folder.path(), &["model", "fire.png", "-o", "fire.rlm"]);
    assert!(model["warnings"].to_string().contains("changes from side to side"), "{model}");
}

#[test]
fn a_plane_of_tiles_is_laid_with_its_source_map() {
    let folder = with_exemplars();
    let synth = ["synth", "weave.png", "-o", "o.png", "--method", "roller", "--force"];
    let laid = json(folder.path(), &[&synth[..], &["--size", "150x90", "--source-map", "map.npy"]].concat());
    let found =
        json(folder.path(), &["compare", "--texture", "weave.png", "o.png", "--source-map", "map.npy"]);
    let piece = laid["tile_width"].as_u64().unwrap() * laid["tile_height"].as_u64().unwrap();
    assert!(found["copying"]["largest_piece"].as_u64().unwrap() <= 4 * piece, "{found}");
    // The same plane as that of a tile set.
    done(folder.path(), &["roll", "weave.png", "-k", "4", "-o", "tiles.png"]);
    assert!(
        done(folder.path(), &["synth", "tiles.png", "-o", "plane.png", "--size", "150x90"]).status.success()
    );
    assert_eq!(json(folder.path(), &["compare", "o.png", "plane.png"])["rmse"], 0.0);
    let text = refused(folder.path(), &[&synth[..], &["--size", "151x90", "--tile"]].concat());
    assert!(text.contains("whole tiles"), "{text}");
}

#[test]
fn what_auto_cannot_do_is_said() {
    let folder = with_exemplars();
    let auto = ["synth", "weave.png", "-o", "o.png", "--size", "64", "--method", "auto"];
    let more = |options: &[&str]| refused(folder.path(), &[&auto[..], options].concat());
    assert!(more(&["--tries", "0"]).contains("0 tries cannot be made: choose 1 to 1000"));
    assert!(more(&["--levels", "3"]).contains("--levels"));
    assert!(more(&["--block", "90"]).contains("at most 80"));
    assert!(more(&["--overlap", "60"]).contains("overlap"));
    let other = ["synth", "weave.png", "-o", "o.png", "--size", "64"];
    assert!(refused(folder.path(), &[&other[..], &["--tries", "2"]].concat()).contains("auto"));
    assert!(refused(folder.path(), &[&other[..], &["--tiles", "2"]].concat()).contains("roller"));
    let window = ["synth", "weave.png", "-o", "o.png", "--window", "0,0,64,64", "--method", "auto"];
    assert!(refused(folder.path(), &window).contains("--window"));
}
