use super::*;
use crate::viewer::AnnotationFile;

fn site() -> ViewerSite {
    let mut site = ViewerSite::new(4321, Job::default()).unwrap();
    site.add("", "text/html; charset=utf-8", b"<p>page".to_vec());
    site.add("textures/0/share.json", "application/octet-stream", b"{}".to_vec());
    site
}

fn status(site: &ViewerSite, request: &[u8]) -> u16 {
    let answer = site.answer(request, b"");
    let status = answer.head.split(' ').nth(1).unwrap().parse().unwrap();
    assert!(status == 200 || answer.body.is_empty());
    status
}

fn get(site: &ViewerSite, path: &str, headers: &str) -> u16 {
    status(site, format!("GET {path} HTTP/1.1\r\n{headers}\r\n").as_bytes())
}

#[test]
fn files_are_found_by_their_names_alone() {
    let site = site();
    let host = "Host: 127.0.0.1:4321\r\n";
    let path = |rest: &str| format!("/{}{rest}", site.token);
    for good in ["/", "/textures/0/share.json", "/?x=1"] {
        assert_eq!(get(&site, &path(good), host), 200, "{good}");
    }
    assert_eq!(get(&site, &path("/"), "host: localhost:4321\r\nOrigin: http://localhost:4321\r\n"), 200);
    for bad in ["", "/textures/0/", "/textures/0", "//", "/./", "/textures/../", "/%2e%2e/", "/share.json"] {
        assert_eq!(get(&site, &path(bad), host), 404, "{bad}");
    }
    for bad in ["/", "//", "/0123/", "/textures/0/share.json"] {
        assert_eq!(get(&site, bad, host), 404, "{bad}");
    }
    let head = format!("HEAD {} HTTP/1.1\r\n{host}\r\n", path("/"));
    assert!(site.answer(head.as_bytes(), b"").body.is_empty());
    let post = format!("POST {} HTTP/1.1\r\n{host}\r\n", path("/"));
    assert_eq!(status(&site, post.as_bytes()), 405);
}

#[test]
fn requests_for_other_hosts_and_from_other_origins_are_refused() {
    let site = site();
    let path = format!("/{}/", site.token);
    for headers in [
        "",
        "Host: example.org\r\n",
        "Host: 127.0.0.1\r\n",
        "Host: 127.0.0.1:4322\r\n",
        "Host: 127.0.0.1:4321.example.org\r\n",
        "Host: 127.0.0.1:4321\r\nHost: example.org\r\n",
        "Host: 127.0.0.1:4321\r\nOrigin: http://example.org\r\n",
        "Host: 127.0.0.1:4321\r\nOrigin: null\r\n",
        "Host: 127.0.0.1:4321\r\nOrigin: https://127.0.0.1:4321\r\n",
        "Host: 127.0.0.1:4321\r\nOrigin: http://127.0.0.1:4321.example.org\r\n",
    ] {
        assert_eq!(get(&site, &path, headers), 403, "{headers}");
    }
}

/// Every way out of the folder that encodings allow, in front of names that exist and names that do not; and
/// requests with bytes changed, cut short and repeated.
#[test]
fn thousands_of_traversals_and_malformed_requests_get_nothing() {
    let site = site();
    let host = "Host: 127.0.0.1:4321\r\n";
    let mut count = 0;
    let ups = ["..", "%2e%2e", "%2E.", ".%2e", "%252e%252e", "..%00", "%c0%ae%c0%ae", "...", ".", "..;"];
    let slashes = ["/", "//", "\\", "%2f", "%5c", "%252f", "/./"];
    let targets = ["etc/passwd", "Cargo.toml", "textures/0/share.json", "windows/win.ini", ""];
    for (up, slash) in ups.iter().flat_map(|up| slashes.map(|slash| (up, slash))) {
        for (target, depth) in targets.iter().flat_map(|target| [1, 3, 8].map(|depth| (target, depth))) {
            let climb = format!("{up}{slash}").repeat(depth);
            for path in [format!("/{}/{climb}{target}", site.token), format!("/{climb}{target}")] {
                assert_ne!(get(&site, &path, host), 200, "{path}");
                count += 1;
            }
        }
    }
    let good = format!("GET /{}/ HTTP/1.1\r\n{host}\r\n", site.token).into_bytes();
    for cut in 0..good.len() {
        assert_ne!(status(&site, &good[..cut]), 200, "cut at {cut}");
        for byte in [0, b'\n', b' ', b'\r', 0x80, 0xff, b':', b'/', b'%'] {
            let mut changed = good.clone();
            changed[cut] = byte;
            // A change that a request survives gives the page itself and nothing else.
            let answer = site.answer(&changed, b"");
            assert!(answer.body.is_empty() || &*answer.body == b"<p>page", "byte {byte} at {cut}");
            count += 1;
        }
    }
    let many = format!("GET / HTTP/1.1\r\n{}\r\n", "A: b\r\n".repeat(MOST_HEADERS + 1));
    assert_eq!(status(&site, many.as_bytes()), 400);
    assert!(count > 2500, "only {count} requests");
}

