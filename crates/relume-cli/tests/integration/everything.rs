//! Every verb at least once, on names of any kind: the JSON matches docs/json.md, and names that are not
//! UTF-8 work everywhere.

use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use relume::Size;
use relume::procedural::Material;
use serde_json::Value;

use crate::support::{write_grey, write_material};

/// All verbs; `@name` is a file or folder of that name.
const COMMANDS: [&str; 53] = [
    "capture sponge -o @c --size 48 --lights 9",
    "capture --height @mask.png --albedo @a.png -o @maps --lights 3",
    "capture --height @mask.png --albedo @a.png --metallic @a.png -o @btf --views 2",
    "capture weave --size 16 -o @btf.zip --pairs 2",
    "capture leather -o @balls --size 64 --lights 4 --balls 1",
    "lights @balls --ball 83.5,32,16 -o @l.lp --picture @l.png",
    "fit @c -o @f.ptm",
    "fit @c -o @g.exr",
    "new @c -o @new",
    "procedural marble -o @p --size 48",
    "synth @a.png -o @o.png --size 40 --block 16 --source-map @m.npy --report @r.json --apply @a.png",
    "synth @a.png -o @o_el.png --size 20 --method efros-leung",
    "synth @a.png -o @o_wl.png --size 48 --method wei-levoy",
    "synth @a.png -o @o_pm.png --size 40 --method patchmatch",
    "synth @a.png -o @o_ro.png --size 40 --method roller",
    "synth @a.png -o @o_au.png --size 40 --method auto --tries 2",
    "synth @a.png -o @o_no.png --size 40 --method noise",
    "roll @a.png -o @t.png",
    "synth @t.png -o @o_ti.png --size 40",
    "model @a.png -o @n.rlm --levels 2 --combine never --curve @n.svg",
    "model @f.ptm -o @l.rlm --levels 1 --fields per-light",
    "synth @n.rlm -o @o_mo.png --size 40",
    "info @f.ptm",
    "info @a.png",
    "info @t.png",
    "info @n.rlm",
    "info @l.rlm",
    "analyze @a.png -o @analysis.png",
    "compare @a.png @a.png",
    "compare --texture @a.png @o.png --source-map @m.npy",
    "relight @f.ptm --light 0,0,1 -o @re.png",
    "relight @f.ptm --env sky -o @env.hdr",
    "relight @f.ptm --sweep orbit:3 -o @sweep",
    "relight @f.ptm --sweep orbit:3 -o @sweep.gif",
    "render @f.ptm -o @x.png --size 24 --mesh @quad.obj --height @h.exr --bump 1x",
    "render @f.ptm -o @xe.png --size 24 --env sky",
    "render @f.ptm -o @turn --size 24 --samples 1 --turntable 3",
    "render @f.ptm -o @xs.png --size 24 --samples 1 --env @env.hdr --env-samples=8 --light 0,0,1",
    "height @f.ptm -o @h.exr --force",
    "height @c -o @hc.exr --normals @hn.png",
    "match @a.png --to @o.png -o @ma.png --ranks @ranks.exr",
    "tileable @a.png -o @ti.png --neighbourhood 7",
    "fill @a.png --mask @mask.png -o @fi.png --neighbourhood 7",
    "gallery @in -o @gallery --methods quilting,noise --lights 1 --size 32",
    "share @f.ptm -o @share",
    "share @t.png @n.rlm --single-file -o @share.html",
    "completions bash",
    "convert @f.ptm -o @f.rti",
    "convert @f.ptm -o @web --web deepzoom",
    "formats",
    "maps @p -o @unreal --preset unreal --tile",
    "man @man",
    "demo -o @demo --lights 12",
];

/// A word of a command, with names that begin with `base`.
fn name(base: &OsStr, word: &str) -> OsString {
    match word.strip_prefix('@') {
        Some(name) => {
            let mut path = base.to_owned();
            path.push(name);
            path
        }
        None => word.into(),
    }
}

/// Runs a command on files whose names begin with `base`.
fn relume(at: &Path, base: &OsStr, command: &str) -> Output {
    let words = command.split(' ').map(|word| name(base, word));
    Command::new(env!("CARGO_BIN_EXE_relume")).current_dir(at).args(words).arg("--json").output().unwrap()
}

/// The inputs of the commands.
fn prepare(at: &Path, base: &OsStr) {
    let file = |word: &str| at.join(name(base, word));
    fs::create_dir_all(file("@in")).unwrap();
    write_material(&file("@a.png"), Material::Marble, Size::new(64, 64), 40.0);
    fs::copy(file("@a.png"), file("@in").join(file("@a.png").file_name().unwrap())).unwrap();
    let is_hole = |i: usize| (20..24).contains(&(i / 64)) && (20..24).contains(&(i % 64));
    let codes: Vec<u8> = (0..64 * 64).map(|i| 255 * u8::from(is_hole(i))).collect();
    write_grey(&file("@mask.png"), (64, 64), &codes);
    fs::write(file("@quad.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n")
        .unwrap();
    fs::copy(file("@mask.png"), file("@h.exr")).unwrap();
}

/// Headings of docs/json.md that are not of a verb that ends by itself; `viewer.rs` runs `view`.
const AROUND: [&str; 3] = ["All verbs", "Failures", "view"];

/// The tables of docs/json.md: for each heading the fields, whether they are always there, and their types.
type Tables = BTreeMap<String, BTreeMap<String, (bool, Vec<String>)>>;

fn tables() -> Tables {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/json.md");
    let mut tables = Tables::new();
    let mut heading = String::new();
    for line in fs::read_to_string(path).unwrap().lines() {
        if let Some(text) = line.strip_prefix("## ") {
            heading = text.to_owned();
        } else if line.starts_with("| `") {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            assert!(["always", "sometimes"].contains(&cells[2]), "{line}");
            let types = cells[3].split(" or ").map(str::to_owned).collect();
            let field = cells[1].trim_matches('`').to_owned();
            tables.entry(heading.clone()).or_default().insert(field, (cells[2] == "always", types));
        }
    }
    tables
}

fn type_of(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "boolean",
        Value::Number(_) => "number",
        Value::String(_) => "string",
        Value::Array(_) => "array",
        Value::Object(_) => "object",
    }
}

