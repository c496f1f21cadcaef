//! Options at their extremes: every number that an option accepts is obeyed or refused with a message, within
//! seconds and within the allowed memory.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use relume::Size;
use relume::numeric::random::{Purpose, Stream};
use relume::procedural::Material;

use crate::support::{done, high_water_mark_kib, refused, relume, run, write_grey, write_material};

/// The number of random command lines; `RELUME_EXTREMES` sets another number, and thereby other lines.
const RUNS: u64 = 250;
/// The longest run of these tiny inputs on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);
/// The allowed memory in GiB, and the same in KiB.
const MEMORY: (&str, u64) = ("0.5", 512 << 10);

const NUMBERS: [&str; 26] = [
    "0",
    "1",
    "-1",
    "2",
    "3",
    "7",
    "0.5",
    "-0.0",
    "",
    "many",
    "NaN",
    "inf",
    "-inf",
    "1e11",
    "1e-300",
    "1e300",
    "20001",
    "65536",
    "131073",
    "1000001",
    "4294967296",
    "-9223372036854775808",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "18446744073709551616",
];

/// Sizes that are tiny, or larger than anything that can be made.
const SIZES: [&str; 9] = [
    "0",
    "1",
    "-1",
    "5",
    "3x1",
    "131073",
    "4294967296x1",
    "1x18446744073709551615",
    "9223372036854775808x9223372036854775808",
];

/// The commands, on the inputs of [`inputs`].
const BASES: [&str; 28] = [
    "synth a.png -o o.png --size 40",
    "synth f.ptm -o o.ptm --size 30 --method efros-leung --neighbourhood 5",
    "synth a.png -o o.png --size 40 --method wei-levoy --levels 2",
    "synth a.png -o o.png --size 40 --method patchmatch --levels 2",
    "synth w.png -o o.png --size 40 --method roller",
    "synth a.png -o o.png --size 30 --method auto --tries 1",
    "synth a.png -o o.exr --size 20 --method noise",
    "synth m.rlm -o o.png --size 20",
    "synth m.rlm -o o.exr",
    "synth t.png -o o.png",
    "capture leather -o oc --size 16 --lights 4",
    "procedural marble -o op --size 16",
    "procedural wood -o op --size 16",
    "procedural fire -o op --size 16",
    "fill a.png --mask holes.png -o o.png",
    "tileable a.png -o o.png",
    "fit cap -o o.ptm",
    "analyze m.rlm -o o.png",
    "compare a.png a.png --texture",
    "compare m.rlm a.png --texture",
    "height cap -o o.exr",
    "height a.png -o o.exr --method shape-from-shading --light 0.3,0.2,0.8",
    "model a.png -o o.rlm",
    "relight f.ptm -o o.gif --sweep orbit:3",
    "render f.ptm -o o.png --size 40",
    "render a.png -o o.png --size 20 --env sky --env-samples=4 --samples 1",
    "render a.png -o o.png --size 40 --height maps/height.png --displace 1x",
    "roll w.png -o o.png",
];

/// Tiny inputs of every kind.
fn inputs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let small = |words: &str| {
        done(path, &words.split(' ').collect::<Vec<_>>());
    };
    write_material(&path.join("a.png"), Material::Leather, Size::new(48, 48), 8.0);
    write_material(&path.join("w.png"), Material::Weave, Size::new(64, 64), 16.0);
    let hole = |i: usize| (20..26).contains(&(i % 48)) && (20..26).contains(&(i / 48));
    let codes: Vec<u8> = (0..48 * 48).map(|i| if hole(i) { 255 } else { 0 }).collect();
    write_grey(&path.join("holes.png"), (48, 48), &codes);
    small("capture leather -o cap --size 24 --lights 8 --feature 8");
    small("fit cap -o f.ptm");
    small("procedural leather -o maps --size 48 --feature 8");
    small("model a.png -o m.rlm");
    small("roll w.png -o t.png");
    folder
}

/// An option that takes a value: its name, what the help calls the value, and the values if it lists them.
struct Valued {
    name: String,
    value: String,
    listed: Vec<String>,
}

