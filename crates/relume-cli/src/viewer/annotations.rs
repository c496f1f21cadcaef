//! Annotations of a texture: a small file beside it.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use relume::{Error, Result};
use serde::{Deserialize, Deserializer, Serialize};

use crate::output::{Outputs, folder_of, is_stream};

/// What follows the name of the texture's file.
const SUFFIX: &str = ".annotations.json";
/// The largest file.
pub const MOST_BYTES: usize = 1 << 20;
const MOST_ANNOTATIONS: usize = 1000;
/// Letters of a text, and of a view.
const MOST_LETTERS: usize = 8000;
/// The largest number of a box, in texels: endless planes have places as far away.
const FARTHEST: f64 = 1e15;
/// Symbolic links that lead from one to the next.
const MOST_LINKS: usize = 40;

/// The file: what it is, and the annotations in their order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnnotationFile {
    relume: AnnotationMark,
    version: u32,
    annotations: Vec<Annotation>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
enum AnnotationMark {
    Annotations,
}

/// A point or a box with a text, and the view in which it was made; without a box, a bookmark: the name of that view.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Annotation {
    text: String,
    /// The left upper corner, width and height, in texels from the left upper corner of the texture.
    #[serde(rename = "box", default, deserialize_with = "given", skip_serializing_if = "Option::is_none")]
    place: Option<[f64; 4]>,
    /// As in the address of the page.
    view: String,
}

/// A box that is named is there.
fn given<'de, D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Option<[f64; 4]>, D::Error> {
    <[f64; 4]>::deserialize(deserializer).map(Some)
}

impl Annotation {
    /// What is wrong with it. The page holds the same rules (`web/src/annotations.ts`).
    fn check(&self) -> std::result::Result<(), String> {
        if self.text.chars().count().max(self.view.chars().count()) > MOST_LETTERS {
            return Err(format!("a text and a view may have {MOST_LETTERS} letters"));
        }
        let Some([x, y, width, height]) = self.place else { return Ok(()) };
        let is_box =
            x.abs().max(y.abs()) <= FARTHEST && [width, height].iter().all(|s| (0.0..=FARTHEST).contains(s));
        is_box.then_some(()).ok_or_else(|| {
            "expected a box of four numbers, left, top, width and height, none beyond 1e15 and no negative size"
                .to_owned()
        })
    }
}

impl Default for AnnotationFile {
    fn default() -> Self {
        Self { relume: AnnotationMark::Annotations, version: 1, annotations: Vec::new() }
    }
}

