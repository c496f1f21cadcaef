//! What is said of photographs under light and view: options that are obeyed or refused, warnings, and advice that can be followed.

use std::fs;

use serde_json::Value;

use crate::btf::{Files, SIDE, photographs, write_folder, write_zip};
use crate::support::{done, failed, json, refused, run};

/// The photographs of which the name passes.
fn some(keep: impl Fn(&str) -> bool) -> Files {
    photographs().into_iter().filter(|(name, _)| keep(name)).collect()
}

fn warnings(report: &Value) -> String {
    report["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one.as_str().unwrap())
        .collect::<Vec<_>>()
        .join("\n")
}

/// A named fault: whatever was asked for, 1,024 texels were measured.
#[test]
fn as_many_texels_are_measured_as_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    for form in [&["--rank", "3"][..], &["--model", "views-ptm"]] {
        for (asked, measured) in [("all", 576), ("9", 9)] {
            let fit = [&["fit", "b.zip", "-o", "b.exr", "--force", "--report-texels", asked], form].concat();
            assert_eq!(json(path, &fit)["report"]["texels_measured"], measured, "{fit:?}");
        }
    }
    let sentence =
        refused(path, &["fit", "b.zip", "-o", "b.btf", "--factors", "per-view", "--report-texels", "9"]);
    assert!(sentence.contains("--report-texels"), "{sentence}");
}

/// A named fault: `fit` and `info` waited for a pipe in silence.
#[cfg(unix)]
#[test]
fn a_pipe_in_the_place_of_photographs_is_refused() {
    use rustix::fs::{CWD, FileType, Mode, mknodat};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("b"), &photographs());
    let photograph = path.join("b").join(&photographs()[9].0);
    fs::remove_file(&photograph).unwrap();
    for pipe in [&photograph, &path.join("p.zip"), &path.join("p.btf"), &path.join("p.bsdf")] {
        mknodat(CWD, pipe, FileType::Fifo, Mode::RUSR | Mode::WUSR, 0).unwrap();
        let input = if *pipe == photograph { "b" } else { pipe.file_name().unwrap().to_str().unwrap() };
        for verb in [&["info", input][..], &["fit", input, "-o", "o.exr"]] {
            let sentence = refused(path, verb);
            assert!(sentence.contains("is a pipe") && sentence.contains("more than once"), "{sentence}");
        }
    }
}

#[test]
fn what_is_left_out_is_something_and_lowers_the_usual_number_of_functions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    for form in [&[][..], &["--model", "views-ptm"]] {
        let sentence = refused(path, &[&["fit", "b.zip", "-o", "b.exr", "--hold-out", "9"], form].concat());
        assert!(sentence.contains("8 lights and 8 views"), "{sentence}");
    }
    let few = some(|name| {
        let of = |part: &str| name.contains(part);
        (of("tl000") || of("tl030 pl000") || of("tl030 pl120")) && (of("tv000 ") || of("tv030 pv000."))
    });
    assert_eq!(few.len(), 6);
    write_zip(&path.join("f.zip"), &few);
    let fit = json(path, &["fit", "f.zip", "-o", "f.exr", "--hold-out", "2"]);
    // Two lights, one view, three channels.
    assert!((1..=6).contains(&fit["report"]["functions"].as_u64().unwrap()), "{fit}");
}

#[test]
fn opacities_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut set = photographs();
    for (_, bytes) in &mut set[3..5] {
        let mut translucent = Vec::new();
        let mut encoder = png::Encoder::new(&mut translucent, SIDE, SIDE);
        encoder.set_color(png::ColorType::Rgba);
        let samples: Vec<u8> = (0..SIDE * SIDE * 4).map(|i| (i % 251) as u8).collect();
        encoder.write_header().unwrap().write_image_data(&samples).unwrap();
        *bytes = translucent;
    }
    write_zip(&path.join("b.zip"), &set);
    write_folder(&path.join("b"), &set);
    for input in ["b", "b.zip"] {
        let said = warnings(&json(path, &["fit", input, "-o", "o.exr", "--rank", "3", "--force"]));
        assert!(said.contains("and one more file: its opacity (alpha) is not used"), "{said}");
    }
}

