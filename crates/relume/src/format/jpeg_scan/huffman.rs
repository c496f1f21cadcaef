//! Huffman tables (ITU-T T.81, annex C): codes of up to 16 bits, the shortest by look-up.

use super::bits::ScanBits;

/// Codes up to this length are looked up.
const LOOK_UP_BITS: u32 = 10;

/// A table of codes.
#[derive(Debug, Clone)]
pub(super) struct HuffmanTable {
    /// Length and symbol of the code that begins with these bits; length 0 where it is longer.
    short: Vec<(u8, u8)>,
    /// For each length the first code above it, as 16 bits, and what is added to a code for its place.
    limits: [(u32, i32); 17],
    symbols: Vec<u8>,
}

impl HuffmanTable {
    /// The first table of a segment: with its class (0 for DC), its number, and the bytes it takes.
    pub(super) fn parse(data: &[u8]) -> Option<(Self, usize, usize, usize)> {
        let (&head, rest) = data.split_first()?;
        let counts = rest.get(..16)?;
        let total: usize = counts.iter().map(|n| usize::from(*n)).sum();
        let symbols = rest.get(16..16 + total)?.to_vec();
        let (class, number) = (usize::from(head >> 4), usize::from(head & 15));
        if class > 1 || number > 3 {
            return None;
        }
        Some((Self::new(counts, symbols), class, number, 17 + total))
    }

    fn new(counts: &[u8], symbols: Vec<u8>) -> Self {
        let mut short = vec![(0, 0); 1 << LOOK_UP_BITS];
        let mut limits = [(0, 0); 17];
        let (mut code, mut place) = (0u32, 0usize);
        for length in 1..=16u32 {
            limits[length as usize].1 = place as i32 - code as i32;
            for _ in 0..counts[length as usize - 1] {
                if length <= LOOK_UP_BITS {
                    let first = (code as usize) << (LOOK_UP_BITS - length);
                    let last = first + (1 << (LOOK_UP_BITS - length));
                    let entry = (length as u8, symbols[place]);
                    // More codes than a length has bits for lie outside.
                    short.iter_mut().take(last).skip(first).for_each(|slot| *slot = entry);
                }
                code += 1;
                place += 1;
            }
            limits[length as usize].0 = code << (16 - length);
            code <<= 1;
        }
        Self { short, limits, symbols }
    }

    /// The next symbol; none where there is no code or the bits end.
    pub(super) fn symbol(&self, bits: &mut ScanBits<'_>) -> Option<u8> {
        let (length, symbol) = self.code(bits.peek())?;
        bits.skip(length)?;
        Some(symbol)
    }

    /// Length and symbol of the code with which 16 bits begin.
    pub(super) fn code(&self, next: u16) -> Option<(u32, u8)> {
        let (length, symbol) = self.short[usize::from(next >> (16 - LOOK_UP_BITS))];
        if length > 0 {
            return Some((u32::from(length), symbol));
        }
        let length =
            (LOOK_UP_BITS + 1..=16).find(|&length| u32::from(next) < self.limits[length as usize].0)?;
        let place = (u32::from(next) >> (16 - length)) as i32 + self.limits[length as usize].1;
        Some((length, *self.symbols.get(usize::try_from(place).ok()?)?))
    }
}
