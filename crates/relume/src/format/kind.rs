//! The kinds of files recognised by their first bytes: one row of [`KINDS`] each.

use std::fmt;

use super::foreign::{self, Foreign};
use super::hsh;
use crate::error::{Error, Result};

/// A kind of file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Ptm,
    Hsh,
    Exr,
    Png,
    Jpeg,
    Tiff,
    Pfm,
    Radiance,
    Rlm,
    Npy,
    Glb,
    Btf,
    Bsdf,
    Merl,
}

/// The contents of files of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Class {
    /// Texels: a picture, possibly with a record that gives it another meaning.
    Texels,
    Model,
    Array,
    Mesh,
    /// Images of pairs of light and view.
    Btf,
    /// A measured reflectance.
    Brdf,
}

/// First bytes, kind, name and class.
type Row = (&'static [u8], Kind, &'static str, Class);

/// The first bytes of a zip archive.
const ARCHIVE: &[u8] = b"PK\x03\x04";

/// All kinds of files with a signature.
const KINDS: [Row; 24] = [
    (b"PTM_", Kind::Ptm, "PTM", Class::Texels),
    // Old files of harmonics have comments of other words, or none.
    (b"#HSH", Kind::Hsh, "HSH", Class::Texels),
    (&[0x76, 0x2f, 0x31, 0x01], Kind::Exr, "EXR", Class::Texels),
    (b"\x89PNG\r\n\x1a\n", Kind::Png, "PNG", Class::Texels),
    (&[0xff, 0xd8, 0xff], Kind::Jpeg, "JPEG", Class::Texels),
    (b"II\x2a\0", Kind::Tiff, "TIFF", Class::Texels),
    (b"MM\0\x2a", Kind::Tiff, "TIFF", Class::Texels),
    // BigTIFF.
    (b"II\x2b\0", Kind::Tiff, "TIFF", Class::Texels),
    (b"MM\0\x2b", Kind::Tiff, "TIFF", Class::Texels),
    (b"PF\n", Kind::Pfm, "PFM", Class::Texels),
    (b"Pf\n", Kind::Pfm, "PFM", Class::Texels),
    (b"PF\r\n", Kind::Pfm, "PFM", Class::Texels),
    (b"Pf\r\n", Kind::Pfm, "PFM", Class::Texels),
    (b"#?", Kind::Radiance, "Radiance", Class::Texels),
    (b"RLM\x1a", Kind::Rlm, "RLM", Class::Model),
    (b"\x93NUMPY", Kind::Npy, "NPY", Class::Array),
    (b"glTF", Kind::Glb, "GLB", Class::Mesh),
    (b"!DFMF08FC", Kind::Btf, "BTF", Class::Btf),
    (b"!FMF12FCE", Kind::Btf, "BTF", Class::Btf),
    (b"!FMF06FC", Kind::Btf, "BTF", Class::Btf),
    (b"!PVF06FC", Kind::Btf, "BTF", Class::Btf),
    (b"!BDIF06R", Kind::Btf, "BTF", Class::Btf),
    (b"tensor_file\0", Kind::Bsdf, "BSDF", Class::Brdf),
    // The numbers of cells: 90, 90 and 180.
    (b"\x5a\0\0\0\x5a\0\0\0\xb4\0\0\0", Kind::Merl, "MERL", Class::Brdf),
];

impl Kind {
    /// The kind of file that begins like `bytes`, if any.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        let signed = KINDS.iter().find(|(signature, ..)| bytes.starts_with(signature)).map(|row| row.1);
        signed.or_else(|| hsh::is_hsh(bytes).then_some(Self::Hsh))
    }

    /// The kind of a file of texels.
    pub(super) fn of_texels(bytes: &[u8]) -> Result<Self> {
        let kind = Self::of(bytes).filter(|kind| kind.class() == Class::Texels);
        kind.ok_or_else(|| unknown(bytes))
    }

    fn row(self) -> &'static Row {
        KINDS.iter().find(|row| row.1 == self).expect("every kind has a row")
    }

    pub(super) fn name(self) -> &'static str {
        self.row().2
    }

    pub(super) fn class(self) -> Class {
        self.row().3
    }
}

/// The ending of the names by which sets of photographs under light and view are known, if a file begins like one.
pub fn set_ending(bytes: &[u8]) -> Option<&'static str> {
    match Kind::of(bytes) {
        Some(Kind::Btf) => Some("btf"),
        Some(Kind::Bsdf) => Some("bsdf"),
        Some(Kind::Merl) => Some("binary"),
        _ => bytes.starts_with(ARCHIVE).then_some("zip"),
    }
}

/// The error for bytes that are not a file of texels.
pub(super) fn unknown(bytes: &[u8]) -> Error {
    let mut names: Vec<&str> = KINDS.iter().filter(|row| row.3 == Class::Texels).map(|row| row.2).collect();
    names.dedup();
    let (last, others) = names.split_last().expect("there are kinds");
    let others = others.join(", ");
    if bytes.is_empty() {
        return Error::invalid(format!("the file is empty: expected {others} or {last}"));
    }
    if bytes.starts_with(ARCHIVE) {
        return of_light_and_view("a zip archive");
    }
    if let Some(Foreign { name, advice }) = foreign::of(bytes) {
        return Error::unsupported(format!("the file is {name}, which is not read: {advice}"));
    }
    let start: Vec<String> = bytes.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    Error::unsupported(format!(
        "the file is none of {others} and {last} (it begins with the bytes {}): convert it to one of these",
        start.join(" ")
    ))
}

/// The error for photographs under light and view, of which `what` says the form, where one texture of functions is expected.
pub fn of_light_and_view(what: impl fmt::Display) -> Error {
    Error::usage(format!(
        "is {what}: `relume fit` makes a texture of functions (.exr) of photographs under light and view, from a name that ends in \
         .zip, .btf, .binary, .bin or .bsdf, or a folder"
    ))
}

/// What is said of data that its decoder refuses, in place of the decoder's own words.
pub(super) fn damaged(kind: Kind) -> Error {
    Error::invalid(format!("the {} data is damaged or truncated: export the file again", kind.name()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_signature_begins_another() {
        for (i, a) in KINDS.iter().enumerate() {
            for (k, b) in KINDS.iter().enumerate() {
                assert!(i == k || !a.0.starts_with(b.0), "{} and {}", a.2, b.2);
            }
        }
    }
}
