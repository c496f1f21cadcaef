//! `relume fit` as a user runs it.

use std::fs;

use crate::support::{done, failed, json, write_grey};

/// Polar angle in units of a right angle and azimuth in turns of each light.
const LIGHTS: [(f64, f64); 12] = [
    (0.0, 0.0),
    (0.3, 0.0),
    (0.35, 0.3),
    (0.3, 0.6),
    (0.6, 0.1),
    (0.7, 0.4),
    (0.6, 0.55),
    (0.75, 0.8),
    (0.6, 0.95),
    (0.5, 0.8),
    (0.15, 0.5),
    (0.85, 0.3),
];

/// A folder with `count` grey photographs of 7 x 5 texels and `lights.lp`.
fn capture(count: usize) -> tempfile::TempDir {
    captured_under(&LIGHTS[..count])
}

/// As [`capture`], under any number of lights all over the hemisphere.
fn dome(count: usize) -> tempfile::TempDir {
    let light = |i: usize| {
        let height = (i as f64 + 0.5) / count as f64;
        (height.acos() / std::f64::consts::FRAC_PI_2, 0.381_966 * i as f64)
    };
    captured_under(&(0..count).map(light).collect::<Vec<_>>())
}

fn captured_under(lights: &[(f64, f64)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut list = format!("{}\n", lights.len());
    for (i, (polar, turns)) in lights.iter().enumerate() {
        let (sin, z) = (polar * std::f64::consts::FRAC_PI_2).sin_cos();
        let (y, x) = (turns * std::f64::consts::TAU).sin_cos();
        list += &format!("p{i}.png {:.4} {:.4} {z:.4}\n", x * sin, y * sin);
        let codes: Vec<u8> = (0..35).map(|t| (z * f64::from(100 + 4 * t)) as u8).collect();
        write_grey(&folder.path().join(format!("p{i}.png")), (7, 5), &codes);
    }
    fs::write(folder.path().join("lights.lp"), list).unwrap();
    folder
}

#[test]
fn a_folder_becomes_a_texture_and_a_report() {
    let folder = capture(9);
    for name in ["a.ptm", "a.exr"] {
        let result = json(folder.path(), &["fit", ".", "-o", name, "--leave-one-out"]);
        let space = if name == "a.ptm" { "srgb" } else { "linear" };
        assert_eq!(result["report"]["space"], space);
        assert_eq!(result["report"]["lights"].as_array().unwrap().len(), 9);
        assert!(result["report"]["error"]["psnr_db"].as_f64().unwrap() > 30.0);
        assert!(folder.path().join(name).is_file());
    }
}

#[test]
fn harmonics_are_fitted_shown_relit_rendered_and_synthesised() {
    let folder = capture(12);
    let path = folder.path();
    let result = json(path, &["fit", ".", "-o", "h.exr", "--basis", "hsh9"]);
    assert_eq!(result["basis"], "hsh9");
    let info = json(path, &["info", "h.exr"]);
    assert_eq!((&info["basis"], &info["planes"][0]["name"]), (&"hsh9".into(), &"L.h0".into()));
    done(path, &["relight", "h.exr", "--light", "0.3,0.2,0.9", "-o", "relit.png"]);
    done(path, &["render", "h.exr", "--size", "16", "-o", "rendered.png"]);
    done(path, &["synth", "h.exr", "--size", "12", "--block", "4", "--overlap", "1", "-o", "s.exr"]);
    assert_eq!(json(path, &["info", "s.exr"])["basis"], "hsh9");
    // Nine functions are not a polynomial, and the square has corners that are not directions.
    let ptm = failed(path, &["fit", ".", "-o", "h.ptm", "--basis", "hsh9"], 2);
    assert!(ptm.contains("not hsh9"), "{ptm}");
    let square = failed(path, &["synth", "h.exr", "--size", "12", "--domain", "square", "-o", "t.exr"], 2);
    assert!(square.contains("cannot be compared over the square"), "{square}");
}

#[test]
fn every_basis_with_a_name_is_fitted_shown_and_relit() {
    let folder = dome(40);
    let path = folder.path();
    for (basis, functions) in [
        ("linear", 3),
        ("ptm", 6),
        ("cubic", 10),
        ("quartic", 15),
        ("hsh4", 4),
        ("hsh16", 16),
        ("hsh25", 25),
        ("sh4", 4),
        ("sh9", 9),
        ("sh16", 16),
        ("sh25", 25),
        ("zernike", 21),
    ] {
        let result = json(path, &["fit", ".", "-o", "b.exr", "--basis", basis, "--force"]);
        assert_eq!(result["basis"], basis);
        // The photographs are proportional to the height of the light, which is no first-order polynomial of u and v.
        let psnr_db = result["report"]["error"]["psnr_db"].as_f64().unwrap();
        assert!(psnr_db > if basis == "linear" { 15.0 } else { 25.0 }, "{basis}: {psnr_db}");
        let info = json(path, &["info", "b.exr"]);
        assert_eq!(info["planes"].as_array().unwrap().len(), functions, "{basis}");
        done(path, &["relight", "b.exr", "--light", "0.3,0.2,0.9", "-o", "relit.png", "--force"]);
    }
    let few = failed(capture(9).path(), &["fit", ".", "-o", "b.exr", "--basis", "hsh16"], 1);
    assert!(few.contains("its 16 functions need at least as many lights, found 9"), "{few}");
}

#[test]
fn photographs_themselves_are_interpolated_and_tested_under_other_lights() {
    let (folder, other) = (dome(30), dome(17));
    let path = folder.path();
    let list = other.path().join("lights.lp");
    for (basis, least_db) in [("rbf", 40.0), ("tabulated", 25.0), ("shapes", 25.0)] {
        let command = ["fit", ".", "-o", "b.exr", "--basis", basis, "--test", list.to_str().unwrap()];
        let result = json(path, &[&command[..], &["--leave-one-out", "--force"]].concat());
        assert_eq!((&result["basis"], &result["color"]), (&basis.into(), &"luminance".into()));
        let figure = |name: &str| result[name].as_f64().unwrap();
        assert!(figure("test_psnr_db") > least_db, "{result}");
        assert_eq!(result["test"]["lights"].as_array().unwrap().len(), 17);
        let left_out = result["report"]["leave_one_out"]["psnr_db"].as_f64().unwrap();
        assert!(left_out > 15.0, "{left_out}");
        let is_warned = |result: &serde_json::Value| {
            result["warnings"].to_string().contains("themselves are the coefficients")
        };
        assert!(!is_warned(&result), "each was predicted from the others");
        assert!(is_warned(&json(path, &[&command[..6], &["--force"]].concat())));
        done(path, &["relight", "b.exr", "--light", "0.3,0.2,0.9", "-o", "relit.png", "--force"]);
        done(
            path,
            &["synth", "b.exr", "--size", "12", "--block", "4", "--overlap", "1", "-o", "s.exr", "--force"],
        );
        assert_eq!(json(path, &["info", "s.exr"])["basis"], basis);
    }
}

/// The page is one file: nothing of it is fetched.
#[test]
fn the_report_is_one_page_and_the_same_as_json() {
    let folder = dome(20);
    let path = folder.path();
    // One photograph of another exposure.
    write_grey(&path.join("p4.png"), (7, 5), &[9; 35]);
    let result = json(path, &["fit", ".", "-o", "a.ptm", "--report", "report.html"]);
    let quality = &result["quality"];
    assert_eq!(quality["lights"].as_array().unwrap().len(), 20);
    assert!(quality["coverage"]["widest_gap_deg"].as_f64().unwrap() < 40.0);
    assert!(result["report"]["leave_one_out"]["psnr_db"].as_f64().is_some());
    let page = fs::read_to_string(path.join("report.html")).unwrap();
    assert!(
        !page.contains("{{") && !page.contains("http"),
        "no mark of the template is left, nothing is fetched"
    );
    assert!(page.contains("data:image/png;base64,") && page.contains("<svg") && page.contains("p19.png"));
    let (_, rest) = page.split_once("<script type=\"application/json\" id=\"report\">").unwrap();
    let embedded: serde_json::Value = serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap();
    assert_eq!(&embedded["quality"], quality);
    let refused = failed(path, &["fit", ".", "-o", "b.ptm", "--report", "p1.png", "--force"], 2);
    assert!(refused.contains("p1.png"), "{refused}");
}

#[test]
fn bytes_are_the_same_at_any_number_of_threads_and_on_standard_output() {
    let folder = capture(9);
    for threads in ["1", "4"] {
        let name = format!("{threads}.ptm");
        done(folder.path(), &["fit", ".", "-o", &name, "--threads", threads]);
    }
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("1.ptm"), read("4.ptm"));
    assert_eq!(done(folder.path(), &["fit", ".", "-o", "-"]).stdout, read("1.ptm"));
}

