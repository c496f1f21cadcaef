//! `relume compare` and `relume analyze` as a user runs them.

use relume::Size;
use relume::procedural::Material;
use serde_json::Value;

use crate::support::{done, json, refused, write_material};

/// A folder with a picture of a weave.
fn with_weave() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("weave.png"), Material::Weave, Size::new(96, 80), 18.0);
    folder
}

#[test]
fn a_texture_is_at_no_distance_from_itself() {
    let folder = with_weave();
    let same = json(folder.path(), &["compare", "weave.png", "weave.png"]);
    assert_eq!((&same["rmse"], &same["psnr_db"]), (&Value::from(0.0), &Value::Null));
    let same = json(folder.path(), &["compare", "--texture", "weave.png", "weave.png"]);
    for measure in ["sliced", "histogram", "autocorrelation", "spectrum_db", "steerable"] {
        assert!(same["worst"][measure].as_f64().unwrap().abs() < 1e-9, "{measure}: {same}");
    }
    for part in ["distance", "patches", "colours", "detail", "direction", "order", "repetition"] {
        assert_eq!(same["worst"]["appearance"][part], 0.0, "{part}: {same}");
    }
}

#[test]
fn synthesis_is_measured_with_its_source_map_in_both_formats() {
    let folder = with_weave();
    for map in ["map.npy", "map.exr"] {
        let synth = [
            "synth",
            "weave.png",
            "-o",
            "big.png",
            "--size",
            "128",
            "--block",
            "24",
            "--source-map",
            map,
            "--force",
        ];
        done(folder.path(), &synth);
        let found =
            json(folder.path(), &["compare", "--texture", "weave.png", "big.png", "--source-map", map]);
        let coverage = found["copying"]["coverage"].as_f64().unwrap();
        let share = found["seams"]["share"].as_f64().unwrap();
        assert!((0.1..=1.0).contains(&coverage) && share > 0.0 && share < 0.5, "{found}");
        assert!(found["seams"]["ratio"].as_f64().unwrap() > 0.0);
        assert!(found["wrap"]["right_to_left"]["ratio"].as_f64().unwrap() > 0.0);
        // The map belongs to the large texture, not to the exemplar.
        let text =
            refused(folder.path(), &["compare", "--texture", "big.png", "weave.png", "--source-map", map]);
        assert!(text.contains("128 x 128") && text.contains("96 x 80"), "{text}");
    }
}

#[test]
fn functions_are_compared_under_several_lights() {
    let folder = tempfile::tempdir().unwrap();
    let capture = ["capture", "sponge", "-o", "sponge", "--size", "48", "--lights", "12"];
    done(folder.path(), &capture);
    done(folder.path(), &["fit", "sponge", "-o", "sponge.ptm"]);
    done(folder.path(), &["fit", "sponge", "-o", "sponge.exr"]);
    let found = json(folder.path(), &["compare", "sponge.exr", "sponge.ptm", "--lights", "3"]);
    assert_eq!(found["lights"].as_array().unwrap().len(), 3);
    // The two files hold the same photographs in other models: close, but equal nowhere.
    let (mean, worst) = (found["psnr_db"].as_f64().unwrap(), found["worst"]["psnr_db"].as_f64().unwrap());
    assert!(worst > 20.0 && worst <= mean && mean < 60.0, "{found}");
    let found = json(folder.path(), &["compare", "--texture", "sponge.exr", "sponge.ptm", "--lights", "3"]);
    assert_eq!(found["by_light"].as_array().unwrap().len(), 3);
    assert!(found["mean"]["sliced"].as_f64() <= found["worst"]["sliced"].as_f64());
}

#[test]
fn analysis_finds_the_weave_and_draws_it() {
    let folder = with_weave();
    let found = json(folder.path(), &["analyze", "weave.png", "-o", "drawn.png"]);
    let basis = &found["periods"]["pattern"]["lattice"]["basis"];
    assert!(basis[0][0].as_f64().is_some_and(|x| (x - 9.6).abs() < 0.5), "{found}");
    assert_eq!(found["advice"]["kind"], "regular");
    let png = std::fs::read(folder.path().join("drawn.png")).unwrap();
    assert_eq!(png[16..24], [0, 0, 1, 32, 0, 0, 0, 80], "288 x 80 texels");
    let text = refused(folder.path(), &["analyze", "weave.png", "-o", "drawn.png"]);
    assert!(text.contains("--force"), "{text}");
}

#[test]
fn what_cannot_be_compared_is_said() {
    let folder = with_weave();
    let crop = ["synth", "weave.png", "-o", "small.png", "--size", "32", "--block", "16"];
    done(folder.path(), &crop);
    assert!(refused(folder.path(), &["compare", "weave.png", "small.png"]).contains("--texture"));
    assert!(refused(folder.path(), &["compare", "-", "-"]).contains("once"));
    refused(folder.path(), &["compare", "weave.png", "weave.png", "--source-map", "map.npy"]);
    refused(folder.path(), &["compare", "weave.png", "weave.png", "--lights", "0"]);
}
