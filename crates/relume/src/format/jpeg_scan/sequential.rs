//! Sequential scans (ITU-T T.81, F.2.2): the coefficients of a block one after another.

use super::bits::ScanBits;
use super::huffman::HuffmanTable;
use super::{RESTART, ScanCheck, ScanHead};

impl ScanCheck {
    pub(super) fn sequential(&self, head: &ScanHead, bits: &mut ScanBits<'_>) -> Option<()> {
        let tables =
            head.parts.iter().map(|&(_, dc, ac)| Some((self.dc[dc].as_ref()?, self.ac[ac].as_ref()?)));
        let tables: Vec<(&HuffmanTable, &HuffmanTable)> = tables.collect::<Option<_>>()?;
        self.blocks(head, bits, |bits, part, number| {
            if number == RESTART {
                return Some(());
            }
            let (dc, ac) = tables[part];
            difference(dc, bits)?;
            coefficients(ac, bits)
        })
    }
}

/// Follows the coefficients after the first.
fn coefficients(table: &HuffmanTable, bits: &mut ScanBits<'_>) -> Option<()> {
    let mut k = 1;
    while k < 64 {
        let symbol = table.symbol(bits)?;
        let (run, length) = (usize::from(symbol >> 4), u32::from(symbol & 15));
        match (run, length) {
            (15, 0) => k += 16,
            (_, 0) => return Some(()),
            _ => {
                k += run + 1;
                bits.skip(length)?;
            }
        }
    }
    (k == 64).then_some(())
}

/// Follows the first coefficient of a block, a difference of so many bits.
pub(super) fn difference(table: &HuffmanTable, bits: &mut ScanBits<'_>) -> Option<()> {
    let length = table.symbol(bits)?;
    bits.skip(u32::from(length.min(16)))
}
