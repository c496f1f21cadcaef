//! `relume relight` and `relume render` as a user runs them.

use std::fs;
use std::path::Path;

use relume::field::{Basis, PlaneLayout};
use relume::format::{decode_field, decode_raster};
use relume::{Direction, Job, Raster, ReflectanceField, Samples, Size};

use crate::support::{failed, refused, run};

const SIZE: Size = Size::new(24, 16);

/// A folder with `field.ptm`, whose texels are tilted in different directions: an LRGB map written byte by
/// byte, coefficients (code - bias) / 255 with biases in the middle, rows from the bottom.
fn folder_with_field() -> (tempfile::TempDir, ReflectanceField) {
    let mut bytes = b"PTM_1.2\nPTM_FORMAT_LRGB\n24\n16\n1 1 1 1 1 1\n128 128 128 128 128 0\n".to_vec();
    for i in 0..SIZE.texels() {
        let wave = (i % 7) as u8 * 16;
        bytes.extend([90, 95, 128, 80 + wave, 100 + wave / 2, 140]);
    }
    (0..SIZE.texels()).for_each(|_| bytes.extend([230, 160, 90]));
    let field = decode_field(&bytes, &Job::default()).unwrap().field;
    assert_eq!((field.basis(), field.layout(), field.size()), (&Basis::Ptm, &PlaneLayout::LRGB, SIZE));
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("field.ptm"), bytes).unwrap();
    (folder, field)
}

fn picture(folder: &Path, name: &str) -> Raster {
    decode_raster(&fs::read(folder.join(name)).unwrap(), &Job::default()).unwrap()
}

fn codes(raster: &Raster) -> &[u8] {
    match raster.samples() {
        Samples::U8(codes) => codes,
        _ => panic!("expected 8 bits"),
    }
}

#[test]
fn a_relit_picture_holds_the_values_of_the_field() {
    let (folder, field) = folder_with_field();
    run(folder.path(), &["relight", "field.ptm", "--light", "-0.6,0,0.8", "-o", "lit.png"]);
    let raster = picture(folder.path(), "lit.png");
    assert_eq!((raster.size(), raster.channels()), (SIZE, 3));
    let light = Direction::new(-0.6, 0.0, 0.8).unwrap();
    for (i, code) in codes(&raster).iter().enumerate() {
        let value = field.value(i / 3 % SIZE.width, i / 3 / SIZE.width, light)[i % 3];
        let exact = field.space().to_srgb(value.clamp(0.0, 1.0)) * 255.0;
        assert!((exact - f32::from(*code)).abs() < 0.51, "sample {i}: {code} instead of {exact}");
    }
}

