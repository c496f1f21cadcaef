//! Writing an EXR file block by block, in rows or in tiles, from samples copied in by a callback. Only a few
//! blocks are kept at a time, and the table of their offsets.

use std::io::{BufWriter, Read, Seek, SeekFrom, Write};

use ::exr::block::BlockIndex;
use ::exr::block::chunk::{
    Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates,
};
use ::exr::block::writer::{ChunkWriter, ChunksWriter, write_chunks_with};
use ::exr::error::UnitResult;
use ::exr::math::RoundingMode;
use ::exr::meta::attribute::{ChannelDescription, LevelMode, TileDescription};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{AttributeValue, Compression, LayerAttributes, LineOrder, SampleType, Text, Vec2};

use super::blocks::Head;
use super::zip::zip;
use super::{ExrDepth, attributes};
use crate::error::{Error, Result};
use crate::format::rows::Rows;
use crate::parallel;
use crate::size::Size;

/// Writes a file of `size` texels. `rows(channel, x, y, row)` copies the bytes of samples, the lowest
/// first, from column `x` of row `y` on.
pub(in crate::format) fn write_blocks(
    head: &Head<'_>,
    size: Size,
    mut out: impl Read + Write + Seek,
    rows: &mut Rows<'_>,
) -> Result<()> {
    let header = header(head, size)?;
    let channels = head.names.len();
    let mut failure = None;
    let mut fill = |index: &BlockIndex, data: &mut Vec<u8>| -> UnitResult {
        let (Vec2(x, y), Vec2(width, height)) = (index.pixel_position, index.pixel_size);
        let line = width * head.depth.bytes();
        data.resize(height * channels * line, 0);
        for (number, row) in data.chunks_exact_mut(line).enumerate() {
            let copied = rows(number % channels, x, y + number / channels, row);
            copied.map_err(|error| {
                failure = Some(error);
                ::exr::error::Error::Aborted
            })?;
        }
        Ok(())
    };
    let write = |meta: MetaData, chunks: &mut ChunkWriter<_>| -> UnitResult {
        let places: Vec<_> = ::exr::block::enumerate_ordered_header_block_indices(&meta.headers).collect();
        // Memory of blocks is used again: pages that the system gives anew take longer than what is written into them.
        let mut blocks = vec![BlockMemory::default(); rayon::current_num_threads().min(places.len())];
        for places in places.chunks(blocks.len().max(1)) {
            for ((_, index), block) in places.iter().zip(&mut blocks) {
                fill(index, &mut block.samples)?;
            }
            let filled = blocks[..places.len()].iter_mut();
            let zipped = parallel::map(filled, |block| zip(&block.samples, &mut block.room));
            for ((at, index), bytes) in places.iter().zip(zipped) {
                chunks.write_chunk(*at, chunk(&meta.headers[0], index, bytes))?;
            }
        }
        Ok(())
    };
    let written = write_chunks_with(BufWriter::new(&mut out), std::iter::once(header).collect(), true, write);
    written.map_err(|error| {
        failure.take().unwrap_or_else(|| match error {
            ::exr::error::Error::Io(error) => Error::io("cannot write the EXR file", &error),
            _ => Error::limit("an EXR file cannot hold a picture of this size: write a smaller one"),
        })
    })?;
    sort_attributes(&mut out, &head.texts).map_err(|e| Error::io("cannot write the EXR file", &e))
}

/// The samples of a block, and room to compress them.
#[derive(Debug, Clone, Default)]
struct BlockMemory {
    samples: Vec<u8>,
    room: Vec<u8>,
}

/// A compressed block at its place.
fn chunk(header: &Header, index: &BlockIndex, compressed_pixels_le: Vec<u8>) -> Chunk {
    let compressed_block = match header.blocks {
        BlockDescription::ScanLines => CompressedBlock::ScanLine(CompressedScanLineBlock {
            y_coordinate: i32::try_from(index.pixel_position.y()).expect("a row that the header allows"),
            compressed_pixels_le,
        }),
        BlockDescription::Tiles(_) => CompressedBlock::Tile(CompressedTileBlock {
            coordinates: TileCoordinates {
                tile_index: index.pixel_position / header.max_block_pixel_size(),
                level_index: index.level,
            },
            compressed_pixels_le,
        }),
    };
    Chunk { layer_index: index.layer, compressed_block }
}

fn header(head: &Head<'_>, size: Size) -> Result<Header> {
    let kind = match head.depth {
        ExrDepth::Half => SampleType::F16,
        ExrDepth::Float => SampleType::F32,
    };
    let channels: Result<_> =
        head.names.iter().map(|name| Ok(ChannelDescription::named(text(name)?, kind))).collect();
    let mut attributes = LayerAttributes::default();
    for (name, value) in &head.texts {
        attributes.other.insert(text(name)?, AttributeValue::Text(text(value)?));
    }
    let blocks = head.tile.map_or(BlockDescription::ScanLines, |tile| {
        BlockDescription::Tiles(TileDescription {
            tile_size: Vec2(tile.width, tile.height),
            level_mode: LevelMode::Singular,
            rounding_mode: RoundingMode::Down,
        })
    });
    Ok(Header::new(Text::default(), (size.width, size.height), channels?)
        .with_encoding(Compression::ZIP16, blocks, LineOrder::Increasing)
        .with_attributes(attributes))
}

/// Sorts the attributes at the head of a file. They take little more than their texts.
fn sort_attributes(out: &mut (impl Read + Write + Seek), texts: &[(&str, String)]) -> std::io::Result<()> {
    const STANDARD: u64 = 1 << 16;
    let length =
        STANDARD + texts.iter().map(|(name, value)| 64 + name.len() + value.len()).sum::<usize>() as u64;
    let mut head = Vec::new();
    out.seek(SeekFrom::Start(0))?;
    Read::by_ref(out).take(length).read_to_end(&mut head)?;
    attributes::sort(&mut head);
    out.seek(SeekFrom::Start(0))?;
    out.write_all(&head)
}

fn text(value: &str) -> Result<Text> {
    let ascii = Text::new_or_none(value).filter(|_| value.is_ascii());
    ascii.ok_or_else(|| Error::usage(format!("'{value}' cannot be text of an EXR file: use ASCII only")))
}
