//! Turntables and sweeps: as folders, animations, and films made by another program.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use relume::format::decode_raster;
use relume::procedural::Material;
use relume::{Job, Raster, Size};

use crate::support::{json, names, refused, run, write_material};

fn frames(folder: &Path) -> Vec<Raster> {
    let decoded =
        |name: &String| decode_raster(&fs::read(folder.join(name)).unwrap(), &Job::default()).unwrap();
    names(folder).iter().filter(|name| name.ends_with(".png")).map(decoded).collect()
}

fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_material(&folder.path().join("a.png"), Material::Marble, Size::new(24, 24), 9.0);
    folder
}

/// Three repetitions around the sphere: quarter turns differ.
const SMALL: [&str; 8] = ["render", "a.png", "--size", "17x12", "--samples", "1", "--tiling", "3,2"];

fn render<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&SMALL[..], more].concat()
}

#[test]
fn a_turntable_shows_what_a_camera_going_round_sees_under_lights_that_stay_with_it() {
    let folder = place();
    let at = folder.path();
    let report = json(at, &render(&["--turntable", "4", "--light", "-1,0.2,0.5", "-o", "turn"]));
    assert_eq!(report["frames"], 4);
    let turned = frames(&at.join("turn"));
    assert_eq!(turned.len(), 4);
    fs::create_dir(at.join("still")).unwrap();
    for azimuth in ["0", "90", "180", "270"] {
        let name = format!("still/{azimuth:0>4}.png");
        run(at, &render(&["--camera", &format!("{azimuth},0"), "--light", "-1,0.2,0.5", "-o", &name]));
    }
    assert_eq!(turned, frames(&at.join("still")));
    assert!(turned[0] != turned[1]);
}

#[test]
fn a_sweep_of_an_object_moves_its_light() {
    let folder = place();
    let at = folder.path();
    run(at, &render(&["--sweep", "arc:3", "-o", "arc"]));
    run(at, &render(&["--light", "0,0,1", "-o", "middle.png"]));
    let middle = decode_raster(&fs::read(at.join("arc/0001.png")).unwrap(), &Job::default()).unwrap();
    assert_eq!(middle, decode_raster(&fs::read(at.join("middle.png")).unwrap(), &Job::default()).unwrap());
    for (name, start) in [("arc.gif", &b"GIF89a"[..]), ("arc.png", b"\x89PNG")] {
        run(at, &render(&["--sweep", "arc:3", "--fps", "5", "-o", name]));
        assert!(fs::read(at.join(name)).unwrap().starts_with(start));
    }
}

#[test]
fn options_of_films_without_a_meaning_are_refused() {
    let folder = place();
    let at = folder.path();
    for (more, said) in [
        (&["--fps", "5", "-o", "x.png"][..], "--turntable"),
        (&["--turntable", "3", "--fps", "5", "-o", "x"], "folder"),
        (&["--turntable", "3", "-o", "x.jpg"], ".gif"),
        (&["--turntable", "0", "-o", "x.gif"], "--turntable"),
        (&["--turntable", "3", "--sweep", "arc:3", "-o", "x.gif"], "--sweep"),
    ] {
        let text = refused(at, &render(more));
        assert!(text.contains(said), "{more:?}: {text}");
    }
}

#[cfg(unix)]
mod by_ffmpeg {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    /// The program with a search path of its own.
    fn with_path(at: &Path, path: &Path, more: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_relume"));
        command.current_dir(at).args(render(more)).env("PATH", path).output().unwrap()
    }

    /// A stand-in for ffmpeg that keeps what it is told: its arguments, and the frames, as the film.
    fn stand_in(at: &Path, ending: &str) {
        let path = at.join("ffmpeg");
        let script = format!(
            "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nprintf '%s\\n' \"$@\" > '{}'\nfor last; do :; done\n/bin/cat > \"$last\"\n\
             exit {ending}\n",
            at.join("arguments").display()
        );
        fs::write(&path, script).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }

    #[test]
    fn ffmpeg_gets_every_frame_as_red_green_and_blue() {
        let (folder, tools) = (place(), tempfile::tempdir().unwrap());
        stand_in(tools.path(), "0");
        let output =
            with_path(folder.path(), tools.path(), &["--turntable", "3", "--fps", "24", "-o", "x.mp4"]);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let film = fs::read(folder.path().join("x.mp4")).unwrap();
        assert_eq!(film.len(), 3 * 17 * 12 * 3);
        run(folder.path(), &render(&["--turntable", "3", "-o", "frames"]));
        for (frame, codes) in frames(&folder.path().join("frames")).iter().zip(film.chunks_exact(17 * 12 * 3))
        {
            let relume::Samples::U8(expected) = frame.samples() else { panic!("8 bits") };
            assert_eq!(expected, codes);
        }
        let arguments = fs::read_to_string(tools.path().join("arguments")).unwrap();
        for word in ["17x12", "24", "rgb24", "libx264", "yuv420p"] {
            assert!(arguments.lines().any(|line| line == word), "{word} in {arguments}");
        }
    }

    #[test]
    fn without_ffmpeg_or_when_it_fails_one_sentence_is_said_and_nothing_stays() {
        let (folder, tools) = (place(), tempfile::tempdir().unwrap());
        for (ending, said) in [(None, "install it"), (Some("7"), "made no film")] {
            if let Some(ending) = ending {
                stand_in(tools.path(), ending);
            }
            let output = with_path(folder.path(), tools.path(), &["--turntable", "3", "-o", "x.mp4"]);
            let text = String::from_utf8(output.stderr).unwrap();
            assert_eq!(output.status.code(), Some(1), "{text}");
            assert!(text.contains(said) && text.contains("x.mp4") && text.lines().count() == 1, "{text}");
            assert_eq!(names(folder.path()), ["a.png"]);
        }
    }
}

#[test]
fn a_name_that_cannot_be_written_is_refused_before_anything_is_rendered() {
    let folder = place();
    fs::write(folder.path().join("x.gif"), b"kept").unwrap();
    refused(folder.path(), &render(&["--turntable", "5000", "-o", "x.gif"]));
    assert_eq!(fs::read(folder.path().join("x.gif")).unwrap(), b"kept");
}
