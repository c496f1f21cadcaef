//! Several codes of a block at once: what the next bits of a sequential scan (ITU-T T.81, F.2.2.2) pass over.

use super::huffman::HuffmanTable;

/// The bits that are looked up.
const LOOK_UP_BITS: u32 = 12;

/// Whole codes, with the bits of their values.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct CodeRun {
    /// Zero where the first code is longer than the bits looked up.
    pub bits: u8,
    /// The coefficients they stand for, the last not zero, or sixteen zeros.
    pub coefficients: u8,
    /// Whether the last code ends the block.
    pub is_end: bool,
}

/// A run of codes for each beginning.
pub(super) struct BlockCodes(Vec<CodeRun>);

impl BlockCodes {
    pub(super) fn new(table: &HuffmanTable) -> Self {
        Self((0..1u16 << LOOK_UP_BITS).map(|beginning| run_of(table, beginning)).collect())
    }

    /// The codes with which the next 16 bits begin.
    pub(super) fn at(&self, next: u16) -> CodeRun {
        self.0[usize::from(next >> (16 - LOOK_UP_BITS))]
    }
}

fn run_of(table: &HuffmanTable, beginning: u16) -> CodeRun {
    let mut run = CodeRun::default();
    let mut known = LOOK_UP_BITS;
    let mut next = beginning << (16 - LOOK_UP_BITS);
    while let Some((length, symbol)) = table.code(next).filter(|(length, _)| *length <= known) {
        let (zeros, value_bits) = (symbol >> 4, u32::from(symbol & 15));
        if usize::from(run.coefficients) + usize::from(zeros) + 1 >= 64 {
            break;
        }
        run.bits += (length + value_bits) as u8;
        match (zeros, value_bits) {
            (0..15, 0) => {
                run.is_end = true;
                break;
            }
            _ => run.coefficients += zeros + 1,
        }
        let Some(left) = known.checked_sub(length + value_bits).filter(|left| *left > 0) else { break };
        known = left;
        next <<= length + value_bits;
    }
    run
}