#[test]
fn missing_photographs_are_made_where_each_light_is_needed_with_each_view() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let holed = some(|name| !name.contains("tl030 pl240 tv030 pv120"));
    assert_eq!(holed.len(), 63);
    write_zip(&path.join("h.zip"), &holed);
    write_zip(&path.join("b.zip"), &photographs());
    for (output, options) in [
        ("o.btf", &["--rank", "8"][..]),
        ("o.btf", &["--rank", "4", "--factors", "per-view"]),
        ("o.btf", &["--rank", "8", "--factors", "decorrelated"]),
        ("o.exr", &["--rank", "8", "--rounding", "0.004"]),
        ("o.exr", &["--model", "separable2"]),
    ] {
        let fit = [&["fit", "h.zip", "-o", output, "--force"], options].concat();
        let sentence = failed(path, &[&fit[..2], &["-o", &format!("x{output}")], options].concat(), 1);
        assert!(sentence.contains("--missing fill"), "{sentence}");
        let said = warnings(&json(path, &[&fit[..], &["--missing", "fill"]].concat()));
        assert!(
            said.contains("1 of the 64 photographs") && said.contains("as if they were photographs"),
            "{said}"
        );
        let whole = json(path, &["compare", "b.zip", output]);
        assert!(whole["psnr_db"].as_f64().unwrap() > 25.0, "{options:?}: {}", whole["psnr_db"]);
        assert_eq!(whole["lights"].as_array().unwrap().len(), 64);
    }
    for words in [
        &["relight", "h.zip", "--light", "0,0,1", "-o", "l.png"][..],
        &["compare", "h.zip", "b.zip"],
        &["compare", "b.zip", "h.zip"],
        &["maps", "h.zip", "-o", "maps", "--preset", "gltf"],
    ] {
        let said = warnings(&json(path, words));
        assert!(said.contains("1 of the 64 photographs of a full grid is missing"), "{words:?}: {said}");
    }
    let sentence = failed(path, &["model", "h.zip", "-o", "m.rlm"], 1);
    assert!(sentence.contains("relume fit SET -o TEXTURE.exr --missing fill"), "{sentence}");
}

#[test]
fn a_name_that_was_not_understood_is_said_with_what_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut set = photographs();
    set[20].0 = "tl-30 pl000 tv030 pv120.png".to_owned();
    write_zip(&path.join("b.zip"), &set);
    let sentence = failed(path, &["fit", "b.zip", "-o", "b.exr"], 1);
    assert!(
        sentence.contains("missing")
            && sentence.contains("the picture tl-30 pl000 tv030 pv120.png has no angles")
    );
}

/// Sets are known by their names; other ones were read as light files, and their bytes came to the terminal.
#[test]
fn sets_under_names_of_no_set_are_refused_with_the_ending_they_need() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "b.btf", "--rank", "2"]);
    for ending in ["zip", "btf"] {
        fs::copy(path.join(format!("b.{ending}")), path.join("odd")).unwrap();
        for verb in [&["fit", "odd", "-o", "o.exr"][..], &["info", "odd"]] {
            let sentence = refused(path, verb);
            assert!(sentence.contains(&format!(".{ending}")) && sentence.len() < 300, "{sentence}");
        }
        let render = &["render", &format!("b.{ending}"), "--mesh", "plane", "-o", "r.png"];
        let sentence = refused(path, render);
        assert!(
            sentence.contains("photographs under light and view") && sentence.contains("`relume fit`"),
            "{sentence}"
        );
    }
    assert!(refused(path, &["fit", "-", "-o", "o.exr"]).contains("name a file or folder"));
}

