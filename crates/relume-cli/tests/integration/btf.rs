//! Textures of light and view as a user meets them: folders and archives of photographs with angles in their names.

use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use serde_json::Value;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::support::{done, failed, json, read_png, refused};

pub const SIDE: u32 = 24;

/// Polar angle and azimuth in degrees.
const DIRECTIONS: [(u32, u32); 8] =
    [(0, 0), (30, 0), (30, 120), (30, 240), (60, 0), (60, 90), (60, 180), (60, 270)];

/// The photograph of a texel pattern that depends on light, view and channel.
pub fn photograph((tl, pl): (u32, u32), (tv, pv): (u32, u32)) -> Vec<u8> {
    let direction = |t: u32, p: u32| {
        let (t, p) = (f64::from(t).to_radians(), f64::from(p).to_radians());
        [t.sin() * p.cos(), t.sin() * p.sin(), t.cos()]
    };
    let (light, view) = (direction(tl, pl), direction(tv, pv));
    let half: f64 = light.iter().zip(view).map(|(a, b)| a * b).sum();
    let value = |i: u32| {
        let (texel, channel) = (i / 3, f64::from(i % 3));
        let (x, y) = (f64::from(texel % SIDE), f64::from(texel / SIDE));
        let bump =
            (x * 0.7).sin() * light[0] + (y * 0.9).cos() * light[1] + 0.4 * (x * 0.3 + y).sin() * view[0];
        120.0 + 60.0 * bump * (1.0 - 0.2 * channel) + 40.0 * half
    };
    (0..3 * SIDE * SIDE).map(|i| value(i).clamp(0.0, 255.0) as u8).collect()
}

pub fn png_of(side: u32, samples: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, side, side);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(samples).unwrap();
    bytes
}

/// Names and files.
pub type Files = Vec<(String, Vec<u8>)>;

/// The name and file of each photograph of the full grid.
pub fn photographs() -> Files {
    let mut all = Vec::new();
    for view in DIRECTIONS {
        for light in DIRECTIONS {
            let name = format!(
                "X/tv{:03}_pv{:03}/{:05} tl{:03} pl{:03} tv{:03} pv{:03}.png",
                view.0,
                view.1,
                all.len(),
                light.0,
                light.1,
                view.0,
                view.1
            );
            all.push((name, png_of(SIDE, &photograph(light, view))));
        }
    }
    all
}

pub fn write_folder(root: &Path, photographs: &[(String, Vec<u8>)]) {
    for (name, bytes) in photographs {
        let path = root.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }
}

