//! From a folder of photographs to a material, and photographs that differ in more than their light.

use std::fs;
use std::path::{Path, PathBuf};

use relume::format::{Depth, PictureFormat, encode_picture, read_raster};
use relume::{Job, Picture, Space};
use serde_json::Value;

use crate::support::{done, failed, json, names, refused, write_grey};

/// Photographs of a virtual surface without their light file and truth, with mirror balls at their right.
fn folder_with_balls() -> (tempfile::TempDir, Value) {
    let folder = tempfile::tempdir().unwrap();
    let shoot = ["capture", "leather", "-o", "photos", "--size", "96", "--lights", "18", "--balls", "1"];
    let report = json(folder.path(), &shoot);
    for file in ["lights.lp", "capture.json", "relume-files.json"] {
        fs::remove_file(folder.path().join("photos").join(file)).unwrap();
    }
    fs::remove_dir_all(folder.path().join("photos/truth")).unwrap();
    (folder, report["balls"][0].clone())
}

/// A former fault: only the folder was named.
#[test]
fn a_damaged_photograph_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let shoot = ["capture", "leather", "-o", "photos", "--size", "24", "--lights", "12", "--format", "exr"];
    done(folder.path(), &shoot);
    let photograph = folder.path().join("photos/light_003.exr");
    let bytes = fs::read(&photograph).unwrap();
    fs::write(&photograph, &bytes[..bytes.len() / 2]).unwrap();
    let message = failed(folder.path(), &["new", "photos/lights.lp", "-o", "leather"], 1);
    assert!(message.contains("light_003.exr"), "{message}");
    assert!(!folder.path().join("leather").exists());
}

#[test]
fn one_command_makes_a_material_of_photographs_with_a_mirror_ball() {
    let (folder, ball) = folder_with_balls();
    let outline = format!("{},{},{}", ball["x"], ball["y"], ball["radius"]);
    let new = ["new", "photos", "-o", "leather", "--ball", &outline, "--crop", "0,0,96,96"];
    let report = json(folder.path(), &new);
    let made = names(&folder.path().join("leather"));
    for file in [
        "albedo.png",
        "balls.png",
        "height.exr",
        "lights.lp",
        "normals_gl.png",
        "page.html",
        "relit.png",
        "report.html",
        "texture.exr",
        "texture.ptm",
    ] {
        assert!(made.iter().any(|name| name == file), "{file} is missing of {made:?}");
    }
    assert_eq!(report["lights"], 18);
    let text = |name: &str| fs::read_to_string(folder.path().join("leather").join(name)).unwrap();
    assert!(text("page.html").contains("<title>leather"), "the page has the name of the folder");
    assert!(text("report.html").contains("light_000") && !text("report.html").contains("http://"));
    assert!(report["fit"]["psnr_db"].as_f64().unwrap() > 25.0, "{}", report["fit"]);
    let size = read_raster(&folder.path().join("leather/albedo.png"), &Job::default()).unwrap().size();
    assert_eq!((size.width, size.height), (96, 96));
    let text = failed(folder.path(), &["new", "leather", "-o", "again", "--ball", "1,1,9"], 1);
    assert!(text.contains("not inside"), "{text}");
}

#[test]
fn four_photographs_give_maps_but_no_texture() {
    let folder = tempfile::tempdir().unwrap();
    done(folder.path(), &["capture", "sponge", "-o", "photos", "--size", "40", "--lights", "4"]);
    let report = json(folder.path(), &["new", "photos", "-o", "material"]);
    assert!(report["warnings"].to_string().contains("only maps"), "{}", report["warnings"]);
    assert!(folder.path().join("material/normals_gl.png").is_file());
    assert!(!folder.path().join("material/report.html").exists());
}

/// Every photograph of a capture, changed.
fn change(folder: &Path, with: &dyn Fn(usize, &mut Picture)) {
    let mut files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.file_name().unwrap().to_string_lossy().starts_with("light_"));
    files.sort();
    for (i, path) in files.iter().enumerate() {
        let mut picture = read_raster(path, &Job::default()).unwrap().to_picture(Space::Linear);
        with(i, &mut picture);
        fs::write(path, encode_picture(&picture, PictureFormat::Png(Depth::Sixteen)).unwrap()).unwrap();
    }
    let list = folder.join("relume-files.json");
    if list.exists() {
        fs::remove_file(list).unwrap();
    }
}

