//! Wavefront OBJ (Wavefront Technologies, "Advanced Visualizer Manual", 1991, appendix B1):
//! vertices, texture coordinates, normals and polygons. All else (groups, materials, lines, free-form
//! surfaces, colours after a vertex) is passed over.
//!
//! Only these statements are looked at, so comments and names may be in any 8-bit encoding. They go on
//! after a backslash at the end of a line. There is no specification of polygons that are not convex;
//! they are cut by their ears ([`super::polygon`]). The crate `tobj` 4.0 reads UTF-8 only, takes no
//! backslashes and cuts fans only.

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::MeshParts;
use super::polygon::triangulate;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::Mesh;

/// The indices of a corner from 0: position, texture coordinate, normal.
type Corner = (usize, usize, Option<usize>);

/// What the search tree of corners takes for each, beside the vertex itself.
const CORNER_BYTES: u64 = 64;

#[derive(Default)]
struct ObjReader {
    positions: Vec<[f32; 3]>,
    texcoords: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    vertices: BTreeMap<Corner, u32>,
    parts: MeshParts,
}

pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<Mesh> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut reader = ObjReader::default();
    let mut lines = bytes.split(|&byte| byte == b'\n').enumerate();
    while let Some((index, line)) = lines.next() {
        let mut statement = statement(line);
        while statement.ends_with('\\') {
            let whole = statement.to_mut();
            whole.pop();
            whole.push(' ');
            whole.push_str(&lines.next().map_or("".into(), |(_, line)| text(line)));
        }
        let read = reader.statement(&statement).and_then(|()| reader.check(job));
        read.map_err(|e| Error::new(e.kind(), format!("line {}: {}", index + 1, e.message())))?;
    }
    if reader.positions.is_empty() {
        return Err(Error::invalid(
            "the file is neither binary glTF nor OBJ: no line of it gives a vertex (`v x y z`)",
        ));
    }
    reader.parts.into_mesh()
}

/// A line that is read, without its comment; nothing for all others.
fn statement(line: &[u8]) -> Cow<'_, str> {
    let keyword = line.trim_ascii_start().split(u8::is_ascii_whitespace).next();
    if matches!(keyword, Some(b"v" | b"vt" | b"vn" | b"f" | b"fo")) { text(line) } else { "".into() }
}

/// A line without its comment, which begins a word: `1.#QNAN` holds none.
fn text(line: &[u8]) -> Cow<'_, str> {
    let begins = |at: usize| line[at] == b'#' && (at == 0 || line[at - 1].is_ascii_whitespace());
    let end = (0..line.len()).find(|&at| begins(at)).unwrap_or(line.len());
    String::from_utf8_lossy(line[..end].trim_ascii())
}

impl ObjReader {
    fn statement(&mut self, statement: &str) -> Result<()> {
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("v") => self.positions.push(numbers("a vertex", 3, words)?),
            // The second number of a texture coordinate is 0 where it is missing.
            Some("vt") => self.texcoords.push(numbers("a texture coordinate", 1, words)?),
            Some("vn") => self.normals.push(numbers("a normal", 3, words)?),
            Some("f" | "fo") => self.face(words)?,
            _ => {}
        }
        Ok(())
    }

    fn check(&self, job: &Job) -> Result<()> {
        let listed = 12 * (self.positions.len() + self.normals.len()) + 8 * self.texcoords.len();
        let corners = CORNER_BYTES * self.vertices.len() as u64;
        job.check_bytes("the mesh", listed as u64 + corners)?;
        self.parts.check(job)
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<()> {
        let corners: Vec<u32> = words.map(|word| self.corner(word)).collect::<Result<_>>()?;
        if corners.len() < 3 {
            return Err(Error::invalid(format!("a face needs at least 3 corners, found {}", corners.len())));
        }
        let positions: Vec<_> = corners.iter().map(|&i| self.parts.positions[i as usize]).collect();
        let triangles = triangulate(&positions)?.into_iter().map(|t| t.map(|i| corners[i]));
        self.parts.triangles.extend(triangles);
        Ok(())
    }

    /// The vertex of a corner such as `3/1/2`; corners with the same indices share one.
    fn corner(&mut self, word: &str) -> Result<u32> {
        let mut fields = word.split('/');
        let position = index("vertex", fields.next(), self.positions.len())?
            .ok_or_else(|| Error::invalid(format!("the corner '{word}' names no vertex")))?;
        let texcoord =
            index("texture coordinate", fields.next(), self.texcoords.len())?.ok_or_else(|| {
                Error::unsupported(format!(
                    "the corner '{word}' has no texture coordinate: unwrap the mesh before exporting it"
                ))
            })?;
        let normal = index("normal", fields.next(), self.normals.len())?;
        let next = self.parts.positions.len() as u32;
        let vertex = *self.vertices.entry((position, texcoord, normal)).or_insert(next);
        if vertex == next {
            self.parts.positions.push(self.positions[position]);
            self.parts.texcoords.push(self.texcoords[texcoord]);
            self.parts.normals.push(normal.map_or([0.0; 3], |n| self.normals[n]));
        }
        Ok(vertex)
    }
}

