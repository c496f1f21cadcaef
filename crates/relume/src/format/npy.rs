//! NumPy arrays: of `i32`, shape (height, width, components), the file format of a source map; and written only, of
//! floats and texts.
//!
//! Version 1.0 of the format (NumPy Enhancement Proposal 1, 2007): magic, version, the length of a
//! Python dictionary, the dictionary padded to a multiple of 64 bytes, then little-endian numbers,
//! the last index fastest. Rows run from the top.

use crate::error::{Error, Result};
use crate::job::Job;
use crate::size::Size;

const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";

/// An array of `i32` values for each texel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Array {
    /// Width and height.
    pub size: Size,
    /// Values per texel.
    pub components: usize,
    /// All values, those of a texel adjacent, rows from the top.
    pub values: Vec<i32>,
}

/// The bytes of a `.npy` file of `components` values per texel; see [`Array`] for the order.
///
/// # Errors
/// When the number of values does not match the shape.
pub fn encode_i32(size: Size, components: usize, values: &[i32]) -> Result<Vec<u8>> {
    let Size { width, height } = size;
    if values.len() != size.texels() * components {
        return Err(Error::invalid(format!(
            "an array of shape ({height}, {width}, {components}) cannot hold {} values",
            values.len()
        )));
    }
    let shape = [height, width, components];
    Ok(file("<i4", &shape, values.iter().flat_map(|value| value.to_le_bytes())))
}

/// The bytes of a `.npy` file of 32-bit floats.
///
/// # Errors
/// When the number of values does not match the shape.
pub fn encode_f32(shape: &[usize], values: &[f32]) -> Result<Vec<u8>> {
    if values.len() != shape.iter().product::<usize>() {
        return Err(Error::invalid(format!(
            "an array of shape {shape:?} cannot hold {} values",
            values.len()
        )));
    }
    Ok(file("<f4", shape, values.iter().flat_map(|value| value.to_le_bytes())))
}

/// The bytes of a `.npy` file of 64-bit floats, by rows of three.
pub(super) fn encode_vectors(vectors: &[[f64; 3]]) -> Vec<u8> {
    file("<f8", &[vectors.len(), 3], vectors.iter().flatten().flat_map(|value| value.to_le_bytes()))
}

/// The bytes of a `.npy` file of texts: a list, or one alone.
pub(super) fn encode_texts(texts: &[String], is_list: bool) -> Vec<u8> {
    let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
    let padded = texts.iter().flat_map(|text| {
        text.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest).flat_map(u32::to_le_bytes)
    });
    let shape = if is_list { vec![texts.len()] } else { Vec::new() };
    file(&format!("<U{longest}"), &shape, padded)
}

fn file(kind: &str, shape: &[usize], data: impl Iterator<Item = u8>) -> Vec<u8> {
    let sides: Vec<String> = shape.iter().map(usize::to_string).collect();
    // A tuple of one has a comma.
    let sides = sides.join(", ") + if shape.len() == 1 { "," } else { "" };
    let mut dictionary = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({sides}), }}");
    let unpadded = MAGIC.len() + 2 + dictionary.len() + 1;
    dictionary.extend(std::iter::repeat_n(' ', unpadded.next_multiple_of(64) - unpadded));
    dictionary.push('\n');
    let mut out = Vec::with_capacity(MAGIC.len() + 2 + dictionary.len() + data.size_hint().0);
    out.extend_from_slice(MAGIC);
    // A few numbers of at most twenty digits: the dictionary is far below 64 KiB.
    out.extend_from_slice(&(dictionary.len() as u16).to_le_bytes());
    out.extend_from_slice(dictionary.as_bytes());
    out.extend(data);
    out
}

