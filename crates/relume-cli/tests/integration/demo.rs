//! The pages of `relume demo`.

use std::fs;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::support::{done, read_png};

/// What stands between two texts.
fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let (_, rest) = text.split_once(before).unwrap_or_else(|| panic!("no {before}"));
    rest.split_once(after).unwrap_or_else(|| panic!("no {after} after {before}")).0
}

#[test]
fn the_demo_shows_a_material_of_light_and_view_and_every_page_it_names() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["demo", "-o", "demo", "--lights", "8"]);
    let file = |name: &str| folder.path().join("demo").join(name);
    let page = fs::read_to_string(file("index.html")).unwrap();
    assert!(!page.contains("{{"), "a field is left open: {}", between(&page, "{{", "}}"));
    let named: Vec<&str> =
        page.split("<iframe src=\"").skip(1).map(|rest| rest.split(['#', '"']).next().unwrap()).collect();
    assert_eq!(named, ["texture.html", "tiles.html", "noise.html", "light_view.html"]);
    assert!(page.contains("learned from the 475 photographs"));

    let shown = fs::read_to_string(file("light_view.html")).unwrap();
    assert!(shown.len() < 1_500_000, "{} bytes", shown.len());
    let header = STANDARD.decode(between(&shown, "\"share.json\":\"", "\"")).unwrap();
    let header: Value = serde_json::from_slice(&header).unwrap();
    let basis = &header["basis"];
    assert_eq!((&basis["name"], &basis["functions"]), (&"learned".into(), &24.into()));
    assert_eq!(basis["depends_on_view"], true);
    assert_eq!(header["cells"]["tiles"], 4, "an endless plane");

    // One light, four views: what is seen differs by far more than rounding does.
    let views = ["above", "left", "right", "below"].map(|name| read_png(&file(&format!("view_{name}.png"))));
    for (i, (size, a)) in views.iter().enumerate() {
        assert_eq!(*size, (128, 128));
        for (_, b) in &views[..i] {
            let sum: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
            assert!(sum > 8 * a.len() as u64, "{} of 255 on average", sum as f64 / a.len() as f64);
        }
    }
}
