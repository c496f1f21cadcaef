//! Blocks of BC7, by the encoder of the crate `block_compression` at its fastest setting.

use block_compression::encode::compress_rgba8;
use block_compression::{BC7Settings, CompressionVariant};
use rayon::prelude::*;

use crate::size::Size;

/// Texels along a side of a block.
const SIDE: usize = 4;
/// Bytes of a block.
const BLOCK_BYTES: usize = 16;

/// The blocks of a picture of four bytes a texel, row by row. Beyond the border its last texels are repeated.
pub(super) fn bc7(rgba: &[u8], size: Size, has_opacity: bool) -> Vec<u8> {
    let settings =
        if has_opacity { BC7Settings::alpha_ultrafast() } else { BC7Settings::opaque_ultra_fast() };
    let (columns, rows) = (size.width.div_ceil(SIDE), size.height.div_ceil(SIDE));
    let mut blocks = vec![0; columns * rows * BLOCK_BYTES];
    blocks.par_chunks_exact_mut(columns * BLOCK_BYTES).enumerate().for_each(|(row, out)| {
        let (strip, width) = (strip(rgba, size, row), (columns * SIDE) as u32);
        let variant = CompressionVariant::BC7(settings);
        compress_rgba8(variant, &strip, out, width, SIDE as u32, 4 * width);
    });
    blocks
}

/// The texels of a row of blocks, repeated at the border to whole blocks.
fn strip(rgba: &[u8], size: Size, row: usize) -> Vec<u8> {
    let width = size.width.next_multiple_of(SIDE);
    let mut out = Vec::with_capacity(4 * width * SIDE);
    for y in 0..SIDE {
        let line = &rgba[4 * size.width * (SIDE * row + y).min(size.height - 1)..][..4 * size.width];
        out.extend(line);
        (size.width..width).for_each(|_| out.extend(&line[line.len() - 4..]));
    }
    out
}
