//! The adaptive binary range coder: bits as a fraction of a range.
//!
//! G. N. N. Martin, "Range Encoding: an Algorithm for Removing Redundancy from a Digitised Message" (1979),
//! for binary decisions, each with its own adaptive [`Chance`]. The range is 32 bits wide and shifts by a
//! byte whenever it becomes narrower than 2^24; a carry propagates back through the bytes held for it.
//!
//! A decoder that reads past the end reads zeros and continues; [`Decoder::read`] reveals it.

/// The range is extended when it is narrower than this.
const NARROW: u32 = 1 << 24;

/// The most updates that a chance counts: older outcomes are forgotten.
const MEMORY: u16 = 60;

/// The least probability of an outcome, in 65536ths.
const RAREST: u16 = 128;

/// The probability that a decision is 0, in 65536ths.
#[derive(Debug, Clone, Copy)]
pub struct Chance {
    zero: u16,
    seen: u16,
}

impl Default for Chance {
    fn default() -> Self {
        Self { zero: 1 << 15, seen: 0 }
    }
}

impl Chance {
    /// The part of a range that represents 0.
    fn bound(self, range: u32) -> u32 {
        (range >> 16) * u32::from(self.zero.clamp(RAREST, u16::MAX - RAREST))
    }

    /// Moves by 1 / (n + 2) of the difference after n decisions.
    fn learn(&mut self, bit: bool) {
        let target = if bit { 0 } else { i32::from(u16::MAX) };
        let zero = i32::from(self.zero);
        self.zero = (zero + (target - zero) / i32::from(self.seen + 2)) as u16;
        self.seen = (self.seen + 1).min(MEMORY);
    }
}

/// Decisions to bytes.
#[derive(Debug)]
pub struct Encoder {
    low: u64,
    range: u32,
    /// The byte that a carry may still raise, and the number of bytes of 255 held behind it.
    held: Option<u8>,
    waiting: usize,
    bytes: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Self {
        Self { low: 0, range: u32::MAX, held: None, waiting: 0, bytes: Vec::new() }
    }
}

impl Encoder {
    /// Encodes a decision.
    pub fn put(&mut self, bit: bool, chance: &mut Chance) {
        let bound = chance.bound(self.range);
        if bit {
            self.low += u64::from(bound);
            self.range -= bound;
        } else {
            self.range = bound;
        }
        chance.learn(bit);
        while self.range < NARROW {
            self.shift();
            self.range <<= 8;
        }
    }

    /// Outputs the highest byte of the lower end of the range.
    fn shift(&mut self) {
        let carry = self.low >> 32 != 0;
        if carry || self.low < 0xff00_0000 {
            let raised = |byte: u8| byte.wrapping_add(u8::from(carry));
            self.bytes.extend(self.held.map(raised));
            self.bytes.extend(std::iter::repeat_n(raised(0xff), self.waiting));
            self.waiting = 0;
            self.held = Some((self.low >> 24) as u8);
        } else {
            self.waiting += 1;
        }
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    /// The bytes: exactly as many as a decoder reads.
    pub fn into_bytes(mut self) -> Vec<u8> {
        (0..5).for_each(|_| self.shift());
        self.bytes
    }
}

/// Bytes to decisions.
#[derive(Debug)]
pub struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
    code: u32,
    range: u32,
}

impl<'a> Decoder<'a> {
    /// Begins to read.
    pub fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self { bytes, at: 0, code: 0, range: u32::MAX };
        (0..4).for_each(|_| decoder.shift());
        decoder
    }

    fn shift(&mut self) {
        self.code = self.code << 8 | u32::from(self.bytes.get(self.at).copied().unwrap_or(0));
        self.at += 1;
    }

    /// The next decision.
    pub fn get(&mut self, chance: &mut Chance) -> bool {
        let bound = chance.bound(self.range);
        let bit = self.code >= bound;
        if bit {
            self.code -= bound;
            self.range -= bound;
        } else {
            self.range = bound;
        }
        chance.learn(bit);
        while self.range < NARROW {
            self.shift();
            self.range <<= 8;
        }
        bit
    }

    /// The number of bytes read, those past the end included; after the last decision, the length of the
    /// code.
    pub fn read(&self) -> usize {
        self.at
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    fn coded(bits: &[(bool, usize)]) -> Vec<u8> {
        let (mut encoder, mut chances) = (Encoder::default(), [Chance::default(); 4]);
        bits.iter().for_each(|&(bit, c)| encoder.put(bit, &mut chances[c]));
        encoder.into_bytes()
    }

    proptest! {
        #[test]
        fn decisions_come_back(bits in prop::collection::vec((any::<bool>(), 0usize..4), 0..600), rare: bool) {
            // Long runs drive chances to their limits, where carries are longest.
            let bits: Vec<(bool, usize)> = bits.iter().flat_map(|&(bit, c)| vec![(bit, c); if rare { 40 } else { 1 }]).collect();
            let bytes = coded(&bits);
            let (mut decoder, mut chances) = (Decoder::new(&bytes), [Chance::default(); 4]);
            for (bit, c) in bits {
                prop_assert_eq!(decoder.get(&mut chances[c]), bit);
            }
            prop_assert_eq!(decoder.read(), bytes.len());
        }
    }

    #[test]
    fn rare_decisions_take_little_more_than_their_entropy() {
        let mut stream = Stream::new(3, Purpose::Sample, [0]);
        let bits: Vec<(bool, usize)> = (0..80_000).map(|_| (stream.unit() < 0.05, 0)).collect();
        let entropy = 80_000.0 / 8.0 * -(0.05 * 0.05f64.log2() + 0.95 * 0.95f64.log2());
        let bytes = coded(&bits).len() as f64;
        assert!(bytes > 0.97 * entropy && bytes < 1.03 * entropy, "{bytes} of {entropy}");
    }
}