#[test]
fn advice_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "b.exr", "--rank", "4"]);
    done(path, &["fit", "b.zip", "-o", "c.exr", "--rank", "3"]);
    let sentence = refused(path, &["match", "b.exr", "--to", "c.exr", "-o", "m.exr"]);
    assert!(sentence.contains("but other functions"), "{sentence}");
    let sentence = refused(path, &["fit", "b.zip", "-o", "x.rlm"]);
    assert!(sentence.contains(".btf") && !sentence.contains(".png"), "{sentence}");
    let sentence = refused(path, &["fit", "b.zip", "-o", "x.ptm", "--model", "ggx"]);
    assert!(sentence.contains("numbers of reflectance models are written as .exr"), "{sentence}");
    let sentence =
        refused(path, &["relight", "b.exr", "--sweep", "orbit:2", "--sweep-light", "0,0,1", "-o", "s.gif"]);
    assert!(sentence.contains("--sweep-light is the light of --view-sweep"), "{sentence}");
    let said = warnings(&json(path, &["fit", "b.zip", "-o", "r.exr", "--rank", "4", "--report", "r.html"]));
    assert!(said.contains("--hold-out N") && !said.contains("ptm"), "{said}");
    let said =
        warnings(&json(path, &["model", "b.zip", "-o", "m.rlm", "--levels", "1", "--combine", "never"]));
    assert!(!said.contains("relume synth b.zip"), "{said}");
}

#[test]
fn what_cannot_vary_and_what_saves_nothing_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    for (name, kept, said) in [
        ("light.zip", some(|name| name.contains("tl030 pl000")), "all 8 photographs have one light"),
        ("view.zip", some(|name| name.contains("tv030 pv000.")), "all 8 photographs have one view"),
        ("one.zip", some(|name| name.contains("tl000 pl000 tv000 pv000")), "there is one photograph"),
    ] {
        write_zip(&path.join(name), &kept);
        let found = warnings(&json(path, &["fit", name, "-o", "o.exr", "--rank", "1", "--force"]));
        assert!(found.contains(said), "{name}: {found}");
    }
    assert!(
        run(path, &["info", "one.zip"]).starts_with("1 photograph of 24 x 24, 3 channels, under 1 light (")
    );
    assert!(run(path, &["info", "o.exr"]).contains("learned from 1 light"));
    done(path, &["capture", "weave", "-o", "shots", "--size", "16", "--lights", "1"]);
    let learned = json(path, &["fit", "shots", "-o", "c.exr", "--basis", "learned", "--rank", "1"]);
    assert!(warnings(&learned).contains("there is one photograph"), "{learned}");
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "g.exr", "--model", "ggx"]);
    let model = run(path, &["model", "g.exr", "-o", "g.rlm", "--levels", "1", "--combine", "never"]);
    assert!(model.contains("it saves nothing") && model.contains("1 to 0."), "{model}");
}

#[test]
fn a_set_is_equal_to_itself() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    let compared = json(path, &["compare", "b.zip", "b.zip"]);
    assert_eq!((&compared["rmse"], &compared["psnr_db"]), (&0.0.into(), &Value::Null), "{compared}");
}

#[test]
fn copies_of_models_are_no_loss_and_heights_say_what_they_come_from() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "g.exr", "--model", "ggx"]);
    let synth = ["synth", "g.exr", "-o", "s.exr", "--size", "32", "--block", "8"];
    let said = warnings(&json(path, &synth));
    assert!(said.contains("are compared by") && !said.contains("is taken as"), "{said}");
    let said = warnings(&json(path, &["relight", "g.exr", "--env", "sky", "-o", "e.png"]));
    assert!(said.contains("is taken as"), "{said}");
    let text = run(path, &["height", "g.exr", "-o", "h.exr"]);
    assert!(
        text.contains("from the normals of the fitted facets") && !text.contains("ptm-normals"),
        "{text}"
    );
    done(path, &["fit", "b.zip", "-o", "l.exr", "--rank", "3"]);
    let text = run(path, &["height", "l.exr", "-o", "k.exr"]);
    assert!(text.contains("from the directions in which its functions are brightest"), "{text}");
}
