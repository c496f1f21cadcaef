//! Textures in other formats, and what that loses.

use std::fs;

use relume::format::NormalY;
use relume::procedural::Material;
use relume::{Job, Size};

use crate::support::{done, failed, json, names, refused, run, write_material};

fn fitted(folder: &std::path::Path) {
    done(folder, &["capture", "sponge", "-o", "c", "--size", "40", "--lights", "20"]);
    done(folder, &["fit", "c", "-o", "a.ptm"]);
}

#[test]
fn a_texture_goes_through_all_formats_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fitted(path);
    let rti = json(path, &["convert", "a.ptm", "-o", "a.rti"]);
    assert_eq!((rti["basis"].as_str(), rti["from"]["basis"].as_str()), (Some("hsh9"), Some("ptm")));
    let rms = rti["loss"]["rms"].as_f64().unwrap();
    assert!(rms > 0.0 && rms < 0.05 && rti["loss"]["largest"].as_f64().unwrap() >= rms, "{rti}");
    let web = json(path, &["convert", "a.rti", "-o", "web", "--web", "itarzoom"]);
    let of_jpeg = web["loss"]["rms"].as_f64().unwrap();
    assert!(of_jpeg > 0.0 && of_jpeg < 0.02, "{web}");
    assert_eq!(names(&path.join("web")).iter().filter(|n| n.starts_with("planes")).count(), 2);
    let older = json(path, &["convert", "a.rti", "-o", "older", "--web", "multires"]);
    assert!(older["loss"]["rms"].as_f64().unwrap() < 0.02 && path.join("older/1_9.jpg").is_file(), "{older}");
    for name in ["older", "older/info.xml"] {
        assert_eq!(json(path, &["info", name])["basis"], "hsh9");
    }
    // Other harmonics than the viewer shows are refused where they are asked for, and refitted where they are not.
    let sentence = failed(path, &["convert", "a.ptm", "-o", "no", "--web", "multires", "--basis", "sh9"], 2);
    assert!(sentence.contains("hsh9"), "{sentence}");
    done(path, &["convert", "a.ptm", "-o", "a16.rti", "--basis", "hsh16"]);
    assert_eq!(json(path, &["convert", "a16.rti", "-o", "refitted", "--web", "multires"])["basis"], "hsh9");
    let back = json(path, &["convert", "web", "-o", "b.ptm", "--jpeg", "95"]);
    assert_eq!(back["basis"], "ptm");
    assert!(fs::read(path.join("b.ptm")).unwrap().starts_with(b"PTM_1.2\nPTM_FORMAT_JPEG_"));
    let compared = json(path, &["compare", "a.ptm", "b.ptm"]);
    assert!(compared["rmse"].as_f64().unwrap() < 0.06, "{compared}");
    for name in ["a.hsh", "a.exr", "a.npz", "a.npy"] {
        done(path, &["convert", "a.ptm", "-o", name]);
    }
    let info = json(path, &["info", "web"]);
    assert_eq!((info["basis"].as_str(), info["width"].as_u64()), (Some("hsh9"), Some(40)));
    done(path, &["relight", "web", "--light", "0.5,0.5,0.7", "-o", "relit.png"]);
}

/// A .hsh file has a function for each channel, and the report says what it holds.
#[test]
fn an_hsh_file_is_said_to_hold_what_it_holds() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fitted(path);
    let made = json(path, &["convert", "a.ptm", "-o", "a.hsh"]);
    assert_eq!((made["from"]["color"].as_str(), made["color"].as_str()), (Some("lrgb"), Some("rgb")));
    assert_eq!(json(path, &["info", "a.hsh"])["color"], "rgb");
    let sentence = failed(path, &["convert", "a.ptm", "-o", "b.hsh", "--color", "lrgb"], 2);
    assert!(sentence.contains(".rti"), "{sentence}");
}

/// The planes of web folders and of compressed files are JPEG, whatever functions they hold.
#[test]
fn what_jpeg_loses_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fitted(path);
    for options in [&["b.ptm", "--jpeg", "50"][..], &["web", "--web"]] {
        let text = run(path, &[&["convert", "a.ptm", "-o"], options].concat());
        assert!(text.contains("relit values change by") && !text.contains("the same functions"), "{text}");
    }
    let sentence = failed(path, &["convert", "a.ptm", "-o", "c.ptm", "--web"], 2);
    assert!(sentence.contains("c.ptm") && sentence.contains("name a folder"), "{sentence}");
    assert!(!path.join("c.ptm").exists());
}

