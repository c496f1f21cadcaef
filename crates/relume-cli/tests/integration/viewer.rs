//! Pages of textures: shared as a folder and as one file, and served to the browser of this machine alone.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use relume::Size;
use relume::procedural::Material;
use serde_json::Value;

use crate::support::{failed, json, names, refused, run, write_grey, write_material};

fn texture(at: &Path, name: &str) {
    write_material(&at.join(name), Material::Marble, Size::new(32, 24), 16.0);
}

/// The data that the program wrote into a page.
fn data(page: &str) -> Value {
    let rest = page.split_once("id=\"relume-data\">").unwrap().1;
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn textures_of_a_comparison_have_texels_of_their_own_sizes() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    texture(at, "b.png");
    for sizes in [&["--mm-per-texel", "0.5,0.1"][..], &["--mm-per-texel", "0.5", "--mm-per-texel", "0.1"]] {
        run(at, &[&["share", "a.png", "b.png", "-o", "out", "--force"], sizes].concat());
        for (i, size) in [0.5, 0.1].into_iter().enumerate() {
            let header = fs::read(at.join(format!("out/textures/{i}/share.json"))).unwrap();
            assert_eq!(serde_json::from_slice::<Value>(&header).unwrap()["mm_per_texel"], size);
        }
    }
    let said = refused(at, &["share", "a.png", "b.png", "-o", "out", "--mm-per-texel", "1,2,3", "--force"]);
    assert!(said.contains("--mm-per-texel has 3 numbers for 2 textures: give one for all, or one for each"));
}

/// A fault: the remark named no picture, so that nobody knew which of several was meant.
#[test]
fn the_picture_whose_values_are_clipped_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "plain.png");
    let mut bright = b"PTM_1.2\nPTM_FORMAT_RGB\n8\n8\n4 4 4 4 4 4\n128 128 128 128 128 0\n".to_vec();
    bright.extend([200; 3 * 8 * 8 * 6]);
    fs::write(at.join("bright.ptm"), bright).unwrap();
    let said = json(at, &["share", "plain.png", "bright.ptm", "-o", "out"])["warnings"].to_string();
    assert!(said.contains("albedo.png of bright: 100.0 % of the values are outside 0..1"), "{said}");
}

#[test]
fn a_folder_holds_a_page_and_the_files_that_it_names() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    texture(at, "b.png");
    run(at, &["share", "a.png", "b.png", "-o", "out", "--title", "Two <marbles>", "--mm-per-texel", "0.5"]);
    let found = names(&at.join("out"));
    assert_eq!(
        found,
        [
            "index.html",
            "relume-files.json",
            "relume-view.js",
            "textures",
            "thumbnail.jpg",
            "viewer.css",
            "viewer.js"
        ]
    );
    let page = fs::read_to_string(at.join("out/index.html")).unwrap();
    assert!(page.contains("<title>Two &lt;marbles&gt;</title>"));
    let data = data(&page);
    for (entry, title) in data["textures"].as_array().unwrap().iter().zip(["a", "b"]) {
        assert_eq!(entry["title"], title);
        let texture = at.join("out").join(entry["folder"].as_str().unwrap());
        let header: Value = serde_json::from_slice(&fs::read(texture.join("share.json")).unwrap()).unwrap();
        assert_eq!(header["size"], serde_json::json!([32, 24]));
        assert_eq!(header["mm_per_texel"], 0.5);
        let files = |list: &str| header[list].as_array().unwrap().clone();
        let named = [files("planes"), files("maps")].concat();
        assert_eq!(names(&texture).len(), named.len() + 1);
        assert!(named.iter().all(|file| texture.join(file["file"].as_str().unwrap()).is_file()));
    }
}

#[test]
fn one_file_holds_everything_and_asks_for_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    let report = json(at, &["share", "a.png", "--single-file", "-o", "page.html"]);
    let page = fs::read_to_string(at.join("page.html")).unwrap();
    assert_eq!(report["bytes"].as_u64().unwrap() as usize, page.len());
    let policy =
        page.split_once("Content-Security-Policy\" content=\"").unwrap().1.split('"').next().unwrap();
    assert!(policy.starts_with("default-src 'none'") && !policy.contains("connect-src"), "{policy}");
    let head = page.split_once("<body>").unwrap().0;
    assert!(!head.contains("src=") && !head.contains("href=\"http"), "the page loads something");
    assert!(data(&page)["textures"][0]["files"]["share.json"].is_string());
}

