//! Numbers as bits, most significant first, and an adaptive Rice code for small integers.
//!
//! The code is that of JPEG-LS (Weinberger, Seroussi, Sapiro, "The LOCO-I Lossless Image Compression
//! Algorithm", IEEE Trans. Image Processing 9, 2000): numbers 0, -1, 1, -2, 2 ... are folded to 0, 1, 2, 3, 4
//! ..., the k low bits are written verbatim and the remainder in unary as zeros and a one, with k derived
//! from the mean of the previous numbers.

use crate::error::{Error, Result};

/// The number of zeros after which a number is written verbatim in [`PLAIN`] bits.
const ESCAPE: u32 = 24;

/// The bits of a number written verbatim: codes are at most 2^20 in magnitude.
const PLAIN: u32 = 22;

/// The running mean that determines k.
#[derive(Debug, Clone)]
pub(super) struct Rice {
    sum: u32,
    count: u32,
}

impl Rice {
    pub(super) fn new() -> Self {
        Self { sum: 4, count: 1 }
    }

    fn low_bits(&self) -> u32 {
        (0..PLAIN).find(|k| self.count << k >= self.sum).unwrap_or(PLAIN)
    }

    fn learn(&mut self, folded: u32) {
        self.sum += folded;
        self.count += 1;
        if self.count == 32 {
            self.sum = self.sum.div_ceil(2);
            self.count = 16;
        }
    }
}

/// Bits to bytes; the last byte is padded with zeros.
#[derive(Debug, Default)]
pub(super) struct BitWriter {
    bytes: Vec<u8>,
    used: u32,
}

impl BitWriter {
    /// The low `count` bits of a number.
    pub(super) fn bits(&mut self, value: u32, count: u32) {
        for i in (0..count).rev() {
            if self.used.is_multiple_of(8) {
                self.bytes.push(0);
            }
            let last = self.bytes.len() - 1;
            self.bytes[last] |= ((value >> i & 1) as u8) << (7 - self.used % 8);
            self.used += 1;
        }
    }

    pub(super) fn float(&mut self, value: f32) {
        self.bits(value.to_bits(), 32);
    }

    pub(super) fn half(&mut self, value: f32) {
        self.bits(u32::from(half::f16::from_f32(value).to_bits()), 16);
    }

    pub(super) fn rice(&mut self, value: i32, state: &mut Rice) {
        let folded = ((value << 1) ^ (value >> 31)) as u32;
        let k = state.low_bits();
        if folded >> k < ESCAPE {
            self.bits(0, folded >> k);
            self.bits(1, 1);
            self.bits(folded, k);
        } else {
            self.bits(0, ESCAPE);
            self.bits(folded, PLAIN);
        }
        state.learn(folded);
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

/// Bytes to bits.
#[derive(Debug)]
pub(super) struct BitReader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> BitReader<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0 }
    }

    pub(super) fn bits(&mut self, count: u32) -> Result<u32> {
        let mut value = 0;
        for _ in 0..count {
            let byte = self.bytes.get(self.at / 8).ok_or_else(|| {
                Error::invalid(format!("the model ends inside its numbers, after {} bits", self.at))
            })?;
            value = value << 1 | u32::from(byte >> (7 - self.at % 8) & 1);
            self.at += 1;
        }
        Ok(value)
    }

    /// The number of bits left.
    pub(super) fn left(&self) -> usize {
        8 * self.bytes.len() - self.at
    }

    /// A finite float.
    pub(super) fn float(&mut self, what: &str) -> Result<f32> {
        finite(f32::from_bits(self.bits(32)?), what)
    }

    /// A finite half.
    pub(super) fn half(&mut self, what: &str) -> Result<f32> {
        finite(half::f16::from_bits(self.bits(16)? as u16).to_f32(), what)
    }

    pub(super) fn rice(&mut self, state: &mut Rice) -> Result<i32> {
        let k = state.low_bits();
        let mut zeros = 0;
        while zeros < ESCAPE && self.bits(1)? == 0 {
            zeros += 1;
        }
        let folded = if zeros == ESCAPE { self.bits(PLAIN)? } else { zeros << k | self.bits(k)? };
        state.learn(folded);
        Ok((folded >> 1) as i32 ^ -((folded & 1) as i32))
    }
}

fn finite(value: f32, what: &str) -> Result<f32> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(Error::invalid(format!("the model's {what} is {value}: expected a finite number")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_come_back(values in prop::collection::vec((-(1i32 << 20)..=1 << 20, 0u32..21), 0..90)) {
            let values: Vec<i32> = values.into_iter().map(|(v, shift)| v >> shift).collect();
            let (mut writer, mut state) = (BitWriter::default(), Rice::new());
            writer.bits(5, 3);
            values.iter().for_each(|&v| writer.rice(v, &mut state));
            writer.float(-0.7);
            writer.half(0.25);
            let bytes = writer.into_bytes();
            let (mut reader, mut state) = (BitReader::new(&bytes), Rice::new());
            prop_assert_eq!(reader.bits(3).unwrap(), 5);
            for v in values {
                prop_assert_eq!(reader.rice(&mut state).unwrap(), v);
            }
            prop_assert_eq!(reader.float("number").unwrap(), -0.7);
            prop_assert_eq!(reader.half("number").unwrap(), 0.25);
            prop_assert!(reader.left() < 8);
            prop_assert!(reader.bits(8).is_err());
        }
    }

    #[test]
    fn small_numbers_take_few_bits() {
        let (mut writer, mut state) = (BitWriter::default(), Rice::new());
        (0..800).for_each(|i| writer.rice([0, 1, -1, 0][i % 4], &mut state));
        assert!(writer.into_bytes().len() <= 250);
    }
}