/// The first `N` numbers of a line, of which `least` must be there; the others are 0.
fn numbers<'a, const N: usize>(
    what: &str,
    least: usize,
    words: impl Iterator<Item = &'a str>,
) -> Result<[f32; N]> {
    let mut found = [0.0; N];
    let mut count = 0;
    for (number, word) in found.iter_mut().zip(words) {
        *number = parse_number(word).ok_or_else(|| {
            Error::invalid(format!(
                "{what} needs numbers, found '{}'",
                word.chars().take(40).collect::<String>()
            ))
        })?;
        count += 1;
    }
    if count < least {
        return Err(Error::invalid(format!("{what} needs {least} numbers, found {count}")));
    }
    Ok(found)
}

/// A number; `-nan(ind)` and `1.#QNAN`, as some run-time libraries print them, are no numbers.
fn parse_number(word: &str) -> Option<f32> {
    let not_a_number = |word: &str| word.starts_with("nan(") || word.starts_with("1.#");
    let unsigned = word.trim_start_matches(['-', '+']);
    word.parse().ok().or_else(|| not_a_number(unsigned).then_some(f32::NAN))
}

/// The place in a list that a field of a corner names, from 0; nothing where it is empty or missing.
/// OBJ counts from 1, or backwards from the end with negative numbers.
fn index(what: &str, field: Option<&str>, count: usize) -> Result<Option<usize>> {
    let Some(field) = field.filter(|field| !field.is_empty()) else { return Ok(None) };
    let number = field.parse::<i64>().ok();
    let index = number.and_then(|n| match n {
        1.. => usize::try_from(n - 1).ok(),
        0 => None,
        _ => usize::try_from(n.unsigned_abs()).ok().and_then(|back| count.checked_sub(back)),
    });
    index.filter(|&i| i < count).map(Some).ok_or_else(|| {
        Error::invalid(format!("a face refers to {what} {field}, but there are {count} so far"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "# a square\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1 1\nvt 0 1\n\
        vn 0 0 2\no name\nusemtl wood\ns off\nf 1/1/1 2/2/1 3/3/1 -1/-1/-1 # the only face\n";

    fn decoded(text: &str) -> Result<Mesh> {
        decode(text.as_bytes(), &Job::default())
    }

    #[test]
    fn a_square_is_two_triangles_over_four_vertices() {
        let mesh = decoded(SQUARE).unwrap();
        assert_eq!(mesh.positions(), [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(mesh.texcoords()[3], [0.0, 1.0]);
        assert_eq!(mesh.normals(), [[0.0, 0.0, 1.0]; 4]);
        assert_eq!(mesh.triangles(), [[0, 1, 2], [0, 2, 3]]);
        let without_normals =
            SQUARE.replace("/1/1 2/2/1 3/3/1 -1/-1/-1", "/1 2/2 3/3 4/4").replace("vn 0 0 2\n", "");
        assert_eq!(decoded(&without_normals).unwrap(), mesh);
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (from, to, expected) in [
            ("v 1 0 0 1.0", "v 1 x 0", "line 3: a vertex needs numbers, found 'x'"),
            ("v 1 0 0 1.0", "v 1 0", "line 3: a vertex needs 3 numbers, found 2"),
            ("3/3/1", "9/3/1", "line 14: a face refers to vertex 9, but there are 4 so far"),
            ("3/3/1", "3//1", "line 14: the corner '3//1' has no texture coordinate"),
            ("3/3/1", "3/0/1", "line 14: a face refers to texture coordinate 0"),
            ("3/3/1", "/3/1", "line 14: the corner '/3/1' names no vertex"),
            (
                "-1/-1/-1",
                "-9223372036854775808/-1/-1",
                "line 14: a face refers to vertex -9223372036854775808",
            ),
            ("2/2/1 3/3/1", "", "line 14: a face needs at least 3 corners, found 2"),
            ("f 1", "g 1", "the mesh has no triangles"),
            ("v 0 0 0", "v inf 0 0", "not a number below 1e18"),
        ] {
            let error = decoded(&SQUARE.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(expected), "{from} -> {to}: {error}");
        }
    }

    #[test]
    fn no_truncation_panics() {
        for end in 0..SQUARE.len() {
            let _ = decoded(&SQUARE[..end]);
        }
    }

    #[test]
    fn lines_go_on_after_a_backslash_but_comments_and_names_do_not() {
        let mesh = decoded(SQUARE).unwrap();
        let continued = SQUARE.replace("v 1 1 0", "v 1 \\\r\n 1 \\ # half\n0").replace(" 3/3/1", "\\\n3/3/1");
        assert_eq!(decoded(&continued).unwrap(), mesh);
        let path = SQUARE.replace("# a square", "# C:\\shapes\\").replace("o name", "mtllib C:\\shapes\\");
        assert_eq!(decoded(&path).unwrap(), mesh);
        let error = decoded(&continued.replace("3/3/1", "9/3/1")).unwrap_err().to_string();
        assert!(error.starts_with("line 16:"), "{error}");
        assert!(decoded(&SQUARE.replace("# the only face", "\\")).is_ok());
        let endless = format!("{SQUARE}v 0 0 0 {}", "\\\n".repeat(300_000));
        assert!(decoded(&endless).is_ok());
    }

    #[test]
    fn a_byte_order_mark_other_encodings_and_other_line_ends_do_not_hurt() {
        let mesh = decoded(SQUARE).unwrap();
        let mut bytes = b"\xef\xbb\xbfv 0 0 0\r\n".to_vec();
        let rest =
            SQUARE.replace("# a square\nv 0 0 0\n", "").replace('\n', " \r\n").replace("v 1", "v\t1.0e0");
        bytes.extend(rest.replace("name", "na\u{e9}me").chars().map(|c| c as u8));
        bytes.extend(b"# Gr\xfc\xdfe");
        assert_eq!(decode(&bytes, &Job::default()).unwrap(), mesh);
    }

    #[test]
    fn colours_weights_and_third_coordinates_are_passed_over() {
        let mesh = decoded(SQUARE).unwrap();
        let more = SQUARE.replace("v 1 1 0", "v 1 1 0 0.5 0.25 1e-3").replace("vt 1 1", "vt 1 1 0.5");
        assert_eq!(decoded(&more).unwrap(), mesh);
        // A texture coordinate of one number lies on the lower edge; a normal that is none is computed.
        let fewer = SQUARE.replace("vt 1 0 0", "vt 1").replace("vn 0 0 2", "vn -nan(ind) 1.#QNAN 0");
        assert_eq!(decoded(&fewer).unwrap(), mesh);
    }

    #[test]
    fn a_concave_face_is_cut_without_leaving_it() {
        let arrow = "v -4 0 0\nv 4 -4 0\nv 0 0 0\nv 4 4 0\nvt 0 0\nf 2/1 3/1 4/1 1/1";
        let mesh = decoded(arrow).unwrap();
        assert_eq!(mesh.triangles().len(), 2);
        assert!(mesh.normals().iter().all(|n| n[2] > 0.99), "{:?}", mesh.normals());
    }
}
