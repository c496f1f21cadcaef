//! Hemispherical harmonics in bytes: the `.rti` files of RTI viewers, and the older `.hsh`.
//!
//! Every term has a scale and a bias common to all channels: value = byte / 255 * scale + bias, with white at 1. Rows
//! run from the top. Values are those of the photographs, sRGB-encoded by convention. No file made by others was at
//! hand: what is read and written follows descriptions and the code of other readers.

mod header;
mod pictures;
mod read;
mod write;

use serde::Serialize;
use serde::ser::Serializer;

pub(super) use header::is_hsh;
pub(super) use pictures::pictures;
pub(super) use read::decode;
pub(super) use write::{encode_hsh, encode_rti};

/// The most terms of a file: five bands.
const MOST_TERMS: usize = 25;

/// Scale and bias of each term.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HshEncoding {
    terms: usize,
    scale: [f32; MOST_TERMS],
    bias: [f32; MOST_TERMS],
}

impl HshEncoding {
    pub(super) fn new(scale: &[f32], bias: &[f32]) -> Self {
        let filled = |numbers: &[f32]| {
            let mut out = [0.0; MOST_TERMS];
            out[..numbers.len()].copy_from_slice(numbers);
            out
        };
        Self { terms: scale.len(), scale: filled(scale), bias: filled(bias) }
    }

    /// The range of values of each term.
    pub fn scale(&self) -> &[f32] {
        &self.scale[..self.terms]
    }

    /// The value of byte 0 of each term.
    pub fn bias(&self) -> &[f32] {
        &self.bias[..self.terms]
    }

    /// The value of a byte.
    pub(super) fn value(&self, term: usize, byte: u8) -> f32 {
        (f64::from(byte) / 255.0 * f64::from(self.scale[term]) + f64::from(self.bias[term])) as f32
    }

    /// The nearest byte of a value.
    fn byte(&self, term: usize, value: f32) -> u8 {
        let scale = f64::from(self.scale[term]);
        if scale == 0.0 {
            return 0;
        }
        super::ptm::nearest_byte((f64::from(value) - f64::from(self.bias[term])) * 255.0 / scale)
    }
}

/// As two lists of numbers.
impl Serialize for HshEncoding {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut out = serializer.serialize_struct("HshEncoding", 2)?;
        out.serialize_field("scale", self.scale())?;
        out.serialize_field("bias", self.bias())?;
        out.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn every_byte_comes_back_under_any_scale_and_bias() {
        let mut random = Stream::new(6, Purpose::Sample, [0]);
        for _ in 0..2000 {
            let scale = (10f64.powf(8.0 * random.unit() - 6.0)) as f32;
            let bias = (scale as f64 * 40.0 * (random.unit() - 0.5)) as f32;
            let encoding = HshEncoding::new(&[1.0, scale], &[0.0, bias]);
            for byte in 0..=255 {
                assert_eq!(encoding.byte(1, encoding.value(1, byte)), byte, "scale {scale:e}, bias {bias:e}");
            }
        }
        let constant = HshEncoding::new(&[0.0], &[0.3]);
        assert_eq!((constant.byte(0, 0.3), constant.value(0, 0)), (0, 0.3));
    }
}
