//! `relume gallery` as a user runs it.

use std::fs;

use relume::Size;
use relume::procedural::Material;
use serde_json::Value;

use crate::support::{failed, json, refused, run, write_material};

/// A name that would be markup and more than one field.
const NAME: &str = "a<b>, \"&{{seed}}.png";

/// A folder `in` with a weave, a texture map, a broken picture and files that are not exemplars.
fn with_exemplars() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("in");
    fs::create_dir_all(input.join("more.png")).unwrap();
    write_material(&input.join(NAME), Material::Weave, Size::new(48, 40), 9.0);
    run(folder.path(), &["capture", "pebbles", "-o", "pebbles", "--size", "64", "--lights", "8"]);
    run(folder.path(), &["fit", "pebbles", "-o", "in/pebbles.ptm"]);
    fs::write(input.join("zbroken.png"), b"no picture").unwrap();
    fs::write(input.join("notes.txt"), b"no exemplar").unwrap();
    folder
}

fn entry<'a>(exemplar: &'a Value, method: &str) -> &'a Value {
    exemplar["entries"].as_array().unwrap().iter().find(|entry| entry["method"] == method).unwrap()
}

#[test]
fn every_method_has_its_entry_and_the_page_needs_nothing_else() {
    let folder = with_exemplars();
    let command = ["gallery", "in", "-o", "out", "--size", "64x60", "--lights", "2"];
    let found = json(folder.path(), &command);
    let exemplars = found["exemplars"].as_array().unwrap();
    let names: Vec<&str> = exemplars.iter().map(|exemplar| exemplar["name"].as_str().unwrap()).collect();
    assert_eq!(names, [NAME, "pebbles.ptm", "zbroken.png"]);
    for method in ["quilting", "efros-leung", "wei-levoy", "roller", "auto"] {
        let weave = entry(&exemplars[0], method);
        assert!(weave["measures"]["mean"]["sliced"].as_f64().unwrap() > 0.0, "{method}: {weave}");
        assert!(weave["largest_piece"].as_f64().unwrap() > 0.0 && weave["seconds"].as_f64().unwrap() > 0.0);
        let file = folder.path().join("out").join(weave["file"].as_str().unwrap());
        assert_eq!(fs::read(file).unwrap()[16..24], [0, 0, 0, 64, 0, 0, 0, 60], "{method}: 64 x 60 texels");
    }
    // Noise refuses a weave, and makes pebbles without sources.
    assert!(entry(&exemplars[0], "noise")["error"].as_str().unwrap().contains("repeats"));
    let noise = entry(&exemplars[1], "noise");
    assert!(noise["measures"]["mean"].is_object() && noise["largest_piece"].is_null(), "{noise}");
    assert!(folder.path().join("out/pebbles.ptm/noise.ptm").is_file());
    assert!(entry(&exemplars[2], "quilting")["error"].as_str().unwrap().contains("zbroken.png"));
    // Among textures that are not copies the nearest is the best, and only that.
    for exemplar in &exemplars[..2] {
        let entries = exemplar["entries"].as_array().unwrap();
        let distance = |entry: &Value| entry["measures"]["mean"]["appearance"]["distance"].as_f64();
        let rivals = entries.iter().filter(|e| e["largest_piece"].as_f64().is_none_or(|piece| piece <= 0.5));
        let least = rivals.filter_map(distance).fold(f64::INFINITY, f64::min);
        let best: Vec<&Value> = entries.iter().filter(|e| e["is_best"] == true).collect();
        assert!(best.len() == 1 && distance(best[0]) == Some(least), "{exemplar}");
    }
    let page = fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    assert!(page.contains("a&lt;b&gt;, &quot;&amp;&#123;&#123;seed}}.png") && !page.contains("a<b>"));
    for outside in ["src=\"http", "href=\"http", "<script", "<link", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.matches("data:image/jpeg;base64,").count() >= 14 && page.contains("noise would dissolve"));
    let csv = fs::read_to_string(folder.path().join("out/gallery.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 3 * 8, "{csv}");
    assert!(csv.contains("\"a<b>, \"\"&{{seed}}.png\",quilting,"));
    let stored = fs::read_to_string(folder.path().join("out/gallery.json")).unwrap();
    let stored: Value = serde_json::from_str(&stored).unwrap();
    assert!(stored.as_object().unwrap().iter().all(|(field, value)| found[field] == *value));
    let left: Vec<_> = fs::read_dir(folder.path().join("out")).unwrap().collect();
    assert_eq!(left.len(), 7, "nothing else is left: {left:?}");
}

/// A former fault: the page stretched exemplars to the width of their textures.
#[test]
fn exemplars_and_textures_are_shown_at_one_scale() {
    let folder = with_exemplars();
    for (size, own, made) in [("120x80", "40.0000%", "100.0000%"), ("36x36", "100.0000%", "75.0000%")] {
        let command = [
            "gallery",
            "in",
            "-o",
            "out",
            "--size",
            size,
            "--methods",
            "quilting",
            "--lights",
            "1",
            "--force",
        ];
        json(folder.path(), &command);
        let page = fs::read_to_string(folder.path().join("out/index.html")).unwrap();
        let shown = |name: &str, width: &str| format!("<img style=\"width: {width}\" alt=\"{name}\"");
        assert!(page.contains(&shown("exemplar", own)) && page.contains(&shown("quilting", made)), "{size}");
    }
}

#[test]
fn textures_depend_on_the_seed_only_and_are_never_overwritten_by_chance() {
    let folder = with_exemplars();
    let made = |out: &str, more: &[&str]| {
        let command = ["gallery", "in", "-o", out, "--methods", "quilting,wei-levoy", "--lights", "1"];
        let text = run(folder.path(), &[&command[..], more].concat());
        assert!(text.contains("wei-levoy") && text.contains("index.html"), "{text}");
        ["quilting", "wei-levoy"]
            .map(|m| fs::read(folder.path().join(format!("{out}/pebbles.ptm/{m}.ptm"))).unwrap())
    };
    let first = made("a", &["--threads", "1"]);
    assert_eq!(first, made("b", &["--threads", "3"]));
    assert_ne!(first, made("c", &["--seed", "1"]));
    assert!(refused(folder.path(), &["gallery", "in", "-o", "a"]).contains("--force"));
}

#[test]
fn what_is_no_gallery_is_said() {
    let folder = with_exemplars();
    fs::create_dir(folder.path().join("empty")).unwrap();
    assert!(refused(folder.path(), &["gallery", "empty", "-o", "out"]).contains("no exemplar"));
    assert!(refused(folder.path(), &["gallery", "in", "-o", "out", "--methods", "magic"]).contains("magic"));
    failed(folder.path(), &["gallery", "missing", "-o", "out"], 1);
    assert!(!folder.path().join("out").exists());
}
