//! Tensor files: named arrays of numbers at given places of a file.

use half::f16;

use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;

/// What a tensor file begins with.
const SIGNATURE: &[u8] = b"tensor_file\0";

/// The most dimensions of an array that are read.
const MOST_DIMENSIONS: usize = 8;

/// The bytes of the longest name of an array.
const LONGEST_NAME: usize = 64;

/// The arrays of a file.
pub(super) struct TensorFile<'a> {
    bytes: &'a [u8],
    fields: Vec<TensorField<'a>>,
}

/// An array: its name, the type of its numbers, the first byte, and the sizes, the last index fastest.
pub(super) struct TensorField<'a> {
    name: &'a str,
    kind: u8,
    data: &'a [u8],
    pub(super) shape: Vec<usize>,
}

impl<'a> TensorFile<'a> {
    /// Reads the table of arrays and checks that all lie inside the file.
    pub(super) fn read(bytes: &'a [u8]) -> Result<Self> {
        let mut at = SIGNATURE.len();
        let version = take(bytes, &mut at, 2)?;
        if version != [1, 0] {
            return Err(Error::unsupported(format!(
                "version {}.{} of tensor files is not read: expected 1.0",
                version[0], version[1]
            )));
        }
        let count = number(take(bytes, &mut at, 4)?);
        let mut file = Self { bytes, fields: Vec::new() };
        // No more than the file has room for: each takes 13 bytes at least.
        if count > bytes.len() as u64 / 13 {
            return Err(truncated(bytes));
        }
        for _ in 0..count {
            let field = file.field_at(&mut at)?;
            file.fields.push(field);
        }
        Ok(file)
    }

    fn field_at(&self, at: &mut usize) -> Result<TensorField<'a>> {
        let bytes = self.bytes;
        let length = number(take(bytes, at, 2)?) as usize;
        let name = std::str::from_utf8(take(bytes, at, length)?).ok();
        let name = name.filter(|name| name.len() <= LONGEST_NAME && !name.chars().any(char::is_control));
        let name = name.ok_or_else(|| {
            Error::invalid(format!(
                "the name of an array in the tensor file is not a text of at most {LONGEST_NAME} bytes: it is damaged"
            ))
        })?;
        let dimensions = number(take(bytes, at, 2)?) as usize;
        let kind = take(bytes, at, 1)?[0];
        let offset = number(take(bytes, at, 8)?);
        let size = size_of_kind(kind).filter(|_| dimensions <= MOST_DIMENSIONS);
        let size = size.ok_or_else(|| {
            Error::invalid(format!(
                "array '{name}' of the tensor file has {dimensions} dimensions and type {kind}: it is damaged"
            ))
        })?;
        let (mut shape, mut length) = (Vec::with_capacity(dimensions), Some(size));
        for _ in 0..dimensions {
            let side = usize::try_from(number(take(bytes, at, 8)?)).ok();
            length = length.zip(side).and_then(|(length, side)| length.checked_mul(side));
            shape.push(side.unwrap_or(usize::MAX));
        }
        let start = usize::try_from(offset).ok();
        let range = start.zip(length).and_then(|(start, length)| Some(start..start.checked_add(length)?));
        let data = range.and_then(|range| bytes.get(range)).ok_or_else(|| {
            Error::invalid(format!(
                "array '{name}' of the tensor file, of shape {shape:?} from byte {offset} on, does not lie inside its \
                 {} bytes: it is damaged or truncated",
                bytes.len()
            ))
        })?;
        Ok(TensorField { name, kind, data, shape })
    }

    /// The array of a name, if there is one.
    pub(super) fn find(&self, name: &str) -> Option<&TensorField<'a>> {
        self.fields.iter().find(|field| field.name == name)
    }

    /// The array of a name with a number of dimensions.
    pub(super) fn field(&self, name: &str, dimensions: usize) -> Result<&TensorField<'a>> {
        let field = self.find(name).ok_or_else(|| {
            Error::invalid(format!(
                "the tensor file has no array '{name}': a measured BRDF has phi_i, theta_i, ndf, sigma, vndf, jacobian, \
                 and rgb or spectra"
            ))
        })?;
        if field.shape.len() != dimensions {
            return Err(Error::invalid(format!(
                "array '{name}' of the tensor file has the shape {:?}: expected {dimensions} dimensions",
                field.shape
            )));
        }
        Ok(field)
    }
}

impl TensorField<'_> {
    /// The numbers of an array of floats.
    pub(super) fn floats(&self, job: &Job) -> Result<Vec<f32>> {
        let size = size_of_kind(self.kind).unwrap_or(1);
        let count = self.data.len() / size;
        job.check_bytes("the tables of the BRDF", 4 * count as u64)?;
        let mut numbers = memory::with_capacity("the tables of the BRDF", count)?;
        match self.kind {
            9 => numbers.extend(self.data.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b).to_f32())),
            10 => numbers.extend(self.data.as_chunks().0.iter().map(|b| f32::from_le_bytes(*b))),
            11 => numbers.extend(self.data.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b) as f32)),
            kind => {
                return Err(Error::invalid(format!(
                    "array '{}' of the tensor file has numbers of type {kind}: expected floats (9, 10, 11)",
                    self.name
                )));
            }
        }
        Ok(numbers)
    }

    /// Whether the array holds a byte that is not 0.
    pub(super) fn is_set(&self) -> bool {
        self.data.iter().any(|byte| *byte != 0)
    }
}

fn size_of_kind(kind: u8) -> Option<usize> {
    Some(match kind {
        1 | 2 => 1,
        3 | 4 | 9 => 2,
        5 | 6 | 10 => 4,
        7 | 8 | 11 => 8,
        _ => return None,
    })
}

/// The next bytes of the table.
fn take<'a>(bytes: &'a [u8], at: &mut usize, count: usize) -> Result<&'a [u8]> {
    let taken = bytes.get(*at..).and_then(|rest| rest.get(..count)).ok_or_else(|| truncated(bytes))?;
    *at += count;
    Ok(taken)
}

fn truncated(bytes: &[u8]) -> Error {
    Error::invalid(format!(
        "the tensor file ends at byte {} inside its table of arrays: it is truncated",
        bytes.len()
    ))
}

/// A little-endian number of up to eight bytes.
fn number(bytes: &[u8]) -> u64 {
    bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte))
}
