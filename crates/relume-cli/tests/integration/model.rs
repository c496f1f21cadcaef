//! `relume model` and `relume synth MODEL.rlm` as a user runs them.

use std::fs;
use std::path::Path;

use relume::field::{Basis, PlaneLayout};
use relume::format::{
    FieldFormat, HeightFormat, PictureFormat, encode_field, encode_height, read_field, read_height,
};
use relume::procedural::{Material, MaterialOptions};
use relume::{Job, ReflectanceField, Size, Space};

use crate::support::{failed, json, refused, run};

/// A folder with a colour picture and its model.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let options = MaterialOptions { size: Size::new(64, 64), feature: 12.0, ..Default::default() };
    let albedo = Material::Leather.make(&options, &Job::default()).unwrap().albedo;
    let field = ReflectanceField::new(Basis::Constant, PlaneLayout::RGB, Space::Srgb, albedo).unwrap();
    let format = FieldFormat::Picture(PictureFormat::from_path(Path::new("a.png")).unwrap());
    let bytes = encode_field(&field, format, None, &Job::default()).unwrap();
    fs::write(folder.path().join("leather.png"), bytes).unwrap();
    let model = [
        "model",
        "leather.png",
        "-o",
        "leather.rlm",
        "--candidates",
        "12",
        "--combine",
        "never",
        "--levels",
        "4",
    ];
    run(folder.path(), &model);
    folder
}

#[test]
fn windows_of_a_model_fit_together_and_the_model_is_small() {
    let folder = folder();
    let folder = folder.path();
    assert!(fs::metadata(folder.join("leather.rlm")).unwrap().len() < 2000);
    run(folder, &["synth", "leather.rlm", "-o", "whole.png", "--window", "-30,-20,90,70"]);
    run(folder, &["synth", "leather.rlm", "-o", "part.png", "--window", "15,5,40,30", "--threads", "1"]);
    let read = |name: &str| read_field(&folder.join(name), &Job::default()).unwrap().field;
    let whole = read("whole.png").coefficients().crop(45, 25, Size::new(40, 30)).unwrap();
    assert_eq!(&whole, read("part.png").coefficients());
}

#[test]
fn windows_of_functions_hold_the_same_bytes_however_they_are_cut() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["capture", "weave", "-o", "c", "--size", "80", "--lights", "12", "--feature", "10"]);
    run(folder, &["fit", "c", "-o", "weave.ptm"]);
    let read = |name: &str| read_field(&folder.join(name), &Job::default()).unwrap();
    for combine in ["always", "never"] {
        let model =
            ["model", "weave.ptm", "-o", "w.rlm", "--candidates", "6", "--combine", combine, "--force"];
        run(folder, &model);
        let draw = |name: &str, window: &str, seed: &str| {
            run(folder, &["synth", "w.rlm", "-o", name, "--window", window, "--seed", seed, "--force"]);
            read(name)
        };
        let whole = draw("whole.ptm", "-150,90,300,200", "0");
        let part = draw("part.ptm", "-31,100,97,160", "0");
        assert_eq!(whole.encoding, part.encoding, "{combine}");
        let cut = whole.field.coefficients().crop(119, 10, Size::new(97, 160)).unwrap();
        assert_eq!(&cut, part.field.coefficients(), "{combine}");
        let other = draw("other.ptm", "4000,-70000,20,20", "5");
        assert_eq!(whole.encoding, other.encoding, "{combine}");
        assert_ne!(
            other.field.coefficients(),
            draw("other.ptm", "4000,-70000,20,20", "6").field.coefficients()
        );
    }
}

#[test]
fn a_window_larger_than_the_memory_allowed_is_drawn_in_bands() {
    let folder = folder();
    let folder = folder.path();
    let least = ["--memory", "0.1"];
    for (size, more) in [("2000x1700", &[][..]), ("1600x1704", &["--tile"])] {
        let draw = |name| [&["synth", "leather.rlm", "-o", name, "--size", size, "--force"], more].concat();
        run(folder, &[&draw("large.png")[..], &least].concat());
        // Files that are not written in rows are made as a whole, which takes 0.38 GiB.
        assert!(failed(folder, &[&draw("once.tif")[..], &least].concat(), 1).contains("memory"));
        run(folder, &draw("once.tif"));
        let read = |name: &str| read_field(&folder.join(name), &Job::default()).unwrap().field;
        assert_eq!(read("once.tif").coefficients(), read("large.png").coefficients(), "{size}");
        fs::remove_file(folder.join("once.tif")).unwrap();
    }
}