#[test]
fn textures_without_a_colour_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    fs::write(at.join("broken.ptm"), b"PTM_1.2\nPTM_FORMAT_RGB\n4\n4\n").unwrap();
    for verb in ["share", "view"] {
        let extra: &[&str] = if verb == "share" { &["-o", "out"] } else { &[] };
        let output = Command::new(env!("CARGO_BIN_EXE_relume"))
            .current_dir(at)
            .args([verb, "broken.ptm"])
            .args(extra)
            .output()
            .unwrap();
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains("broken.ptm") && text.lines().count() == 1, "{text}");
    }
    refused(at, &["share", "broken.ptm"]);
    refused(at, &["view"]);
    refused(at, &["view", "broken.ptm", "--port", "0"]);
}

#[test]
fn noise_comes_as_planes_of_normal_values_with_their_tables_and_functions() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_material(&at.join("a.png"), Material::Sponge, Size::new(64, 64), 9.0);
    run(at, &["share", "a.png", "--noise", "-o", "out"]);
    let texture = at.join("out/textures/0");
    let header: Value = serde_json::from_slice(&fs::read(texture.join("share.json")).unwrap()).unwrap();
    let noise = &header["noise"];
    assert_eq!((&header["size"], &noise["planes"]), (&serde_json::json!([64, 64]), &serde_json::json!(3)));
    for file in ["tables", "functions"] {
        assert!(texture.join(noise[file].as_str().unwrap()).is_file(), "{file}");
    }
    run(at, &["procedural", "weave", "-o", "weave", "--size", "64", "--feature", "16"]);
    let text = refused(at, &["share", "weave/albedo.png", "--noise", "-o", "woven"]);
    assert!(text.contains("albedo.png"), "{text}");
}

#[test]
fn squares_of_the_plane_of_a_model_are_those_of_the_library() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_material(&at.join("a.png"), Material::Marble, Size::new(32, 32), 9.0);
    run(at, &["model", "a.png", "-o", "a.rlm", "--combine", "never"]);
    let server = Server::start(at, &["a.rlm"]);
    let header = server.get(&format!("{}textures/0/share.json", server.path));
    let header: Value = serde_json::from_str(header.split_once("\r\n\r\n").unwrap().1).unwrap();
    assert_eq!(
        (&header["blocks"]["side"], &header["planes"]),
        (&serde_json::json!(256), &serde_json::json!([]))
    );
    let request = format!(
        "GET {}textures/0/block_-1_2.f16.gz HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n",
        server.path, server.port
    );
    let answer = server.exchange(request.as_bytes());
    let start = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap() + 4;
    let mut raw = Vec::new();
    flate2::read::GzDecoder::new(&answer[start..]).read_to_end(&mut raw).unwrap();
    run(at, &["synth", "a.rlm", "--window=-256,512,256,256", "-o", "part.exr"]);
    let file = relume::format::read_field(&at.join("part.exr"), &relume::Job::default()).unwrap();
    let halves = raw.chunks_exact(2).map(|b| half::f16::from_le_bytes([b[0], b[1]]).to_f32());
    let expected = file.field.coefficients().as_slice();
    assert_eq!(raw.len(), 2 * expected.len());
    assert!(halves.zip(expected).all(|(a, b)| (a - b).abs() < 1e-3));
    for bad in ["block_01_0.f16.gz", "block_0_0.f16.gz/", "block_99999999999999_0.f16.gz"] {
        assert!(
            !server.get(&format!("{}textures/0/{bad}", server.path)).starts_with("HTTP/1.1 200"),
            "{bad}"
        );
    }
    #[cfg(unix)]
    assert_eq!(server.interrupt(), Some(130));
    // A page without a server has a tile.
    run(at, &["share", "a.rlm", "-o", "tile"]);
    let header: Value =
        serde_json::from_slice(&fs::read(at.join("tile/textures/0/share.json")).unwrap()).unwrap();
    assert!(header["blocks"].is_null() && !header["planes"].as_array().unwrap().is_empty());
}

/// Runs `relume view` until its page has been read.
pub fn shown(at: &Path, arguments: &[&str]) {
    // No test opens a browser.
    let files: Vec<&str> = arguments.iter().copied().filter(|word| *word != "--open").collect();
    let server = Server::start(at, &files);
    assert!(server.get(&server.path).starts_with("HTTP/1.1 200"));
    #[cfg(unix)]
    assert_eq!(server.interrupt(), Some(130));
}

/// A running `relume view`.
struct Server {
    child: Child,
    port: u16,
    path: String,
}

