//! No cycle of imports runs through files of different folders: the contents of a folder can be read, changed
//! and moved independently of its users.
//!
//! An import is a path in a `use` or in the code, followed through the modules that re-export it to the file
//! that defines it. Re-exports themselves, comments and tests do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

type Module = Vec<String>;

/// The source of a crate: its files by module, and the names that modules re-export.
#[derive(Default)]
struct Sources {
    files: BTreeMap<Module, (PathBuf, String)>,
    reexports: BTreeMap<(Module, String), Vec<String>>,
}

impl Sources {
    fn read(root: &Path) -> Self {
        let mut sources = Self::default();
        for path in super::layering::source_files(root) {
            let inside = path.strip_prefix(root).expect("found below the root").to_path_buf();
            let mut module: Module = inside
                .with_extension("")
                .components()
                .map(|part| part.as_os_str().to_string_lossy().into_owned())
                .collect();
            if module.last().is_some_and(|last| ["mod", "lib", "main"].contains(&last.as_str())) {
                module.pop();
            }
            let text = code(&fs::read_to_string(&path).expect("a readable source file"));
            sources.files.insert(module, (inside, text));
        }
        for (module, (_, text)) in &sources.files {
            for (is_public, path, name) in uses(text) {
                if is_public {
                    sources.reexports.insert((module.clone(), name), path);
                }
            }
        }
        sources
    }

    /// The module whose file defines the target of a path, as seen from a module; `None` for other crates.
    fn defined_in(&self, from: &Module, path: &[String]) -> Option<Module> {
        let mut at = from.clone();
        let mut rest = path;
        match path.first()?.as_str() {
            "crate" => (at, rest) = (Vec::new(), &path[1..]),
            "self" => rest = &path[1..],
            "super" => {
                while rest.first().is_some_and(|segment| segment == "super") {
                    at.pop();
                    rest = &rest[1..];
                }
            }
            first => {
                let child = [&from[..], &[first.to_owned()]].concat();
                if !self.files.contains_key(&child) {
                    return None;
                }
            }
        }
        for (i, segment) in rest.iter().enumerate() {
            let child = [&at[..], std::slice::from_ref(segment)].concat();
            if self.files.contains_key(&child) {
                at = child;
                continue;
            }
            if let Some(target) = self.reexports.get(&(at.clone(), segment.clone())) {
                let target = [&target[..], &rest[i + 1..]].concat();
                return self.defined_in(&at, &target);
            }
            break;
        }
        Some(at)
    }

    /// The modules that each module imports from.
    fn imports(&self) -> BTreeMap<&Module, BTreeSet<Module>> {
        let of = |(module, (_, text)): (&Module, &(PathBuf, String))| {
            let uses = uses(text).into_iter().filter(|(is_public, ..)| !is_public).map(|(_, path, _)| path);
            uses.chain(inline(text))
                .filter_map(|path| self.defined_in(module, &path))
                .filter(|target| target != module)
                .collect()
        };
        self.files.iter().map(|entry| (entry.0, of(entry))).collect()
    }

    /// The cycles that run through more than one folder, as the files of each.
    fn circles(&self) -> BTreeSet<Vec<String>> {
        let imports = self.imports();
        let reached: BTreeMap<&Module, BTreeSet<&Module>> =
            imports.keys().map(|module| (*module, reachable(&imports, module))).collect();
        let circle = |module: &Module| -> Vec<&Module> {
            let back = |other: &&&Module| reached[**other].contains(module);
            reached[module].iter().filter(back).copied().collect()
        };
        let file = |module: &&Module| &self.files[*module].0;
        let circles = imports.keys().map(|module| circle(module)).filter(|circle| {
            let folders: BTreeSet<_> = circle.iter().map(|module| file(module).parent()).collect();
            folders.len() > 1
        });
        circles.map(|circle| circle.iter().map(|m| file(m).display().to_string()).collect()).collect()
    }
}

fn reachable<'a>(imports: &'a BTreeMap<&Module, BTreeSet<Module>>, from: &Module) -> BTreeSet<&'a Module> {
    let mut seen = BTreeSet::new();
    let mut open: Vec<&Module> = imports[from].iter().collect();
    while let Some(module) = open.pop() {
        if seen.insert(module) {
            open.extend(&imports[module]);
        }
    }
    seen
}

