//! The direction of dependency: what everything stands on names no stage, a stage names no other
//! stage, `format` or `workflow`; `format` does not name `workflow`, which may name everything.

use std::fs;
use std::path::{Path, PathBuf};

const STAGES: [&str; 9] =
    ["analysis", "capture", "fit", "metric", "procedural", "random_field", "render", "surface", "synthesis"];

/// The items that the root of the crate takes from `workflow` and stages: an exception to the rule.
const FRONT: [&str; 6] = ["Capture", "FitOptions", "SynthOptions", "Synthesized", "relight", "synthesize"];

/// What a stage may name besides itself and the foundation.
const ALLOWED: [(&str, &str); 1] = [("fit", "capture")];

pub fn source_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).expect("the source folder is readable");
    entries
        .flat_map(|entry| {
            let path = entry.expect("a readable entry").path();
            match path.is_dir() {
                true => source_files(&path),
                false => vec![path],
            }
        })
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .collect()
}

/// The top-level modules of the library named by a source text outside its comments.
fn modules_named(text: &str) -> Vec<String> {
    let code: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let code = code.join("\n");
    let mut named = Vec::new();
    for (start, _) in code.match_indices("crate::") {
        let rest = &code[start + "crate::".len()..];
        let group = rest.strip_prefix('{').and_then(|inner| inner.split('}').next());
        let paths = group.map_or(vec![rest], |inner| inner.split(',').collect());
        for path in paths {
            let name: String = path.trim().chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            named.push(name);
        }
    }
    named
}

fn violations(module: &str, named: &[String]) -> Vec<String> {
    let is_above = |name: &str| name == "workflow" || FRONT.contains(&name);
    let is_upper = |name: &str| match module {
        "workflow" | "lib" => false,
        "format" => is_above(name),
        _ => is_above(name) || name == "format" || STAGES.contains(&name),
    };
    let allowed = |name: &str| name == module || ALLOWED.contains(&(module, name));
    named.iter().filter(|name| is_upper(name) && !allowed(name)).cloned().collect()
}

#[test]
fn modules_depend_only_downwards() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut seen = 0;
    for path in source_files(&root) {
        let inside = path.strip_prefix(&root).expect("found below the root");
        let first = inside.components().next().expect("a file name").as_os_str().to_string_lossy();
        let module = first.trim_end_matches(".rs");
        seen += 1;
        let text = fs::read_to_string(&path).expect("a readable source file");
        let bad = violations(module, &modules_named(&text));
        assert!(bad.is_empty(), "{} names {bad:?}", inside.display());
    }
    assert!(seen > 20, "only {seen} source files were looked at");
}

/// Whether a source text loops over threads by itself.
fn iterates_by_rayon(text: &str) -> bool {
    text.contains("rayon::prelude") || text.contains("rayon::iter")
}

#[test]
fn loops_over_threads_are_in_one_place() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let found = source_files(&root)
        .into_iter()
        .filter(|path| iterates_by_rayon(&fs::read_to_string(path).expect("a readable source file")));
    assert_eq!(found.collect::<Vec<_>>(), [root.join("parallel.rs")]);
}

#[test]
fn the_check_itself_sees_a_violation() {
    let named = modules_named(
        "use crate::{planes::Size, render::relight};\nlet a = crate::format::read();\n// crate::fit",
    );
    assert_eq!(named, ["planes", "render", "format"]);
    assert_eq!(violations("surface", &named), ["render", "format"]);
    assert_eq!(violations("render", &named), ["format"]);
    assert!(violations("fit", &["capture".to_owned()]).is_empty());
    let upper = ["workflow", "format", "synthesize"].map(str::to_owned);
    assert_eq!(violations("synthesis", &upper), upper);
    assert_eq!(violations("format", &upper), ["workflow", "synthesize"]);
    assert!(violations("workflow", &upper).is_empty());
}