/// The options of a verb that take numbers or names, from its help.
fn options(folder: &Path, verb: &str) -> Vec<Valued> {
    let help = run(folder, &[verb, "--help"]);
    let mut entries: Vec<String> = Vec::new();
    for line in help.lines().map(str::trim) {
        if line.starts_with('-') {
            entries.push(line.to_owned());
        } else if let Some(entry) = entries.last_mut().filter(|_| !line.is_empty()) {
            *entry = format!("{entry} {line}");
        }
    }
    let common = ["--threads", "--memory"];
    let files = ["FILE", "DIR", "IMAGE", "MASK", "MESH", "OUT", "NAME"];
    let parsed = entries.iter().filter_map(|entry| valued(entry));
    let kept: Vec<_> = parsed
        .filter(|option| !common.contains(&option.name.as_str()))
        .filter(|option| !files.iter().any(|file| option.value.starts_with(file)))
        .collect();
    assert!(verb == "analyze" || kept.len() > 1, "{verb}: the help was not understood");
    kept
}

fn valued(entry: &str) -> Option<Valued> {
    let name = entry.split([' ', '=', '[', ',']).find(|word| word.starts_with("--"))?;
    let value = entry.split_once(name)?.1.trim_start_matches([' ', '[', '=']);
    let value = value.strip_prefix('<')?.split_once('>')?.0;
    let listed = entry.split_once("[possible values: ").and_then(|(_, rest)| rest.split_once(']'));
    let listed = listed.map_or("", |(names, _)| names).split(", ").filter(|name| !name.is_empty());
    Some(Valued {
        name: name.to_owned(),
        value: value.to_owned(),
        listed: listed.map(str::to_owned).collect(),
    })
}

/// A value, mostly an extreme one, in the form that an option expects.
fn extreme(option: &Valued, stream: &mut Stream) -> String {
    if !option.listed.is_empty() {
        return option.listed[stream.below(option.listed.len())].clone();
    }
    let mut pick = |from: &[&'static str]| from[stream.below(from.len())];
    match option.value.as_str() {
        "WxH" => pick(&SIZES).to_owned(),
        "PATH:N" => format!("{}{}", pick(&["orbit:", "arc:"]), pick(&NUMBERS)),
        "AMOUNT" => format!("{}{}", pick(&NUMBERS), pick(&["", "x", "mm"])),
        value if value.contains(',') => {
            let part = |_| {
                let number = pick(&NUMBERS);
                pick(&[number, "4", "4"])
            };
            (0..=value.matches(',').count()).map(part).collect::<Vec<_>>().join(",")
        }
        _ => pick(&NUMBERS).to_owned(),
    }
}

/// The fault of a run, if any.
fn fault(folder: &Path, arguments: &[String]) -> Option<String> {
    let mut child = Command::new(env!("CARGO_BIN_EXE_relume"))
        .current_dir(folder)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    let mut peak = 0;
    let code = loop {
        if let Some(ended) = child.try_wait().unwrap() {
            break ended.code();
        }
        peak = high_water_mark_kib(child.id()).unwrap_or(0).max(peak);
        if begun.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            return Some(format!("does not end within {PATIENCE:?}"));
        }
        sleep(Duration::from_millis(2));
    };
    let mut text = String::new();
    child.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    let sentences = if text.contains("try '--help'") { 1 } else { text.lines().count() };
    let words = ["panicked", "overflow", "a fault of relume"];
    let fault = match code {
        Some(0) if text.is_empty() => None,
        Some(1 | 2) if sentences == 1 && !words.iter().any(|word| text.contains(word)) => None,
        _ => Some(format!("ends with {code:?}: {text}")),
    };
    let greedy = (peak > MEMORY.1).then(|| format!("takes {} MiB", peak >> 10));
    fault.or(greedy)
}

