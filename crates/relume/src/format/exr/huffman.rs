//! Bytes as literals of a deflate stream (RFC 1951), each with the code of its frequency and without matches.
//!
//! The differences of the samples of photographs repeat no sequences, so a search for them finds little and takes most of
//! the time of a compressor. On 116 photographs of a surface as halves, the upper bytes take 47 % of their size so, and
//! 51 % with matches searched at zlib's level 6.

/// The longest code. Four codes and the seven bits before them fit into 64 bits; deflate allows 15.
const LONGEST: u32 = 14;

/// The symbols of the code of literals: bytes, and the end of a block.
const SYMBOLS: usize = 257;

/// The bits of the head of a block: its kind, the numbers of codes, the lengths of the code of lengths, and the lengths.
const HEAD_BITS: usize = 3 + 14 + 19 * 3 + 4 * (SYMBOLS + 1);

/// Adds bytes, at least one, to a deflate stream that ends at a whole byte, and ends at one again.
pub(super) fn add_literals(bytes: &[u8], frequencies: &[u32; 256], out: &mut Vec<u8>) {
    assert!(!bytes.is_empty(), "a code needs two symbols, and one is the end");
    let mut counts = [1u32; SYMBOLS];
    counts[..256].copy_from_slice(frequencies);
    let lengths = lengths_of(&counts);
    let codes = codes_of(&lengths);
    let bits: u64 = counts.iter().zip(&lengths).map(|(n, length)| u64::from(*n) * u64::from(*length)).sum();
    let mut writer = LiteralWriter::new(out, HEAD_BITS + bits as usize + 16);
    write_head(&lengths, &mut writer);
    let (fours, rest) = bytes.as_chunks::<4>();
    for four in fours {
        four.iter().for_each(|byte| writer.push(codes[usize::from(*byte)]));
        writer.settle();
    }
    for byte in rest {
        writer.push(codes[usize::from(*byte)]);
        writer.settle();
    }
    writer.push(codes[256]);
    writer.settle();
    // An empty stored block ends at a whole byte.
    writer.push(LiteralCode { bits: 0, length: 3 });
    writer.finish();
    out.extend_from_slice(&[0, 0, 0xff, 0xff]);
}

/// A code, whose first bit is the lowest.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct LiteralCode {
    bits: u32,
    length: u32,
}

/// The lengths of an optimal prefix code (Huffman, "A Method for the Construction of Minimum-Redundancy Codes", 1952), of
/// halved counts where it would be too long; 0 for symbols that do not occur.
fn lengths_of(counts: &[u32; SYMBOLS]) -> [u32; SYMBOLS] {
    let mut counts = *counts;
    loop {
        let lengths = unlimited_lengths(&counts);
        if lengths.iter().all(|length| *length <= LONGEST) {
            return lengths;
        }
        counts.iter_mut().filter(|n| **n > 0).for_each(|n| *n = n.div_ceil(2));
    }
}

fn unlimited_lengths(counts: &[u32; SYMBOLS]) -> [u32; SYMBOLS] {
    use std::cmp::Reverse;
    use std::collections::BinaryHeap;
    let mut parents = [0usize; 2 * SYMBOLS];
    let leaves = (0..SYMBOLS).filter(|s| counts[*s] > 0).map(|s| Reverse((u64::from(counts[s]), s)));
    let mut heap: BinaryHeap<_> = leaves.collect();
    let mut next = SYMBOLS;
    while let (Some(Reverse((a, first))), Some(Reverse((b, second)))) = (heap.pop(), heap.pop()) {
        (parents[first], parents[second]) = (next, next);
        heap.push(Reverse((a + b, next)));
        if heap.len() == 1 {
            break;
        }
        next += 1;
    }
    let root = next;
    let depth = |symbol: usize| {
        let ancestors = std::iter::successors(Some(symbol), |node| Some(parents[*node]));
        ancestors.take_while(|node| *node != root).count() as u32
    };
    std::array::from_fn(|s| if counts[s] > 0 { depth(s) } else { 0 })
}

/// The codes of lengths (RFC 1951, 3.2.2), with the bits in the order in which they are written.
fn codes_of(lengths: &[u32; SYMBOLS]) -> [LiteralCode; SYMBOLS] {
    let mut codes = [LiteralCode::default(); SYMBOLS];
    let mut next = 0u32;
    for length in 1..=LONGEST {
        next <<= 1;
        for symbol in (0..SYMBOLS).filter(|s| lengths[*s] == length) {
            codes[symbol] = LiteralCode { bits: next.reverse_bits() >> (32 - length), length };
            next += 1;
        }
    }
    codes
}