impl Server {
    fn start(at: &Path, files: &[&str]) -> Self {
        let mut child = Command::new(env!("CARGO_BIN_EXE_relume"))
            .current_dir(at)
            .arg("view")
            .args(files)
            .arg("--json")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let mut text = String::new();
        while serde_json::from_str::<Value>(&text).is_err() {
            text += &lines.next().expect("a report").unwrap();
        }
        let report: Value = serde_json::from_str(&text).unwrap();
        let fields: Vec<&str> = report.as_object().unwrap().keys().map(String::as_str).collect();
        assert_eq!(fields, ["verb", "outputs", "warnings", "url", "port"], "docs/json.md");
        let port = u16::try_from(report["port"].as_u64().unwrap()).unwrap();
        let url = report["url"].as_str().unwrap();
        let path = url.strip_prefix(&format!("http://127.0.0.1:{port}")).unwrap().to_owned();
        assert_eq!(path.len(), 34, "a token of 32 digits between slashes: {path}");
        Self { child, port, path }
    }

    /// Sends bytes; gives all that comes back.
    fn exchange(&self, bytes: &[u8]) -> Vec<u8> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        // The server may answer and close before it has everything.
        let _ = stream.write_all(bytes).and_then(|()| stream.shutdown(std::net::Shutdown::Write));
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        answer
    }

    fn get(&self, path: &str) -> String {
        let request = format!("GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n\r\n", self.port);
        String::from_utf8_lossy(&self.exchange(request.as_bytes())).into_owned()
    }

    /// Ends it as Ctrl-C does, and gives its exit status.
    fn interrupt(mut self) -> Option<i32> {
        let sent = Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        self.child.wait().unwrap().code()
    }
}

#[test]
fn the_server_gives_its_page_and_ends_with_the_status_of_the_signal() {
    let folder = tempfile::tempdir().unwrap();
    texture(folder.path(), "a.png");
    let server = Server::start(folder.path(), &["a.png", "missing.png"]);
    let page = server.get(&server.path);
    assert!(page.starts_with("HTTP/1.1 200 OK\r\n"), "{page}");
    for header in ["Content-Security-Policy: default-src 'none'", "X-Content-Type-Options: nosniff"] {
        assert!(page.contains(header), "{header}");
    }
    let data = data(&page);
    assert!(data["textures"][1]["error"].as_str().unwrap().contains("missing.png"));
    let texture = format!("{}{}share.json", server.path, data["textures"][0]["folder"].as_str().unwrap());
    assert!(server.get(&texture).contains("\"relume\": \"share\""));
    assert!(server.get(&format!("{}viewer.js", server.path)).starts_with("HTTP/1.1 200"));
    assert_eq!(server.interrupt(), Some(130));
}

#[test]
fn a_thousand_traversals_and_malformed_requests_get_nothing_and_leave_the_server_whole() {
    let folder = tempfile::tempdir().unwrap();
    texture(folder.path(), "a.png");
    fs::write(folder.path().join("secret.txt"), "hidden words").unwrap();
    let server = Server::start(folder.path(), &["a.png"]);
    let mut count = 0;
    for up in ["..", "%2e%2e", "..%2f", "..\\", "%252e%252e", ".%00.", "....", "%c0%ae%c0%ae"] {
        for depth in 1..8 {
            for target in ["secret.txt", "a.png", "etc/passwd", "Cargo.toml", "viewer.js", ""] {
                let climb = format!("{up}/").repeat(depth);
                for path in [format!("{}{climb}{target}", server.path), format!("/{climb}{target}")] {
                    let answer = server.get(&path);
                    assert!(answer.starts_with("HTTP/1.1 4"), "{path}: {answer}");
                    assert!(!answer.contains("hidden words"));
                    count += 1;
                }
            }
        }
    }
    let mut state = 1u32;
    for length in (0..400).chain([5_000, 20_000, 100_000]) {
        let mut byte = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let noise: Vec<u8> = (0..length).map(|_| byte()).collect();
        for request in [noise.clone(), [b"GET / HTTP/1.1\r\n", &*noise, b"\r\n\r\n"].concat()] {
            let answer = server.exchange(&request);
            assert!(answer.is_empty() || answer.starts_with(b"HTTP/1.1 4"), "{length} bytes of noise");
            count += 1;
        }
    }
    assert!(count > 1_000, "only {count} requests");
    for host in ["example.org", "127.0.0.1", "127.0.0.1:1"] {
        let request = format!("GET {} HTTP/1.1\r\nHost: {host}\r\n\r\n", server.path);
        assert!(server.exchange(request.as_bytes()).starts_with(b"HTTP/1.1 403"), "{host}");
    }
    assert!(server.get(&server.path).starts_with("HTTP/1.1 200"), "the server still answers");
    assert_eq!(server.interrupt(), Some(130));
}

