//! The commands of the documents, run in the order in which they are printed.

use std::fs;
use std::path::Path;

use crate::support::done;
use crate::viewer::shown;

/// The lines of code blocks that run the program.
fn commands(document: &str) -> Vec<Vec<String>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(document);
    let text = fs::read_to_string(path).unwrap();
    let (mut in_code, mut commands) = (false, Vec::new());
    for line in text.lines() {
        if line.starts_with("```") {
            in_code = !in_code;
        } else if let Some(arguments) = line.strip_prefix("relume ").filter(|_| in_code) {
            commands.push(arguments.split_whitespace().map(str::to_owned).collect());
        }
    }
    commands
}

fn run_in_order(document: &str, at_least: usize) {
    let folder = tempfile::tempdir().unwrap();
    let commands = commands(document);
    assert!(commands.len() >= at_least, "{document} has {} commands", commands.len());
    for command in &commands {
        let words: Vec<&str> = command.iter().map(String::as_str).collect();
        match words[..] {
            ["view", ref files @ ..] => shown(folder.path(), files),
            _ => drop(done(folder.path(), &words)),
        }
    }
}

#[test]
fn every_command_of_the_readme_works_in_the_order_printed_in_a_new_folder() {
    run_in_order("README.md", 18);
}

/// The library's example is the one that its documentation runs.
#[test]
fn the_example_of_the_library_is_that_of_its_documentation() {
    let read = |file: &str| {
        fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(file)).unwrap()
    };
    let (readme, library) = (read("README.md"), read("crates/relume/src/lib.rs"));
    let example = readme.split("```rust\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let run: Vec<&str> = library.lines().filter_map(|line| line.strip_prefix("//! ")).collect();
    let lines: Vec<&str> = example.lines().filter(|line| !line.is_empty()).collect();
    assert!(lines.len() >= 5 && lines.iter().all(|line| run.contains(line)), "{lines:?}");
}

#[test]
fn the_ways_of_artists_to_a_seamless_material_work() {
    run_in_order("docs/artists.md", 8);
}

#[test]
fn the_how_to_from_five_maps_to_a_seamless_material_works() {
    run_in_order("docs/maps.md", 3);
}
