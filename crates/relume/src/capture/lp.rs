//! Light-position files, `.lp`: the number of lights, then one line `name x y z` per light.
//!
//! The format has no specification; it is what RTI builders read and write. Vectors point from
//! the object to the light (x right, y up, z towards the camera) and have any length. Names may
//! hold spaces, be absolute Windows paths or carry sub-folders, so the last three words of a line
//! are the vector and everything before them is the name. Decimal commas, CR LF, a byte-order
//! mark and empty lines are accepted; a line that is not UTF-8 is taken as Latin-1, and the bytes
//! of its name are kept. Directions at or a little below the horizon, which measurements give, are taken as just above it.

use crate::direction::Direction;
use crate::error::{Error, Result};

/// One line of a light-position file.
#[derive(Debug, Clone, PartialEq)]
pub struct LpEntry {
    /// The name of the photograph as spelled in the file.
    pub name: String,
    /// The bytes of the name: a path of this system where they are not UTF-8.
    pub raw_name: Vec<u8>,
    /// The direction of the light, seen from the object.
    pub light: Direction,
    /// The vector as it stands in the file: a position where its length is not 1.
    pub vector: [f64; 3],
    /// Whether the light was at or a little below the horizon, and is taken as just above it.
    pub is_raised: bool,
    /// The line number in the file, from 1.
    pub line: usize,
}

/// The lowest direction that is accepted, and the one it is taken for, as the sine of the elevation.
const LOWEST: f64 = -0.02;
const HORIZON: f64 = 1e-3;

/// The direction of a listed light, and whether it was raised above the horizon.
pub(super) struct Listed {
    pub light: Direction,
    pub is_raised: bool,
}

/// A light at or a little below the horizon as one just above it; `None` farther below.
pub(super) fn raised(light: Direction) -> Option<Listed> {
    if light.z() > 0.0 {
        return Some(Listed { light, is_raised: false });
    }
    let raised = Direction::new(light.x(), light.y(), HORIZON).ok().filter(|_| light.z() >= LOWEST)?;
    Some(Listed { light: raised, is_raised: true })
}

/// Reads the content of a light-position file.
///
/// # Errors
/// A count that is missing, 0, or differs from the number of lines, a line without a name and three numbers, and
/// a vector that is not finite, zero, or not above the surface.
pub fn parse(bytes: &[u8]) -> Result<Vec<LpEntry>> {
    let list = List::parse(bytes)?;
    list.check_count()?;
    Ok(list.entries)
}

/// The lines of a file, and what its first line promises of them.
#[derive(Debug)]
pub(super) struct List {
    count_line: usize,
    count: usize,
    pub(super) entries: Vec<LpEntry>,
}

impl List {
    /// Reads all lines; the count may differ, see [`List::mismatch`].
    pub(super) fn parse(bytes: &[u8]) -> Result<Self> {
        if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
            return Err(Error::unsupported("the light file is UTF-16 text: save it as UTF-8"));
        }
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let lines = bytes.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
        let lines = lines.enumerate().map(|(i, line)| (i + 1, line));
        let mut lines = lines.filter(|(_, line)| !line.is_empty());
        let (count_line, first) = lines.next().ok_or_else(|| {
            Error::invalid(
                "the file is empty: expected the number of lights, then a line `name x y z` for each",
            )
        })?;
        let first = decode(first);
        let count = first.parse().map_err(|_| {
            Error::invalid(format!(
                "line {count_line}: expected the number of lights alone, found `{}`",
                excerpt(&first)
            ))
        })?;
        let entries: Vec<LpEntry> =
            lines.map(|(line, text)| parse_line(line, text)).collect::<Result<_>>()?;
        if count == 0 && entries.is_empty() {
            return Err(Error::invalid(format!(
                "line {count_line} promises 0 lights: expected the number of lights, then a line `name x y z` for each"
            )));
        }
        Ok(Self { count_line, count, entries })
    }

    /// A list without a first line that counts.
    pub(super) fn of(entries: Vec<LpEntry>) -> Self {
        Self { count_line: 0, count: entries.len(), entries }
    }

    /// Whether the first line promises this number of lights.
    pub(super) fn promises(&self, count: usize) -> bool {
        self.count == count && self.count != self.entries.len()
    }

    /// Refuses a count that is not the number of lines.
    fn check_count(&self) -> Result<()> {
        self.mismatch().map_or(Ok(()), |mismatch| {
            Err(Error::invalid(format!("{mismatch}: correct the number or the list")))
        })
    }

    /// That the count is not the number of lines, where it is not.
    pub(super) fn mismatch(&self) -> Option<String> {
        let (line, count, found) = (self.count_line, self.count, self.entries.len());
        (found != count).then(|| {
            let lines =
                if found == 1 { "1 line follows".to_owned() } else { format!("{found} lines follow") };
            format!("line {line} promises {count} lights, but {lines}")
        })
    }
}