/// The mean angle to the true normals.
fn angle(at: &Path, more: &[&str]) -> f64 {
    let height = ["height", "p", "-o", "h.exr", "--force", "--truth-normals", "p/truth/normals.exr"];
    json(at, &[&height[..], more].concat())["normal_error"]["mean_deg"].as_f64().unwrap()
}

fn matt_capture() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let shoot =
        ["capture", "pebbles", "-o", "p", "--size", "64", "--lights", "24", "--format", "png16", "--matte"];
    done(folder.path(), &shoot);
    folder
}

#[test]
fn linear_photographs_are_recognised_and_read_as_declared() {
    let folder = matt_capture();
    let at = folder.path();
    let right = angle(at, &[]);
    // Files whose codes are proportional to light: encoding them as they are decoded keeps their values.
    change(&at.join("p"), &|_, picture| {
        for v in picture.planes.as_mut_slice() {
            *v = Space::Srgb.to_linear(*v);
        }
    });
    let (wrong, declared) = (angle(at, &[]), angle(at, &["--input-space", "linear"]));
    assert!((declared - right).abs() < 0.5 && wrong > right + 2.0, "{right} {wrong} {declared}");
    let auto = json(at, &["fit", "p", "-o", "a.ptm", "--input-space", "auto"]);
    assert_eq!(auto["development"]["input_space"], "linear");
    let srgb = json(at, &["fit", "p", "-o", "b.ptm", "--input-space", "srgb"]);
    assert!(srgb["warnings"].to_string().contains("look linear rather than"), "{}", srgb["warnings"]);
}

#[test]
fn exposures_intensities_and_the_light_of_the_room_are_undone() {
    let folder = matt_capture();
    let at = folder.path();
    let right = angle(at, &[]);
    let gain = |i: usize| if i.is_multiple_of(3) { 0.5f32 } else { 0.8 };
    change(&at.join("p"), &|i, picture| picture.planes.as_mut_slice().iter_mut().for_each(|v| *v *= gain(i)));
    let wrong = angle(at, &[]);
    let found = angle(at, &["--equalize"]);
    let text: String = (0..24).map(|i| format!("{}\n", gain(i))).collect();
    fs::write(at.join("strength.txt"), &text).unwrap();
    let given = angle(at, &["--intensities", "strength.txt"]);
    assert!((given - right).abs() < 0.3, "{right} {wrong} {given}");
    assert!(found < right + 1.0 && wrong > right + 2.0, "{right} {wrong} {found}");
    fs::write(at.join("zero.txt"), text.replacen("0.5", "0", 1)).unwrap();
    let height = ["height", "p", "-o", "x.exr", "--intensities"];
    let refuse = |file: &str| failed(at, &[&height[..], &[file]].concat(), 1);
    assert!(refuse("zero.txt").contains("line 1: the intensity 0"));
    for value in ["1e-300", "1e300", "inf", "NaN"] {
        fs::write(at.join("zero.txt"), text.replacen("0.5", value, 1)).unwrap();
        assert!(refuse("zero.txt").contains("from 0.000001 to 1000000"), "{value}");
    }
    fs::write(at.join("few.txt"), "1\n1\n").unwrap();
    assert!(refuse("few.txt").contains("2 intensities for 24 lights"));
    fs::write(at.join("words.txt"), "bright\n").unwrap();
    assert!(refuse("words.txt").contains("expected an intensity"));
    assert!(refuse("absent.txt").contains("cannot read the file"));
    fs::write(at.join("picture.txt"), [137, 80, 78, 71]).unwrap();
    assert!(refuse("picture.txt").contains("is not a text: expected a line for each light"));
}

