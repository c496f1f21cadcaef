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

use crate::support::{done, high_water_mark_kib, run, write_grey};

/// Resident memory that is no data of the job: the program itself and the stacks of its threads.
const PROGRAM_MIB: f64 = 32.0;
/// The GNU allocator gives blocks of this size back to the system as soon as they are freed. By itself it raises
/// this to 32 MiB as such blocks come and go, and then keeps them: the program holds what it counts, and the
/// allocator up to twice that.
const FREED: &str = "MALLOC_MMAP_THRESHOLD_";
const FREED_FROM: &str = "131072";
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
        .env(FREED, FREED_FROM)
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

/// Every verb that works on data, with sizes at which it takes more than the program itself. Words that
/// begin with `out` are outputs.
const COMMANDS: &[&str] = &[
    "capture leather -o out --size 384 --lights 3",
    "capture maps -o out --lights 2 --format exr --no-bounce",
    "capture leather -o out.zip --size 320 --views 3",
    "fit photographs -o out.ptm",
    "fit photographs -o out.exr --color rgb",
    "procedural clouds -o out --size 768",
    "height photographs -o out.exr --normals out_n.png --albedo-map out_a.png",
    "height photographs -o out.exr --roughness-map out_r.png --specular-map out_s.exr",
    "height functions.ptm -o out.png --border periodic",
    "height maps/normals_gl.png --method normal-map -o out.exr",
    "height maps/albedo.png --method shape-from-shading --light 0.5,0.2,0.8 --rounds 3 -o out.exr",
    "relight functions.ptm --light 0,0,1 -o out.png",
    "relight functions.ptm --normals -o out.png",
    "relight functions.ptm --albedo -o out.exr",
    "relight functions.ptm --sweep orbit:6 -o out.png",
    "relight functions.ptm --sweep orbit:6 -o out.gif",
    "relight functions.ptm --sweep orbit:3 -o out",
    "render functions.ptm --mesh sphere --size 512 --samples 1 -o out.png",
    "render functions.ptm --mesh sphere --size 128 --samples 1 --turntable 3 -o out.gif",
    "relight functions.ptm --env maps/albedo.png -o out.hdr",
    "render functions.ptm --size 256 --samples 1 --env maps/albedo.png -o out.png",
    "render functions.ptm --size 64 --samples 1 --env maps/albedo.png --env-samples=8 -o out.png",
    "render functions.ptm --mesh plane --size 512 --samples 1 --height maps/height.png --bump 1x -o out.exr",
    "match functions.ptm --to functions.ptm -o out.ptm --ranks out.exr",
    "compare functions.ptm functions.ptm",
    "compare --texture small.ptm small.ptm --lights 2",
    "analyze functions.ptm -o out.png",
    "info functions.ptm",
    "info functions.exr",
    "model small.ptm -o out.rlm --levels 2 --combine never",
    "synth model.rlm -o out.exr --size 512",
    "synth tiles.exr -o out.ptm --size 1024",
    "synth small.ptm -o out.exr --size 768 --method noise",
    "synth small.ptm -o out.ptm --size 512 --block 64 --apply maps/crop.png --source-map out.npy",
    "synth small.ptm -o out.ptm --size 256 --method auto --tries 2",
    "roll regular.png -o out.exr --period 16,0,0,16",
    "fill small.ptm --mask hole.png -o out.ptm",
    "tileable small.ptm -o out.exr --band 3",
    "gallery folder -o out --methods quilting --size 128",
    "demo -o out --lights 8",
    "convert functions.ptm -o out.exr --basis hsh9",
    "convert small.ptm -o out.rti",
    "convert functions.ptm -o out.npz",
    "maps small.ptm -o out --preset gltf",
    "lights balls -o out.lp",
    "new photographs -o out",
    "share functions.exr -o out",
    "share functions.ptm -o out.html --single-file",
];

/// Verbs that work on no data, and the one that serves what `share` writes until it is interrupted.
const WITHOUT_DATA: [&str; 5] = ["completions", "formats", "man", "help", "view"];

/// The inputs of [`COMMANDS`].
fn write_inputs(folder: &Path) {
    write_functions(&folder.join("functions.ptm"), Size::new(640, 640));
    write_functions(&folder.join("small.ptm"), Size::new(192, 192));
    let hole: Vec<u8> = (0..192 * 192).map(|i| if i / 192 < 8 && i % 192 < 8 { 255 } else { 0 }).collect();
    write_grey(&folder.join("hole.png"), (192, 192), &hole);
    let regular: Vec<u8> = (0..512 * 512).map(|i| (i % 16 * 9 + i / 512 % 16 * 5) as u8).collect();
    write_grey(&folder.join("regular.png"), (512, 512), &regular);
    let commands: [&[&str]; 8] = [
        &["capture", "leather", "-o", "balls", "--size", "160", "--lights", "8", "--balls", "1"],
        &["capture", "sponge", "-o", "photographs", "--size", "512", "--lights", "12", "--no-bounce"],
        &["procedural", "leather", "-o", "maps", "--size", "512"],
        &["match", "functions.ptm", "--to", "functions.ptm", "-o", "functions.exr"],
        &["model", "small.ptm", "-o", "model.rlm", "--levels", "2", "--combine", "never"],
        &["procedural", "weave", "-o", "crops", "--size", "192"],
        &["capture", "weave", "-o", "weave", "--size", "128", "--lights", "9", "--no-bounce"],
        &["fit", "weave", "-o", "weave.ptm"],
    ];
    commands.iter().for_each(|words| drop(done(folder, words)));
    done(folder, &["roll", "weave.ptm", "-o", "tiles.exr"]);
    fs::copy(folder.join("crops/albedo.png"), folder.join("maps/crop.png")).unwrap();
    fs::create_dir(folder.join("folder")).unwrap();
    fs::copy(folder.join("crops/albedo.png"), folder.join("folder/a.png")).unwrap();
}

