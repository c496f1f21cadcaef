//! What a file holds, told by its bytes.

use std::fmt;

use super::kind::{Class, Kind};
use super::tile_set::Said;
use super::whole::HEAD_BYTES;
use super::{brdf, exr, foreign, height};
use crate::error::Result;

/// The content of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Content {
    /// Colours or greys.
    Picture,
    /// A texture of functions.
    Field,
    /// A texture of tiles stacked one below the other.
    Tiles,
    /// Heights with a recorded scale.
    Heights,
    /// A random-field model.
    Model,
    /// An array of numbers, such as a source map.
    Array,
    /// Triangles.
    Mesh,
    /// A texture of light and view, as images of pairs of directions.
    Btf,
    /// A measured reflectance.
    Brdf,
    /// A light file, or a folder of photographs.
    Capture,
    /// None of these.
    Unknown,
}

impl fmt::Display for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Picture => "a picture",
            Self::Field => "a texture of functions",
            Self::Tiles => "a set of tiles",
            Self::Heights => "a height map",
            Self::Model => "a random-field model",
            Self::Array => "an array of numbers",
            Self::Mesh => "a mesh",
            Self::Btf => "a texture of light and view (BTF)",
            Self::Brdf => "a measured reflectance (BRDF)",
            Self::Capture => "a capture of photographs under known lights",
            Self::Unknown => "of an unknown kind",
        })
    }
}

/// Whether the first bytes of a file are those of a kind that is read.
pub(super) fn is_known(head: &[u8]) -> bool {
    Kind::of(head).is_some() || content_of_text(head) != Content::Unknown
}

/// The content of a file, and what it says of the tiles it holds.
pub(super) fn content(bytes: &[u8]) -> Result<(Content, Option<Said>)> {
    let Some(kind) = Kind::of(bytes) else {
        let content = if brdf::is_utia(bytes) { Content::Brdf } else { content_of_text(bytes) };
        return Ok((content, None));
    };
    let content = match kind.class() {
        Class::Model => Content::Model,
        Class::Array => Content::Array,
        Class::Mesh => Content::Mesh,
        Class::Btf => Content::Btf,
        Class::Brdf => Content::Brdf,
        Class::Texels if matches!(kind, Kind::Ptm | Kind::Hsh) => Content::Field,
        Class::Texels => {
            // A header that cannot be read is reported where the file is decoded.
            let head = if kind == Kind::Exr { exr::head(bytes).ok() } else { None };
            if let Some((_, texts)) = &head
                && let Some(tiles) = exr::tiles_of(texts)?
            {
                let (count, cells, corners) = tiles;
                return Ok((Content::Tiles, Some(Said { count, cells, corners, stamp: None })));
            }
            match head {
                Some((names, texts)) if exr::is_field(&names, &texts) => Content::Field,
                _ if height::is_recorded(bytes) => Content::Heights,
                _ => Content::Picture,
            }
        }
    };
    Ok((content, None))
}

/// Text formats have no signature: a light file begins with a number, and a line of an OBJ file with a
/// vertex.
fn content_of_text(bytes: &[u8]) -> Content {
    if foreign::of(bytes).is_some() {
        return Content::Unknown;
    }
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(HEAD_BYTES)]);
    let mut lines = start.lines().map(str::trim).filter(|line| !line.is_empty());
    let counted = lines.next().is_some_and(|line| line.parse::<u32>().is_ok());
    let placed = |line: &str| {
        let mut numbers = line.split_whitespace().rev().take(3).map(|word| word.parse::<f64>().is_ok());
        line.split_whitespace().count() >= 4 && numbers.all(|is_number| is_number)
    };
    if counted && lines.next().is_some_and(placed) {
        return Content::Capture;
    }
    match start.lines().any(|line| line.trim_start().starts_with("v ")) {
        true => Content::Mesh,
        false => Content::Unknown,
    }
}
