//! Faults once found by trying to break the program, each with a test named after it.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use relume::format::{ExrDepth, PictureFormat, encode_picture};
use relume::procedural::Material;
use relume::{Picture, Planes, Size, Space};
use serde_json::Value;

use crate::support::{done, failed, json, names, refused, relume, run, write_grey, write_material};

/// A folder with a picture of 32 x 32 texels.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("a.png"), Material::Pebbles, Size::new(32, 32), 8.0);
    folder
}

/// Writes grey floats.
fn write_floats(path: &Path, format: PictureFormat, size: Size, value: impl Fn(usize) -> f32) {
    let planes = Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap();
    fs::write(path, encode_picture(&Picture { planes, space: Space::Linear }, format).unwrap()).unwrap();
}

fn warned(report: &Value, words: &str) -> bool {
    report["warnings"].as_array().unwrap().iter().any(|warning| warning.as_str().unwrap().contains(words))
}

#[test]
fn a_light_file_of_no_lights_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::create_dir(at.join("x")).unwrap();
    fs::write(at.join("x/a.lp"), "0\n").unwrap();
    for pictures in [false, true] {
        if pictures {
            write_grey(&at.join("x/a.png"), (4, 4), &[9; 16]);
        }
        for arguments in [
            &["fit", "x", "-o", "q.exr"][..],
            &["fit", "x", "-o", "q.exr", "--pair", "order"],
            &["height", "x", "-o", "q.exr"],
            &["height", "x", "-o", "q.exr", "--method", "shape-from-shading"],
        ] {
            let text = failed(at, arguments, 1);
            assert!(text.contains("a.lp: line 1 promises 0 lights"), "{text}");
        }
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_error_changes_no_exit_status() {
    let folder = folder();
    let status = |script: &str| {
        let script = script.replace("relume", env!("CARGO_BIN_EXE_relume"));
        let mut shell = Command::new("sh");
        shell.args(["-c", &script]).current_dir(folder.path()).stdout(Stdio::null());
        shell.status().unwrap().code()
    };
    assert_eq!(status("relume info nofile 2>/dev/full"), Some(1));
    assert_eq!(status("relume info nofile 2>&-"), Some(1));
    assert_eq!(status("relume info --nonsense 2>/dev/full"), Some(2));
    assert_eq!(status("relume info a.png --threads 0 2>/dev/full"), Some(2));
    assert_eq!(status("relume relight a.png --light 0,0,1 -o - 2>/dev/full"), Some(0));
    assert_eq!(status("relume --help >/dev/full"), Some(1));
    assert_eq!(status("relume --version >/dev/full"), Some(1));
}

#[test]
fn periods_of_any_number_are_refused_or_used_in_seconds() {
    let folder = folder();
    for period in ["1e-300,20", "1e300,1e-300", "1e300,1e300", "0.01,200", "200000,8"] {
        let started = Instant::now();
        let option = format!("--period={period}");
        let text = refused(folder.path(), &["roll", "a.png", "-o", "z.png", &option]);
        assert!(text.contains("--period") && text.contains("expected"), "{text}");
        assert!(started.elapsed() < Duration::from_secs(20), "{period}");
    }
}

#[test]
fn sizes_of_texels_that_make_unreadable_heights_are_refused() {
    let folder = folder();
    let at = folder.path();
    let method = ["height", "a.png", "--method", "shape-from-shading", "--light", "1,1,1", "--rounds", "2"];
    for mm in ["1e308", "1e38", "1e-300", "0", "-1", "nan"] {
        for output in ["i.exr", "i.png"] {
            let text = refused(at, &[&method[..], &["-o", output, "--pixel-mm", mm]].concat());
            assert!(text.contains("--pixel-mm") && text.contains("expected millimetres"), "{text}");
        }
    }
    done(at, &[&method[..], &["-o", "i.png", "--pixel-mm", "1e9"]].concat());
    assert!(run(at, &["info", "i.png"]).contains("32x32") || run(at, &["info", "i.png"]).contains("32 x 32"));
}

#[test]
fn values_that_integer_files_cannot_hold_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let size = Size::new(32, 32);
    let exr = PictureFormat::Exr(ExrDepth::Float);
    write_floats(&at.join("neg.exr"), exr, size, |i| -1.0 - (i % 7) as f32);
    write_floats(&at.join("hdr.pfm"), PictureFormat::Pfm, size, |i| 0.1 * (i % 70) as f32);
    write_floats(&at.join("fine.exr"), exr, size, |i| (i % 9) as f32 / 8.0);
    write_material(&at.join("a.png"), Material::Pebbles, size, 8.0);
    let words = "outside 0..1";
    for input in ["neg.exr", "hdr.pfm"] {
        for output in ["o.png", "o.jpg", "o.tif"] {
            let report = json(at, &["match", input, "--to", input, "-o", output, "--force"]);
            assert!(warned(&report, words), "match {input} {output}: {report}");
        }
        for command in [
            format!("relight {input} --light 0,0,1 -o o.png"),
            format!("tileable {input} -o o.png --band 3 --neighbourhood 5"),
            format!("synth {input} -o o.png --size 24 --block 8"),
            format!("synth a.png -o o.exr --size 24 --block 8 --follow {input} --apply-format png"),
        ] {
            let words_of = command.split(' ').chain(["--force"]).collect::<Vec<_>>();
            assert!(warned(&json(at, &words_of), words), "{command}");
        }
        let kept = json(at, &["relight", input, "--light", "0,0,1", "-o", "o.exr", "--force"]);
        assert!(!warned(&kept, words), "{kept}");
    }
    let fine = json(at, &["relight", "fine.exr", "--light", "0,0,1", "-o", "o.png", "--force"]);
    assert!(!warned(&fine, words), "{fine}");
}

