use super::*;

/// A folder with a light file `lights.lp` and empty pictures.
fn folder(lp: &str, pictures: &[&str]) -> tempfile::TempDir {
    set("lights.lp", lp.as_bytes(), pictures)
}

/// A folder with a light file somewhere in it, and empty pictures.
fn set(light_file: &str, lp: &[u8], pictures: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(light_file);
    std::fs::create_dir_all(path.parent().unwrap()).unwrap();
    std::fs::write(path, lp).unwrap();
    for name in pictures {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, b"").unwrap();
    }
    folder
}

fn opened(folder: &tempfile::TempDir, pairing: Pairing) -> Result<Vec<String>> {
    let capture = Capture::open_paired(folder.path(), pairing)?;
    let relative = |p: &Photograph| p.path.strip_prefix(folder.path()).unwrap().display().to_string();
    Ok(capture.photographs.iter().map(relative).collect())
}

fn message(folder: &tempfile::TempDir, pairing: Pairing) -> String {
    opened(folder, pairing).unwrap_err().to_string()
}

#[test]
fn names_are_found_through_paths_and_case() {
    let lp =
        "5\nC:\\Dome\\A.JPG 0 0 1\nsub/b.png 0 0 1\nother/c.png 0 0 1\nd e.png 0 0 1\n/abs/x/f.png 0 0 1";
    let folder = folder(lp, &["a.jpg", "sub/b.png", "b.png", "c.png", "d e.png", "f.png", "F.png"]);
    let expected = ["a.jpg", "sub/b.png", "c.png", "d e.png", "f.png"];
    assert_eq!(opened(&folder, Pairing::ByName).unwrap(), expected);
}

#[test]
fn a_missing_photograph_names_the_line() {
    let folder = folder("2\na.png 0 0 1\n\nb.png 0 0 1", &["a.png"]);
    let text = message(&folder, Pairing::ByName);
    assert!(text.contains("lights.lp: line 4: the photograph b.png is missing"), "{text}");
}

#[test]
fn names_that_match_nothing_need_pairing_by_order() {
    let folder = folder("3\nx1 0 0 1\nx2 1 0 1\nx3 0 1 1", &["p10.png", "p2.PNG", "p1.png", "notes.txt"]);
    let text = message(&folder, Pairing::ByName);
    assert!(text.contains("none of the 3 names") && text.contains("by order"), "{text}");
    assert_eq!(opened(&folder, Pairing::ByOrder).unwrap(), ["p1.png", "p2.PNG", "p10.png"]);
}

#[test]
fn pairing_by_order_counts() {
    let folder = folder("2\nx1 0 0 1\nx2 1 0 1", &["a.png", "b.png", "mask.png"]);
    let text = message(&folder, Pairing::ByOrder);
    assert!(text.contains("2 lights") && text.contains("3 pictures"), "{text}");
}

#[test]
fn ambiguity_is_refused() {
    let twice = folder("2\na.png 0 0 1\nA.PNG 1 0 1", &["a.png"]);
    assert!(message(&twice, Pairing::ByName).contains("lines 2 and 3 both name"));
    let cases = folder("1\nA.png 0 0 1", &["a.png", "a.PNG"]);
    assert!(message(&cases, Pairing::ByName).contains("could be any of"));
    let two = folder("0\n", &["more.LP"]);
    let text = message(&two, Pairing::ByName);
    assert!(text.contains("2 light-position files (lights.lp, more.LP)"), "{text}");
    let none = tempfile::tempdir().unwrap();
    assert!(message(&none, Pairing::ByName).contains("no light-position file (.lp)"));
    let below = set("Dome/lights.lp", b"0\n", &["Photos/a.jpg"]);
    assert!(message(&below, Pairing::ByName).ends_with("that do: Dome"));
}

#[test]
fn a_light_file_may_be_named_itself() {
    let folder = folder("1\na.png 0 0 1", &["a.png", "second.lp"]);
    let capture = Capture::open(folder.path().join("lights.lp")).unwrap();
    assert_eq!(capture.lights(), [("a.png".to_owned(), Direction::ZENITH)]);
    assert!(Capture::open(folder.path().join("absent.lp")).is_err());
}

/// The photographs of a set whose light file has this name, below the real folder of the set.
fn found(set: &tempfile::TempDir, light_file: &str) -> (Vec<String>, Vec<String>) {
    let capture = Capture::open_paired(set.path().join(light_file), Pairing::ByName).unwrap();
    let root = set.path().canonicalize().unwrap();
    let real = |p: &Photograph| p.path.canonicalize().unwrap();
    let names =
        capture.photographs.iter().map(|p| real(p).strip_prefix(&root).unwrap().display().to_string());
    (names.collect(), capture.warnings)
}