/// A source text without its comments and its tests.
fn code(text: &str) -> String {
    let text = text.split("\nmod tests {").next().unwrap_or_default();
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// All names imported by `use`: whether they are re-exported, their paths and their local names.
fn uses(text: &str) -> Vec<(bool, Vec<String>, String)> {
    let mut found = Vec::new();
    for statement in text.split(';') {
        let words: Vec<&str> = statement.split_whitespace().collect();
        let Some(at) = words.iter().rposition(|word| *word == "use") else { continue };
        // A restricted re-export begins with `pub(in path)` or `pub(super)`.
        let before = words[..at].iter().rev().take(2);
        let is_public = before.into_iter().any(|word| word.starts_with("pub"));
        let tree: String = words[at + 1..].join(" ");
        for path in leaves(&tree) {
            let (path, alias) = path.split_once(" as ").unwrap_or((&path, ""));
            let mut segments: Vec<String> = path.split("::").map(|s| s.trim().to_owned()).collect();
            if segments.last().is_some_and(|last| last == "self") {
                segments.pop();
            }
            let last = segments.last().cloned().unwrap_or_default();
            let name = if alias.is_empty() { last } else { alias.trim().to_owned() };
            found.push((is_public, segments, name));
        }
    }
    found
}

/// The paths of a tree such as `a::{b, c::{d, e}}`.
fn leaves(tree: &str) -> Vec<String> {
    let Some((prefix, rest)) = tree.split_once('{') else { return vec![tree.trim().to_owned()] };
    let inside = rest.rsplit_once('}').map_or(rest, |(inside, _)| inside);
    let (mut depth, mut parts) = (0, vec![String::new()]);
    for c in inside.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        parts.last_mut().expect("there is a part").push(c);
    }
    let parts = parts.iter().filter(|part| !part.trim().is_empty());
    parts.flat_map(|part| leaves(&format!("{}{}", prefix.trim(), part.trim()))).collect()
}

/// The paths from `crate` or `super` in the code.
fn inline(text: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for statement in text.split(';').filter(|s| !s.split_whitespace().any(|word| word == "use")) {
        for start in ["crate::", "super::"] {
            for (at, _) in statement.match_indices(start) {
                let end = |c: char| !(c.is_alphanumeric() || c == '_' || c == ':');
                let path = statement[at..].split(end).next().unwrap_or_default();
                found.push(path.split("::").map(str::to_owned).filter(|s| !s.is_empty()).collect());
            }
        }
    }
    found
}

#[test]
fn no_circle_of_imports_runs_through_two_folders() {
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("../relume-cli/src");
    // A package of the library alone has no program beside it.
    for root in [library, program].into_iter().filter(|root| root.is_dir()) {
        let sources = Sources::read(&root);
        assert!(sources.files.len() > 20, "only {} source files were looked at", sources.files.len());
        let circles = sources.circles();
        assert!(circles.is_empty(), "circles of imports in {}: {circles:#?}", root.display());
    }
}

#[test]
fn the_check_itself_sees_a_circle() {
    let sources = |files: &[(&str, &str)]| {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        Sources::read(folder.path()).circles()
    };
    let root = ("lib.rs", "mod a;\nmod b;\npub use b::inner::Thing;");
    let through_reexport = [
        root,
        ("a.rs", "pub struct A;\nuse crate::{Thing, other};"),
        ("b/mod.rs", "pub mod inner;\npub(crate) use inner::Thing as Same;"),
        ("b/inner.rs", "pub struct Thing(crate::a::A);"),
    ];
    assert_eq!(sources(&through_reexport).into_iter().flatten().collect::<Vec<_>>(), ["a.rs", "b/inner.rs"]);
    let only_down =
        [through_reexport[0], ("a.rs", "// use crate::Thing;\npub struct A;"), through_reexport[2]];
    assert!(sources(&only_down).is_empty());
    let one_folder = [root, ("b/mod.rs", "mod inner;\nuse inner::x;"), ("b/inner.rs", "use super::y;")];
    assert!(sources(&one_folder).is_empty());
}