pub fn write_zip(path: &Path, photographs: &[(String, Vec<u8>)]) {
    let mut zip = ZipWriter::new(File::create(path).unwrap());
    for (name, bytes) in photographs {
        zip.start_file(name.as_str(), SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
}

#[test]
fn a_folder_and_its_archive_give_the_same_texture() {
    let folder = tempfile::tempdir().unwrap();
    let (path, all) = (folder.path(), photographs());
    write_folder(&path.join("btf"), &all);
    write_zip(&path.join("btf.zip"), &all);
    for input in ["btf", "btf.zip"] {
        let info = json(path, &["info", input]);
        assert_eq!(
            (&info["photographs"], &info["light_count"], &info["view_count"]),
            (&64.into(), &8.into(), &8.into())
        );
        let output = format!("{input}.exr");
        let fit = json(path, &["fit", input, "-o", &output, "--rank", "6"]);
        assert_eq!((&fit["basis"], &fit["color"]), (&Value::from("learned"), &Value::from("shared")));
        assert!(fit["report"]["error"]["psnr_db"].as_f64().unwrap() > 45.0, "{fit}");
        let compared = json(path, &["compare", input, &output]);
        assert!(compared["psnr_db"].as_f64().unwrap() > 44.0, "{compared}");
        assert!(compared["mean"]["ssim"].as_f64().unwrap() > 0.98, "{compared}");
    }
    assert!(fs::read(path.join("btf.exr")).unwrap() == fs::read(path.join("btf.zip.exr")).unwrap());
}

#[test]
fn a_measured_pair_is_shown_as_its_photograph() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    done(path, &["fit", "btf", "-o", "b.exr", "--rank", "12"]);
    // tl030 pl120 seen from tv060 pv090.
    let (sin, cos) = (30f64.to_radians().sin(), 30f64.to_radians().cos());
    let light = format!("{},{},{cos}", sin * 120f64.to_radians().cos(), sin * 120f64.to_radians().sin());
    let view = format!("0,{},0.5", 60f64.to_radians().sin());
    done(path, &["relight", "b.exr", "--light", &light, "--view", &view, "-o", "p.png"]);
    let (_, shown) = read_png(&path.join("p.png"));
    let truth = photograph((30, 120), (60, 90));
    let worst = shown.iter().zip(&truth).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
    assert!(worst <= 3, "off by {worst}");
    // The photograph itself, without a fit; and a mean of photographs between them.
    done(path, &["relight", "btf", "--light", &light, "--view", &view, "-o", "q.png"]);
    assert_eq!(read_png(&path.join("q.png")).1, truth);
    done(path, &["relight", "btf", "--light", "0.3,0.1,0.8", "--view", "0.2,0.2,0.9", "-o", "m.png"]);
    assert!(refused(path, &["relight", "btf", "--normals", "-o", "n_gl.png"]).contains("relume fit"));
    let sweep = json(path, &["relight", "b.exr", "--view-sweep", "arc:3", "-o", "s.png"]);
    assert_eq!(sweep["views"].as_array().unwrap().len(), 3);
}

#[test]
fn every_verb_takes_a_factorised_texture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "b.exr", "--error", "0.02", "--half"]);
    done(path, &["synth", "b.exr", "-o", "large.exr", "--size", "40", "--source-map", "m.npy"]);
    done(path, &["render", "large.exr", "--size", "24", "--mesh", "sphere", "-o", "r.png"]);
    done(path, &["tileable", "b.exr", "-o", "t.exr"]);
    done(path, &["analyze", "b.exr"]);
    done(path, &["relight", "b.exr", "--normals", "-o", "n_gl.png"]);
    let compared = json(path, &["compare", "b.exr", "b.exr"]);
    assert!(compared["views"].as_array().unwrap().iter().any(|view| view[2] != 1.0), "{compared}");
    // The functions of light alone are fitted to the photographs seen from above.
    let light = json(path, &["fit", "b.zip", "-o", "l.ptm", "--basis", "ptm"]);
    assert_eq!(light["report"]["lights"].as_array().unwrap().len(), 8);
    let warnings = light["warnings"].as_array().unwrap();
    assert!(warnings.iter().any(|w| w.as_str().unwrap().contains("8 of 64 photographs")), "{light}");
}

#[test]
fn pairs_left_out_are_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    let fit = json(path, &["fit", "b.zip", "-o", "b.exr", "--rank", "6", "--hold-out", "4"]);
    assert_eq!(fit["report"]["held_out"]["pairs"], 64 - 36);
    assert_eq!(fit["report"]["fitted"]["pairs"], 36);
}

#[test]
fn a_grid_with_holes_is_refused_or_filled() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mut some = photographs();
    let lost = some.remove(19);
    write_folder(&path.join("btf"), &some);
    let text = failed(path, &["fit", "btf", "-o", "b.exr"], 1);
    assert!(
        text.contains("1 of the 64 photographs") && text.contains("tl30 pl240 tv30 pv120"),
        "{text} {}",
        lost.0
    );
    let filled = json(path, &["fit", "btf", "-o", "b.exr", "--missing", "fill", "--rank", "8"]);
    assert!(filled["warnings"][0].as_str().unwrap().contains("1 of the 64"), "{filled}");
    assert_eq!(json(path, &["info", "btf"])["missing"], 1);
}

