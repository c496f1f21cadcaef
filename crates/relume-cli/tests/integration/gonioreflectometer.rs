//! `relume capture --views` as a user runs it.

use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use zip::ZipArchive;

use crate::support::{done, failed, json, names, run};

/// All entries of an archive with their bytes, in order.
fn entries(path: &Path) -> Vec<(String, Vec<u8>)> {
    let mut archive = ZipArchive::new(File::open(path).unwrap()).unwrap();
    let count = archive.len();
    let entry = |k: usize| {
        let mut file = archive.by_index(k).unwrap();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        (file.name().unwrap().into_owned(), bytes)
    };
    (0..count).map(entry).collect()
}

#[test]
fn all_pairs_of_the_published_directions_are_in_the_archive_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let report =
        json(folder.path(), &["capture", "weave", "--size", "9", "--views", "bonn", "-o", "my weave.zip"]);
    assert_eq!(
        (&report["images"], &report["lights"], &report["views"]),
        (&6561.into(), &81.into(), &81.into())
    );
    let all = entries(&folder.path().join("my weave.zip"));
    let images: Vec<&str> =
        all.iter().map(|(name, _)| name.as_str()).filter(|name| name.ends_with(".jpg")).collect();
    assert_eq!(images.len(), 6561);
    assert_eq!(images[0], "my weave/tv000_pv000/00000 tl000 pl000 tv000 pv000.jpg");
    assert_eq!(images[83], "my weave/tv015_pv000/00083 tl015 pl060 tv015 pv000.jpg");
    assert_eq!(images[6560], "my weave/tv075_pv345/06560 tl075 pl345 tv075 pv345.jpg");
    assert!(images.is_sorted(), "view by view, numbers ascending");
    let others: Vec<&str> = all[6561..].iter().map(|(name, _)| name.as_str()).collect();
    let truth = ["normals.exr", "albedo.exr", "height.exr", "roughness.exr", "normals_gl.png"];
    let expected: Vec<String> = truth.map(|name| format!("my weave/truth/{name}")).to_vec();
    assert_eq!(others[..5], expected);
    assert_eq!(others[5..], ["my weave/capture.json"]);
    let described: serde_json::Value = serde_json::from_slice(&all[6566].1).unwrap();
    assert_eq!((&described["sampling"], &described["holds_cosine"]), (&"bonn".into(), &true.into()));
    assert_eq!(described["encoding"], "srgb");
}

#[test]
fn an_archive_unpacks_to_the_folder_of_the_same_name() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for format in ["jpg", "png", "exr"] {
        let common = ["--size", "16x12", "--views", "3", "--lights", "2", "--format", format, "--force"];
        run(at, &[&["capture", "pebbles", "-o", "out"], &common[..]].concat());
        run(at, &[&["capture", "pebbles", "-o", "out.zip"], &common[..]].concat());
        let all = entries(&at.join("out.zip"));
        assert_eq!(
            all.iter().filter(|(name, _)| name.ends_with(&format!(".{format}"))).count() > 6,
            format != "jpg"
        );
        for (name, bytes) in all {
            assert!(fs::read(at.join(&name)).unwrap() == bytes, "{name} differs");
        }
    }
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let archive = |threads: &str| {
        let out = format!("{threads}/out.zip");
        let measured =
            ["capture", "leather", "-o", &out, "--size", "20", "--pairs", "9", "--threads", threads];
        run(folder.path(), &measured);
        fs::read(folder.path().join(out)).unwrap()
    };
    assert!(archive("1") == archive("3"));
}

#[test]
fn random_directions_belong_to_their_seed_and_names_have_decimals() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let of = |out: &str, more: &[&str]| {
        run(at, &[&["capture", "weave", "--size", "8", "-o", out], more].concat());
        let names =
            entries(&at.join(out)).into_iter().map(|(name, _)| name.split_once('/').unwrap().1.to_owned());
        names.filter(|name| name.starts_with("tv")).collect::<Vec<_>>()
    };
    let (first, again, other) = (
        of("a.zip", &["--pairs", "5"]),
        of("b.zip", &["--pairs", "5", "--direction-seed", "0"]),
        of("c.zip", &["--pairs", "5", "--direction-seed", "1"]),
    );
    assert!(first == again && first != other && first.len() == 5, "{first:?}");
    assert!(first.iter().all(|name| name.matches('.').count() > 1), "{first:?}");
    assert_eq!(of("d.zip", &["--views", "4"]).len(), 16);
}

#[test]
fn what_cannot_be_measured_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let refused = |more: &[&str]| failed(at, &[&["capture", "weave", "-o", "x.zip"], more].concat(), 2);
    assert!(refused(&[]).contains("--views"));
    assert!(refused(&["--views", "many"]).contains("bonn"));
    assert!(refused(&["--views", "0"]).contains("bonn"));
    assert!(refused(&["--views", "bonn", "--lights", "9"]).contains("--lights"));
    assert!(refused(&["--views", "bonn", "--pairs", "9"]).contains("--pairs"));
    assert!(refused(&["--views", "dome", "--direction-seed", "9"]).contains("random"));
    assert!(refused(&["--direction-seed", "9"]).contains("random"));
    assert!(refused(&["--views", "9000", "--lights", "9000"]).contains("1000000"));
    assert!(refused(&["--views", "3", "--ambient", "2"]).contains("ambient"));
    assert!(
        failed(at, &["capture", "weave", "-o", "x.zip", "--views", "3", "--memory", "0.001"], 1)
            .contains("GiB of memory")
    );
    fs::write(at.join("x.zip"), "mine").unwrap();
    assert!(refused(&["--views", "3"]).contains("--force"));
    assert_eq!(fs::read(at.join("x.zip")).unwrap(), b"mine");
    done(at, &["capture", "weave", "-o", "x.zip", "--views", "3", "--size", "8", "--force"]);
    assert_eq!(names(at), ["x.zip"]);
}
