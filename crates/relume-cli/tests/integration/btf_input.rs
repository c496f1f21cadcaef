//! Sets of photographs under light and view that are not as they should be, and names of outputs: one sentence each, before the work.

use std::fs;
use std::path::Path;

use crate::btf::{photographs, png_of, write_folder, write_zip};
use crate::support::{done, failed, json, refused, run};

/// The photographs of which the name passes.
fn some(keep: impl Fn(&str) -> bool) -> Vec<(String, Vec<u8>)> {
    photographs().into_iter().filter(|(name, _)| keep(name)).collect()
}

#[test]
fn a_file_is_not_written_under_the_name_of_another_kind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "b.exr", "--rank", "4"]);
    for (arguments, said) in [
        (&["model", "b.exr", "-o", "z.exr"][..], ".rlm"),
        (&["model", "b.exr", "-o", "z.rlm", "--curve", "c.png"], ".svg"),
        (&["fit", "b.zip", "-o", "z.exr", "--report", "r.png"], ".html"),
        (&["match", "b.exr", "--to", "b.exr", "-o", "z.exr", "--ranks", "r.png"], ".exr"),
        (&["share", "b.exr", "-o", "z.png", "--single-file"], ".html"),
        (&["lights", "b.exr", "-o", "z.exr"], ".lp"),
        (&["share", "b.exr", "-o", "z.zip"], "name a folder"),
        (&["maps", "b.exr", "-o", "z.glb", "--preset", "gltf"], "name a folder"),
        (&["convert", "b.exr", "-o", "z.btf"], "relume fit PHOTOGRAPHS"),
    ] {
        let sentence = refused(path, arguments);
        assert!(sentence.contains(said), "{arguments:?}: {sentence}");
    }
}

#[test]
fn a_btf_that_cannot_hold_the_pairs_is_refused_before_the_fit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // Photographs that cannot be read: no work is done on them.
    let unequal = some(|name| !name.contains("tv060 pv090"));
    let broken: Vec<(String, Vec<u8>)> = unequal.iter().map(|(name, _)| (name.clone(), vec![0])).collect();
    write_zip(&path.join("u.zip"), &broken);
    for factors in [&[][..], &["--factors", "decorrelated"]] {
        let sentence = refused(path, &[&["fit", "u.zip", "-o", "u.btf"][..], factors].concat());
        assert!(sentence.starts_with("relume: u.btf: "), "{sentence}");
        assert!(
            sentence.contains("7 views and 8 lights") && sentence.contains("--factors per-view"),
            "{sentence}"
        );
    }
    write_zip(&path.join("v.zip"), &unequal);
    done(path, &["fit", "v.zip", "-o", "v.btf", "--factors", "per-view", "--rank", "2"]);
    assert!(run(path, &["compare", "v.zip", "v.btf"]).contains("56 photographs"));
}

/// A fault: textures whose functions have one name and are not the same ended in a panic.
#[test]
fn textures_of_other_learned_functions_are_no_exemplars_of_one_texture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("a.zip"), &photographs());
    write_zip(&path.join("b.zip"), &some(|name| !name.contains("tv060 pv090")));
    for name in ["a", "b"] {
        done(path, &["fit", &format!("{name}.zip"), "-o", &format!("{name}.exr"), "--rank", "4"]);
    }
    for method in [&[][..], &["--method", "patchmatch"], &["--method", "wei-levoy"]] {
        let two = [&["synth", "a.exr", "b.exr", "--size", "32", "-o", "c.exr"], method].concat();
        let sentence = refused(path, &two);
        assert!(
            sentence.starts_with("relume: b.exr: ") && sentence.contains("other functions"),
            "{sentence}"
        );
        assert!(!sentence.contains("  "), "{sentence}");
    }
    done(path, &["synth", "a.exr", "a.exr", "--size", "32", "-o", "c.exr"]);
}

/// A fault: one photograph that was equal made the mean of all infinite, which was said to be equal.
#[test]
fn photographs_that_are_equal_do_not_make_others_equal() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut other = photographs();
    let last = other.len() - 1;
    other[last].1 = other[0].1.clone();
    write_folder(&path.join("a"), &photographs());
    write_folder(&path.join("b"), &other);
    let found = json(path, &["compare", "a", "b"]);
    assert!(found["psnr_db"].as_f64().is_some() && found["exact"].as_u64().unwrap() > 0, "{found}");
    assert!(found["worst"]["psnr_db"].as_f64().unwrap() < 60.0, "{found}");
}

#[test]
fn two_single_pairs_are_fitted_and_a_model_says_why_it_takes_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let two =
        some(|name| name.contains("tl000 pl000 tv000 pv000") || name.contains("tl030 pl000 tv060 pv090"));
    assert_eq!(two.len(), 2);
    write_zip(&path.join("p.zip"), &two);
    done(path, &["fit", "p.zip", "-o", "p.exr", "--rank", "2"]);
    for arguments in [
        &["model", "p.zip", "-o", "p.rlm"][..],
        &["fit", "p.zip", "-o", "q.exr", "--rank", "2", "--rounding", "0.01"],
    ] {
        let sentence = refused(path, arguments);
        assert!(
            sentence.contains("2 pairs of 2 lights and 2 views") && sentence.contains("relume fit"),
            "{sentence}"
        );
    }
    let sentence = refused(path, &["fit", "p.zip", "-o", "q.exr", "--rounding", "1e-12"]);
    assert!(sentence.contains("0.000001 to 0.25"), "{sentence}");
}

