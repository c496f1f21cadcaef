//! Wavefront OBJ (Wavefront Technologies, "Advanced Visualizer Manual", 1991, appendix B1): vertices, texture
//! coordinates, normals and polygons. Everything else (groups, materials, lines, free-form surfaces) is
//! ignored. Polygons are split into fans, which is correct for convex ones.

use std::collections::BTreeMap;

use super::Parts;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::render::Mesh;

/// The indices of a corner from 0: position, texture coordinate, normal.
type Corner = (usize, usize, Option<usize>);

#[derive(Default)]
struct Reader {
    positions: Vec<[f32; 3]>,
    texcoords: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    vertices: BTreeMap<Corner, u32>,
    parts: Parts,
}

pub(super) fn decode(bytes: &[u8], job: &Job) -> Result<Mesh> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| Error::unsupported("the file is neither binary glTF nor the text of an OBJ file"))?;
    let mut reader = Reader::default();
    for (index, line) in text.lines().enumerate() {
        let read = reader.line(line).and_then(|()| reader.parts.check(job));
        read.map_err(|e| Error::new(e.kind(), format!("line {}: {}", index + 1, e.message())))?;
    }
    reader.parts.into_mesh()
}

impl Reader {
    fn line(&mut self, line: &str) -> Result<()> {
        let mut words = line.split('#').next().unwrap_or_default().split_whitespace();
        match words.next() {
            Some("v") => self.positions.push(numbers("a vertex", words)?),
            Some("vt") => self.texcoords.push(numbers("a texture coordinate", words)?),
            Some("vn") => self.normals.push(numbers("a normal", words)?),
            Some("f") => self.face(words)?,
            _ => {}
        }
        Ok(())
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a str>) -> Result<()> {
        let corners: Vec<u32> = words.map(|word| self.corner(word)).collect::<Result<_>>()?;
        if corners.len() < 3 {
            return Err(Error::invalid(format!("a face needs at least 3 corners, found {}", corners.len())));
        }
        let fan = corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]);
        self.parts.triangles.extend(fan);
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

/// The first `N` numbers of a line.
fn numbers<'a, const N: usize>(what: &str, words: impl Iterator<Item = &'a str>) -> Result<[f32; N]> {
    let found: Vec<f32> = words.take(N).map_while(|word| word.parse().ok()).collect();
    found
        .try_into()
        .map_err(|found: Vec<f32>| Error::invalid(format!("{what} needs {N} numbers, found {}", found.len())))
}

/// An index from 0; OBJ counts from 1, or backwards from the end with negative numbers.
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
            ("v 1 0 0 1.0", "v 1 x 0", "line 3: a vertex needs 3 numbers, found 1"),
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
            ("v 0 0 0", "v inf 0 0", "not a finite number"),
        ] {
            let error = decoded(&SQUARE.replace(from, to)).unwrap_err().to_string();
            assert!(error.contains(expected), "{from} -> {to}: {error}");
        }
        assert!(decode(&[0xff, 0xfe, 0], &Job::default()).is_err());
    }

    #[test]
    fn no_truncation_panics() {
        for end in 0..SQUARE.len() {
            let _ = decoded(&SQUARE[..end]);
        }
    }
}