#[test]
fn photographs_brighter_than_white_and_halves_that_overflow_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    done(at, &["capture", "sponge", "-o", "c", "--size", "16", "--lights", "8", "--format", "exr"]);
    let fine = json(at, &["fit", "c", "-o", "fine.exr", "--half"]);
    assert!(!warned(&fine, "brighter than white") && !warned(&fine, "16-bit floats"), "{fine}");
    for entry in fs::read_dir(at.join("c")).unwrap().flatten() {
        if entry.path().extension().is_some_and(|e| e == "exr") {
            write_floats(&entry.path(), PictureFormat::Exr(ExrDepth::Float), Size::new(16, 16), |i| {
                1e5 * (i % 11) as f32
            });
        }
    }
    fs::remove_file(at.join("c/relume-files.json")).unwrap();
    let bright = json(at, &["fit", "c", "-o", "bright.exr", "--half"]);
    assert!(warned(&bright, "brighter than white") && warned(&bright, "16-bit floats"), "{bright}");
    assert!(warned(&json(at, &["fit", "c", "-o", "bright.ptm"]), "brighter than white"));
}

#[cfg(unix)]
#[test]
fn a_replaced_folder_keeps_its_permissions_and_leaves_nothing_behind() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let set =
        |path: &str, mode: u32| fs::set_permissions(at.join(path), fs::Permissions::from_mode(mode)).unwrap();
    let mode = |path: &str| fs::metadata(at.join(path)).unwrap().permissions().mode() & 0o777;
    fs::create_dir_all(at.join("p/inner")).unwrap();
    fs::write(at.join("p/inner/f"), "mine").unwrap();
    set("p/inner", 0o555);
    set("p", 0o711);
    done(at, &["procedural", "wood", "-o", "p", "--size", "16", "--force"]);
    assert_eq!((mode("p"), mode("p/inner"), names(at)), (0o711, 0o555, vec!["p".to_owned()]));
    assert_eq!(fs::read(at.join("p/inner/f")).unwrap(), b"mine");
    done(at, &["procedural", "wood", "-o", "p", "--size", "16", "--force"]);
    assert_eq!((mode("p"), mode("p/inner"), names(at)), (0o711, 0o555, vec!["p".to_owned()]));
    fs::create_dir(at.join("q")).unwrap();
    set("q", 0o700);
    done(at, &["procedural", "wood", "-o", "q", "--size", "16"]);
    assert_eq!(mode("q"), 0o700);
    set("p/inner", 0o755);
}

