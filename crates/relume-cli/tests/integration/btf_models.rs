//! Reflectance models of texels, and random fields of clusters of photographs, as a user meets them.

use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::btf::{SIDE, photograph, photographs, png_of, write_folder, write_zip};
use crate::support::{done, failed, json, names, read_png, refused, run};

const PAIR: [&str; 4] = ["--light", "0.433,-0.25,0.866", "--view", "0.5,0,0.866"];

/// A measured pair: light at 30 degrees and azimuth 0, view at 60 degrees and azimuth 90.
const MEASURED: [&str; 4] = ["--light", "0.5,0,0.8660254037844387", "--view", "0,0.8660254037844386,0.5"];

/// The mean difference of codes.
fn difference(path: &Path, picture: &str) -> f64 {
    let (_, shown) = read_png(&path.join(picture));
    let truth = photograph((30, 0), (60, 90));
    let sum: u64 = shown.iter().zip(&truth).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / truth.len() as f64
}

#[test]
fn every_model_is_fitted_shown_compared_and_synthesised() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    for (model, numbers, most) in [
        ("lafortune1", 10, 25.0),
        ("ggx", 7, 30.0),
        ("views-ptm", 8 * 18, 2.0),
        ("views-lafortune1", 80, 12.0),
        ("separable3", 3 * (8 + 3 * 8), 8.0),
    ] {
        let fit = json(path, &["fit", "b.zip", "-o", "m.exr", "--model", model, "--force"]);
        assert_eq!((&fit["model"], &fit["report"]["numbers"]), (&model.into(), &numbers.into()), "{fit}");
        assert_eq!(fit["numbers"].as_array().unwrap().len(), numbers);
        let said = fit["report"]["fitted"]["psnr_db"].as_f64().unwrap();
        done(path, &[&["relight", "m.exr", "-o", "p.png", "--force"][..], &MEASURED].concat());
        let off = difference(path, "p.png");
        assert!(off < most, "{model}: {off}, {said} dB");
        let info = json(path, &["info", "m.exr"]);
        assert_eq!(
            (&info["model"], info["planes"].as_array().unwrap().len()),
            (&model.into(), numbers),
            "{info}"
        );
        // The picture for a pair is that of the numbers; other verbs take the linear form, and say so.
        let large = ["synth", "m.exr", "-o", "l.exr", "--size", "32", "--block", "8", "--force"];
        let made = json(path, &large);
        assert!(made["warnings"][0].as_str().unwrap().contains("learned functions"), "{made}");
        let made = json(path, &["info", "l.exr"]);
        assert_eq!((&made["model"], &made["width"]), (&model.into(), &32.into()));
        done(path, &[&["relight", "l.exr", "-o", "l.png", "--force"][..], &PAIR].concat());
    }
    let compared = json(path, &["compare", "b.zip", "m.exr"]);
    assert!(compared["psnr_db"].as_f64().unwrap() > 20.0, "{compared}");
    let sweep = json(path, &["relight", "m.exr", "--view-sweep", "arc:3", "-o", "s.png"]);
    assert_eq!(sweep["views"].as_array().unwrap().len(), 3);
    done(path, &["render", "l.exr", "--size", "24", "--mesh", "sphere", "-o", "r.png"]);
}

#[test]
fn pairs_left_out_of_a_model_are_predicted_and_halves_are_smaller() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    let fit = json(
        path,
        &["fit", "btf", "-o", "m.exr", "--model", "lafortune2", "--hold-out", "4", "--fit-pairs", "30"],
    );
    assert_eq!(fit["report"]["held_out"]["pairs"], 64 - 36);
    assert_eq!(fit["report"]["pairs_fitted"], 30);
    done(path, &["fit", "btf", "-o", "h.exr", "--model", "lafortune2", "--half"]);
    let length = |name: &str| fs::metadata(path.join(name)).unwrap().len();
    assert!(length("h.exr") < length("m.exr"));
}

#[test]
fn a_texture_of_light_and_view_gives_maps_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["maps", "b.zip", "-o", "maps", "--preset", "blender", "--name", "Knit"]);
    // Learned functions hold no roughness.
    done(path, &["fit", "b.zip", "-o", "l.exr", "--rank", "4"]);
    done(path, &["maps", "l.exr", "-o", "learned", "--preset", "blender", "--name", "Knit"]);
    for (made, has_roughness) in [("maps", true), ("learned", false)] {
        let found = names(&path.join(made));
        for map in ["BaseColor.png", "Normal_GL.png", "Displacement.exr", "AO.png"] {
            assert!(found.contains(&format!("Knit_{map}")), "{found:?}");
        }
        assert_eq!(found.contains(&"Knit_Roughness.png".to_owned()), has_roughness, "{found:?}");
    }
}

