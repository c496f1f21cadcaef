//! Progressive scans (ITU-T T.81, G.1.2): a band of coefficients at a time, first coarsely and then bit by bit.

use super::bits::ScanBits;
use super::huffman::HuffmanTable;
use super::sequential::difference;
use super::{RESTART, ScanCheck, ScanHead};

impl ScanCheck {
    pub(super) fn progressive(&mut self, head: &ScanHead, bits: &mut ScanBits<'_>) -> Option<()> {
        match (head.first, head.is_refinement) {
            (0, false) => {
                let tables: Vec<&HuffmanTable> =
                    head.parts.iter().map(|&(_, dc, _)| self.dc[dc].as_ref()).collect::<Option<_>>()?;
                self.blocks(head, bits, |bits, part, number| match number {
                    RESTART => Some(()),
                    _ => difference(tables[part], bits),
                })
            }
            (0, true) => self.blocks(head, bits, |bits, _, number| match number {
                RESTART => Some(()),
                _ => bits.skip(1),
            }),
            _ => self.band(head, bits),
        }
    }

    /// A band of one component, in which runs of blocks may end together.
    fn band(&mut self, head: &ScanHead, bits: &mut ScanBits<'_>) -> Option<()> {
        let [(_, _, table)] = head.parts[..] else { return None };
        // Taken out, since the walk over the blocks reads the rest of the state.
        let mut filled = std::mem::take(&mut self.filled);
        let table = self.ac[table].clone()?;
        let mut band = CoefficientBand { table, first: head.first, last: head.last, ended: 0 };
        let done = self.blocks(head, bits, |bits, _, number| {
            if number == RESTART {
                band.ended = 0;
                return Some(());
            }
            let filled = filled.get_mut(number)?;
            if head.is_refinement { band.refined(filled, bits) } else { band.coarse(filled, bits) }
        });
        self.filled = filled;
        done
    }
}

/// The state within a scan of a band.
struct CoefficientBand {
    table: HuffmanTable,
    first: u8,
    last: u8,
    /// The blocks from here on that have no further code.
    ended: u32,
}

impl CoefficientBand {
    /// The blocks of a run of ends, by the length of its number.
    fn run_of_ends(length: u32, bits: &mut ScanBits<'_>) -> Option<u32> {
        Some((1 << length) + if length == 0 { 0 } else { bits.take(length)? })
    }

    fn coarse(&mut self, filled: &mut u64, bits: &mut ScanBits<'_>) -> Option<()> {
        if self.ended > 0 {
            self.ended -= 1;
            return Some(());
        }
        let mut k = u32::from(self.first);
        while k <= u32::from(self.last) {
            let symbol = self.table.symbol(bits)?;
            let (run, length) = (u32::from(symbol >> 4), u32::from(symbol & 15));
            match (run, length) {
                (15, 0) => k += 16,
                (_, 0) => {
                    self.ended = Self::run_of_ends(run, bits)? - 1;
                    return Some(());
                }
                _ => {
                    k += run;
                    bits.skip(length)?;
                    *filled |= 1u64.checked_shl(k)?;
                    k += 1;
                }
            }
        }
        Some(())
    }

    fn refined(&mut self, filled: &mut u64, bits: &mut ScanBits<'_>) -> Option<()> {
        let mut k = u32::from(self.first);
        while self.ended == 0 && k <= u32::from(self.last) {
            let symbol = self.table.symbol(bits)?;
            let (run, length) = (u32::from(symbol >> 4), u32::from(symbol & 15));
            if length == 0 && run < 15 {
                self.ended = Self::run_of_ends(run, bits)?;
                break;
            }
            if length > 0 {
                bits.skip(1)?;
            }
            k = self.passed(k, run, filled, bits)?;
            if length > 0 && k <= u32::from(self.last) {
                *filled |= 1 << k;
            }
            k += 1;
        }
        if self.ended > 0 {
            let rest = *filled & Self::from(k) & !Self::from(u32::from(self.last) + 1);
            (0..rest.count_ones()).try_for_each(|_| bits.skip(1))?;
            self.ended -= 1;
        }
        Some(())
    }

    /// Passes over `run` zeros and the coefficients between them, which are corrected by a bit each; the place of the
    /// next zero.
    fn passed(&self, mut k: u32, mut run: u32, filled: &u64, bits: &mut ScanBits<'_>) -> Option<u32> {
        while k <= u32::from(self.last) {
            if filled >> k & 1 == 1 {
                bits.skip(1)?;
            } else if run == 0 {
                break;
            } else {
                run -= 1;
            }
            k += 1;
        }
        Some(k)
    }

    /// The coefficients from `k` on.
    fn from(k: u32) -> u64 {
        u64::MAX.checked_shl(k).unwrap_or(0)
    }
}