#[test]
fn a_thousand_threads_take_no_longer_than_a_few() {
    let folder = folder();
    let started = Instant::now();
    done(folder.path(), &["info", "a.png", "--threads", "1024"]);
    assert!(started.elapsed() < Duration::from_secs(3), "{:?}", started.elapsed());
}

#[test]
fn what_cannot_be_done_is_refused_before_the_work() {
    let folder = folder();
    let at = folder.path();
    let text = refused(at, &["demo", "-o", "d", "--lights", "5"]);
    assert!(text.contains("--lights 5") && text.contains("6 functions") && !text.contains(".tmp"), "{text}");
    write_grey(&at.join("wrong.png"), (9, 9), &[9; 81]);
    done(at, &["capture", "sponge", "-o", "c", "--size", "32", "--lights", "6"]);
    let text = refused(at, &["height", "c", "-o", "h.exr", "--truth-height", "wrong.png"]);
    assert!(text.contains("wrong.png") && text.contains("same size"), "{text}");
    fs::write(at.join("garbage.png"), "garbage").unwrap();
    assert!(
        failed(at, &["height", "c", "-o", "h.exr", "--truth-height", "garbage.png"], 1)
            .contains("garbage.png")
    );
}

#[test]
fn a_picture_too_large_as_a_texture_is_refused_by_its_header() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // The samples alone would fit.
    write_grey(&at.join("bomb.png"), (12_000, 12_000), &vec![7; 144_000_000]);
    let started = Instant::now();
    let text = failed(at, &["info", "bomb.png", "--memory", "0.2"], 1);
    assert!(text.contains("the picture as a field") && text.contains("1.2"), "{text}");
    assert!(started.elapsed() < Duration::from_secs(5), "{:?}", started.elapsed());
}

#[cfg(target_os = "linux")]
#[test]
fn endless_input_of_an_unknown_kind_is_not_read_to_the_limit_of_the_memory() {
    let folder = tempfile::tempdir().unwrap();
    let script = format!("yes | '{}' info -", env!("CARGO_BIN_EXE_relume"));
    let started = Instant::now();
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.code() == Some(1) && text.contains("the file is none of"), "{text}");
    let text = failed(folder.path(), &["info", "/dev/zero"], 1);
    assert!(text.contains("the file is none of"), "{text}");
    assert!(started.elapsed() < Duration::from_secs(5));
}

#[test]
fn the_examples_of_the_help_of_synth_and_model_can_be_run() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let help = run(at, &["roll", "--help"]) + &run(at, &["model", "--help"]);
    assert!(!help.contains("-o cloth.png") && !help.contains("--size 4096 --window"), "{help}");
}

#[test]
fn a_refusal_for_memory_names_the_limit_that_suffices() {
    let folder = folder();
    let at = folder.path();
    let render = ["render", "a.png", "-o", "o.png", "--size", "900", "--memory"];
    let text = failed(at, &[&render[..], &["0.02"]].concat(), 1);
    let mut needed = text.split_once("needs ").unwrap().1.split_once(" GiB").unwrap().0.to_owned();
    // A later stage may need more, and says so too.
    for _ in 0..6 {
        let output = relume(at, &[&render[..], &[&needed]].concat());
        if output.status.success() {
            return;
        }
        let text = String::from_utf8(output.stderr).unwrap();
        let more = text.split_once("needs ").unwrap().1.split_once(" GiB").unwrap().0.to_owned();
        assert!(more.parse::<f64>().unwrap() > needed.parse::<f64>().unwrap(), "{text}");
        needed = more;
    }
    panic!("no figure sufficed");
}