#[test]
fn info_tells_what_a_model_holds() {
    let folder = folder();
    let text = run(folder.path(), &["info", "leather.rlm"]);
    assert!(text.contains("random field") && text.contains("log evidence"), "{text}");
    let json = json(folder.path(), &["info", "leather.rlm"]);
    assert_eq!(json["source_bytes"], 64 * 64 * 3);
    assert_eq!(json["bytes"], fs::metadata(folder.path().join("leather.rlm")).unwrap().len());
    assert!(!json["levels"][0]["neighbours"].as_array().unwrap().is_empty());
}

#[test]
fn what_a_model_cannot_do_is_refused_in_one_sentence() {
    let folder = folder();
    let folder = folder.path();
    let synth = |more: &[&str], status: i32| {
        let arguments = [&["synth", "leather.rlm", "-o", "x.png", "--size", "33"], more].concat();
        failed(folder, &arguments, status)
    };
    assert!(synth(&["--tile"], 2).contains("multiples of"));
    assert!(synth(&["--apply", "leather.png"], 2).contains("--apply"));
    assert!(failed(folder, &["roll", "leather.rlm", "-o", "y.png"], 1).contains("random-field model"));
    let window = ["synth", "leather.png", "-o", "x.png", "--window", "0,0,33,33"];
    assert!(failed(folder, &window, 2).contains("--window"));
    let bytes = fs::read(folder.join("leather.rlm")).unwrap();
    fs::write(folder.join("cut.rlm"), &bytes[..bytes.len() - 9]).unwrap();
    assert!(failed(folder, &["info", "cut.rlm"], 1).contains("cut.rlm"));
    assert!(!folder.join("x.png").exists() && !folder.join("y.png").exists());
}

#[test]
fn a_regular_material_is_combined_and_its_bytes_are_said() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let options = MaterialOptions { size: Size::new(96, 96), feature: 12.0, ..Default::default() };
    let albedo = Material::Weave.make(&options, &Job::default()).unwrap().albedo;
    let field = ReflectanceField::new(Basis::Constant, PlaneLayout::RGB, Space::Srgb, albedo).unwrap();
    let format = FieldFormat::Picture(PictureFormat::from_path(Path::new("a.png")).unwrap());
    let bytes = encode_field(&field, format, None, &Job::default()).unwrap();
    fs::write(folder.join("weave.png"), bytes).unwrap();
    let model = |name: &str, more: &[&str]| {
        run(folder, &[&["--json", "model", "weave.png", "--candidates", "12", "-o", name], more].concat())
    };
    let value = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
    let combined = value(&model("weave.rlm", &["--structure-bytes", "900", "--curve", "weave.svg"]));
    assert!(combined["structure"]["bytes"].as_u64().unwrap() <= 900, "{combined}");
    assert!(fs::read_to_string(folder.join("weave.svg")).unwrap().starts_with("<svg"));
    let plain = value(&model("plain.rlm", &["--combine", "never"]));
    assert!(plain["structure"].is_null());
    // Given periods are followed, or it is said why not.
    let followed =
        run(folder, &["model", "weave.png", "--candidates", "12", "-o", "p.rlm", "--period", "31,29"]);
    assert!(followed.contains("62 x 58 texels by the Roller"), "{followed}");
    let given = ["model", "weave.png", "-o", "x.rlm", "--period"];
    assert!(failed(folder, &[&given[..], &["200,200"]].concat(), 2).contains("larger exemplar"));
    assert!(refused(folder, &[&given[..], &["24,24", "--combine", "never"]].concat()).contains("structure"));
    run(folder, &["synth", "weave.rlm", "-o", "whole.png", "--window", "-30,-20,90,70"]);
    run(folder, &["synth", "weave.rlm", "-o", "part.png", "--window", "15,5,40,30", "--threads", "1"]);
    let read = |name: &str| read_field(&folder.join(name), &Job::default()).unwrap().field;
    let whole = read("whole.png").coefficients().crop(45, 25, Size::new(40, 30)).unwrap();
    assert_eq!(&whole, read("part.png").coefficients());
    assert!(run(folder, &["info", "weave.rlm"]).contains("structure: one tile"));
    let levels = |levels: &str| {
        let report = value(&model("auto.rlm", &["--levels", levels, "--combine", "never", "--force"]));
        (report["levels"].as_array().unwrap().len().to_string(), fs::read(folder.join("auto.rlm")).unwrap())
    };
    let (count, bytes) = levels("auto");
    assert_eq!(levels(&count), (count, bytes));
    let wrong = ["model", "weave.png", "-o", "x.rlm", "--levels", "many"];
    assert!(refused(folder, &wrong).contains("auto"));
    let curve = ["model", "weave.png", "-o", "x.rlm", "--curve", "x.rlm"];
    assert!(failed(folder, &curve, 2).contains(".svg"));
}