/// A square of two triangles with texture coordinates.
const SQUARE: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
const NOTES: &str = r#"{"relume":"annotations","version":1,"annotations":[{"text":"</script>a tear","box":[1.0,2.0,3.0,4.0],"view":"mode=normals"}]}"#;

#[test]
fn an_object_an_environment_and_annotations_come_with_the_page() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    fs::write(at.join("square.obj"), SQUARE).unwrap();
    fs::write(at.join("a.png.annotations.json"), NOTES).unwrap();
    let words = ["a.png", "--mesh", "square.obj", "--env", "a.png", "--url", "https://example.org/a/"];
    run(at, &[&["share"], &words[..], &["-o", "out"]].concat());
    let page = fs::read_to_string(at.join("out/index.html")).unwrap();
    assert!(page.contains("content=\"https://example.org/a/thumbnail.jpg\""));
    assert!(page.contains("property=\"og:description\" content=\"a: "));
    let data = data(&page);
    assert_eq!(data["mesh"]["title"], "square.obj");
    assert!(at.join("out").join(data["mesh"]["file"].as_str().unwrap()).is_file());
    let entry = &data["textures"][0];
    assert_eq!(entry["annotations"], serde_json::from_str::<Value>(NOTES).unwrap());
    assert_eq!(entry["environment"], true);
    let header = at.join("out").join(entry["folder"].as_str().unwrap()).join("share.json");
    let header: Value = serde_json::from_slice(&fs::read(header).unwrap()).unwrap();
    assert_eq!(header["environment"]["nodes"], 2, "a picture needs no more than the mean light");
    fs::write(at.join("bare.obj"), "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n").unwrap();
    let error = failed(at, &["share", "a.png", "--mesh", "bare.obj", "-o", "other"], 1);
    assert!(error.contains("bare.obj") && error.contains("no texture coordinate"), "{error}");
    refused(at, &["share", "a.png", "-o", "other", "--url", "example.org"]);
    let sentence = failed(at, &["share", "a.png", "-o", "other.html"], 2);
    assert!(sentence.contains("other.html") && sentence.contains("--single-file"), "{sentence}");
}

/// A fault: a texture could not be seen because of the file beside it.
#[test]
fn damaged_annotations_hide_no_texture_and_stay_as_they_are() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    let notes = at.join("a.png.annotations.json");
    fs::write(&notes, "{broken").unwrap();
    let shared = json(at, &["share", "a.png", "-o", "out"]);
    let said = shared["warnings"][0].as_str().unwrap();
    assert!(said.contains("a.png.annotations.json") && said.contains("no annotations"), "{said}");
    let page = fs::read_to_string(at.join("out/index.html")).unwrap();
    assert_eq!(data(&page)["textures"][0]["annotations"], Value::Null);
    let server = Server::start(at, &["a.png"]);
    let page = server.get(&server.path);
    assert!(page.starts_with("HTTP/1.1 200 OK"), "{page}");
    let path = format!("{}{}", server.path, data(&page)["textures"][0]["notes"].as_str().unwrap());
    assert!(server.get(&path).starts_with("HTTP/1.1 409"));
    let post = format!(
        "POST {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Type: application/json\r\nIf-Match: \"none\"\r\n\
         Content-Length: {}\r\n\r\n{NOTES}",
        server.port,
        NOTES.len()
    );
    let answer = String::from_utf8_lossy(&server.exchange(post.as_bytes())).into_owned();
    assert!(answer.starts_with("HTTP/1.1 409"), "{answer}");
    assert_eq!(fs::read_to_string(&notes).unwrap(), "{broken");
    assert_eq!(server.interrupt(), Some(130));
    fs::remove_file(&notes).unwrap();
    fs::create_dir(&notes).unwrap();
    let shared = json(at, &["share", "a.png", "-o", "other"]);
    assert!(shared["warnings"][0].as_str().unwrap().contains("no file"), "{shared}");
}

#[test]
fn pages_that_cannot_be_meant_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    write_grey(&at.join("dot.png"), (1, 1), &[200]);
    for (words, said) in [
        (vec!["a.png", "--single-file", "-o", "x.exr"], "name it .html"),
        (vec!["a.png", "--single-file", "-o", "x"], "name it .html"),
        (vec!["a.png", "-o", "x.htm"], "--single-file"),
        (vec!["a.png", "-o", "x", "--title", ""], "without --title"),
        (vec!["a.png", "-o", "x", "--title", " "], "without --title"),
        ([vec!["a.png"; 17], vec!["-o", "x"]].concat(), "17 textures are given, and a page shows 16"),
        (
            vec!["dot.png", "--noise", "-o", "x"],
            "at least 8 texels on each side, and this is 1 x 1: use a larger",
        ),
    ] {
        let sentence = refused(at, &[&["share"], &words[..]].concat());
        assert!(sentence.contains(said), "{words:?}: {sentence}");
    }
    let sentence = refused(at, &[&["view"][..], &["a.png"; 17][..]].concat());
    assert!(sentence.contains("17 textures are given"), "{sentence}");
}