impl AnnotationFile {
    /// From the bytes of a file or a request.
    ///
    /// # Errors
    /// Anything but a file of annotations.
    pub fn parse(bytes: &[u8]) -> Result<Self> {
        let file: Self = serde_json::from_slice(bytes)
            .map_err(|e| Error::invalid(format!("these are no annotations: {e}; move the file away")))?;
        if file.version != 1 {
            let found = file.version;
            return Err(Error::unsupported(format!("annotations of version {found}: expected version 1")));
        }
        let count = file.annotations.len();
        if count > MOST_ANNOTATIONS {
            return Err(Error::limit(format!(
                "there may be {MOST_ANNOTATIONS} annotations of a texture: found {count}"
            )));
        }
        for (i, annotation) in file.annotations.iter().enumerate() {
            annotation.check().map_err(|what| Error::invalid(format!("annotation {}: {what}", i + 1)))?;
        }
        Ok(file)
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> Vec<u8> {
        serde_json::to_vec_pretty(self).expect("annotations are texts and finite numbers")
    }

    /// Those beside a texture, none where there is no such file or the texture is standard input.
    ///
    /// # Errors
    /// As [`AnnotationFile::read`].
    pub fn beside(texture: &Path) -> Result<Option<Self>> {
        place(texture).map_or(Ok(None), |path| Self::read(&path))
    }

    /// Those of a file, none where there is no such file.
    ///
    /// # Errors
    /// As [`AnnotationFile::parse`], and a file that cannot be read.
    pub fn read(path: &Path) -> Result<Option<Self>> {
        if !path.exists() {
            return Ok(None);
        }
        if !path.is_file() {
            return Err(
                Error::invalid("is no file: annotations of the texture are kept under this name").at(path)
            );
        }
        let unreadable = |e: std::io::Error| Error::io("cannot be read", &e).at(path);
        let mut bytes = Vec::new();
        let file = File::open(path).map_err(unreadable)?;
        file.take(MOST_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(unreadable)?;
        if bytes.len() > MOST_BYTES {
            let most = Error::limit(format!("annotations have at most {MOST_BYTES} bytes"));
            return Err(most.at(path));
        }
        Self::parse(&bytes).map(Some).map_err(|e| e.at(path))
    }
}

/// Writes annotations, whole or not at all; through a symbolic link, which stays one.
///
/// # Errors
/// When the file cannot be written.
pub fn save(path: &Path, bytes: Vec<u8>) -> Result<()> {
    let path = followed(path);
    let mut outputs = Outputs::replacing();
    outputs.file(&path, &[])?;
    outputs.write(&path, bytes)?;
    outputs.commit().map(drop)
}

/// Where symbolic links lead, also to a file that is not there yet.
pub fn followed(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        let Ok(target) = fs::read_link(&path) else { break };
        path = folder_of(&path).join(target);
    }
    path
}

/// The file of the annotations of a texture; `None` for standard input.
pub fn place(texture: &Path) -> Option<PathBuf> {
    if is_stream(texture) {
        return None;
    }
    let mut name = OsString::from(texture.file_name()?);
    name.push(SUFFIX);
    Some(texture.with_file_name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The files that the page's tests read as well (`web/tests/unit/annotations.test.ts`).
    #[test]
    fn program_and_page_take_and_refuse_the_same_annotations() {
        let cases: serde_json::Value =
            serde_json::from_str(include_str!("../../../../web/tests/unit/annotations.json")).unwrap();
        for (kind, is_good) in [("good", true), ("bad", false)] {
            for case in cases[kind].as_array().unwrap() {
                let (one, times) = (&case["annotation"], case["times"].as_u64().unwrap_or(1));
                let all = vec![one.as_str().unwrap(); usize::try_from(times).unwrap()].join(",");
                let text = format!(r#"{{"relume":"annotations","version":1,"annotations":[{all}]}}"#);
                let parsed = AnnotationFile::parse(text.as_bytes());
                assert_eq!(parsed.is_ok(), is_good, "{}: {parsed:?}", case["what"]);
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn annotations_are_written_through_links_to_their_file() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("elsewhere")).unwrap();
        std::os::unix::fs::symlink("second.json", at("first.json")).unwrap();
        std::os::unix::fs::symlink("elsewhere/notes.json", at("second.json")).unwrap();
        for text in ["new", "replaced"] {
            save(&at("first.json"), text.into()).unwrap();
            assert_eq!(fs::read_to_string(at("elsewhere/notes.json")).unwrap(), text);
            assert!(at("first.json").is_symlink() && at("second.json").is_symlink());
        }
    }

    #[test]
    fn annotations_come_back_and_anything_else_is_refused_in_a_sentence() {
        let text = r#"{"relume":"annotations","version":1,"annotations":[
            {"text":"</script><b>","box":[1,2.5,0,0],"view":"mode=normals"}]}"#;
        let file = AnnotationFile::parse(text.as_bytes()).unwrap();
        assert_eq!(AnnotationFile::parse(&file.bytes()).unwrap(), file);
        let long = text.replace("<b>", &"x".repeat(MOST_LETTERS + 1));
        for bad in [
            "",
            "{}",
            "[]",
            &text.replace("annotations\",\"v", "share\",\"v"),
            &text.replace(":1,", ":2,"),
            &text.replace("2.5", "1e999"),
            &text.replace("2.5", "null"),
            &text.replace("\"view\"", "\"path\""),
            &long,
        ] {
            let error = AnnotationFile::parse(bad.as_bytes()).unwrap_err().to_string();
            assert!(error.lines().count() == 1, "{error}");
        }
        assert_eq!(place(Path::new("a/b.ptm")), Some(PathBuf::from("a/b.ptm.annotations.json")));
        assert_eq!(place(Path::new("-")), None);
    }
}