#[test]
fn extremes_of_every_option_give_a_result_or_a_sentence_in_time_and_memory() {
    let folder = inputs();
    let path = folder.path();
    let runs = std::env::var("RELUME_EXTREMES").ok().and_then(|n| n.parse().ok()).unwrap_or(RUNS);
    let mut known: BTreeMap<&str, Vec<Valued>> = BTreeMap::new();
    let mut faults = Vec::new();
    for number in 0..runs {
        let mut stream = Stream::new(runs, Purpose::Sample, [number]);
        let base = BASES[number as usize % BASES.len()];
        let verb = base.split(' ').next().unwrap();
        let options = known.entry(verb).or_insert_with(|| options(path, verb));
        let mut words: Vec<String> = base.split(' ').map(str::to_owned).collect();
        for _ in 0..=stream.below(2) {
            let option = &options[stream.below(options.len())];
            // An option given twice only reports that.
            if !words.iter().any(|word| word.split('=').next() == Some(&option.name)) {
                words.push(format!("{}={}", option.name, extreme(option, &mut stream)));
            }
        }
        words.extend(["--force", "--threads", "2", "--memory", MEMORY.0].map(str::to_owned));
        faults.extend(fault(path, &words).map(|fault| format!("relume {}: {fault}", words.join(" "))));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_window_at_the_end_of_numbers_is_refused() {
    let folder = inputs();
    for window in
        ["-9223372036854775808,0,16,16", "0,-9223372036854775808,16,16", "9223372036854775807,0,1,1"]
    {
        for source in ["m.rlm", "t.png"] {
            let text =
                refused(folder.path(), &["synth", source, "-o", "o.png", &format!("--window={window}")]);
            assert!(text.contains("whole texels"), "{text}");
        }
    }
    let far = ["synth", "m.rlm", "-o", "o.png", "--window=4503599627370496,0,16,16"];
    assert!(refused(folder.path(), &far).contains("farther than 2^40"));
}

#[test]
fn numbers_that_would_never_end_or_fit_are_refused_with_their_range() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_material(&path.join("a.png"), Material::Leather, Size::new(48, 48), 8.0);
    for (words, expected) in [
        ("tileable a.png -o o.png --method patches --epsilon 1e11", "from 0 to 1,000,000"),
        ("tileable a.png -o o.png --band 9223372036854775808", "choose 1 to 23"),
        ("tileable a.png -o o.png --neighbourhood 18446744073709551615", "at most 1023"),
        ("synth a.png -o o.png --size 64 --method efros-leung --neighbourhood 20001", "at most 1023"),
        ("synth a.png -o o.png --size 64 --method efros-leung --neighbourhood 1000001", "at most 1023"),
        ("synth a.png -o o.png --size 64 --method patchmatch --rounds 131073", "choose 1 to 1000"),
        ("synth a.png -o o.png --size 64 --method wei-levoy --coherence 1000001", "choose 1 to 256"),
        ("synth a.png -o o.png --size 64 --tolerance 1e300", "from 0 to 1000000"),
        ("model a.png -o o.rlm --most 20001", "from 0 to 500"),
        ("roll a.png -o o.png --overlap 18446744073709551615", "choose 1 to 65536"),
        ("roll a.png -o o.png --period 18446744073709551616,4", "from -131072 to 131072"),
    ] {
        let words: Vec<&str> = words.split(' ').chain(["--memory", "0.5"]).collect();
        let begun = Instant::now();
        let text = refused(path, &words);
        assert!(text.contains(expected), "{words:?}: {text}");
        assert!(begun.elapsed() < Duration::from_secs(10), "{words:?}");
    }
}

/// Runs under a limit of the address space in KiB; `None` where the shell cannot set it.
#[cfg(target_os = "linux")]
fn under(kib: u64, folder: &Path, words: &str) -> (Option<i32>, String) {
    let program = env!("CARGO_BIN_EXE_relume");
    let script = format!("ulimit -v {kib} && exec '{program}' {words}");
    let output = Command::new("sh").args(["-c", &script]).current_dir(folder).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[cfg(target_os = "linux")]
#[test]
fn under_a_limit_of_the_process_verbs_give_a_result_or_a_sentence() {
    let folder = inputs();
    let path = folder.path();
    for kib in [400_000, 700_000, 1_500_000, 3_000_000] {
        for words in [
            "synth a.png -o o.png --size 200 --force --threads 2",
            "procedural marble -o op --size 20000 --force --threads 2",
            "render f.ptm -o o.png --size 20000 --force --threads 2",
            "procedural marble -o op --size 20000 --force --threads 2 --memory 64",
        ] {
            let (code, text) = under(kib, path, words);
            assert!(
                matches!(code, Some(0..=2)) && text.lines().count() <= 1,
                "{kib} {words}: {code:?} {text}"
            );
        }
    }
    assert!(relume(path, &["info", "a.png"]).status.success());
}