#[test]
fn sets_that_are_no_texture_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let all = photographs();
    let with = |name: &str, change: &dyn Fn(&mut Files)| {
        let mut set = all.clone();
        change(&mut set);
        write_zip(&path.join(name), &set);
        failed(path, &["fit", name, "-o", "out.exr", "--missing", "fill"], 1)
    };
    let twice = with("twice.zip", &|set| {
        let (name, bytes) = set[5].clone();
        set.push((name.replace("X/", "Y/"), bytes));
    });
    assert!(twice.contains("same directions"), "{twice}");
    let below = with("below.zip", &|set| set[5].0 = "tl120 pl000 tv000 pv000.png".to_owned());
    assert!(below.contains("120 degrees"), "{below}");
    let sizes = with("sizes.zip", &|set| set[5].1 = png_of(8, &[7; 192]));
    assert!(sizes.contains("same size"), "{sizes}");
    let leaving = with("leaving.zip", &|set| set[5].0 = "../tl120 pl000 tv000 pv000.png".to_owned());
    assert!(leaving.contains("leads out of its folder"), "{leaving}");
    let of_drive = with("drive.zip", &|set| set[5].0 = "C:\\x\\tl20 pl000 tv000 pv000.png".to_owned());
    assert!(of_drive.contains("leads out of its folder"), "{of_drive}");
    let damaged = with("damaged.zip", &|set| set[5].1.truncate(60));
    assert!(damaged.contains("00005"), "{damaged}");
    let none = with("none.zip", &|set| set.iter_mut().for_each(|(name, _)| *name = name.replace("tl", "xl")));
    assert!(none.contains("expected names such as"), "{none}");
    write_zip(&path.join("cut.zip"), &all);
    let bytes = fs::read(path.join("cut.zip")).unwrap();
    fs::write(path.join("cut.zip"), &bytes[..bytes.len() / 2]).unwrap();
    let cut = failed(path, &["fit", "cut.zip", "-o", "out.exr"], 1);
    assert!(cut.contains("not a complete zip archive"), "{cut}");
}

#[test]
fn options_without_a_part_in_the_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    let refuse = |arguments: &[&str]| refused(path, &[&["fit", "b.zip", "-o", "o.exr"], arguments].concat());
    let rank = refuse(&["--rank", "0"]);
    assert!(rank.contains("1 to 256") && rank.contains("--rank"), "{rank}");
    let error = refuse(&["--error", "5"]);
    assert!(error.contains("between 0 and 1") && error.contains("--error"), "{error}");
    let pair = refuse(&["--pair", "order"]);
    assert!(pair.contains("--pair is of captures"), "{pair}");
    assert!(refuse(&["--rank", "193"]).contains("at most 192"));
    assert!(refuse(&["--basis", "ptm", "--rank", "3"]).contains("--basis learned"));
    assert!(refuse(&["--leave-one-out"]).contains("--hold-out"));
    assert!(refuse(&["--hold-out", "1"]).contains("2 or more"));
    assert!(refused(path, &["fit", "b.zip", "-o", "o.ptm"]).contains("name an .exr"));
    done(path, &["fit", "b.zip", "-o", "l.exr", "--basis", "ptm", "--crop", "0,0,8,8", "--missing", "fill"]);
    let view = refused(path, &["relight", "l.exr", "--light", "0,0,1", "--view", "1,0,1", "-o", "x.png"]);
    assert!(view.contains("a view makes no difference"), "{view}");
}

#[test]
fn a_btf_file_is_written_read_shown_and_fitted_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "b.btf", "--rank", "12"]);
    let info = json(path, &["info", "b.btf"]);
    assert_eq!((&info["photographs"], &info["light_count"]), (&64.into(), &8.into()));
    done(path, &["fit", "b.zip", "-o", "linear.exr", "--rank", "12", "--space", "linear"]);
    // The file holds the same texture, to the rounding of floats.
    let compared = json(path, &["compare", "b.btf", "linear.exr"]);
    assert!(compared["psnr_db"].as_f64().unwrap() > 90.0, "{compared}");
    done(path, &["fit", "b.btf", "-o", "again.exr", "--rank", "12", "--space", "linear"]);
    assert!(json(path, &["compare", "linear.exr", "again.exr"])["psnr_db"].as_f64().unwrap() > 60.0);
    done(path, &["relight", "b.btf", "--light", "0.3,0.1,0.8", "--view", "0.2,0.2,0.9", "-o", "m.png"]);
    assert!(
        refused(path, &["fit", "b.zip", "-o", "s.btf", "--space", "srgb"]).contains("proportional to light")
    );
    assert!(refused(path, &["fit", "b.zip", "-o", "p.btf", "--basis", "ptm"]).contains("--basis learned"));
    fs::write(path.join("cut.btf"), &fs::read(path.join("b.btf")).unwrap()[..500]).unwrap();
    assert!(failed(path, &["info", "cut.btf"], 1).contains("cut.btf"));
}