#[test]
fn values_are_matched_exactly_and_taken_back() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &["synth", "leather.rlm", "-o", "made.png", "--size", "64"]);
    let to = ["match", "made.png", "--to", "leather.png", "-o", "matched.png", "--ranks", "ranks.exr"];
    run(folder, &to);
    run(folder, &["match", "ranks.exr", "--to", "made.png", "-o", "again.png"]);
    let read = |name: &str| read_field(&folder.join(name), &Job::default()).unwrap().field;
    let sorted = |name: &str, plane: usize| {
        let mut values = read(name).coefficients().plane(plane).to_vec();
        values.sort_unstable_by(f32::total_cmp);
        values
    };
    for plane in 0..3 {
        assert_eq!(sorted("matched.png", plane), sorted("leather.png", plane));
    }
    assert_ne!(read("made.png").coefficients(), read("matched.png").coefficients());
    assert_eq!(read("made.png").coefficients(), read("again.png").coefficients());
    run(folder, &["synth", "leather.rlm", "-o", "made.exr", "--size", "64"]);
    let twice = ["match", "made.png", "--to", "leather.png", "-o", "x.exr", "--ranks", "x.exr"];
    assert!(failed(folder, &twice, 2).contains("two outputs"));
    fs::write(folder.join("grey.lp"), "no picture").unwrap();
    failed(folder, &["match", "made.png", "--to", "grey.lp", "-o", "y.png"], 1);
    assert!(!folder.join("y.png").exists());
}

#[test]
fn a_model_is_shown_and_measured_as_a_tile_of_it() {
    let folder = folder();
    let at = folder.path();
    run(at, &["synth", "leather.rlm", "-o", "tile.exr", "--size", "64", "--tile"]);
    run(at, &["synth", "leather.rlm", "-o", "wide.exr", "--size", "128x96", "--tile", "--seed", "4"]);
    let shown = |verb: &[&str], file: &str, more: &[&str]| {
        run(at, &[&[verb[0], file], &verb[1..], &["-o", "shown.png", "--force"], more].concat());
        fs::read(at.join("shown.png")).unwrap()
    };
    let render = ["render", "--size", "90", "--plain", "--tiling", "3,2"];
    let wide = ["--model-size", "128x96", "--model-seed", "4"];
    for verb in [&["relight", "--light", "0,0,1"][..], &render, &["analyze"]] {
        assert!(shown(verb, "leather.rlm", &[]) == shown(verb, "tile.exr", &[]), "{verb:?}");
        assert!(shown(verb, "leather.rlm", &wide) == shown(verb, "wide.exr", &[]), "{verb:?}");
    }
    run(at, &["synth", "leather.rlm", "-o", "window.exr", "--window", "-9,40,70,30"]);
    for verb in [&["relight", "--light", "0,0,1"][..], &["analyze"]] {
        let window = shown(verb, "leather.rlm", &["--model-window=-9,40,70,30"]);
        assert!(window == shown(verb, "window.exr", &[]), "{verb:?}");
    }
    let scaled = ["render", "leather.rlm", "--size", "9", "-o", "scaled.png", "--model-size", "128x96"];
    assert_eq!(
        json(at, &scaled)["tiling"],
        serde_json::json!([2.0, 1.0]),
        "features as large as of 64 x 64 texels"
    );
    let compared = |file: &str| json(at, &["compare", "leather.png", file, "--texture"])["mean"].clone();
    assert_eq!(compared("leather.rlm"), compared("tile.exr"));

    run(at, &["procedural", "pebbles", "-o", "maps", "--size", "64", "--feature", "12", "--tile"]);
    run(at, &["height", "maps/normals_gl.png", "--method", "normal-map", "-o", "h.exr"]);
    run(at, &["model", "h.exr", "-o", "h.rlm", "--combine", "never"]);
    run(at, &["synth", "h.rlm", "-o", "again.exr", "--size", "64", "--tile"]);
    for amount in [&["--displace", "1x"][..], &["--bump", "9"]] {
        let relief = |file: &str| shown(&render, "leather.png", &[&["--height", file], amount].concat());
        assert!(relief("h.rlm") == relief("again.exr"));
        assert!(relief("h.rlm") != shown(&render, "leather.png", &[]));
    }
    let height = ["render", "leather.png", "--displace", "1x", "-o", "x.png", "--height"];
    assert!(
        failed(at, &[&height[..], &["leather.rlm"]].concat(), 2).contains("not the model of a height map")
    );
    let size = ["relight", "leather.png", "--light", "0,0,1", "--model-size", "64", "-o", "x.png"];
    assert!(failed(at, &size, 2).contains(".rlm"));
    let window = ["relight", "leather.png", "--light", "0,0,1", "--model-window", "0,0,9,9", "-o", "x.png"];
    assert!(failed(at, &window, 2).contains("no input is one"));
    let size = ["relight", "leather.rlm", "--light", "0,0,1", "--model-size", "63", "-o", "x.png"];
    assert!(failed(at, &size, 2).contains("multiples of"));
}