#[test]
fn sweeps_become_folders_or_animations() {
    let (folder, _) = folder_with_field();
    run(folder.path(), &["relight", "field.ptm", "--sweep", "orbit:4", "-o", "frames"]);
    let frames: Vec<Raster> = (0..4).map(|i| picture(folder.path(), &format!("frames/{i:04}.png"))).collect();
    assert!(frames.iter().all(|frame| frame.size() == SIZE) && frames[0] != frames[2]);
    let json = run(folder.path(), &["relight", "field.ptm", "--sweep", "arc:3", "-o", "arc.png", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["lights"][1], serde_json::json!([0.0, 0.0, 1.0]));
    let bytes = fs::read(folder.path().join("arc.png")).unwrap();
    assert!(bytes.windows(4).any(|w| w == b"acTL"), "an animated PNG");
    run(folder.path(), &["relight", "field.ptm", "--sweep", "arc:3", "-o", "arc.gif"]);
    assert!(fs::read(folder.path().join("arc.gif")).unwrap().starts_with(b"GIF89a"));
}

#[test]
fn normals_are_data_and_say_which_way_y_points() {
    let (folder, field) = folder_with_field();
    let text = run(folder.path(), &["relight", "field.ptm", "--normals", "-o", "normals.png"]);
    assert!(text.contains("+Y"), "{text}");
    let raster = picture(folder.path(), "normals.png");
    let Samples::U16(codes) = raster.samples() else { panic!("expected 16 bits") };
    let normals = relume::surface::normals(&field);
    for (i, &code) in codes.iter().enumerate() {
        let found = f32::from(code) / 65535.0 * 2.0 - 1.0;
        assert!((found - normals.plane(i % 3)[i / 3]).abs() < 4e-5);
    }
}

#[test]
fn a_render_is_the_same_at_any_thread_count_and_options_matter() {
    let (folder, _) = folder_with_field();
    let render = |out: &str, more: &[&str]| {
        let base = ["render", "field.ptm", "--size", "60x40", "--light", "-1,0.5,0.5", "-o", out];
        run(folder.path(), &[&base[..], more].concat());
        fs::read(folder.path().join(out)).unwrap()
    };
    let one = render("a.png", &["--threads", "1"]);
    assert_eq!(one, render("b.png", &["--threads", "3"]));
    assert_ne!(one, render("c.png", &["--plain"]));
    let torus = render("d.png", &["--mesh", "torus"]);
    assert_ne!(torus, render("e.png", &["--mesh", "torus", "--no-cast-shadows"]));
    assert_ne!(torus, render("f.png", &["--mesh", "torus", "--camera", "-20,10"]));
    // Lit from the left: the left of the sphere is bright, its right dark.
    let raster = picture(folder.path(), "a.png");
    assert_eq!(raster.size(), Size::new(60, 40));
    let at = |x: usize| codes(&raster)[(20 * 60 + x) * 3];
    assert!(at(20) > 40 && at(46) == 0, "{} {}", at(20), at(46));
}

#[test]
fn meshes_come_from_files() {
    let (folder, _) = folder_with_field();
    let square =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    fs::write(folder.path().join("square.obj"), square).unwrap();
    let render = |mesh: &str, out: &str| {
        // Of 24 x 16 texels: the plane is a square.
        let tiling = ["--tiling", "2,3"];
        let render = ["render", "field.ptm", "--mesh", mesh, "--size", "50", "-o", out];
        run(folder.path(), &[&render[..], &tiling].concat());
        fs::read(folder.path().join(out)).unwrap()
    };
    assert_eq!(render("square.obj", "a.png"), render("plane", "b.png"));
    fs::write(folder.path().join("bad.obj"), square.replace("4/4", "7/4")).unwrap();
    let message = failed(folder.path(), &["render", "field.ptm", "--mesh", "bad.obj", "-o", "c.png"], 1);
    assert!(message.contains("bad.obj: line 9: a face refers to vertex 7"), "{message}");
    let message = failed(folder.path(), &["render", "field.ptm", "--mesh", "no.obj", "-o", "c.png"], 1);
    assert!(message.contains("no.obj"), "{message}");
}

#[test]
fn displacement_changes_the_outline_and_bump_only_the_shading() {
    let (folder, _) = folder_with_field();
    let maps = ["procedural", "pebbles", "-o", "maps", "--tile", "--size", "48x32", "--feature", "14"];
    run(folder.path(), &maps);
    let render = |out: &str, more: &[&str]| {
        let base =
            ["render", "maps/albedo.png", "--plain", "--size", "120", "--light", "-1,0.6,0.5", "-o", out];
        let base = [&base[..], &["--background", "0,0,1", "--tiling", "4,3"], more].concat();
        run(folder.path(), &base);
        codes(&picture(folder.path(), out)).to_vec()
    };
    let smooth = render("a.png", &[]);
    let bump = render("b.png", &["--height", "maps/height.png", "--bump", "1x"]);
    let moved = render("c.png", &["--height", "maps/height.png", "--displace", "1x", "--threads", "1"]);
    let again = render("d.png", &["--height", "maps/height.png", "--displace", "1x", "--threads", "3"]);
    assert_eq!(moved, again);
    // Pure background pixels show no object.
    let outside = |codes: &[u8]| codes.chunks(3).map(|c| c == [0, 0, 255]).collect::<Vec<_>>();
    let differing = |a: &[bool], b: &[bool]| a.iter().zip(b).filter(|(a, b)| a != b).count();
    assert_eq!(differing(&outside(&smooth), &outside(&bump)), 0);
    assert!(smooth != bump && differing(&outside(&smooth), &outside(&moved)) > 40);
    let flat = render("e.png", &["--height", "maps/height.png", "--displace", "0", "--bump", "0x"]);
    assert_eq!(flat, smooth);
    for (amount, more) in [("2mm", &["--pixel-mm", "0.5"][..]), ("4", &[])] {
        let args = [&["--height", "maps/height.png", "--displace", amount], more].concat();
        assert_eq!(
            render("f.png", &args),
            render("g.png", &["--height", "maps/height.png", "--displace", "4texels"])
        );
        fs::remove_file(folder.path().join("f.png")).unwrap();
        fs::remove_file(folder.path().join("g.png")).unwrap();
    }
}

#[test]
fn an_environment_lights_objects_and_the_flat_texture() {
    let (folder, _) = folder_with_field();
    let at = folder.path();
    let render = |out: &str, more: &[&str]| {
        let base = ["render", "field.ptm", "--size", "40", "--env", "sky", "-o", out];
        let report = crate::support::json(at, &[&base[..], more].concat());
        (codes(&picture(at, out)).to_vec(), report)
    };
    let (fast, report) = render("a.png", &["--threads", "1"]);
    assert_eq!(report["environment"]["method"], "prefiltered");
    assert_eq!(report["environment"]["map"], "sky");
    assert_eq!(report["lights"], serde_json::json!([]));
    assert_eq!(fast, render("b.png", &["--threads", "3"]).0);
    let (drawn, report) = render("c.png", &["--env-samples=512", "--env-seed", "3"]);
    assert_eq!(report["environment"]["samples"], 512);
    assert_eq!(report["environment"]["seed"], 3);
    let error: f64 = fast.iter().zip(&drawn).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
    assert!((error / fast.len() as f64).sqrt() < 4.0, "{error}");
    assert_ne!(drawn, render("d.png", &["--env-samples=512", "--env-seed", "4"]).0);
    assert_ne!(fast, render("e.png", &["--env-rotate", "-90"]).0);
    assert_ne!(fast, render("f.png", &["--light", "1,0,0"]).0);
    // The sun is to the upper left.
    let at_texel = |x: usize, y: usize| u32::from(fast[3 * (40 * y + x)]);
    assert!(at_texel(12, 12) > at_texel(28, 28) + 30, "{} {}", at_texel(12, 12), at_texel(28, 28));
    run(at, &["relight", "field.ptm", "--env", "sky", "-o", "flat.hdr"]);
    // A constant map as a file of each kind that holds light.
    crate::support::write_grey(&at.join("grey.png"), (8, 4), &[255; 32]);
    for name in ["grey.hdr", "grey.exr", "grey.pfm"] {
        run(at, &["relight", "grey.png", "--light", "0,0,1", "-o", name]);
        let out = format!("under_{name}.png");
        run(at, &["relight", "grey.png", "--env", name, "--env-strength", "0.25", "-o", &out]);
        // A texture of constants is as bright as all light above it: twice the radiance.
        assert!(codes(&picture(at, &out)).iter().all(|&code| (186..=190).contains(&code)), "{name}");
    }
}

#[test]
fn maps_that_are_no_environment_are_named() {
    let (folder, _) = folder_with_field();
    let at = folder.path();
    crate::support::write_grey(&at.join("black.png"), (8, 4), &[0; 32]);
    crate::support::write_grey(&at.join("square.png"), (8, 8), &[90; 64]);
    let under = |map: &'static str| ["render", "field.ptm", "--size", "20", "--env", map, "-o", "o.png"];
    assert!(failed(at, &under("black.png"), 1).contains("black.png: the environment map is black"));
    assert!(failed(at, &under("field.ptm"), 1).contains("field.ptm"));
    assert!(failed(at, &under("none.hdr"), 1).contains("none.hdr"));
    let text = run(at, &under("square.png"));
    assert!(text.contains("twice as wide as high") && text.contains("square.png"), "{text}");
}

#[test]
fn wrong_usage_has_status_2() {
    let (folder, _) = folder_with_field();
    for args in [
        &["relight", "field.ptm", "-o", "x.png"][..],
        &["relight", "field.ptm", "--normals", "--albedo", "-o", "x.png"],
        &["relight", "field.ptm", "--light", "0,0,-1", "-o", "x.png"],
        &["relight", "field.ptm", "--sweep", "spiral:3", "-o", "x.png"],
        &["relight", "field.ptm", "--light", "0,0,1", "-o", "field.ptm/x.png"],
        &["render", "field.ptm", "--light", "0,0,0", "-o", "x.png"],
        &["render", "field.ptm", "--samples", "0", "-o", "x.png"],
        &["render", "field.ptm", "--camera", "0,95", "-o", "x.png"],
        &["render", "field.ptm", "--tiling", "nan", "-o", "x.png"],
        &["render", "field.ptm", "-o", "x.tga"],
        &["render", "field.ptm", "--env-rotate", "3", "-o", "x.png"],
        &["render", "field.ptm", "--env", "sky", "--env-seed", "3", "-o", "x.png"],
        &["render", "field.ptm", "--env", "sky", "--env-samples=0", "-o", "x.png"],
        &["render", "field.ptm", "--env", "sky", "--env-strength", "-1", "-o", "x.png"],
        &["relight", "field.ptm", "--env", "sky", "--light", "0,0,1", "-o", "x.png"],
        &["render", "field.ptm", "--displace", "3", "-o", "x.png"],
        &["render", "field.ptm", "--height", "field.ptm", "-o", "x.png"],
        &["render", "field.ptm", "--height", "field.ptm", "--bump", "-3", "-o", "x.png"],
    ] {
        refused(folder.path(), args);
    }
}

#[test]
fn normals_of_few_lights_are_doubted_and_better_ones_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    run(at, &["capture", "sponge", "-o", "sponge", "--lights", "8", "--size", "32"]);
    run(at, &["fit", "sponge", "-o", "sponge.exr"]);
    let text = run(at, &["relight", "sponge.exr", "--normals", "-o", "n.png"]);
    assert!(text.contains("not to be trusted") && text.contains("8 lights"), "{text}");
    assert!(text.contains("relume height"), "{text}");
}