#[test]
fn options_without_a_part_in_the_work_are_refused() {
    let folder = folder();
    let at = folder.path();
    done(at, &["capture", "sponge", "-o", "c", "--size", "24", "--lights", "8"]);
    done(at, &["fit", "c", "-o", "f.ptm"]);
    done(at, &["roll", "f.ptm", "-o", "t.ptm"]);
    for (command, words) in [
        ("height c -o h.exr --light 0,0,1", "--light"),
        ("height c -o h.exr --albedo 0.5", "--albedo"),
        ("height c -o h.exr --photograph 99", "--photograph"),
        ("height c -o h.exr --rounds 5", "--rounds"),
        ("height c -o h.exr --longest 5", "--longest"),
        ("height f.ptm -o h.exr --estimator robust", "--estimator"),
        ("height f.ptm -o h.exr --ambient", "--ambient"),
        ("height f.ptm -o h.exr --pair order", "--pair"),
        ("relight f.ptm --light 0,0,1 -o o.png --fps 5", "--fps"),
        ("relight f.ptm --sweep orbit:3 -o frames --fps 5", "--fps"),
        ("relight f.ptm --sweep orbit:3 -o o.jpg", "o.jpg"),
        ("synth t.ptm -o o.ptm --size 20 --method patchmatch", "--method"),
        ("synth t.ptm -o o.ptm --size 20 --metric luminance", "--metric"),
        ("synth t.ptm t.ptm -o o.ptm --size 20 --block 8", "set of tiles"),
        ("synth a.png -o o.png --size 20 --kernels dct --search fft", "kernels"),
        ("gallery . -o g --methods quilting,quilting", "--methods"),
        ("man -", "folder"),
        ("gallery a.png -o g", "folder"),
    ] {
        let text = refused(at, &command.split(' ').collect::<Vec<_>>());
        assert!(text.contains(words), "{command}: {text}");
    }
}

#[test]
fn advice_can_be_followed() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_grey(&at.join("thin.png"), (2, 64), &[9; 128]);
    write_grey(&at.join("one.png"), (1, 1), &[9]);
    fs::create_dir(at.join("empty")).unwrap();
    let says = |command: &str, words: &str| {
        let status = if command.starts_with("info") { 1 } else { 2 };
        let output = relume(at, &command.split(' ').collect::<Vec<_>>());
        let text = String::from_utf8(output.stderr).unwrap();
        assert!(
            text.contains(words) && matches!(output.status.code(), Some(1 | 2)),
            "{command} {status}: {text}"
        );
    };
    says("tileable thin.png -o o.png", "at least 3");
    says("synth one.png -o o.png --size 8 --block 4", "too small for any block");
    says(
        "synth thin.png -o o.png --size 8 --method efros-leung --neighbourhood 3",
        "too small for any window",
    );
    let text = String::from_utf8(relume(at, &["info", "empty"]).stderr).unwrap();
    assert!(text.contains("folder") && !text.contains("relume fit"), "{text}");
}

#[test]
fn messages_blame_the_option_that_is_wrong() {
    let folder = folder();
    let at = folder.path();
    for (command, words) in [
        ("render a.png -o o.png --fov -1", "--fov"),
        ("render a.png -o o.png --fov nan", "--fov"),
        ("capture sponge -o o --lamp-radius -1", "expected degrees from 0 to 45"),
        ("synth a.png -o o.png --size 8 --delta nan", "--delta"),
        ("synth a.png -o o.png --size 8 --delta -1", "--delta"),
        ("synth a.png -o o.png --size 8 --seed=-1", "expected a whole number"),
        ("synth a.png -o o.png --size 8 --block abc", "expected a whole number"),
        ("capture sponge -o o --lights -1", "from 1 to 10000"),
        ("render a.png -o o.png --height a.png --displace 1e9", "from 0 to 1000000"),
        ("capture --height a.png -o c", "--albedo"),
        ("capture -o c", "--albedo"),
    ] {
        let text = refused(at, &command.split(' ').collect::<Vec<_>>());
        assert!(text.contains(words) && !text.contains("invalid digit"), "{command}: {text}");
    }
    // Negative values are values.
    done(
        at,
        &[
            "capture",
            "--height",
            "a.png",
            "--albedo",
            "a.png",
            "-o",
            "c",
            "--lights",
            "2",
            "--height-scale",
            "-5",
        ],
    );
}