#[test]
fn annotations_are_written_whole_or_not_at_all_and_only_to_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.ptm.annotations.json");
    let mut site = site();
    site.add_notes("annotations/0.json".to_owned(), path.clone());
    let good =
        br#"{"relume":"annotations","version":1,"annotations":[{"text":"a","box":[1,2,0,0],"view":""}]}"#;
    let head = |method: &str, name: &str, headers: &str, body: &[u8]| {
        let length = body.len();
        let token = &site.token;
        format!(
            "{method} /{token}/{name} HTTP/1.1\r\nHost: 127.0.0.1:4321\r\nContent-Length: {length}\r\n{headers}\r\n"
        )
    };
    let json = "Content-Type: application/json\r\nIf-Match: \"none\"\r\n";
    let untagged = "Content-Type: application/json\r\n";
    let older = "Content-Type: application/json\r\nIf-Match: \"0\"\r\n";
    let foreign = "Content-Type: application/json\r\nOrigin: http://example.org\r\n";
    let pieces = "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n";
    let twice = "Content-Type: application/json\r\nContent-Length: 3\r\n";
    for (name, headers, body, expected) in [
        ("annotations/0.json", "", &good[..], 415),
        ("annotations/0.json", "Content-Type: text/plain\r\n", good, 415),
        ("annotations/0.json", foreign, good, 403),
        ("annotations/0.json", pieces, good, 411),
        ("annotations/0.json", twice, good, 411),
        ("annotations/0.json", untagged, good, 428),
        ("annotations/0.json", older, good, 412),
        ("annotations/0.json", json, b"{}", 400),
        ("annotations/0.json", json, b"<html>", 400),
        ("annotations/1.json", json, good, 405),
        ("annotations/../0.json", json, good, 405),
        ("", json, good, 405),
        ("textures/0/share.json", json, good, 405),
    ] {
        let head = head("POST", name, headers, body);
        assert_eq!(status_of(&site.answer(head.as_bytes(), body)), expected, "{name} {headers}");
        assert!(!path.exists());
    }
    let long = head("POST", "annotations/0.json", json, &vec![b' '; MOST_BYTES + 1]);
    assert_eq!(site.body_length(long.as_bytes()), None);
    assert_eq!(status_of(&site.answer(long.as_bytes(), b"")), 413);
    let cut = head("POST", "annotations/0.json", json, good);
    assert_eq!(site.body_length(cut.as_bytes()), Some(good.len()));
    assert_eq!(status_of(&site.answer(cut.as_bytes(), &good[1..])), 400);
    assert_eq!(status_of(&site.answer(cut.as_bytes(), good)), 200);
    // What was written since is not written over.
    assert_eq!(status_of(&site.answer(cut.as_bytes(), good)), 412);
    let written = std::fs::read(&path).unwrap();
    assert_eq!(AnnotationFile::parse(&written).unwrap(), AnnotationFile::parse(good).unwrap());
    let get = head("GET", "annotations/0.json", "", b"");
    assert_eq!(&*site.answer(get.as_bytes(), b"").body, written);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary is left");
}

#[test]
fn annotations_that_could_not_be_read_again_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.json");
    let mut site = site();
    site.add_notes("annotations/0.json".to_owned(), path.clone());
    // Short as it is sent, and long with the spaces and line ends of the file.
    let one = format!(r#"{{"text":"{}","box":[1,2,0,0],"view":""}}"#, "x".repeat(980));
    let all = vec![one; 1000].join(",");
    let body = format!(r#"{{"relume":"annotations","version":1,"annotations":[{all}]}}"#);
    assert!(body.len() <= MOST_BYTES);
    let head = format!(
        "POST /{}/annotations/0.json HTTP/1.1\r\nHost: 127.0.0.1:4321\r\nContent-Length: {}\r\n\
         Content-Type: application/json\r\nIf-Match: \"none\"\r\n\r\n",
        site.token,
        body.len()
    );
    let answer = site.answer(head.as_bytes(), body.as_bytes());
    assert_eq!(status_of(&answer), 409);
    assert!(String::from_utf8_lossy(&answer.body).contains("1048576 bytes in all"));
    assert!(!path.exists());
}

#[test]
fn textures_with_one_file_of_annotations_share_it() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("b")).unwrap();
    let mut site = site();
    let mut add = |i: usize, name: &str| site.add_notes(format!("annotations/{i}.json"), at(name));
    assert_eq!(add(0, "a.json"), "annotations/0.json");
    assert_eq!(add(1, "b/../a.json"), "annotations/0.json");
    assert_eq!(add(2, "b/a.json"), "annotations/2.json");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("b/a.json", at("c.json")).unwrap();
        assert_eq!(add(3, "c.json"), "annotations/2.json");
    }
}

fn status_of(answer: &Answer) -> u16 {
    answer.head.split(' ').nth(1).unwrap().parse().unwrap()
}

#[test]
fn tokens_differ() {
    assert_ne!(
        ViewerSite::new(1, Job::default()).unwrap().token,
        ViewerSite::new(1, Job::default()).unwrap().token
    );
}