#[test]
fn what_does_not_fit_the_photographs_is_refused_in_one_sentence() {
    let folder = matt_capture();
    let at = folder.path();
    write_grey(&at.join("card.png"), (9, 9), &[200; 81]);
    write_grey(&at.join("black.png"), (64, 64), &[0; 64 * 64]);
    let height =
        |more: &[&str], status| failed(at, &[&["height", "p", "-o", "x.exr"], more].concat(), status);
    assert!(height(&["--white-card", "card.png"], 1).contains("both must be alike"));
    assert!(height(&["--white-card", "black.png"], 1).contains("it must show the card everywhere"));
    assert!(height(&["--ambient-frame", "card.png"], 1).contains("both must be alike"));
    assert!(height(&["--mask", "card.png"], 1).contains("expected the 64 x 64 of the photographs"));
    assert!(height(&["--mask", "black.png"], 1).contains("leaves no texel"));
    assert!(
        height(&["--grey", "60,0,30,30"], 1).contains("--grey: 30 x 30 pixels at (60, 0) do not lie inside")
    );
    let shading = ["--method", "shape-from-shading", "--surface-mm", "100", "--lamp-mm", "90"];
    assert!(height(&shading, 2).contains("--surface-mm has no part"));
    assert!(height(&["--surface-mm", "100"], 2).contains("--lamp-mm"));
    assert!(height(&["--crop", "60,0,30,30"], 1).contains("does not lie inside"));
    assert!(height(&["--reduce", "64", "--crop", "0,0,20,20"], 2).contains("nothing would be left"));
    let text =
        refused(at, &["height", "p/truth/normals.exr", "--method", "normal-map", "-o", "x.exr", "--align"]);
    assert!(text.contains("--align has no part"), "{text}");
    fs::create_dir(at.join("black")).unwrap();
    let list = "8\na 0 0 1\nb 1 0 1\nc -1 0 1\nd 0 1 1\ne 0 -1 1\nf 1 1 1\ng -1 1 1\nh -1 -1 1";
    fs::write(at.join("black/l.lp"), list).unwrap();
    for name in ["a", "b", "c", "d", "e", "f", "g", "h"] {
        write_grey(&at.join("black").join(name), (8, 8), &[0; 64]);
    }
    let text = failed(at, &["fit", "black", "-o", "x.ptm", "--equalize"], 1);
    assert!(text.contains("too dark"), "{text}");
    for name in ["a", "b", "c", "d", "e", "f", "g", "h"] {
        write_grey(&at.join("black").join(name), (8, 8), &[255; 64]);
    }
    let white = json(at, &["fit", "black", "-o", "x.ptm"]);
    assert!(
        white["warnings"].to_string().contains("8 of 8 photographs are saturated"),
        "{}",
        white["warnings"]
    );
    write_grey(&at.join("black/c"), (8, 8), &[0; 64]);
    let learned = json(at, &["fit", "black", "-o", "l.exr", "--basis", "learned", "--rank", "1"]);
    assert!(
        learned["warnings"].to_string().contains("1 of 8 photographs are black"),
        "{}",
        learned["warnings"]
    );
    let still = json(at, &["fit", "black", "-o", "s.ptm", "--align"]);
    assert!(still["warnings"].to_string().contains("do not agree with the others"), "{}", still["warnings"]);
    fs::write(at.join("black/l.lp"), "2\na 0 0 1\nb 1 0 1").unwrap();
    let few = failed(at, &["height", "black", "-o", "x.exr"], 1);
    assert!(few.contains("at least 3 lights, found 2"), "{few}");
    let equalize = failed(at, &["height", "black", "-o", "x.exr", "--equalize"], 1);
    assert!(equalize.contains("at least 8 photographs, found 2"), "{equalize}");
}

#[test]
fn what_a_mask_leaves_out_is_black_in_the_texture() {
    let folder = matt_capture();
    let at = folder.path();
    let codes: Vec<u8> = (0..64 * 64).map(|i| if i % 64 < 32 { 255 } else { 0 }).collect();
    write_grey(&at.join("mask.png"), (64, 64), &codes);
    done(at, &["fit", "p", "-o", "t.ptm", "--mask", "mask.png"]);
    done(at, &["relight", "t.ptm", "--light", "0,0,1", "-o", "t.png"]);
    let lit = read_raster(&at.join("t.png"), &Job::default()).unwrap();
    let brightest = |columns: std::ops::Range<usize>| {
        columns.map(|x| lit.samples().value(3 * (64 * 30 + x))).fold(0.0, f32::max)
    };
    assert!(brightest(0..31) > 0.2 && brightest(33..64) < 0.05, "{} {}", brightest(0..31), brightest(33..64));
    let maps = ["-o", "h.exr", "--normals", "n.png", "--albedo-map", "a.png", "--mask", "mask.png"];
    done(at, &[&["height", "p"][..], &maps].concat());
    let texel = |file: &str, x: usize| {
        let raster = read_raster(&at.join(file), &Job::default()).unwrap();
        let channels = raster.channels();
        (0..channels).map(|c| raster.samples().value(channels * (64 * 30 + x) + c)).collect::<Vec<f32>>()
    };
    assert!(texel("a.png", 50).iter().all(|v| *v == 0.0) && texel("a.png", 10).iter().all(|v| *v > 0.1));
    let level = texel("n.png", 50);
    assert!(level[2] == 1.0 && level[..2].iter().all(|v| (v - 0.5).abs() < 0.01), "{level:?}");
}