/// A measured reflectance is the texture of one texel.
#[test]
fn a_reflectance_is_a_texture_of_one_texel() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    // A matt grey in the layout of the UTIA database: planes of 288 x 288 numbers.
    let numbers = vec![0.25 / std::f64::consts::PI; 3 * 288 * 288];
    let bytes: Vec<u8> = numbers.iter().flat_map(|v| v.to_le_bytes()).collect();
    fs::write(path.join("matt.bin"), bytes).unwrap();
    let fit = json(path, &["fit", "matt.bin", "-o", "matt.exr", "--space", "linear"]);
    assert_eq!((&fit["width"], &fit["report"]["functions"]), (&1.into(), &1.into()));
    done(path, &["relight", "matt.exr", "--light", "0,0,1", "-o", "matt.png"]);
    // A quarter of the light, encoded.
    assert_eq!(read_png(&path.join("matt.png")).1, [137; 3]);
}

#[test]
fn all_photographs_are_rearranged_with_the_texture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_zip(&path.join("b.zip"), &photographs());
    done(path, &["fit", "b.zip", "-o", "b.exr", "--rank", "8"]);
    let synth =
        ["synth", "b.exr", "-o", "large.exr", "--size", "32", "--apply", "b.zip", "--source-map", "m.npy"];
    let outputs = json(path, &synth)["outputs"].clone();
    assert!(outputs.as_array().unwrap().contains(&"large_b.zip".into()), "{outputs}");
    let info = json(path, &["info", "large_b.zip"]);
    assert_eq!((&info["photographs"], &info["width"]), (&64.into(), &32.into()));
    // Each photograph is that of the map: the photograph of the exemplar, rearranged by itself.
    done(path, &["relight", "b.zip", "--light", "0,0,1", "-o", "one.png"]);
    done(path, &["synth", "b.exr", "-o", "l2.exr", "--size", "32", "--follow", "one.png"]);
    done(path, &["relight", "large_b.zip", "--light", "0,0,1", "-o", "all.png"]);
    assert_eq!(read_png(&path.join("all.png")).1, read_png(&path.join("l2_one.png")).1);
    done(path, &["tileable", "b.exr", "-o", "t.exr", "--follow", "b.zip"]);
    assert_eq!(json(path, &["info", "t_b.zip"])["photographs"], 64);
    write_zip(
        &path.join("small.zip"),
        &[photographs()[0].clone(), ("tl1 pl0 tv0 pv0.png".to_owned(), png_of(8, &[7; 192]))],
    );
    let several = refused(
        path,
        &["synth", "b.exr", "b.exr", "-o", "x.exr", "--size", "32", "--apply", "b.zip", "b.zip"],
    );
    assert!(several.contains("one exemplar"), "{several}");
}