#[test]
fn textures_of_one_name_have_titles_that_tell_them_apart() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    for side in ["left", "right"] {
        fs::create_dir(at.join(side)).unwrap();
        texture(&at.join(side), "a.png");
    }
    run(at, &["share", "left/a.png", "right/a.png", "-o", "out"]);
    let data = data(&fs::read_to_string(at.join("out/index.html")).unwrap());
    let titles: Vec<&str> =
        data["textures"].as_array().unwrap().iter().map(|t| t["title"].as_str().unwrap()).collect();
    assert_eq!(titles, ["a (left)", "a (right)"]);
}

#[cfg(unix)]
#[test]
fn a_link_to_annotations_stays_a_link() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    fs::create_dir(at.join("kept")).unwrap();
    std::os::unix::fs::symlink("kept/notes.json", at.join("a.png.annotations.json")).unwrap();
    let server = Server::start(at, &["a.png"]);
    let request = format!(
        "POST {}annotations/0.json HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Type: application/json\r\n\
         If-Match: \"none\"\r\nContent-Length: {}\r\n\r\n{NOTES}",
        server.path,
        server.port,
        NOTES.len()
    );
    assert!(server.exchange(request.as_bytes()).starts_with(b"HTTP/1.1 200"));
    assert!(at.join("a.png.annotations.json").is_symlink());
    assert!(fs::read_to_string(at.join("kept/notes.json")).unwrap().contains("a tear"));
    assert_eq!(server.interrupt(), Some(130));
}

#[test]
fn annotations_that_the_page_sends_are_written_beside_the_texture() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    texture(at, "a.png");
    let server = Server::start(at, &["a.png"]);
    let name = data(&server.get(&server.path))["textures"][0]["notes"].as_str().unwrap().to_owned();
    let (host, path) = (format!("Host: 127.0.0.1:{}", server.port), format!("{}{name}", server.path));
    assert!(server.get(&path).contains("\"annotations\": []"));
    let post = |headers: &str, body: &str| {
        let length = body.len();
        let head =
            format!("POST {path} HTTP/1.1\r\n{host}\r\nContent-Length: {length}\r\n{headers}\r\n\r\n{body}");
        String::from_utf8(server.exchange(head.as_bytes())).unwrap()
    };
    let json = "Content-Type: application/json";
    let none = "Content-Type: application/json\r\nIf-Match: \"none\"";
    let file = at.join("a.png.annotations.json");
    for (headers, body, status) in [
        ("Content-Type: text/plain", NOTES, "415"),
        (&format!("{json}\r\nOrigin: http://example.org"), NOTES, "403"),
        (json, NOTES, "428"),
        (none, "{}", "400"),
        (json, &"x".repeat((1 << 20) + 1), "413"),
    ] {
        let answer = post(headers, body);
        // A server that refuses a long body may close before it has been sent.
        assert!(answer.is_empty() || answer.starts_with(&format!("HTTP/1.1 {status}")), "{answer}");
        assert!(!file.exists());
    }
    assert!(post(none, NOTES).starts_with("HTTP/1.1 200"));
    let written: Value = serde_json::from_slice(&fs::read(&file).unwrap()).unwrap();
    assert_eq!(written, serde_json::from_str::<Value>(NOTES).unwrap());
    let read = server.get(&path);
    assert!(read.contains("a tear"));
    assert_eq!(names(at), ["a.png", "a.png.annotations.json"]);
    // What somebody else wrote meanwhile stays.
    let tag = read.lines().find_map(|line| line.strip_prefix("ETag: ")).unwrap();
    let seen = format!("{json}\r\nIf-Match: {tag}");
    fs::write(&file, NOTES.replace("a tear", "by hand")).unwrap();
    assert!(post(&seen, NOTES).starts_with("HTTP/1.1 412"));
    assert!(server.get(&path).contains("by hand"));
    fs::write(&file, "{").unwrap();
    for answer in [server.get(&path), post(&seen, NOTES)] {
        assert!(answer.starts_with("HTTP/1.1 409") && answer.contains("no annotations"), "{answer}");
    }
    assert_eq!(fs::read_to_string(&file).unwrap(), "{");
    assert_eq!(server.interrupt(), Some(130));
}