#[test]
fn functions_are_modelled_for_each_of_some_lights() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, &["capture", "sponge", "-o", "c", "--size", "64", "--lights", "12", "--feature", "10"]);
    run(folder, &["fit", "c", "-o", "sponge.ptm"]);
    let model =
        ["model", "sponge.ptm", "-o", "s.rlm", "--candidates", "6", "--fields", "per-light", "--force"];
    let report = json(folder, &model);
    assert_eq!(
        (report["lights"].as_array().unwrap().len(), report["lights"][0]["planes"].as_u64()),
        (12, Some(3))
    );
    assert_eq!(report["estimation"].as_array().unwrap().len(), 12);
    assert!(run(folder, &["info", "s.rlm"]).contains("a model for each of 12 lights"));
    let given = ["0,0,1", "0.6,0,0.8", "-0.6,0,0.8", "0,0.6,0.8", "0,-0.6,0.8", "0.5,0.5,0.7"];
    let lights: Vec<&str> = given.iter().flat_map(|light| ["--light", light]).collect();
    assert_eq!(json(folder, &[&model[..], &lights].concat())["lights"].as_array().unwrap().len(), 6);
    let read = |name: &str| read_field(&folder.join(name), &Job::default()).unwrap();
    for extension in ["ptm", "exr"] {
        let [whole, part] = ["whole", "part"].map(|name| format!("{name}.{extension}"));
        run(folder, &["synth", "s.rlm", "-o", &whole, "--window", "-30,-20,90,70"]);
        run(folder, &["synth", "s.rlm", "-o", &part, "--window", "15,5,40,30", "--threads", "1"]);
        let cut = read(&whole).field.coefficients().crop(45, 25, Size::new(40, 30)).unwrap();
        assert_eq!((&cut, read(&whole).encoding), (read(&part).field.coefficients(), read(&part).encoding));
    }
    let wrong = |more: &[&str]| refused(folder, &[&["model", "sponge.ptm", "-o", "x.rlm"], more].concat());
    assert!(wrong(&["--light", "0,0,1"]).contains("per-light"));
    assert!(wrong(&["--fields", "per-light", "--light", "0,0,1"]).contains("do not determine"));
    assert!(wrong(&["--fields", "per-light", "--combine", "always"]).contains("structure"));
    run(folder, &["relight", "sponge.ptm", "--light", "0,0,1", "-o", "sponge.png"]);
    assert!(
        refused(folder, &["model", "sponge.png", "-o", "x.rlm", "--fields", "per-light"]).contains("picture")
    );
}