/// Writes a light-position file: unit vectors, nine decimals, one line per light. Names are written unchanged.
///
/// # Errors
/// A name with a line break.
pub fn format(lights: &[(String, Direction)]) -> Result<String> {
    written(lights, |light| format!("{:.9} {:.9} {:.9}", light.x(), light.y(), light.z()))
}

/// Writes a light-position file of positions instead of unit vectors, in the same form.
///
/// # Errors
/// As [`format()`].
pub fn format_positions(lights: &[(String, [f64; 3])]) -> Result<String> {
    written(lights, |[x, y, z]| format!("{x:.6} {y:.6} {z:.6}"))
}

fn written<T>(lights: &[(String, T)], numbers: impl Fn(&T) -> String) -> Result<String> {
    let mut text = format!("{}\n", lights.len());
    for (name, light) in lights {
        if name.contains(['\n', '\r']) {
            return Err(Error::unsupported(format!(
                "the name {name:?} has a line break, which no light file can hold: rename the file or its folder"
            )));
        }
        text += &format!("{name} {}\n", numbers(light));
    }
    Ok(text)
}

/// UTF-8, else Latin-1, in which every byte is a character.
pub(super) fn decode(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

fn parse_line(line: usize, text: &[u8]) -> Result<LpEntry> {
    let malformed = || {
        Error::invalid(format!(
            "line {line}: expected a name and three numbers `name x y z`, found `{}`",
            excerpt(&decode(text))
        ))
    };
    let mut rest = text;
    let mut vector = [0.0f64; 3];
    for component in vector.iter_mut().rev() {
        let space = rest.iter().rposition(u8::is_ascii_whitespace).ok_or_else(malformed)?;
        *component = parse_number(&rest[space + 1..]).ok_or_else(malformed)?;
        rest = rest[..space].trim_ascii_end();
    }
    if rest.is_empty() {
        return Err(malformed());
    }
    let [x, y, z] = vector;
    let name = decode(rest);
    let light = Direction::new(x, y, z).map_err(|e| {
        Error::invalid(format!("line {line}: the light of {}: {}", printable(&name), e.message()))
    })?;
    let Listed { light, is_raised } = raised(light).ok_or_else(|| {
        Error::invalid(format!(
            "line {line}: the light of {} at ({x}, {y}, {z}) is not above the surface: z must be positive",
            printable(&name)
        ))
    })?;
    Ok(LpEntry { name, raw_name: rest.to_vec(), light, vector, is_raised, line })
}

/// A number with a decimal point or a decimal comma.
fn parse_number(word: &[u8]) -> Option<f64> {
    let word = std::str::from_utf8(word).ok()?;
    word.parse().ok().or_else(|| word.replace(',', ".").parse().ok())
}

/// A name from a file, whole, for a message.
pub(super) fn printable(name: &str) -> String {
    name.chars().map(|c| if c.is_control() { '?' } else { c }).collect()
}

/// At most sixty characters of a text from a file, for a message.
fn excerpt(text: &str) -> String {
    let mut short: String = printable(text).chars().take(60).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn message(text: &str) -> String {
        parse(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn every_known_variant_is_read() {
        let text = "\u{feff}5\r\nplain.png 0 0 1\r\nwith two  words.jpg 3.0 0 4.0\r\n\
                    C:\\Dome 1\\img.tif 0,6 -0,0 0,8\r\nsub/folder.png\t0\t0\t2e1\r\n\r\n12 1 0 1\r\n\r\n\r\n";
        let entries = parse(text.as_bytes()).unwrap();
        let names: Vec<_> = entries.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(
            names,
            ["plain.png", "with two  words.jpg", "C:\\Dome 1\\img.tif", "sub/folder.png", "12"]
        );
        assert_eq!(entries.iter().map(|e| e.line).collect::<Vec<_>>(), [2, 3, 4, 5, 7]);
        let near = |i: usize, expected: [f64; 3]| {
            let found = entries[i].light.to_array();
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        };
        near(1, [0.6, 0.0, 0.8]);
        near(2, [0.6, 0.0, 0.8]);
        near(3, [0.0, 0.0, 1.0]);
    }

    #[test]
    fn latin_1_names_are_read_and_utf_16_is_refused() {
        assert_eq!(parse(b"1\nn\xe9.png 0 0 1").unwrap()[0].name, "n\u{e9}.png");
        assert!(parse(b"\xff\xfe1\x00").unwrap_err().message().contains("UTF-16"));
    }

    #[test]
    fn lights_a_little_below_the_horizon_are_raised_and_vectors_kept() {
        let entries = parse(b"3\na 0.9 0.1 -0.001\nb 0 0.79 0\nc 0 0.8 0.7").unwrap();
        assert_eq!(entries.iter().map(|e| e.is_raised).collect::<Vec<_>>(), [true, true, false]);
        assert!(entries.iter().all(|e| e.light.z() > 0.0 && (e.light.dot(e.light) - 1.0).abs() < 1e-12));
        assert_eq!(entries[0].vector, [0.9, 0.1, -0.001]);
    }

    #[test]
    fn errors_name_the_line() {
        assert!(message("2\na 0 0 1\n\nb 0 nan 1").starts_with("line 4: the light of b"));
        assert!(message("1\na 0 0 inf").starts_with("line 2"));
        assert!(message("1\na 0 0 0").starts_with("line 2"));
        assert!(message("1\na 0.5 0 -0.1").contains("not above the surface"));
        assert!(message("1\na 0 0 -1").contains("not above the surface"));
        assert!(message("1\n0 0 1").contains("expected a name and three numbers"));
        assert!(message("1\na 0 1,2,3 1").contains("expected a name and three numbers"));
        assert!(message("a.png 0 0 1").contains("expected the number of lights"));
        assert!(message(" \n").contains("empty"));
        assert!(message("\n0\n").contains("line 2 promises 0 lights"));
        let both = message("3\na 0 0 1\nb 0 0 1");
        assert!(both.contains("3 lights") && both.contains("2 lines"), "{both}");
    }

    #[test]
    fn names_that_no_file_can_hold_are_refused() {
        let text = format(&[("a\nb.png".to_owned(), Direction::ZENITH)]).unwrap_err().to_string();
        assert!(text.contains(r"a\nb.png") && text.contains("rename"), "{text}");
    }

    proptest! {
        #[test]
        fn what_is_written_is_read_back(polar in 0.0..1.5f64, azimuth in 0.0..6.3f64, name in "[a-z ]{0,8}[a-z]") {
            let light = Direction::from_angles(polar, azimuth);
            let name = name.trim_start().to_owned();
            let back = parse(format(&[(name.clone(), light), ("b".into(), light)]).unwrap().as_bytes()).unwrap();
            prop_assert_eq!(back.len(), 2);
            prop_assert_eq!(&back[0].name, &name);
            prop_assert!(back.iter().all(|e| e.light.dot(light) > 1.0 - 1e-15));
        }

        #[test]
        fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..80)) {
            let _ = parse(&bytes);
        }
    }
}
