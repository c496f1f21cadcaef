//! Blocks of BC7: all in mode 6, then those that it serves worst by the encoder of the crate `block_compression`, which
//! divides blocks in parts, where that is nearer.
//!
//! Division is what takes time: a tenth of the blocks at most are tried, so that a texture of noise takes about as
//! long as one of smooth colours.

use super::mode6::{self, BlockTexels, squared_distance};
use crate::parallel;
use crate::size::Size;
use block_compression::decode::decompress_blocks_as_rgba8;
use block_compression::encode::compress_rgba8;
use block_compression::{BC7Settings, CompressionVariant};

/// Texels along a side of a block.
const SIDE: usize = 4;
/// Bytes of a block.
const BLOCK_BYTES: usize = 16;
/// One in so many blocks is tried again.
const TRIED_AGAIN: usize = 10;
/// The sum of squared errors from which a block is tried again: about two codes in each of three channels of a texel.
const HARD: u32 = 200;
/// Blocks that are tried together.
const TOGETHER: usize = 64;

/// The blocks of a picture of four bytes a texel, row by row. Beyond the border its last texels are repeated.
pub(super) fn bc7(rgba: &[u8], size: Size, has_opacity: bool) -> Vec<u8> {
    let (columns, rows) = (size.width.div_ceil(SIDE), size.height.div_ceil(SIDE));
    let mut blocks = vec![0; columns * rows * BLOCK_BYTES];
    let mut errors = vec![0; columns * rows];
    let in_rows = blocks.chunks_exact_mut(columns * BLOCK_BYTES).zip(errors.chunks_exact_mut(columns));
    parallel::for_each(in_rows.enumerate(), |(row, (blocks, errors))| {
        for (column, (block, error)) in blocks.chunks_exact_mut(BLOCK_BYTES).zip(errors).enumerate() {
            let (bytes, squares) = mode6::encode(&texels(rgba, size, column, row));
            block.copy_from_slice(&bytes);
            *error = squares;
        }
    });
    let again = |group: &[usize]| -> Vec<(usize, [u8; BLOCK_BYTES])> {
        let of: Vec<BlockTexels> =
            group.iter().map(|b| texels(rgba, size, b % columns, b / columns)).collect();
        let found = group.iter().zip(divided(&of, has_opacity));
        found.filter(|(b, (_, error))| *error < errors[**b]).map(|(&b, (bytes, _))| (b, bytes)).collect()
    };
    let better = parallel::map(hardest(&errors).chunks(TOGETHER), again);
    for (b, bytes) in better.into_iter().flatten() {
        blocks[b * BLOCK_BYTES..(b + 1) * BLOCK_BYTES].copy_from_slice(&bytes);
    }
    blocks
}

/// The texels of a block, repeated at the border.
fn texels(rgba: &[u8], size: Size, column: usize, row: usize) -> BlockTexels {
    std::array::from_fn(|i| {
        let (x, y) =
            ((SIDE * column + i % SIDE).min(size.width - 1), (SIDE * row + i / SIDE).min(size.height - 1));
        std::array::from_fn(|c| rgba[4 * (y * size.width + x) + c])
    })
}

/// The blocks with the largest errors, in their order, if these are large at all.
fn hardest(errors: &[u32]) -> Vec<usize> {
    let mut sorted = errors.to_vec();
    let place = errors.len() - errors.len().div_ceil(TRIED_AGAIN);
    let least = (*sorted.select_nth_unstable(place).1).max(HARD);
    (0..errors.len())
        .filter(|&block| errors[block] >= least)
        .take(errors.len().div_ceil(TRIED_AGAIN))
        .collect()
}

/// Blocks by the crate's encoder at its fastest setting, and their squared errors.
fn divided(blocks: &[BlockTexels], has_opacity: bool) -> Vec<([u8; BLOCK_BYTES], u32)> {
    let settings =
        if has_opacity { BC7Settings::alpha_ultrafast() } else { BC7Settings::opaque_ultra_fast() };
    let variant = CompressionVariant::BC7(settings);
    let width = (SIDE * blocks.len()) as u32;
    let row = |y: usize| {
        blocks.iter().flat_map(move |block| block[SIDE * y..SIDE * (y + 1)].iter().flatten().copied())
    };
    let strip: Vec<u8> = (0..SIDE).flat_map(row).collect();
    let mut coded = vec![0; BLOCK_BYTES * blocks.len()];
    compress_rgba8(variant, &strip, &mut coded, width, SIDE as u32, 4 * width);
    let coded =
        coded.chunks_exact(BLOCK_BYTES).map(|bytes| <[u8; BLOCK_BYTES]>::try_from(bytes).expect("a block"));
    let mut back = [0; 4 * SIDE * SIDE];
    let with_error = |(bytes, block): ([u8; BLOCK_BYTES], &BlockTexels)| {
        decompress_blocks_as_rgba8(variant, SIDE as u32, SIDE as u32, &bytes, &mut back);
        let found = back.chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2], texel[3]]);
        (bytes, block.iter().zip(found).map(|(a, b)| squared_distance(*a, b)).sum())
    };
    coded.zip(blocks).map(with_error).collect()
}