/// The verbs of the program, from its help.
fn verbs(folder: &Path) -> Vec<String> {
    let help = run(folder, &["--help"]);
    let listed = help.lines().skip_while(|line| *line != "Commands:").skip(1);
    let names = listed.take_while(|line| !line.trim().is_empty());
    // Continued descriptions are indented deeper.
    let names = names.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.filter_map(|line| line.split_whitespace().next().map(str::to_owned)).collect()
}

/// The limit that a refusal asks for, in MiB.
fn needed_mib(message: &str) -> Option<f64> {
    let (before, _) = message.split_once(" GiB of memory and the limit is ")?;
    Some(1024.0 * before.rsplit(' ').next()?.parse::<f64>().ok()?)
}

/// Removes all outputs.
fn clear(folder: &Path) {
    for entry in fs::read_dir(folder).unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with("out") {
            let path = entry.path();
            if path.is_dir() { fs::remove_dir_all(path).unwrap() } else { fs::remove_file(path).unwrap() }
        }
    }
}

/// Gives a command what its refusals ask for, until it is done. Returns the last budget in MiB.
fn granted(folder: &Path, command: &str) -> Result<(f64, Taken), String> {
    let words: Vec<&str> = command.split_whitespace().collect();
    let before = fs::read_dir(folder).unwrap().count();
    let mut budget_mib = 0.25;
    for _ in 0..MOST_REFUSALS {
        let gib = (budget_mib / 1024.0).to_string();
        let taken = watched(folder, &[&words[..], &["--threads", "2", "--memory", &gib]].concat());
        let what = format!("{command} with {budget_mib:.2} MiB: {}", taken.message.trim());
        match (taken.status, needed_mib(&taken.message)) {
            (Some(0), _) => return Ok((budget_mib, taken)),
            (Some(1), Some(needed)) => {
                if taken.processor_s > REFUSED_WITHIN_S {
                    return Err(format!("{what} after {:.2} s", taken.processor_s));
                }
                if fs::read_dir(folder).unwrap().count() != before {
                    return Err(format!("{what} left something behind"));
                }
                if needed <= budget_mib {
                    return Err(format!("{what} asked for no more"));
                }
                budget_mib = needed;
            }
            (status, _) => return Err(format!("{what}: exit status {status:?}")),
        }
    }
    Err(format!("{command} asked for more memory {MOST_REFUSALS} times"))
}

/// A verb may learn what it needs from several inputs, one after another.
const MOST_REFUSALS: usize = 12;

/// Any verb, given what it says it needs, keeps to it; given less, it refuses at once and leaves nothing.
#[test]
fn every_verb_keeps_to_the_memory_it_asks_for_or_refuses_before_it_works() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tested = |verb: &String| COMMANDS.iter().any(|command| command.split(' ').next() == Some(verb));
    let missing: Vec<String> = verbs(folder)
        .into_iter()
        .filter(|verb| !tested(verb) && !WITHOUT_DATA.contains(&verb.as_str()))
        .collect();
    assert!(missing.is_empty(), "add a command to the table for {missing:?}");
    write_inputs(folder);
    let mut faults = Vec::new();
    for command in COMMANDS {
        match granted(folder, command) {
            Ok((budget_mib, taken)) => {
                let line = format!("{command}: {budget_mib:.1} MiB allowed, {:.1} used", taken.peak_mib);
                eprintln!("{line}");
                if taken.peak_mib > budget_mib + PROGRAM_MIB {
                    faults.push(line);
                }
            }
            Err(fault) => faults.push(fault),
        }
        clear(folder);
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Limits of the address space, in KiB: the program and its threads barely start under the first.
const ADDRESS_SPACES_KIB: [u64; 8] = [40_000, 46_000, 54_000, 64_000, 80_000, 110_000, 160_000, 300_000];

/// What a command does under `ulimit -v`: an allocation that the system refuses would end it with a signal.
#[cfg(target_os = "linux")]
#[test]
fn under_any_limit_of_the_address_space_every_verb_gives_a_result_or_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_inputs(folder);
    // The others make whole textures, for which the budget test runs them.
    let slow = ["--method auto", "gallery", "demo", "synth small", "tileable", "model small"];
    let mut faults = Vec::new();
    for command in COMMANDS.iter().filter(|command| !slow.iter().any(|part| command.contains(part))) {
        let (mut enough, mut refused) = (None, 0);
        for kib in ADDRESS_SPACES_KIB {
            let script = format!("ulimit -v {kib} && exec '{}' {command}", env!("CARGO_BIN_EXE_relume"));
            let output = Command::new("sh").args(["-c", &script]).current_dir(folder).output().unwrap();
            let text = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            clear(folder);
            match output.status.code() {
                // Larger limits are none.
                Some(0) => {
                    enough = Some(kib);
                    break;
                }
                Some(1) if text.lines().count() == 1 && !text.contains("fault of relume") => refused += 1,
                status => faults.push(format!("{command} under {kib} KiB: {status:?} {text}")),
            }
        }
        eprintln!("{command}: {enough:?} KiB are enough, {refused} refused");
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