/// A fault: copies of height and normal maps were sRGB pictures without the record of their scale and direction.
#[test]
fn copies_of_maps_keep_what_they_record() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    done(at, &["procedural", "leather", "-o", "m", "--size", "64"]);
    done(at, &["maps", "m", "-o", "p", "--preset", "unreal", "--texel-mm", "0.5"]);
    let (recorded, down) = ("p/T_Material_H.png", "p/T_Material_N.png");
    for (from, to) in [(recorded, "h.png"), (down, "n.png")] {
        let text = run(at, &["convert", from, "-o", to]);
        assert!(text.contains("with their record"), "{text}");
    }
    let open = |name: &str| relume::format::open(&at.join(name), &Job::default()).unwrap();
    let height = |name: &str| open(name).into_height().unwrap();
    assert_eq!(height(recorded).scale.unwrap().mm_per_texel, Some(0.5));
    assert_eq!(height("h.png"), height(recorded));
    let normals = |name: &str| open(name).into_normals(None).unwrap();
    assert_eq!(normals("n.png"), normals(down));
    assert_eq!(normals("n.png").y, NormalY::Down);
    // Through the other kind of file and back.
    done(at, &["convert", recorded, "-o", "h.exr"]);
    done(at, &["convert", "h.exr", "-o", "back.png"]);
    let (stored, back) = (height(recorded), height("back.png"));
    assert_eq!(back.scale.unwrap().mm_per_texel, Some(0.5));
    let pairs = stored.texels(1.0);
    let pairs = pairs.as_slice().iter().zip(back.texels(1.0).as_slice().to_vec());
    assert!(pairs.clone().all(|(a, b)| (a - b).abs() < 1e-3));
    done(at, &["convert", down, "-o", "n.exr"]);
    assert_eq!(normals("n.exr").y, NormalY::Down);
    for output in ["h.tif", "h.npy"] {
        assert!(failed(at, &["convert", recorded, "-o", output], 2).contains("--space srgb"));
    }
    assert!(failed(at, &["convert", "h.exr", "-o", "half.exr", "--half"], 2).contains("leave out --half"));
    let single = failed(at, &["maps", recorded, "-o", "one", "--preset", "unity"], 2);
    assert!(single.contains("not of colours"), "{single}");
    assert!(!fs::read(at.join("n.png")).unwrap().windows(4).any(|chunk| chunk == b"sRGB"));
}

/// A fault: the depth of the file that was read won over the one that was asked for.
#[test]
fn halves_that_are_asked_for_are_written_of_the_same_functions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fitted(path);
    done(path, &["convert", "a.ptm", "-o", "a.exr"]);
    let report = json(path, &["convert", "a.exr", "-o", "half.exr", "--half"]);
    assert!(report["loss"]["rms"].as_f64().unwrap() < 1e-3, "{report}");
    assert_eq!(json(path, &["info", "half.exr"])["encoding"]["exr"], "half");
    assert_eq!(json(path, &["info", "a.exr"])["encoding"]["exr"], "float");
    // Of halves, halves are kept, and nothing is lost.
    assert!(json(path, &["convert", "half.exr", "-o", "again.exr"])["loss"].is_null());
}

#[test]
fn a_copy_keeps_the_bytes_and_says_that_nothing_changed() {
    let folder = tempfile::tempdir().unwrap();
    fitted(folder.path());
    let report = json(folder.path(), &["convert", "a.ptm", "-o", "b.ptm"]);
    assert!(report["loss"].is_null());
    let [a, b] = ["a.ptm", "b.ptm"].map(|name| fs::read(folder.path().join(name)).unwrap());
    assert!(a == b);
}

#[test]
fn linear_textures_are_encoded_where_the_format_holds_encoded_values() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    done(path, &["capture", "sponge", "-o", "c", "--size", "24", "--lights", "20"]);
    done(path, &["fit", "c", "-o", "a.exr"]);
    let report = json(path, &["convert", "a.exr", "-o", "a.ptm"]);
    assert_eq!((report["space"].as_str(), report["from"]["space"].as_str()), (Some("srgb"), Some("linear")));
    assert!(report["loss"]["rms"].as_f64().unwrap() < 0.1, "{report}");
    let sentence = failed(path, &["convert", "a.exr", "-o", "b.ptm", "--space", "linear"], 2);
    assert!(sentence.contains("linear"), "{sentence}");
}

#[test]
fn arrays_are_read_by_numpy_where_it_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    fitted(path);
    done(path, &["convert", "a.ptm", "-o", "a.npz"]);
    let script = "import numpy; z = numpy.load('a.npz'); print(z['coefficients'].shape, z['coefficients'].dtype, \
                  list(z['names'])[:2], z['lights'].shape, str(z['basis']), str(z['space']))";
    let python = std::process::Command::new("python3").current_dir(path).args(["-c", script]).output();
    match python {
        Ok(output) if output.status.success() => {
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(
                text.contains("40, 40) float32") && text.contains("u2") && text.contains("ptm srgb"),
                "{text}"
            );
        }
        _ => println!("SKIPPED: python3 with numpy is not there"),
    }
}

#[test]
fn what_cannot_be_converted_is_said_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_material(&path.join("a.png"), Material::Sponge, Size::new(16, 16), 8.0);
    assert!(refused(path, &["convert", "a.png", "-o", "out"]).contains("--web"));
    assert!(
        refused(path, &["convert", "a.png", "-o", "a.exr", "--jpeg", "90"]).contains("--jpeg is for .ptm")
    );
    assert!(refused(path, &["convert", "a.png", "-o", "a.tif", "--half"]).contains("--half is for .exr"));
    assert!(refused(path, &["convert", "a.png", "-o", "b.png", "--basis", "ptm"]).contains("relight"));
    // A picture as functions that no light changes.
    let report = json(path, &["convert", "a.png", "-o", "a.ptm"]);
    assert!(report["loss"]["largest"].as_f64().unwrap() < 1.0 / 255.0, "a code at most: {report}");
}

#[test]
fn formats_lists_what_is_read_and_written() {
    let folder = tempfile::tempdir().unwrap();
    let text = crate::support::run(folder.path(), &["formats"]);
    for word in ["PTM .ptm", "RTI .rti", "web folder", "JPEG-LS", "neural"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}