/// Reads the files of [`encode_i32`], and those of other programs: the keys of the dictionary may be in any
/// order.
///
/// # Errors
/// Other versions, types and shapes; truncated or surplus bytes; sizes over the limits.
pub fn decode_i32(bytes: &[u8], job: &Job) -> Result<Array> {
    let rest = bytes
        .strip_prefix(MAGIC)
        .ok_or_else(|| Error::unsupported("this is not a NumPy array file of version 1.0"))?;
    let (length, rest) = rest.split_first_chunk().ok_or_else(|| truncated(bytes))?;
    let (dictionary, data) =
        rest.split_at_checked(usize::from(u16::from_le_bytes(*length))).ok_or_else(|| truncated(bytes))?;
    let dictionary = String::from_utf8_lossy(dictionary);
    for (key, expected) in [("descr", "'<i4'"), ("fortran_order", "False")] {
        let found = entry(&dictionary, key)?;
        if !found.starts_with(expected) {
            return Err(Error::unsupported(format!(
                "the array does not have {key} {expected}, the only supported value"
            )));
        }
    }
    let (size, components) = shape(entry(&dictionary, "shape")?)?;
    job.check("the array", size, (components as u64).saturating_mul(4))?;
    let expected = size.texels() * components * 4;
    if data.len() != expected {
        return Err(Error::invalid(format!(
            "the array's shape needs {expected} bytes after its header, found {}",
            data.len()
        )));
    }
    let values = data.chunks_exact(4).map(|b| i32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    Ok(Array { size, components, values })
}

fn truncated(bytes: &[u8]) -> Error {
    Error::invalid(format!("the array file ends at byte {} inside its header", bytes.len()))
}

/// The text after `'key':` in the dictionary.
fn entry<'a>(dictionary: &'a str, key: &str) -> Result<&'a str> {
    let after = dictionary.split_once(&format!("'{key}'")).and_then(|(_, rest)| rest.split_once(':'));
    after
        .map(|(_, value)| value.trim_start())
        .ok_or_else(|| Error::invalid(format!("the array's header has no entry '{key}'")))
}

fn shape(text: &str) -> Result<(Size, usize)> {
    let inner = text.strip_prefix('(').and_then(|t| t.split_once(')')).map(|(inner, _)| inner);
    let sides: Option<Vec<usize>> = inner.and_then(|t| t.split(',').map(|n| n.trim().parse().ok()).collect());
    match sides.as_deref() {
        Some(&[height, width, components]) => Ok((Size::new(width, height), components)),
        _ => Err(Error::invalid(
            "the array's shape is not three whole numbers (height, width, components)".to_owned(),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_come_back_and_the_header_is_as_the_format_says() {
        let size = Size::new(3, 2);
        let values: Vec<i32> = (0..12).map(|i| i * 1_000_003 - 5).collect();
        let bytes = encode_i32(size, 2, &values).unwrap();
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        assert_eq!(&bytes[10..72], b"{'descr': '<i4', 'fortran_order': False, 'shape': (2, 3, 2), }");
        assert_eq!((bytes[127], &bytes[128..132]), (b'\n', &(-5i32).to_le_bytes()[..]));
        assert_eq!(decode_i32(&bytes, &Job::default()).unwrap(), Array { size, components: 2, values });
    }

    #[test]
    fn broken_arrays_are_refused() {
        let bytes = encode_i32(Size::new(2, 2), 1, &[1, 2, 3, 4]).unwrap();
        for length in 0..bytes.len() {
            assert!(decode_i32(&bytes[..length], &Job::default()).is_err(), "{length}");
        }
        let text = |from: &str, to: &str| {
            let header = String::from_utf8_lossy(&bytes[10..128]).replace(from, to);
            let mut changed = bytes[..10].to_vec();
            changed.extend_from_slice(&header.as_bytes()[..118]);
            changed.extend_from_slice(&bytes[128..]);
            decode_i32(&changed, &Job::default())
        };
        assert!(text("zzz", "zzz").is_ok());
        assert!(text("<i4", ">i4").is_err());
        assert!(text("False", "True ").is_err());
        assert!(text("(2, 2, 1), }      ", "(999999, 999999, 999999), }").is_err());
        assert!(text("(2, 2, 1)", "(2, 2)   ").is_err());
        assert!(encode_i32(Size::new(2, 2), 1, &[1]).is_err());
    }

    #[test]
    fn a_shape_that_promises_more_than_the_file_holds_is_refused_before_memory_is_taken() {
        let with_shape = |shape: &str| {
            let mut dictionary = format!("{{'descr': '<i4', 'fortran_order': False, 'shape': {shape}, }}");
            dictionary.extend(std::iter::repeat_n(' ', 117 - dictionary.len()));
            [MAGIC, &118u16.to_le_bytes(), dictionary.as_bytes(), b"\n", &[0; 16]].concat()
        };
        let message = |shape: &str| decode_i32(&with_shape(shape), &Job::default()).unwrap_err().to_string();
        assert!(message("(131072, 131072, 3)").contains("of memory"), "{}", message("(131072, 131072, 3)"));
        assert!(message("(1, 1, 18446744073709551615)").contains("of memory"));
        assert!(message("(18446744073709551615, 1, 1)").contains("longest side"));
        assert!(message("(100, 100, 3)").contains("needs 120000 bytes after its header, found 16"));
        assert!(decode_i32(&with_shape("(1, 1, 4)"), &Job::default()).is_ok());
    }
}
