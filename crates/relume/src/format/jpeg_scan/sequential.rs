//! Sequential scans (ITU-T T.81, F.2.2): the coefficients of a block one after another.

use super::bits::ScanBits;
use super::block_codes::BlockCodes;
use super::huffman::HuffmanTable;
use super::{RESTART, ScanCheck, ScanHead};

impl ScanCheck {
    pub(super) fn sequential(&self, head: &ScanHead, bits: &mut ScanBits<'_>) -> Option<()> {
        let tables = head.parts.iter().map(|&(_, dc, ac)| {
            let ac = self.ac[ac].as_ref()?;
            Some((self.dc[dc].as_ref()?, ac, BlockCodes::new(ac)))
        });
        let tables: Vec<(&HuffmanTable, &HuffmanTable, BlockCodes)> = tables.collect::<Option<_>>()?;
        self.blocks(head, bits, |bits, part, number| {
            if number == RESTART {
                return Some(());
            }
            let (dc, ac, codes) = &tables[part];
            difference(dc, bits)?;
            coefficients(ac, codes, bits)
        })
    }
}

/// Follows the coefficients after the first, several codes at once where all of them are within the block.
fn coefficients(table: &HuffmanTable, codes: &BlockCodes, bits: &mut ScanBits<'_>) -> Option<()> {
    let mut k = 1;
    while k < 64 {
        let run = codes.at(bits.peek());
        if run.bits > 0 && k + usize::from(run.coefficients) < 64 {
            bits.skip(u32::from(run.bits))?;
            k += usize::from(run.coefficients);
            if run.is_end {
                return Some(());
            }
            continue;
        }
        k = one_code(table, k, bits)?;
    }
    (k == 64).then_some(())
}

/// Follows one code: the place of the next coefficient, which is 64 at the end of a block.
fn one_code(table: &HuffmanTable, k: usize, bits: &mut ScanBits<'_>) -> Option<usize> {
    let symbol = table.symbol(bits)?;
    match (usize::from(symbol >> 4), u32::from(symbol & 15)) {
        (15, 0) => Some(k + 16),
        (_, 0) => Some(64),
        (run, length) => bits.skip(length).map(|()| k + run + 1),
    }
}

/// Follows the first coefficient of a block, a difference of so many bits.
pub(super) fn difference(table: &HuffmanTable, bits: &mut ScanBits<'_>) -> Option<()> {
    let length = table.symbol(bits)?;
    bits.skip(u32::from(length.min(16)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    /// A table in which codes of all lengths from 2 to 16 occur.
    fn table() -> HuffmanTable {
        let counts = [0, 1, 1, 2, 2, 2, 3, 3, 4, 4, 4, 5, 5, 6, 6, 9];
        let total: u8 = counts.iter().sum();
        let symbols = (0..total).map(|i| match i {
            0 => 0x00,
            1 => 0x01,
            2 => 0xf0,
            _ => (i.wrapping_mul(37) % 0xfb) | 1,
        });
        let data: Vec<u8> = [0x10].into_iter().chain(counts).chain(symbols).collect();
        HuffmanTable::parse(&data).unwrap().0
    }

    #[test]
    fn several_codes_at_once_pass_over_the_bits_of_one_after_another() {
        let (table, mut random) = (table(), Stream::new(6, Purpose::Sample, [0]));
        let (codes, mut ends) = (BlockCodes::new(&table), 0);
        for length in 1..400 {
            let bytes: Vec<u8> = (0..length % 40 + 1).map(|_| random.below(255) as u8).collect();
            let (mut fast, mut slow) = (ScanBits::new(&bytes, 0), ScanBits::new(&bytes, 0));
            let found = coefficients(&table, &codes, &mut fast);
            let mut k = Some(1);
            while let Some(at) = k.filter(|k| *k < 64) {
                k = one_code(&table, at, &mut slow);
            }
            assert_eq!(found.is_some(), k == Some(64), "{length}");
            if found.is_some() {
                assert_eq!(fast.taken(), slow.taken(), "{length}");
                ends += 1;
            }
        }
        assert!(ends > 20, "{ends} whole blocks");
    }
}