#[test]
fn facets_come_out_as_maps_with_their_roughness() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "g.exr", "--model", "ggx"]);
    done(path, &["maps", "g.exr", "-o", "maps", "--preset", "blender", "--name", "Knit"]);
    let found = names(&path.join("maps"));
    for map in ["BaseColor.png", "Normal_GL.png", "Roughness.png", "Specular.png"] {
        assert!(found.contains(&format!("Knit_{map}")), "{found:?}");
    }
    // Presets name the map as their programs do, or say that they have none.
    for (preset, name) in [
        ("unreal", "T_Material_S.png"),
        ("polyhaven", "material_spec_24px.png"),
        ("ambientcg", "Material_24px-PNG_Specular.png"),
    ] {
        let made = json(path, &["maps", "g.exr", "-o", preset, "--preset", preset]);
        assert!(made["maps"].as_array().unwrap().iter().any(|map| map["file"] == name), "{made}");
    }
    let made = json(path, &["maps", "g.exr", "-o", "godot", "--preset", "godot"]);
    assert!(made["warnings"][0].as_str().unwrap().contains("no map of specular reflectance"), "{made}");
}

/// The root mean square of the differences of two planes, and of the steps between neighbours of the first.
fn compared(found: &[f32], truth: &[f32], width: usize) -> (f64, f64) {
    let rms = |values: &mut dyn Iterator<Item = f32>| {
        let (sum, count) = values.fold((0.0, 0), |(s, n), v| (s + f64::from(v * v), n + 1));
        (sum / f64::from(count)).sqrt()
    };
    let steps = &mut (0..found.len()).filter(|i| i % width > 0).map(|i| found[i] - found[i - 1]);
    (rms(&mut found.iter().zip(truth).map(|(a, b)| a - b)), rms(steps))
}

/// A fault: neighbouring texels fell into different minima, mirrors whose highlights no photograph shows and white ones that
/// reflect nothing else, and maps of roughness and colour were blotchy.
#[test]
fn maps_of_light_and_view_are_near_the_truth_and_not_blotchy() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let material = ["--size", "24", "--feature", "24", "--views", "14", "--lights", "14", "--format", "png"];
    done(path, &[&["capture", "leather", "-o", "leather"][..], &material].concat());
    done(path, &["maps", "leather", "-o", "maps", "--preset", "blender"]);
    let grey = |codes: Vec<u8>, texels: usize| -> Vec<f32> {
        let channels = codes.len() / texels;
        codes.iter().step_by(channels).map(|v| f32::from(*v) / 255.0).collect()
    };
    let map = |name: &str| {
        let ((width, height), codes) = read_png(&path.join(format!("maps/Material_{name}.png")));
        grey(codes, width * height)
    };
    let truth =
        relume::format::read_field(&path.join("leather/truth/roughness.exr"), &relume::Job::default());
    let truth = truth.unwrap().field.coefficients().plane(0).to_vec();
    let (error, step) = compared(&map("Roughness"), &truth, 24);
    assert!(error < 0.12 && step < 0.12, "roughness: {error} from the truth, steps of {step}");
    // White is 0.08, and the leather's reflectance 0.04.
    let (error, step) = compared(&map("Specular"), &[0.5; 24 * 24], 24);
    assert!(error < 0.25 && step < 0.22, "specular: {error} from the truth, steps of {step}");
}