/// Texels in clusters: smaller than the plain texture, and read by every verb.
#[test]
fn a_texture_in_clusters_is_relit_compared_rendered_and_synthesised() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    done(path, &["fit", "btf", "-o", "plain.exr", "--rank", "8", "--half"]);
    let clusters = ["--rank", "8", "--clusters", "6", "--cluster-axes", "3", "--half"];
    let fit = json(path, &[&["fit", "btf", "-o", "c.exr"][..], &clusters].concat());
    assert_eq!((&fit["clusters"]["clusters"], &fit["clusters"]["axes"]), (&6.into(), &3.into()));
    assert!(
        fs::metadata(path.join("c.exr")).unwrap().len() < fs::metadata(path.join("plain.exr")).unwrap().len()
    );
    let said = fit["report"]["error"]["psnr_db"].as_f64().unwrap();
    let measured = json(path, &["compare", "btf", "c.exr"])["psnr_db"].as_f64().unwrap();
    assert!(said > 38.0 && (measured - said).abs() < 1.5, "{said} dB, measured {measured} dB");
    let info = json(path, &["info", "c.exr"]);
    assert_eq!((&info["basis"], info["planes"].as_array().unwrap().len()), (&"learned".into(), 8));
    done(path, &["relight", "c.exr", "--light", "0.3,0.4,0.8", "--view", "0.5,0,0.8", "-o", "relit.png"]);
    done(path, &["render", "c.exr", "--mesh", "sphere", "--size", "40", "-o", "sphere.png"]);
    done(path, &["synth", "c.exr", "-o", "large.exr", "--size", "40", "--block", "8"]);
    assert_eq!(json(path, &["info", "large.exr"])["basis"], "learned");
}

/// Rounded numbers and functions: a smaller file, which every verb reads, whose texels are rearranged as they are.
#[test]
fn a_rounded_texture_is_small_and_stays_so_when_it_is_enlarged() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    done(path, &["fit", "btf", "-o", "plain.exr", "--rank", "8", "--half"]);
    let fit = json(path, &["fit", "btf", "-o", "r.exr", "--rank", "8", "--rounding", "0.008"]);
    assert_eq!(fit["rounding"], 0.008);
    let bytes = |name: &str| fs::metadata(path.join(name)).unwrap().len();
    assert!(bytes("r.exr") < bytes("plain.exr") * 2 / 3, "{} and {}", bytes("r.exr"), bytes("plain.exr"));
    let said = fit["report"]["error"]["psnr_db"].as_f64().unwrap();
    let measured = json(path, &["compare", "btf", "r.exr"])["psnr_db"].as_f64().unwrap();
    assert!(said > 38.0 && (measured - said).abs() < 1.5, "{said} dB, measured {measured} dB");
    done(path, &["relight", "r.exr", "--light", "0.3,0.4,0.8", "--view", "0.5,0,0.8", "-o", "relit.png"]);
    done(path, &["synth", "r.exr", "-o", "same.exr", "--size", "24", "--block", "8"]);
    assert!(bytes("same.exr") < bytes("plain.exr") * 2 / 3, "{}", bytes("same.exr"));
    let refusal = |more: &[&str]| refused(path, &[&["fit", "btf", "--rounding", "0.01"][..], more].concat());
    assert!(refusal(&["-o", "r.btf"]).contains("holds plain numbers"));
    assert!(refusal(&["-o", "r.ptm"]).contains("needs an .exr"));
    assert!(refusal(&["-o", "r.exr", "--basis", "ptm"]).contains("--rounding is of functions"));
}

#[test]
fn clusters_that_cannot_be_made_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    let refusal = |more: &[&str]| refused(path, &[&["fit", "btf"][..], more].concat());
    assert!(refusal(&["-o", "c.btf", "--clusters", "4"]).contains("holds no clusters"));
    assert!(refusal(&["-o", "c.exr", "--clusters", "4", "--error", "0.1"]).contains("give --rank"));
    assert!(refusal(&["-o", "c.exr", "--clusters", "999"]).contains("1 to 576 clusters"));
    let axes = ["-o", "c.exr", "--clusters", "4", "--rank", "6", "--cluster-axes", "6"];
    assert!(refusal(&axes).contains("fewer numbers than the 6"));
    assert!(
        refusal(&["-o", "c.ptm", "--basis", "ptm", "--clusters", "4"]).contains("--clusters is of functions")
    );
    assert!(refusal(&["-o", "c.exr", "--cluster-axes", "4"]).contains("--clusters"));
}