#[test]
fn near_lamps_are_taken_from_positions_or_a_distance() {
    let folder = matt_capture();
    let at = folder.path();
    let far = angle(at, &[]);
    // Lamps ten metres away are as good as infinitely far.
    let near = angle(at, &["--surface-mm", "100", "--lamp-mm", "10000"]);
    assert!((near - far).abs() < 0.3, "{far} {near}");
    let wrong = angle(at, &["--surface-mm", "100", "--lamp-mm", "60"]);
    assert!(wrong > far + 2.0, "{far} {wrong}");
    let report = json(at, &["height", "p", "-o", "n.exr", "--surface-mm", "128", "--lamp-mm", "5000"]);
    assert_eq!(report["pixel_mm"], 2.0);
}

/// A fault: photographs were deleted with the folder that the result replaced, and overwritten by maps.
#[test]
fn no_output_takes_the_place_of_a_photograph() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    done(at, &["capture", "sponge", "-o", "p", "--size", "48", "--lights", "12"]);
    let input = |arguments: &[&str]| {
        let text = failed(at, &[arguments, &["--force"]].concat(), 2);
        assert!(text.contains("an input of this command"), "{text}");
    };
    input(&["new", "p/lights.lp", "-o", "p"]);
    input(&["new", "p", "-o", "p"]);
    input(&["height", "p", "-o", "p/light_000.png"]);
    input(&["height", "p", "-o", "h.png", "--normals", "p/light_001.png"]);
    input(&[
        "height",
        "p",
        "-o",
        "h.png",
        "--truth-normals",
        "p/truth/normals.exr",
        "--normals",
        "p/truth/normals.exr",
    ]);
    done(at, &["capture", "sponge", "-o", "t", "--size", "48", "--lights", "6", "--format", "exr"]);
    done(at, &["fit", "t", "-o", "f.ptm"]);
    let photograph = fs::read_dir(at.join("t")).unwrap().flatten().map(|entry| entry.path());
    let photograph = photograph.filter(|path| path.extension().is_some_and(|e| e == "exr")).min().unwrap();
    input(&["fit", "p", "-o", photograph.to_str().unwrap(), "--test", "t"]);
    assert_eq!(
        fs::read_dir(at.join("p"))
            .unwrap()
            .flatten()
            .filter(|e| e.path().extension().is_some_and(|e| e == "png"))
            .count(),
        12
    );
}

/// Faults: masks and counts did not agree, and development hid saturated photographs.
#[test]
fn counts_are_those_of_the_surface_and_saturation_is_said_after_development() {
    let folder = matt_capture();
    let at = folder.path();
    let codes: Vec<u8> = (0..64 * 64).map(|i| if i % 64 < 20 { 255 } else { 0 }).collect();
    write_grey(&at.join("mask.png"), (64, 64), &codes);
    let maps = ["height", "p", "-o", "h.exr", "--roughness-map", "r.png", "--mask", "mask.png"];
    let facts = json(at, &maps)["facts"].clone();
    assert!(facts["texels_without_highlight"].as_u64().unwrap() <= 20 * 64, "{facts}");
    assert_eq!(facts["undetermined_texels"], 0);
    let strengths = "1.03\n".repeat(24);
    fs::write(at.join("strength.txt"), strengths).unwrap();
    change(&at.join("p"), &|i, picture| {
        if i == 4 {
            picture.planes.as_mut_slice().fill(1.0);
        }
    });
    write_grey(&at.join("room.png"), (64, 64), &[250; 64 * 64]);
    let lit = json(at, &["fit", "p", "-o", "u.ptm", "--ambient-frame", "room.png"]);
    assert!(lit["warnings"].to_string().contains("was it made without the lamp"), "{}", lit["warnings"]);
    let fit = json(at, &["fit", "p", "-o", "t.ptm", "--intensities", "strength.txt"]);
    assert!(fit["warnings"].to_string().contains("1 of 24 photographs are saturated"), "{}", fit["warnings"]);
}
