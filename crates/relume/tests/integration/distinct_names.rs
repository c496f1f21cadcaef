//! Distinct things have distinct names: no two types of the library and the program share one.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::layering::source_files;

/// What each verb's options are called.
const SHARED: [&str; 1] = ["Args"];

/// The type that a line of code defines at the top level of a module.
fn defined(line: &str) -> Option<&str> {
    let visible = line.strip_prefix("pub").map_or(line, |rest| {
        rest.strip_prefix('(').and_then(|scope| scope.split_once(')')).map_or(rest, |(_, rest)| rest)
    });
    let mut words = visible.split_whitespace();
    let keyword = words.next().filter(|_| !line.starts_with(' '))?;
    let name = words.next().filter(|_| ["struct", "enum", "trait", "type"].contains(&keyword))?;
    name.split(|c: char| !c.is_alphanumeric()).next()
}

#[test]
fn distinct_types_have_distinct_names() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for path in ["relume/src", "relume-cli/src"].iter().flat_map(|folder| source_files(&crates.join(folder)))
    {
        let text = fs::read_to_string(&path).expect("a readable source file");
        for name in text.lines().filter_map(defined).filter(|name| !SHARED.contains(name)) {
            places.entry(name.to_owned()).or_default().push(path.display().to_string());
        }
    }
    assert!(places.len() > 200, "only {} types were found", places.len());
    places.retain(|_, files| files.len() > 1);
    assert!(places.is_empty(), "defined more than once: {places:#?}");
}

#[test]
fn definitions_are_recognised() {
    assert_eq!(defined("pub(in crate::format) struct Layer<'a> {"), Some("Layer"));
    assert_eq!(defined("type Vector = [f32; 8];"), Some("Vector"));
    assert_eq!(defined("pub enum Kind {"), Some("Kind"));
    assert_eq!(defined("    type Output = Self;"), None);
    assert_eq!(defined("pub fn structure() {"), None);
}