/// Every field printed is documented with its type, and every field documented as always there is printed.
fn check(printed: &Value, headings: &[&str], tables: &Tables, what: &str) {
    let documented = |field: &str| headings.iter().find_map(|heading| tables.get(*heading)?.get(field));
    for (field, value) in printed.as_object().unwrap() {
        let (_, types) = documented(field).unwrap_or_else(|| panic!("{what}: '{field}' is not documented"));
        assert!(
            types.iter().any(|t| t == type_of(value)),
            "{what}: '{field}' is {value}, said to be {types:?}"
        );
    }
    for (field, (always, _)) in headings.iter().filter_map(|heading| tables.get(*heading)).flatten() {
        assert!(!always || printed.get(field).is_some(), "{what}: '{field}' is missing");
    }
}

#[test]
fn every_verb_prints_what_the_document_says() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path(), OsStr::new("./"));
    let tables = tables();
    let mut verbs: Vec<&str> = Vec::new();
    for command in COMMANDS {
        let output = relume(folder.path(), OsStr::new("./"), command);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command}: {text}");
        let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
        let verb = command.split(' ').next().unwrap();
        check(&printed, &["All verbs", verb], &tables, command);
        assert_eq!(printed["verb"], verb);
        let outputs = printed["outputs"].as_array().unwrap();
        assert!(outputs.iter().all(|path| folder.path().join(path.as_str().unwrap()).exists()), "{command}");
        assert_eq!(
            outputs.is_empty(),
            ["info", "compare", "completions", "formats"].contains(&verb),
            "{command}"
        );
        verbs.push(verb);
    }
    let documented: Vec<&str> = tables.keys().map(String::as_str).filter(|h| !AROUND.contains(h)).collect();
    verbs.sort_unstable();
    verbs.dedup();
    assert_eq!(verbs, documented, "every verb is run and documented");
}

#[test]
fn every_failure_has_one_shape() {
    let folder = tempfile::tempdir().unwrap();
    prepare(folder.path(), OsStr::new("./"));
    let tables = tables();
    for (command, verb, kind, status) in [
        ("info missing.png", "info", "io", 1),
        ("info @quad.obj", "info", "unsupported", 1),
        ("info @a.png --memory 0", "info", "usage", 2),
        ("synth @a.png", "synth", "usage", 2),
        ("synth @a.png -o @o.png --size 0", "synth", "usage", 2),
        ("relight @a.png --light 0,0,1 -o @a.png/x.png", "relight", "usage", 2),
        ("nonsense", "", "usage", 2),
        ("--threads 2 render --nonsense", "render", "usage", 2),
    ] {
        let output = relume(folder.path(), OsStr::new("./"), command);
        let printed: Value = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|e| panic!("{command}: {e}: {}", String::from_utf8_lossy(&output.stdout)));
        check(&printed, &["Failures"], &tables, command);
        assert_eq!(output.status.code(), Some(status), "{command}");
        let error = &printed["error"];
        assert_eq!(printed["verb"].as_str().unwrap_or_default(), verb);
        assert_eq!(
            (error["kind"].as_str(), error["exit_status"].as_i64()),
            (Some(kind), Some(i64::from(status))),
            "{command}"
        );
        let message = error["message"].as_str().unwrap();
        assert!(message.len() > 10 && message.lines().count() == 1, "{command}: {message}");
    }
    let help = relume(folder.path(), OsStr::new("./"), "synth --help");
    assert!(help.status.success() && String::from_utf8_lossy(&help.stdout).contains("Usage:"));
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_utf8_work_everywhere() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    let odd = OsStr::from_bytes(b"b\xffse %41/\xff");
    fs::create_dir(folder.path().join(OsStr::from_bytes(b"b\xffse %41"))).unwrap();
    prepare(folder.path(), odd);
    for command in COMMANDS {
        let output = relume(folder.path(), odd, command);
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{command}: {text}");
        let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
        let (outputs, encoded) =
            (printed["outputs"].as_array().unwrap(), &printed["outputs_percent_encoded"]);
        for (k, lossy) in outputs.iter().enumerate() {
            assert!(lossy.as_str().unwrap().starts_with("b\u{fffd}se %41/\u{fffd}"), "{command}: {lossy}");
            assert!(encoded[k].as_str().unwrap().starts_with("b%FFse %2541/%FF"), "{command}: {encoded}");
        }
    }
    let output = relume(folder.path(), odd, "info @missing.png");
    let printed: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(printed["error"]["path_percent_encoded"], "b%FFse %2541/%FFmissing.png");
}

#[test]
fn completions_and_pages_come_from_the_same_definitions() {
    let folder = tempfile::tempdir().unwrap();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output =
            Command::new(env!("CARGO_BIN_EXE_relume")).args(["completions", shell]).output().unwrap();
        let script = String::from_utf8(output.stdout).unwrap();
        assert!(script.contains("source-map") && script.contains("gallery"), "{shell}");
    }
    let output = relume(folder.path(), OsStr::new("./"), "man @pages");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = fs::read_to_string(folder.path().join("pages/relume-synth.1")).unwrap();
    assert!(page.contains("source\\-map") && page.contains("relume\\-synth"), "{page}");
    assert!(fs::read_to_string(folder.path().join("pages/relume.1")).unwrap().contains("tileable"));
}