#[test]
fn an_absolute_path_that_exists_is_taken_before_its_name_beside_the_light_file() {
    let elsewhere = folder("0\n", &["a b.png"]);
    let path = elsewhere.path().join("a b.png");
    let set = folder(&format!("1\n{} 0 0 1", path.display()), &["a b.png"]);
    let capture = Capture::open_paired(set.path(), Pairing::ByName).unwrap();
    assert_eq!(capture.photographs[0].path, path);
}

#[test]
fn listed_folders_that_are_missing_or_spelt_otherwise_are_no_obstacle() {
    let lp = "4\nphotos/a.jpg 0 0 1\nC:\\dome\\Photos 2\\b.JPG 0 0 1\n..\\x\\c.jpg 0 0 1\nsub\\d.jpg 0 0 1";
    let set = folder(lp, &["a.jpg", "photos 2/b.jpg", "b.JPG", "c.jpg", "sub\\d.jpg"]);
    assert_eq!(found(&set, "lights.lp").0, ["a.jpg", "photos 2/b.jpg", "c.jpg", "sub\\d.jpg"]);
}

#[test]
fn photographs_in_the_folder_beside_that_their_paths_name_are_found() {
    let lp = b"2\nC:\\rti\\jpeg-exports\\a.jpg 0 0 1\nC:\\rti\\jpeg-exports\\b.jpg 0 1 1";
    let pictures = ["jpeg-exports/a.jpg", "jpeg-exports/b.jpg", "other/a.jpg", "other/b.jpg"];
    let set = set("assembly-files/x.lp", lp, &pictures);
    assert_eq!(found(&set, "assembly-files/x.lp").0, ["jpeg-exports/a.jpg", "jpeg-exports/b.jpg"]);
}

#[test]
fn bare_names_are_found_in_the_only_folder_near_that_holds_them_all_and_that_is_said() {
    let lp = b"2\na.jpg 0 0 1\nb.jpg 0 1 1";
    for place in ["set/photos/", "photos/", ""] {
        let files = [format!("{place}a.jpg"), format!("{place}b.jpg"), "half/a.jpg".to_owned()];
        let set = set("set/x.lp", lp, &files.each_ref().map(String::as_str));
        let (names, warnings) = found(&set, "set/x.lp");
        assert_eq!(names, files[..2]);
        assert!(warnings.len() == 1 && warnings[0].contains("all were found in"), "{warnings:?}");
    }
    let two = set("set/x.lp", lp, &["p/a.jpg", "p/b.jpg", "q/a.jpg", "q/b.jpg"]);
    let error = Capture::open_paired(two.path().join("set/x.lp"), Pairing::ByName).unwrap_err().to_string();
    assert!(error.contains("2 other folders hold files of all these names"), "{error}");
}

#[test]
fn one_photograph_missing_is_not_borrowed_from_another_set() {
    let set = set("Test/x.lp", b"2\na.jpg 0 0 1\nb.jpg 0 1 1", &["Test/a.jpg", "Dome/a.jpg", "Dome/b.jpg"]);
    let error = Capture::open_paired(set.path().join("Test/x.lp"), Pairing::ByName).unwrap_err().to_string();
    assert!(error.contains("line 3: the photograph b.jpg is missing"), "{error}");
}

#[test]
fn a_missing_name_is_told_whole_with_the_folders_searched() {
    let name = format!("C:\\{}\\photographs\\img_0001.jpg", "long ".repeat(30));
    let set = folder(&format!("2\na.png 0 0 1\n{name} 0 0 1"), &["a.png"]);
    let text = message(&set, Pairing::ByName);
    let above = set.path().canonicalize().unwrap();
    assert!(text.contains(&name) && text.contains(&above.parent().unwrap().display().to_string()), "{text}");
}

#[test]
fn files_of_systems_are_no_photographs_and_no_light_files() {
    let extra = ["._a.jpg", "._b.jpg", ".DS_Store", "Thumbs.db", "._lights.lp"];
    let set = folder("2\nx 0 0 1\ny 0 1 1", &[&["a.jpg", "b.jpg"][..], &extra].concat());
    assert_eq!(opened(&set, Pairing::ByOrder).unwrap(), ["a.jpg", "b.jpg"]);
    std::fs::write(set.path().join("lights.lp"), "2\na.jpg 0 0 1\nb.jpg 0 1 1").unwrap();
    assert_eq!(found(&set, "lights.lp").1, [""; 0]);
}

