//! The ZIP compression of EXR files ("OpenEXR File Layout", Academy Software Foundation): the even bytes of a block, then
//! the odd ones, as differences between neighbours, in a zlib stream (RFC 1950).
//!
//! Each stretch of the stream is written in the way that suits it: bytes without a pattern as they are, those of
//! photographs with a code of their frequencies, and those that repeat by zlib's search for matches.

use flate2::{Compress, Compression, FlushCompress};

use super::huffman::add_literals;

/// Bytes that are written in one way.
const STRETCH: usize = 1 << 18;

/// Bits a byte above which nothing is gained that is worth the time.
const RANDOM_BITS: f64 = 7.6;

/// Bits a byte below which bytes may repeat in sequences.
const REPETITIVE_BITS: f64 = 2.0;

/// The level of the search for matches, as that of the `exr` library.
const LEVEL: u32 = 4;

/// The most bytes of a stored block of deflate.
const STORED: usize = 65_535;

/// The bytes of a block, in little-endian samples, as a file of ZIP compression holds them: as they are where they would
/// not become fewer. `room` is memory that is used again for the next block.
pub(super) fn zip(block: &[u8], room: &mut Vec<u8>) -> Vec<u8> {
    room.resize(block.len(), 0);
    differences(block, room);
    let mut out = Vec::with_capacity(block.len() + STRETCH);
    out.extend_from_slice(&[0x78, 0x5e]);
    let mut search = Compress::new(Compression::new(LEVEL), false);
    for stretch in room.chunks(STRETCH) {
        add(stretch, &mut search, &mut out);
    }
    // The last block, empty and stored.
    out.extend_from_slice(&[1, 0, 0, 0xff, 0xff]);
    out.extend_from_slice(&simd_adler32::adler32(&room.as_slice()).to_be_bytes());
    if out.len() >= block.len() {
        out.clear();
        out.extend_from_slice(block);
    }
    out
}

/// Pairs of bytes that are taken apart at once.
const PAIRS: usize = 2048;

/// Even bytes, then odd ones, each as its difference to the one before, with 128 for none.
fn differences(block: &[u8], out: &mut [u8]) {
    let (even, odd) = out.split_at_mut(block.len().div_ceil(2));
    let last_even = block.len().checked_sub(1).map_or(0, |last| block[last & !1]);
    // The byte before the first, from which its difference is the byte itself.
    let mut before = [128, last_even];
    for ((block, even), odd) in block.chunks(2 * PAIRS).zip(even.chunks_mut(PAIRS)).zip(chunks_or_none(odd)) {
        for (k, out) in [even, odd].into_iter().enumerate() {
            let mut bytes = [0; PAIRS + 1];
            bytes[0] = before[k];
            let alternate = block.iter().skip(k).step_by(2);
            bytes[1..].iter_mut().zip(alternate).for_each(|(byte, from)| *byte = *from);
            before[k] = bytes[out.len()];
            let neighbours = bytes[1..].iter().zip(&bytes);
            out.iter_mut().zip(neighbours).for_each(|(out, (byte, before))| {
                *out = byte.wrapping_sub(*before).wrapping_add(128);
            });
        }
    }
}

/// The chunks of a half of a block, and an empty one where the other half has one more.
fn chunks_or_none(half: &mut [u8]) -> impl Iterator<Item = &mut [u8]> {
    half.chunks_mut(PAIRS).chain(std::iter::once_with(|| &mut [][..]))
}

/// Adds a stretch to a deflate stream that ends at a whole byte, and ends at one again.
fn add(bytes: &[u8], search: &mut Compress, out: &mut Vec<u8>) {
    let frequencies = frequencies(bytes);
    let most = frequencies.iter().max().copied().unwrap_or_default();
    let bits = entropy_bits(&frequencies, bytes.len());
    if bits < REPETITIVE_BITS || 2 * most as usize > bytes.len() {
        search.reset();
        add_matches(bytes, search, out);
    } else if bits < RANDOM_BITS {
        add_literals(bytes, &frequencies, out);
    } else {
        add_stored(bytes, out);
    }
}