#[test]
fn a_model_of_light_and_view_is_made_from_photographs_and_shows_directions_never_measured() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    let options =
        ["--functions", "4", "--levels", "2", "--candidates", "8", "--coarse", "5", "--combine", "never"];
    let model =
        json(path, &[&["model", "btf", "-o", "b.rlm", "--function-bytes", "3000"][..], &options].concat());
    assert_eq!((&model["basis"], &model["source"]["photographs"]), (&"learned".into(), &64.into()));
    assert_eq!(model["source_bytes"], 64 * 3 * SIDE * SIDE);
    let bytes = fs::metadata(path.join("b.rlm")).unwrap().len();
    assert!(bytes > 1000 && bytes < 4000, "{bytes} bytes");
    done(path, &["relight", "b.rlm", "--light", "0.3,0.4,0.8", "--view", "0.5,0,0.8", "-o", "relit.png"]);
    done(path, &["synth", "b.rlm", "-o", "large.exr", "--size", "50"]);
    assert_eq!(json(path, &["info", "large.exr"])["basis"], "learned");
    let refusal = |more: &[&str]| refused(path, &[&["model", "btf", "-o", "r.rlm"][..], more].concat());
    assert!(refusal(&["--functions", "4", "--function-bytes", "50"]).contains("do not fit 50 bytes"));
    assert!(
        refusal(&["--functions", "4", "--fields", "per-light"])
            .contains("models per light are of functions of light")
    );
    fs::write(path.join("p.png"), png_of(SIDE, &photograph((30, 0), (0, 0)))).unwrap();
    let plain = refused(path, &["model", "p.png", "-o", "r.rlm", "--functions", "3"]);
    assert!(plain.contains("--functions is of learned functions"), "{plain}");
}

/// Decorrelated colours come back from a `.btf` near to the photographs, and better than as few common functions.
#[test]
fn decorrelated_colours_are_factored_into_a_btf_and_compared_with_the_photographs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_folder(&path.join("btf"), &photographs());
    let fit = json(path, &["fit", "btf", "-o", "d.btf", "--rank", "8", "--factors", "decorrelated"]);
    let functions = &fit["report"]["functions"];
    assert_eq!((&functions["luminance"], &functions["color"]), (&8.into(), &2.into()));
    done(path, &["fit", "btf", "-o", "f.btf", "--rank", "8"]);
    let db = |file: &str| json(path, &["compare", "btf", file])["psnr_db"].as_f64().unwrap();
    let (decorrelated, common) = (db("d.btf"), db("f.btf"));
    assert!(decorrelated > 34.0 && common > 34.0, "{decorrelated} and {common} dB");
    // Eight functions for each view hold eight lights of three channels well.
    done(path, &["fit", "btf", "-o", "v.btf", "--rank", "8", "--factors", "per-view"]);
    assert!(db("v.btf") > common + 3.0, "{} dB", db("v.btf"));
    // A set compared with itself.
    let own = json(path, &["compare", "btf", "btf"]);
    assert!(own["psnr_db"].is_null() && own["rmse"] == 0.0, "{own}");
    let refusal =
        |more: &[&str]| refused(path, &[&["fit", "btf", "--factors", "decorrelated"][..], more].concat());
    assert!(refusal(&["-o", "d.exr"]).contains("is of .btf files"));
    assert!(refusal(&["-o", "h.btf", "--hold-out", "5"]).contains("--hold-out has no meaning"));
}

#[test]
fn greys_have_no_colour_differences_to_factor() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let grey = |bytes: Vec<u8>| bytes.chunks(3).flat_map(|rgb| [rgb[1]; 3]).collect::<Vec<u8>>();
    let all: Files =
        photographs()
            .into_iter()
            .map(|(name, _)| name)
            .zip(DIRECTIONS.iter().flat_map(|view| {
                DIRECTIONS.iter().map(|light| png_of(SIDE, &grey(photograph(*light, *view))))
            }))
            .collect();
    write_folder(&path.join("grey"), &all);
    done(path, &["fit", "grey", "-o", "g.btf", "--rank", "8", "--factors", "decorrelated"]);
    assert!(json(path, &["compare", "grey", "g.btf"])["psnr_db"].as_f64().unwrap() > 34.0);
}