#[test]
fn a_built_in_material_that_hides_a_folder_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    done(at, &["procedural", "leather", "-o", "leather", "--size", "16"]);
    let capture =
        |from: &str, to: &str| json(at, &["capture", from, "-o", to, "--lights", "2", "--size", "16"]);
    assert!(warned(&capture("leather", "a"), "./leather"));
}

#[test]
fn pictures_that_are_no_normal_maps_are_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    done(at, &["procedural", "leather", "-o", "m", "--size", "32"]);
    let height = |from: &str| json(at, &["height", from, "--method", "normal-map", "-o", "h.exr", "--force"]);
    assert!(warned(&height("m/albedo.png"), "no normal map"));
    assert!(!warned(&height("m/normals_gl.png"), "no normal map"));
}

#[test]
fn control_characters_of_file_names_do_not_reach_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let text = failed(folder.path(), &["info", "\u{1b}[31mx\n"], 1);
    assert!(!text.contains('\u{1b}') && text.contains("\\u{1b}[31mx\\n"), "{text:?}");
}

#[test]
fn help_helps_with_itself() {
    let folder = tempfile::tempdir().unwrap();
    for typed in [["help", "--help"], ["help", "-h"], ["help", "help"]] {
        let text = run(folder.path(), &typed);
        assert!(text.contains("Usage: relume help [COMMAND]"), "{text}");
    }
}

#[test]
fn intensities_beyond_reason_are_refused_as_they_were_typed() {
    let folder = folder();
    for (option, value) in [("--light", "0,0,1@1e300"), ("--background", "0,-1,0"), ("--light", "0,0,1@-1")] {
        let text = refused(folder.path(), &["render", "a.png", "-o", "r.png", option, value]);
        assert!(text.contains(&format!("invalid value '{value}'")), "{text}");
        assert!(text.contains(" from 0 "), "{text}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn too_few_open_files_leave_no_temporary() {
    let folder = tempfile::tempdir().unwrap();
    for most in 4..9 {
        let script = format!(
            "ulimit -n {most}; exec {} capture sponge -o c{most} --size 16 --lights 4",
            env!("CARGO_BIN_EXE_relume")
        );
        let done = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
        let left = names(folder.path());
        let expected = format!("c{most}");
        assert!(left.iter().all(|name| !name.contains("tmp")), "{most}: {left:?}");
        assert_eq!(done.status.success(), left.contains(&expected), "{most}: {left:?}");
    }
}

#[test]
fn a_light_file_with_a_count_alone_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    for text in ["3\n", "3\n\n\n", "999999999999\n"] {
        fs::write(folder.path().join("p.lp"), text).unwrap();
        for verb in [&["fit", "p.lp", "-o", "x.ptm"][..], &["height", "p.lp", "-o", "h.exr"]] {
            let message = failed(folder.path(), verb, 1);
            assert!(message.contains("p.lp") && message.contains("line"), "{message}");
        }
    }
}

#[test]
fn textures_too_small_to_measure_are_made_by_auto() {
    let folder = folder();
    for size in ["1", "1x40", "6x60"] {
        done(
            folder.path(),
            &["synth", "a.png", "-o", "t.png", "--size", size, "--method", "auto", "--force"],
        );
    }
}