#[test]
fn pictures_without_a_line_are_said() {
    let set = folder("1\na.jpg 0 0 1", &["a.jpg", "mask.png", "b.jpg", "notes.txt"]);
    let warnings = found(&set, "lights.lp").1;
    assert!(warnings.len() == 1 && warnings[0].contains("2 pictures have no line"), "{warnings:?}");
    assert!(warnings[0].ends_with("b.jpg, mask.png"), "{warnings:?}");
}

#[test]
fn a_wrong_count_and_a_missing_photograph_are_said_together() {
    let set = folder("4\na.jpg 0 0 1\nb.jpg 0 1 1\nc.jpg 1 0 1\n\n", &["a.jpg", "b.jpg"]);
    let text = message(&set, Pairing::ByName);
    assert!(text.contains("line 4: the photograph c.jpg is missing"), "{text}");
    assert!(text.contains("line 1 promises 4 lights, but 3 lines follow"), "{text}");
}

#[test]
fn a_wrong_count_is_said_and_the_capture_usable() {
    let set = folder("2\na.jpg 0 0 1\nb.jpg 0 1 1\nc.jpg 1 0 1\n\n", &["a.jpg", "b.jpg", "c.jpg"]);
    let (names, warnings) = found(&set, "lights.lp");
    assert_eq!(names, ["a.jpg", "b.jpg", "c.jpg"]);
    assert!(warnings.len() == 1 && warnings[0].contains("promises 2 lights, but 3 lines"), "{warnings:?}");
    // A line without a photograph that the first line does not count either.
    std::fs::remove_file(set.path().join("b.jpg")).unwrap();
    let (names, warnings) = found(&set, "lights.lp");
    assert_eq!(names, ["a.jpg", "c.jpg"]);
    assert!(warnings[0].contains("no photographs of b.jpg"), "{warnings:?}");
}

#[test]
fn lights_at_the_horizon_are_said() {
    let set = folder("2\na.jpg 0 0.79 -0.001\nb.jpg 0 0 1.06", &["a.jpg", "b.jpg"]);
    let warnings = found(&set, "lights.lp").1;
    assert!(warnings.len() == 1 && warnings[0].contains("a.jpg are at or below the horizon"), "{warnings:?}");
}

#[test]
fn projects_and_domes_of_relightlab_are_captures() {
    let project =
        br#"{"folder": "jpg", "images": [{"filename": "b.jpg", "direction": {"x":0,"y":0,"z":1}}]}"#;
    let named = set("x.relight", project, &["jpg/b.jpg"]);
    assert_eq!(found(&named, "x.relight").0, ["jpg/b.jpg"]);
    assert_eq!(opened(&named, Pairing::ByName).unwrap(), ["jpg/b.jpg"]);
    let dome = set("x.dome", br#"{"directions": [[0,0,1],[0,1,1]]}"#, &["2.jpg", "10.jpg"]);
    assert_eq!(found(&dome, "x.dome").0, ["2.jpg", "10.jpg"]);
}

#[cfg(unix)]
#[test]
fn names_that_are_not_utf_8_are_found_by_their_bytes_or_as_latin_1() {
    use std::os::unix::ffi::OsStrExt;
    let set = set("lights.lp", b"2\nn\xe9.png 0 0 1\n\xe8.png 0 1 1", &["\u{e8}.png"]);
    let path = set.path().join(OsStr::from_bytes(b"n\xe9.png"));
    std::fs::write(&path, b"").unwrap();
    let capture = Capture::open_paired(set.path(), Pairing::ByName).unwrap();
    let paths: Vec<_> = capture.photographs.into_iter().map(|p| p.path).collect();
    assert_eq!(paths, [path.clone(), set.path().join("\u{e8}.png")]);
    std::fs::write(set.path().join("lights.lp"), "1\nN\u{e9}.png 0 0 1").unwrap();
    assert_eq!(Capture::open_paired(set.path(), Pairing::ByName).unwrap().photographs[0].path, path);
    std::fs::write(set.path().join("lights.lp"), "2\nx 0 0 1\ny 0 1 1").unwrap();
    assert_eq!(Capture::open_paired(set.path(), Pairing::ByOrder).unwrap().photographs[0].path, path);
}