#[test]
fn pictures_without_angles_are_named_and_double_entries_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut more = photographs();
    let one = more[0].1.clone();
    more.push(("extra.png".to_owned(), one.clone()));
    more.push(("00099 tl0-15 pl0 tv0 pv0.png".to_owned(), one.clone()));
    write_zip(&path.join("b.zip"), &more);
    write_folder(&path.join("b"), &more);
    for set in ["b.zip", "b"] {
        let info = json(path, &["info", set]);
        assert_eq!((&info["photographs"], &info["view_count"]), (&64.into(), &8.into()), "{info}");
        let warning = info["warnings"][0].as_str().unwrap();
        assert!(
            warning.contains("2 pictures") && warning.contains("extra.png") && warning.contains("tl0-15"),
            "{warning}"
        );
    }
    // The same bytes with two entries of one name: names of one length are exchanged in place.
    let bytes = fs::read(path.join("b.zip")).unwrap();
    let (from, to) = (b"extra.png".as_slice(), b"extrb.png".as_slice());
    let twice = [&more[..], &[("extrb.png".to_owned(), one)]].concat();
    write_zip(&path.join("d.zip"), &twice);
    let mut double = fs::read(path.join("d.zip")).unwrap();
    for at in 0..double.len() - to.len() {
        if double[at..].starts_with(to) {
            double[at..at + from.len()].copy_from_slice(from);
        }
    }
    assert!(double.len() > bytes.len());
    fs::write(path.join("d.zip"), double).unwrap();
    let sentence = failed(path, &["info", "d.zip"], 1);
    assert!(sentence.contains("two entries of the name") && sentence.contains("extra.png"), "{sentence}");
}

#[test]
fn a_compression_that_is_not_read_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    // The method of an entry, in its own head and in the directory: 14 is LZMA.
    let mut bytes = fs::read(path.join("b.zip")).unwrap();
    for at in 0..bytes.len() - 12 {
        for (signature, place) in [(b"PK\x03\x04", 8), (b"PK\x01\x02", 10)] {
            if bytes[at..].starts_with(signature) {
                bytes[at + place..at + place + 2].copy_from_slice(&[14, 0]);
            }
        }
    }
    fs::write(path.join("b.zip"), bytes).unwrap();
    let sentence = failed(path, &["info", "b.zip"], 1);
    assert!(sentence.contains("deflate") && sentence.to_lowercase().contains("lzma"), "{sentence}");
    assert!(!sentence.contains("damaged"), "{sentence}");
}

#[test]
fn black_photographs_are_refused_by_every_form() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let black = png_of(8, &[0; 192]);
    let black: Vec<(String, Vec<u8>)> =
        photographs().into_iter().map(|(name, _)| (name, black.clone())).collect();
    write_zip(&path.join("b.zip"), &black);
    for (output, options, status) in [
        ("b.exr", &[][..], 1),
        ("b.exr", &["--model", "ggx"], 1),
        ("b.exr", &["--model", "lafortune1"], 1),
        // A fit of each view blames the functions chosen.
        ("b.exr", &["--model", "views-ptm"], 2),
        ("b.btf", &["--factors", "decorrelated"], 1),
        ("b.btf", &["--factors", "per-view"], 1),
    ] {
        let sentence = failed(path, &[&["fit", "b.zip", "-o", output][..], options].concat(), status);
        assert!(sentence.contains("black"), "{options:?}: {sentence}");
    }
}

#[test]
fn archives_and_textures_given_to_other_verbs_are_called_what_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "b.exr", "--rank", "4"]);
    for (arguments, said) in [
        (&["convert", "b.zip", "-o", "c.exr"][..], "relume fit"),
        (&["render", "b.zip", "-o", "c.png"], "relume fit"),
        (&["fit", "b.exr", "-o", "c.exr"], "relume convert"),
        (
            &["synth", "b.exr", "-o", "c.exr", "--size", "32", "--apply", "nosuchfolder"],
            "no such file or folder",
        ),
    ] {
        let sentence = refused(path, arguments);
        assert!(sentence.contains(said), "{arguments:?}: {sentence}");
    }
    fs::create_dir(path.join("empty")).unwrap();
    let sentence = refused(path, &["synth", "b.exr", "-o", "c.exr", "--size", "32", "--apply", "empty"]);
    assert!(sentence.contains("folder without photographs"), "{sentence}");
    let text =
        run(path, &["synth", "b.exr", "-o", "c.exr", "--size", "32", "--block", "8", "--apply", "b.zip"]);
    assert!(text.contains("c_b.zip: 64 photographs of 32 x 32 rearranged, "), "{text}");
}

#[test]
fn errors_of_all_fits_are_said_by_the_measure_of_compare() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    let fit = json(path, &["fit", "b.zip", "-o", "b.btf", "--rank", "4"]);
    let said = fit["report"]["fitted"]["encoded"]["rmse"].as_f64().unwrap();
    let compared = json(path, &["compare", "b.zip", "b.btf"])["rmse"].as_f64().unwrap();
    assert!((compared / said - 1.0).abs() < 0.3, "{compared} where the fit said {said}");
    let text = run(path, &["fit", "b.zip", "-o", "b.btf", "--rank", "4", "--force"]);
    assert!(text.contains("relit photographs, encoded: ") && text.contains("of linear values"), "{text}");
    let text = run(path, &["compare", "b.zip", "b.zip"]);
    assert!(text.contains("equal") && !text.contains("inf"), "{text}");
}

#[test]
fn a_model_of_reflectance_models_is_not_compared_with_photographs_that_never_were() {
    let folder = tempfile::tempdir().unwrap();
    let path: &Path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "g.exr", "--model", "ggx"]);
    let model = json(
        path,
        &["model", "g.exr", "-o", "g.rlm", "--levels", "1", "--combine", "never", "--candidates", "2"],
    );
    assert_eq!(model["source"]["photographs"], 0, "{model}");
}
