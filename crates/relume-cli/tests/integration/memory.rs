//! `--memory` is a budget of the whole job: the peak stays within it, and a job that cannot is refused
//! before it works.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use relume::field::{Basis, PlaneLayout};
use relume::format::{FieldFormat, encode_field};
use relume::numeric::random::{Purpose, Stream};
use relume::{Job, Planes, ReflectanceField, Size, Space};

use crate::support::high_water_mark_kib;

/// Resident memory that is no data of the job: the program itself and the stacks of its threads.
const PROGRAM_MIB: f64 = 32.0;
/// Processor seconds within which a job is refused that does not fit.
const REFUSED_WITHIN_S: f64 = 1.0;

/// What a run took.
struct Taken {
    status: Option<i32>,
    message: String,
    peak_mib: f64,
    processor_s: f64,
}

/// Runs the program and watches its memory and time.
fn watched(folder: &Path, arguments: &[&str]) -> Taken {
    let mut program = Command::new(env!("CARGO_BIN_EXE_relume"))
        .current_dir(folder)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut peak_mib, mut processor_s) = (0.0f64, 0.0f64);
    loop {
        let ended = program.try_wait().unwrap().is_some();
        peak_mib = peak_mib.max(high_water_mark_kib(program.id()).map_or(0.0, |kib| kib as f64 / 1024.0));
        processor_s = processor_s.max(processor_seconds(program.id()).unwrap_or(0.0));
        if ended {
            break;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    let output = program.wait_with_output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    Taken { status: output.status.code(), message, peak_mib, processor_s }
}

/// User and system time, in ticks of a hundredth of a second.
fn processor_seconds(process: u32) -> Option<f64> {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    Some((fields[11].parse::<f64>().ok()? + fields[12].parse::<f64>().ok()?) / 100.0)
}

/// A texture of functions as a `.ptm`.
fn write_functions(path: &Path, size: Size) {
    let mut stream = Stream::new(3, Purpose::Sample, [0]);
    let data = (0..9 * size.texels()).map(|_| stream.unit() as f32).collect();
    let planes = Planes::from_vec(size, 9, data).unwrap();
    let field = ReflectanceField::new(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb, planes).unwrap();
    fs::write(path, encode_field(&field, FieldFormat::Ptm, None, &Job::default()).unwrap()).unwrap();
}

/// Runs a command at several budgets: each run is within its own, or refused at once.
fn kept_or_refused(folder: &Path, arguments: &[&str], budgets_mib: &[u32]) {
    let before = fs::read_dir(folder).unwrap().count();
    for &budget in budgets_mib {
        let gib = (f64::from(budget) / 1024.0).to_string();
        let taken = watched(folder, &[arguments, &["--force", "--memory", &gib]].concat());
        let what = format!("{arguments:?} at {budget} MiB: {}", taken.message);
        match taken.status {
            Some(0) => {
                let allowed = f64::from(budget) + PROGRAM_MIB;
                assert!(taken.peak_mib <= allowed, "{what}: {:.1} MiB used", taken.peak_mib);
            }
            Some(1) => {
                assert!(taken.message.contains("of memory and the limit is"), "{what}");
                assert!(taken.processor_s <= REFUSED_WITHIN_S, "{what}: after {:.2} s", taken.processor_s);
                assert_eq!(fs::read_dir(folder).unwrap().count(), before, "{what} left something behind");
            }
            status => panic!("{what}: {status:?}"),
        }
        fs::read_dir(folder).unwrap().flatten().for_each(|entry| {
            if entry.file_name().to_string_lossy().starts_with("out") {
                fs::remove_file(entry.path()).unwrap();
            }
        });
    }
}

/// Seen: 0.3 GiB allowed, 695 MB used, and refused after 9 seconds of work.
#[test]
fn a_synthesis_that_cannot_be_written_is_refused_before_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    write_functions(&folder.path().join("functions.ptm"), Size::new(128, 128));
    let synth = ["synth", "functions.ptm", "-o", "out.ptm", "--size", "768"];
    kept_or_refused(folder.path(), &synth, &[8, 24, 40, 56, 68, 80, 96, 128]);
}

/// Seen: 0.25 GiB allowed, 420 MB used.
#[test]
fn a_texture_made_tileable_stays_within_the_memory_allowed() {
    let folder = tempfile::tempdir().unwrap();
    write_functions(&folder.path().join("functions.ptm"), Size::new(160, 160));
    let close = ["tileable", "functions.ptm", "-o", "out.ptm", "--band", "4"];
    kept_or_refused(folder.path(), &close, &[1, 3, 6, 12, 24]);
}