#[test]
fn a_modelled_height_map_keeps_its_millimetres() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let options = MaterialOptions { size: Size::new(64, 64), feature: 12.0, ..Default::default() };
    let relief = Material::Leather.make(&options, &Job::default()).unwrap().height;
    let (low, high) = relief.range(0);
    for (mm, extension) in [(Some(0.25), "exr"), (Some(0.25), "png"), (None, "png")] {
        let format = HeightFormat::from_path(Path::new(&format!("x.{extension}"))).unwrap();
        let name = format!("relief.{extension}");
        fs::write(folder.join(&name), encode_height(&relief, mm, format).unwrap()).unwrap();
        run(folder, &["model", &name, "-o", "r.rlm", "--candidates", "12", "--force"]);
        let info = json(folder, &["info", "r.rlm"]);
        assert_eq!(info["heights"]["mm_per_texel"].as_f64(), mm);
        for made in ["made.exr", "made.png"] {
            run(folder, &["synth", "r.rlm", "-o", made, "--size", "80", "--force"]);
            let map = read_height(&folder.join(made), &Job::default()).unwrap();
            assert_eq!(map.scale.unwrap().mm_per_texel, mm, "{name} {made}");
            let (least, greatest) = map.texels(1.0).range(0);
            assert!(
                least >= low - 0.01 && greatest <= high + 0.01 && greatest - least > 0.5 * (high - low),
                "{name}"
            );
        }
    }
    assert!(refused(folder, &["synth", "r.rlm", "-o", "made.jpg", "--size", "80"]).contains("height map"));
}

/// A grey picture of 96 x 96 texels.
fn picture(path: &Path, value: impl Fn(usize, usize) -> f32) {
    let size = Size::new(96, 96);
    let data = (0..size.texels()).map(|i| value(i % 96, i / 96)).collect();
    let planes = relume::Planes::from_vec(size, 1, data).unwrap();
    let field = ReflectanceField::new(Basis::Constant, PlaneLayout::LUMINANCE, Space::Srgb, planes).unwrap();
    let format = FieldFormat::Picture(PictureFormat::from_path(path).unwrap());
    fs::write(path, encode_field(&field, format, None, &Job::default()).unwrap()).unwrap();
}

fn grain(x: usize, y: usize) -> f32 {
    ((x * 7919 + y * 104_729 + x * y * 31) % 101) as f32 / 101.0
}

#[test]
fn a_model_says_whether_it_looks_like_the_material() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    picture(&at.join("grain.png"), |x, y| 0.2 + 0.6 * grain(x * x + 3 * y, y * y + x));
    picture(&at.join("stones.png"), |x, y| {
        let joint = (x + y / 16 * 7) % 16 < 3 || y % 16 < 3;
        (if joint { 0.1 } else { 0.6 }) + 0.1 * grain(x, y)
    });
    let model = |name: &str, more: &[&str]| {
        json(at, &[&["model", name, "-o", "m.rlm", "--force", "--candidates", "12"], more].concat())
    };
    let report = model("grain.png", &[]);
    assert!(report["likeness"]["alike"] == true && report["warnings"] == serde_json::json!([]), "{report}");
    let report = model("stones.png", &["--combine", "never"]);
    assert_eq!(report["likeness"]["alike"], false, "{report}");
    let warning = report["warnings"][0].as_str().unwrap();
    assert!(
        warning.contains("does not look like the material") && warning.contains("relume synth"),
        "{warning}"
    );
    let text = run(at, &["model", "stones.png", "-o", "m.rlm", "--force", "--combine", "never"]);
    assert!(text.contains("a made sample, patches 0.") && text.contains("of the way to shuffled"), "{text}");
    run(at, &["synth", "m.rlm", "-o", "small.png", "--size", "24"]);
    let text = run(at, &["model", "small.png", "-o", "m.rlm", "--force"]);
    assert!(text.contains("too small to judge whether the model looks like it: 32 texels"), "{text}");
}

#[test]
fn a_structure_chosen_by_itself_keeps_the_model_of_a_picture_to_two_thousand_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    run(at, &["procedural", "pebbles", "-o", "maps", "--size", "128", "--feature", "24"]);
    let report = json(at, &["model", "maps/albedo.png", "-o", "p.rlm", "--candidates", "12"]);
    assert!(report["structure"].is_object(), "{report}");
    assert!(report["bytes"].as_u64().unwrap() <= 2000, "{report}");
    let plain =
        json(at, &["model", "maps/albedo.png", "-o", "q.rlm", "--candidates", "12", "--combine", "never"]);
    let excess = |report: &serde_json::Value| report["likeness"]["excess"].as_f64().unwrap();
    assert!(excess(&report) < excess(&plain), "{report} {plain}");
}