#[test]
fn models_that_cannot_be_fitted_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    let refusal = |more: &[&str]| refused(path, &[&["fit", "btf"][..], more].concat());
    assert!(refusal(&["-o", "m.ptm", "--model", "ggx"]).contains("name an .exr"));
    assert!(refusal(&["-o", "m.btf", "--model", "ggx"]).contains("written as .exr"));
    assert!(refusal(&["-o", "m.exr", "--model", "phong"]).contains("expected lafortune1"));
    assert!(refusal(&["-o", "m.exr", "--model", "ggx", "--rank", "3"]).contains("--rank"));
    assert!(refusal(&["-o", "m.exr", "--model", "ggx", "--space", "srgb"]).contains("has no meaning"));
    assert!(refusal(&["-o", "m.exr", "--model", "ggx", "--fit-pairs", "3"]).contains("at least 8 pairs"));
    assert!(refusal(&["-o", "m.exr", "--fit-pairs", "30"]).contains("--model"));
    assert!(refusal(&["-o", "m.exr", "--model", "ggx", "--hold-out", "1"]).contains("2 or more"));
    assert!(refusal(&["-o", "m.exr", "--model", "views-quartic"]).contains("photographs of the view"));
    done(path, &["capture", "pebbles", "-o", "lit", "--size", "24", "--lights", "9"]);
    let lights = refused(path, &["fit", "lit", "-o", "m.exr", "--model", "ggx"]);
    assert!(lights.contains("this is a capture of lights"), "{lights}");
    done(path, &["fit", "btf", "-o", "m.exr", "--model", "lafortune1"]);
    let bytes = fs::read(path.join("m.exr")).unwrap();
    fs::write(path.join("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    assert!(failed(path, &["relight", "cut.exr", "--light", "0,0,1", "-o", "x.png"], 1).contains("cut.exr"));
}

#[test]
fn a_model_of_clusters_shows_pairs_windows_and_its_range_map() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    let options = ["--levels", "1", "--candidates", "6", "--combine", "never"];
    let command =
        [&["model", "btf", "-o", "c.rlm", "--fields", "clusters", "--image-clusters", "5"][..], &options]
            .concat();
    let model = json(path, &command);
    assert_eq!((&model["basis"], &model["source"]["photographs"]), (&"learned".into(), &64.into()));
    assert_eq!(model["clusters"].as_array().unwrap().len(), 5);
    let sizes: u64 =
        model["clustering"]["photographs"].as_array().unwrap().iter().filter_map(Value::as_u64).sum();
    assert_eq!(sizes, 64);
    assert_eq!(model["clustering"]["range"]["photographs"], 8);
    assert!(model["ratio"].as_f64().unwrap() > 20.0 && model["range_map"].is_object(), "{model}");
    assert!(run(path, &["info", "c.rlm"]).contains("5 clusters of photographs"));
    done(path, &[&["relight", "c.rlm", "-o", "relit.png"][..], &PAIR].concat());
    done(path, &["relight", "c.rlm", "--view-sweep", "arc:3", "-o", "s.png"]);
    done(path, &["synth", "c.rlm", "-o", "large.exr", "--window", "-20,900,50,40"]);
    assert_eq!(json(path, &["info", "large.exr"])["basis"], "learned");
    let of_model = [&["relight", "c.rlm", "-o", "a.png", "--model-window=-20,900,50,40"][..], &PAIR].concat();
    done(path, &of_model);
    done(path, &[&["relight", "large.exr", "-o", "b.png"][..], &PAIR].concat());
    let [(_, a), (_, b)] = ["a.png", "b.png"].map(|name| read_png(&path.join(name)));
    assert!(
        a.iter().zip(&b).all(|(a, b)| a.abs_diff(*b) <= 1),
        "the picture of a window is that of its functions"
    );
    let relief = ["render", "c.rlm", "--height", "c.rlm", "--bump", "1x", "--size", "24", "-o", "r.png"];
    done(path, &relief);
    done(
        path,
        &[&["model", "btf", "-o", "n.rlm", "--fields", "clusters", "--no-range"][..], &options].concat(),
    );
    let none = refused(path, &["render", "n.rlm", "--height", "n.rlm", "--bump", "1x", "-o", "x.png"]);
    assert!(none.contains("height map"), "{none}");
}

#[test]
fn models_of_clusters_that_cannot_be_made_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    fs::write(path.join("p.png"), png_of(SIDE, &photograph((30, 0), (0, 0)))).unwrap();
    let refusal =
        |input: &str, more: &[&str]| refused(path, &[&["model", input, "-o", "c.rlm"][..], more].concat());
    assert!(refusal("p.png", &["--fields", "clusters"]).contains("photographs under light and view"));
    assert!(refusal("btf", &["--fields", "clusters", "--image-clusters", "0"]).contains("1 to 255 clusters"));
    assert!(
        refusal("btf", &["--fields", "clusters", "--functions", "3"]).contains("is of learned functions")
    );
    assert!(refusal("btf", &["--image-clusters", "3"]).contains("--fields clusters"));
    assert!(refusal("btf", &["--fields", "clusters", "--light", "0,0,1"]).contains("per-light"));
}

#[test]
fn the_gallery_factors_photographs_of_light_and_view() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fs::create_dir(path.join("in")).unwrap();
    write_zip(&path.join("in/knit.zip"), &photographs());
    write_zip(&path.join("in/other.zip"), &[("notes.txt".to_owned(), vec![1])]);
    let found =
        json(path, &["gallery", "in", "-o", "out", "--methods", "quilting", "--size", "32", "--lights", "2"]);
    let exemplars = found["exemplars"].as_array().unwrap();
    assert!(exemplars[0]["factored"].as_str().unwrap().contains("knit.zip/factored.exr"), "{}", exemplars[0]);
    let entry = &exemplars[0]["entries"][0];
    assert!(entry["measures"]["mean"]["sliced"].as_f64().unwrap() > 0.0, "{entry}");
    assert!(path.join("out/knit.zip/factored.exr").is_file());
    assert!(exemplars[1]["entries"][0]["error"].as_str().unwrap().contains("expected names such as"));
    assert!(fs::read_to_string(path.join("out/index.html")).unwrap().contains("relume fit --rank 16"));
}