fn add_matches(bytes: &[u8], search: &mut Compress, out: &mut Vec<u8>) {
    // Twice the size and the ends of blocks hold any result.
    out.reserve(2 * bytes.len() + 64);
    let before = search.total_in();
    search.compress_vec(bytes, out, FlushCompress::Sync).expect("deflate takes any bytes");
    assert_eq!(search.total_in() - before, bytes.len() as u64, "the room suffices");
}

fn add_stored(bytes: &[u8], out: &mut Vec<u8>) {
    for block in bytes.chunks(STORED) {
        let length = block.len() as u16;
        out.push(0);
        out.extend_from_slice(&length.to_le_bytes());
        out.extend_from_slice(&(!length).to_le_bytes());
        out.extend_from_slice(block);
    }
}

/// How often each byte occurs; counted in four tables, which do not wait for each other.
fn frequencies(bytes: &[u8]) -> [u32; 256] {
    let mut counts = [[0u32; 256]; 4];
    let (fours, rest) = bytes.as_chunks::<4>();
    for four in fours {
        (0..4).for_each(|k| counts[k][usize::from(four[k])] += 1);
    }
    rest.iter().for_each(|byte| counts[0][usize::from(*byte)] += 1);
    std::array::from_fn(|byte| counts.iter().map(|table| table[byte]).sum())
}

fn entropy_bits(frequencies: &[u32; 256], count: usize) -> f64 {
    let share = |n: &u32| f64::from(*n) / count as f64;
    frequencies.iter().filter(|n| **n > 0).map(|n| -share(n) * share(n).log2()).sum()
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    /// What a reader of ZIP compression makes of a file's bytes, after the file layout.
    fn unzip(bytes: &[u8]) -> Vec<u8> {
        let mut read = Vec::new();
        flate2::read::ZlibDecoder::new(bytes).read_to_end(&mut read).unwrap();
        for i in 1..read.len() {
            read[i] = read[i].wrapping_add(read[i - 1]).wrapping_sub(128);
        }
        let half = read.len().div_ceil(2);
        (0..read.len()).map(|i| if i % 2 == 0 { read[i / 2] } else { read[half + i / 2] }).collect()
    }

    /// Constant, smooth, noisy and repeating samples, so that every way of writing occurs.
    #[test]
    fn blocks_come_back_whatever_they_hold() {
        let mut stream = Stream::new(2, Purpose::Sample, [0]);
        for length in [16, 37, 1001, 2 * PAIRS, 2 * PAIRS + 1, 2 * PAIRS + 2, STRETCH + 5] {
            let mut noise = || (stream.unit() * 256.0) as usize;
            let kinds: [Vec<usize>; 5] = [
                vec![0; length],
                (0..length).map(|i| i / 7).collect(),
                (0..length).map(|i| if i % 2 == 0 { 7 } else { noise() / 32 }).collect(),
                (0..length).map(|i| [i % 11, noise()][i % 2]).collect(),
                (0..length).map(|i| (i % 13) * (i % 5)).collect(),
            ];
            for (kind, values) in kinds.iter().enumerate() {
                let block: Vec<u8> = values.iter().map(|v| *v as u8).collect();
                let file = zip(&block, &mut Vec::new());
                assert!(file.len() <= block.len());
                if file.len() < block.len() {
                    assert!(unzip(&file) == block, "{length} bytes of kind {kind}");
                } else {
                    assert!(file == block && length < 1000, "{length} bytes of kind {kind}");
                }
            }
        }
    }

    #[test]
    fn what_has_no_pattern_stays_as_it_is() {
        let mut stream = Stream::new(4, Purpose::Sample, [0]);
        let block: Vec<u8> = (0..10_000).map(|_| (stream.unit() * 256.0) as u8).collect();
        assert!(zip(&block, &mut Vec::new()) == block);
        assert!(zip(&[], &mut Vec::new()).is_empty());
    }
}
