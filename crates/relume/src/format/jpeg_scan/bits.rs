//! The bits of a scan (ITU-T T.81, F.2.2.5): a zero byte follows each byte of ones, and markers end the data.

/// Bits from the highest of each byte on.
pub(super) struct ScanBits<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The next bits, the first in the highest place.
    held: u64,
    count: u32,
}

impl<'a> ScanBits<'a> {
    pub(super) fn new(bytes: &'a [u8], at: usize) -> Self {
        Self { bytes, at, held: 0, count: 0 }
    }

    /// The byte after those taken.
    pub(super) fn position(&self) -> usize {
        self.at
    }

    /// The bits taken so far.
    #[cfg(test)]
    pub(super) fn taken(&self) -> usize {
        8 * self.at - self.count as usize
    }

    fn fill(&mut self) {
        // Eight bytes at once where none of them is all ones, so that no marker is among them.
        if let Some(next) = self.bytes.get(self.at..).and_then(<[u8]>::first_chunk) {
            let next = u64::from_be_bytes(*next);
            if self.count <= 56 && !has_byte_of_ones(next) {
                let taken = (64 - self.count) / 8;
                self.held |= next >> self.count;
                self.count += 8 * taken;
                // What follows the whole bytes comes again.
                self.held &= u64::MAX << (64 - self.count);
                self.at += taken as usize;
                return;
            }
        }
        while self.count <= 56 {
            let Some(&byte) = self.bytes.get(self.at) else { return };
            if byte == 0xff {
                if self.bytes.get(self.at + 1) != Some(&0) {
                    return;
                }
                self.at += 1;
            }
            self.at += 1;
            self.held |= u64::from(byte) << (56 - self.count);
            self.count += 8;
        }
    }

    /// The next 16 bits, with zeros after the last.
    pub(super) fn peek(&mut self) -> u16 {
        if self.count < 32 {
            self.fill();
        }
        (self.held >> 48) as u16
    }

    /// Takes bits, at most 32; none if there are not so many.
    pub(super) fn skip(&mut self, count: u32) -> Option<()> {
        if self.count < count {
            self.fill();
        }
        self.count = self.count.checked_sub(count)?;
        self.held <<= count;
        Some(())
    }

    /// The number of at most 16 bits.
    pub(super) fn take(&mut self, count: u32) -> Option<u32> {
        let value = u32::from(self.peek()) >> (16 - count);
        self.skip(count)?;
        Some(value)
    }

    /// Goes on after the next restart marker, which has to follow the bits of the last byte.
    pub(super) fn restart(&mut self) -> Option<()> {
        self.fill();
        if self.count >= 8 {
            return None;
        }
        while self.bytes.get(self.at..self.at + 2)? == [0xff, 0xff] {
            self.at += 1;
        }
        let marker = self.bytes.get(self.at..self.at + 2)?;
        if marker[0] != 0xff || !(0xd0..=0xd7).contains(&marker[1]) {
            return None;
        }
        *self = Self { bytes: self.bytes, at: self.at + 2, held: 0, count: 0 };
        Some(())
    }
}

/// Whether a byte of a word is 255: adding one to its lower seven bits reaches the eighth, which is set already.
fn has_byte_of_ones(word: u64) -> bool {
    const LOW: u64 = 0x7f7f_7f7f_7f7f_7f7f;
    ((word & LOW) + (!LOW >> 7)) & word & !LOW != 0
}