#[test]
fn what_cannot_be_done_is_said_in_one_sentence() {
    let folder = capture(9);
    let path = folder.path();
    assert!(failed(path, &["fit", ".", "-o", "p3.png"], 2).contains("exists already"));
    assert!(failed(path, &["fit", ".", "-o", "new.png"], 2).contains("name a .ptm or .exr"));
    assert!(failed(path, &["fit", ".", "-o", "a.ptm", "--half"], 2).contains("--half needs an .exr"));
    assert!(
        failed(path, &["fit", ".", "-o", "a.ptm", "--crop", "4,0,4,4"], 1)
            .contains("does not lie inside 7 x 5")
    );
    assert!(failed(path, &["fit", ".", "-o", "a.ptm", "--crop", "4,0"], 2).contains("four whole numbers"));
    let heavy = failed(path, &["fit", ".", "-o", "a.ptm", "--ridge", "1e300"], 2);
    assert!(heavy.contains("a weight above 0 and up to 1000000"), "{heavy}");
    assert!(failed(path, &["fit", ".", "-o", "a.ptm", "--lamp-mm", "90"], 2).contains("--surface-mm"));
    assert!(failed(path, &["fit", "nothing", "-o", "a.ptm"], 1).contains("nothing: cannot read"));
    write_grey(&path.join("p5.png"), (5, 7), &[9; 35]);
    let text = failed(path, &["fit", ".", "-o", "a.ptm"], 1);
    assert!(text.contains("p5.png is 5 x 7 texels and p0.png is 7 x 5"), "{text}");
    fs::write(path.join("p5.png"), b"\x89PNG\r\n\x1a\nbroken").unwrap();
    assert!(failed(path, &["fit", ".", "-o", "a.ptm"], 1).contains("p5.png"));
    fs::remove_file(path.join("p5.png")).unwrap();
    assert!(
        failed(path, &["fit", ".", "-o", "a.ptm"], 1).contains("line 7: the photograph p5.png is missing")
    );
    let few = capture(5);
    let text = failed(few.path(), &["fit", ".", "-o", "a.ptm"], 1);
    assert!(text.contains("6 functions need at least as many lights, found 5"), "{text}");
}

#[test]
fn photographs_are_never_overwritten() {
    let folder = capture(9);
    let path = folder.path();
    // Files are recognised by content, so a photograph may have the name of an output.
    fs::rename(path.join("p3.png"), path.join("p3.exr")).unwrap();
    let list = fs::read_to_string(path.join("lights.lp")).unwrap().replace("p3.png", "p3.exr");
    fs::write(path.join("lights.lp"), list).unwrap();
    let before = fs::read(path.join("p3.exr")).unwrap();
    assert!(failed(path, &["fit", ".", "-o", "p3.exr", "--force"], 2).contains("is an input"));
    assert!(failed(path, &["fit", "lights.lp", "-o", "lights.lp", "--force"], 2).contains("is an input"));
    assert_eq!(fs::read(path.join("p3.exr")).unwrap(), before);
}
