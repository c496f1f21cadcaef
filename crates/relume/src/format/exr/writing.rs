//! Writing an EXR file block by block, in rows or in tiles, from samples copied in by a callback. Only a few
//! blocks are kept at a time, and the table of their offsets.

use std::io::{BufWriter, Read, Seek, SeekFrom, Write};

use ::exr::block::writer::{ChunkWriter, ChunksWriter, ParallelBlocksCompressor, write_chunks_with};
use ::exr::block::{BlockIndex, UncompressedBlock};
use ::exr::error::UnitResult;
use ::exr::math::RoundingMode;
use ::exr::meta::attribute::{ChannelDescription, LevelMode, TileDescription};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{AttributeValue, Compression, LayerAttributes, LineOrder, SampleType, Text, Vec2};

use super::blocks::Head;
use super::{ExrDepth, attributes};
use crate::error::{Error, Result};
use crate::format::rows::Rows;
use crate::size::Size;

/// Writes a file of `size` texels. `rows(channel, x, y, row)` copies the bytes of samples from
/// column `x` of row `y` on.
pub(in crate::format) fn write_blocks(
    head: &Head<'_>,
    size: Size,
    mut out: impl Read + Write + Seek,
    rows: &mut Rows<'_>,
) -> Result<()> {
    let header = header(head, size)?;
    let channels = head.names.len();
    let mut failure = None;
    let mut block = |index: BlockIndex| -> ::exr::error::Result<UncompressedBlock> {
        let (Vec2(x, y), Vec2(width, height)) = (index.pixel_position, index.pixel_size);
        let line = width * head.depth.bytes();
        let mut data = vec![0; height * channels * line];
        for (number, row) in data.chunks_exact_mut(line).enumerate() {
            let copied = rows(number % channels, x, y + number / channels, row);
            copied.map_err(|error| {
                failure = Some(error);
                ::exr::error::Error::Aborted
            })?;
        }
        Ok(UncompressedBlock { index, data })
    };
    let write = |meta: MetaData, chunks: &mut ChunkWriter<_>| -> UnitResult {
        let places: Vec<_> = ::exr::block::enumerate_ordered_header_block_indices(&meta.headers).collect();
        // The compressor has a pool of its own, which is to be no larger than that of the program.
        let threads = rayon::current_num_threads();
        let pool = || rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let parallel = if threads > 1 {
            ParallelBlocksCompressor::new_with_thread_pool(&meta, chunks, pool)
        } else {
            None
        };
        if let Some(mut compressor) = parallel {
            return places
                .into_iter()
                .try_for_each(|(at, index)| compressor.add_block_to_compression_queue(at, block(index)?));
        }
        let mut compressor = chunks.sequential_blocks_compressor(&meta);
        places.into_iter().try_for_each(|(at, index)| compressor.compress_block(at, block(index)?))
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