/// The head of a block of dynamic codes: lengths are codes of four bits each, and no distance occurs.
fn write_head(lengths: &[u32; SYMBOLS], writer: &mut LiteralWriter) {
    let mut put = |bits: u32, length: u32| {
        writer.push(LiteralCode { bits, length });
        writer.settle();
    };
    put(0b100, 3);
    // 257 literals, one distance, 19 lengths of codes.
    put(0, 5);
    put(0, 5);
    put(15, 4);
    // In the order 16, 17, 18, 0, 8, 7, ...: repetitions are not used.
    (0..19).for_each(|k| put(if k < 3 { 0 } else { 4 }, 3));
    let distance = 1;
    for length in lengths.iter().chain([&distance]) {
        put(length.reverse_bits() >> 28, 4);
    }
}

/// Bits in whole bytes, the first the lowest.
struct LiteralWriter<'a> {
    out: &'a mut Vec<u8>,
    at: usize,
    held: u64,
    count: u32,
}

impl<'a> LiteralWriter<'a> {
    /// Room for so many bits more.
    fn new(out: &'a mut Vec<u8>, bits: usize) -> Self {
        let at = out.len();
        out.resize(at + bits.div_ceil(8) + 16, 0);
        Self { out, at, held: 0, count: 0 }
    }

    /// Holds a code; four fit between two calls of [`Self::settle`].
    fn push(&mut self, code: LiteralCode) {
        self.held |= u64::from(code.bits) << self.count;
        self.count += code.length;
    }

    /// Writes the whole bytes.
    fn settle(&mut self) {
        self.out[self.at..self.at + 8].copy_from_slice(&self.held.to_le_bytes());
        let whole = self.count / 8;
        self.at += whole as usize;
        self.held >>= 8 * whole;
        self.count -= 8 * whole;
    }

    /// Writes what is left, filled up with zeros.
    fn finish(mut self) {
        self.settle();
        self.out.truncate(self.at + usize::from(self.count > 0));
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    fn frequencies(bytes: &[u8]) -> [u32; 256] {
        let mut counts = [0; 256];
        bytes.iter().for_each(|byte| counts[usize::from(*byte)] += 1);
        counts
    }

    fn round_trip(bytes: &[u8]) -> usize {
        let mut stream = Vec::new();
        add_literals(bytes, &frequencies(bytes), &mut stream);
        let length = stream.len();
        stream.extend_from_slice(&[1, 0, 0, 0xff, 0xff]);
        let mut read = Vec::new();
        flate2::read::DeflateDecoder::new(&*stream).read_to_end(&mut read).unwrap();
        assert!(read == bytes, "flate2, {} bytes", bytes.len());
        length
    }

    #[test]
    fn bytes_come_back_whatever_their_frequencies() {
        let mut stream = crate::numeric::random::Stream::new(1, crate::numeric::random::Purpose::Sample, [0]);
        for length in [1, 2, 3, 4, 5, 255, 9000] {
            for power in [1, 8, 60] {
                let byte = |u: f64| (255.0 * u.powi(power)) as u8;
                let bytes: Vec<u8> = (0..length).map(|_| byte(stream.unit())).collect();
                round_trip(&bytes);
            }
        }
        round_trip(&[7; 1000]);
    }

    /// Counts as Fibonacci's numbers have the deepest of all trees.
    #[test]
    fn codes_are_never_too_long() {
        let mut counts = [0u32; SYMBOLS];
        let (mut a, mut b) = (1u32, 1u32);
        for count in counts.iter_mut().take(40) {
            *count = a;
            (a, b) = (b, a + b);
        }
        assert!(unlimited_lengths(&counts).into_iter().max() > Some(LONGEST));
        let lengths = lengths_of(&counts);
        let kraft: f64 = lengths.iter().filter(|l| **l > 0).map(|l| 0.5f64.powi(*l as i32)).sum();
        assert!(lengths.iter().all(|l| *l <= LONGEST) && kraft == 1.0, "{kraft}");
    }

    #[test]
    fn sizes_are_near_the_entropy() {
        let bytes: Vec<u8> = (0..65_536u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 28) as u8).collect();
        let length = round_trip(&bytes);
        assert!((32_768..33_500).contains(&length), "{length} bytes for 65536 of 4 bits each");
    }
}
