//! Paths as text, for people and programs, even if they are not UTF-8.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// A path as text, with U+FFFD for bytes that are not UTF-8.
pub fn text(path: impl AsRef<Path>) -> String {
    path.as_ref().to_string_lossy().into_owned()
}

/// Whether a path means standard input or output.
pub fn is_stream(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// A path with `%` and every byte that is not UTF-8 as `%XX`, which is unique for each path.
pub fn percent_encoded(path: &Path) -> String {
    let mut encoded = String::new();
    for chunk in path.as_os_str().as_encoded_bytes().utf8_chunks() {
        encoded.push_str(&chunk.valid().replace('%', "%25"));
        chunk.invalid().iter().for_each(|byte| encoded.push_str(&format!("%{byte:02X}")));
    }
    encoded
}

/// The path of [`percent_encoded`] text.
pub fn percent_decoded(text: &str) -> PathBuf {
    let mut bytes = Vec::new();
    let mut rest = text.as_bytes();
    while let [first, after @ ..] = rest {
        let code = after.get(..2).and_then(|code| std::str::from_utf8(code).ok());
        let code = code.and_then(|code| u8::from_str_radix(code, 16).ok()).filter(|_| *first == b'%');
        bytes.push(code.unwrap_or(*first));
        rest = if code.is_some() { &after[2..] } else { after };
    }
    PathBuf::from(of_bytes(bytes))
}

#[cfg(unix)]
fn of_bytes(bytes: Vec<u8>) -> OsString {
    std::os::unix::ffi::OsStringExt::from_vec(bytes)
}

#[cfg(not(unix))]
fn of_bytes(bytes: Vec<u8>) -> OsString {
    String::from_utf8_lossy(&bytes).into_owned().into()
}

/// A word of a command as a POSIX shell takes it: quoted where it has other characters than those of plain names.
pub fn shell_word(word: impl AsRef<Path>) -> String {
    let word = text(word);
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_@%+=:,./-".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word;
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// A text for a terminal, which would obey the control characters of a file name; lines stay lines.
pub fn visible(text: &str) -> String {
    let shown = |c: char| if c == '\n' { "\n".to_owned() } else { shown(c) };
    text.chars().map(shown).collect()
}

/// As [`visible`], on one line.
pub fn on_one_line(text: &str) -> String {
    text.chars().map(shown).collect()
}

fn shown(c: char) -> String {
    if c.is_control() { c.escape_default().to_string() } else { c.to_string() }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn any_path_has_a_text_of_its_own() {
        for (bytes, expected) in [
            (&b"wool.png"[..], "wool.png"),
            (b"a\xffb/c", "a%FFb/c"),
            (b"100%", "100%25"),
            ("größe".as_bytes(), "größe"),
            (b"%\xc3", "%25%C3"),
        ] {
            let path = PathBuf::from(of_bytes(bytes.to_vec()));
            assert_eq!(percent_encoded(&path), expected);
            assert_eq!(percent_decoded(expected), path);
        }
        assert_eq!(percent_decoded("50% off, %"), PathBuf::from("50% off, %"));
    }

    #[test]
    fn words_of_a_shell_are_quoted_where_they_must_be() {
        assert_eq!(shell_word("photos/a-1.lp"), "photos/a-1.lp");
        assert_eq!(shell_word("my photos"), "'my photos'");
        assert_eq!(shell_word("it's $HOME"), "'it'\\''s $HOME'");
        assert_eq!(shell_word("~/a"), "'~/a'");
        assert_eq!(shell_word(""), "''");
    }

    #[test]
    fn control_characters_of_names_are_shown_and_not_sent_to_the_terminal() {
        assert_eq!(visible("a\u{1b}[31m\nb"), "a\\u{1b}[31m\nb");
        assert_eq!(on_one_line("a\tb\nc\u{e9}"), "a\\tb\\nc\u{e9}");
    }
}