#[test]
fn a_plane_keeps_the_proportions_of_its_texture_and_a_displaced_object_stays_in_the_frame() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    crate::support::write_grey(&at.join("wide.png"), (64, 16), &[200; 1024]);
    let lit = |name: &str| {
        let raster = decode_raster(&fs::read(at.join(name)).unwrap(), &Job::default()).unwrap();
        let size = raster.size();
        let bright = |x: usize, y: usize| raster.samples().value(3 * size.index(x, y)) > 0.0;
        let columns = (0..size.width).filter(|&x| (0..size.height).any(|y| bright(x, y))).collect::<Vec<_>>();
        let rows = (0..size.height).filter(|&y| (0..size.width).any(|x| bright(x, y))).collect::<Vec<_>>();
        (columns, rows)
    };
    let render = ["render", "wide.png", "--light", "0,0,1", "--samples", "1", "--force"];
    run(at, &[&render[..], &["--mesh", "plane", "-o", "plane.png", "--size", "200"]].concat());
    let (columns, rows) = lit("plane.png");
    assert!((columns.len() as f64 / rows.len() as f64 - 4.0).abs() < 0.3, "{} {}", columns.len(), rows.len());
    // Heights of half the width of the object's texture.
    let codes: Vec<u8> = (0..1024).map(|i| if i % 64 < 32 { 0 } else { 255 }).collect();
    crate::support::write_grey(&at.join("h.png"), (64, 16), &codes);
    let relief = ["--height", "h.png", "--displace", "40", "--mesh", "sphere", "--tiling", "1"];
    run(at, &[&render[..], &relief, &["-o", "sphere.png", "--size", "120"]].concat());
    let (columns, rows) = lit("sphere.png");
    assert!(columns[0] > 0 && *columns.last().unwrap() < 119 && rows[0] > 0 && *rows.last().unwrap() < 119);
}

#[test]
fn a_height_map_of_other_proportions_is_refused_and_one_of_another_size_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    crate::support::write_grey(&at.join("t.png"), (32, 32), &[200; 1024]);
    crate::support::write_grey(&at.join("wide.png"), (64, 16), &[9; 1024]);
    crate::support::write_grey(&at.join("half.png"), (16, 16), &[9; 256]);
    let render = |height: &'static str| {
        ["render", "t.png", "-o", "o.png", "--size", "40", "--height", height, "--displace", "3", "--force"]
    };
    let text = failed(at, &render("wide.png"), 2);
    assert!(text.contains("64 x 16") && text.contains("proportions"), "{text}");
    assert!(run(at, &render("half.png")).contains("stretched over the texture"));
    assert!(!run(at, &render("t.png")).contains("stretched"));
}
