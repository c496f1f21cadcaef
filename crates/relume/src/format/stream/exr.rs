//! EXR fields in blocks of rows or in tiles.

use super::{Lane, StreamKind};
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::format::ExrDepth;
use crate::format::exr::{self, Head};
use crate::size::Size;

/// The samples of each channel, in the order of the file.
pub(super) fn lanes(field: &ReflectanceField, depth: ExrDepth) -> Result<(Vec<Lane>, StreamKind)> {
    let (names, texts) = exr::field_head(field, depth);
    let mut order: Vec<usize> = (0..names.len()).collect();
    order.sort_by(|&a, &b| names[a].cmp(&names[b]));
    let lane = |&k: &usize| {
        let plane = field.coefficients().plane(k);
        let mut data = vec![0; plane.len() * depth.bytes()];
        exr::write_samples(plane, depth, &mut data);
        Lane { bytes_per_texel: depth.bytes(), data }
    };
    let lanes = order.iter().map(lane).collect();
    let names = order.iter().map(|&k| names[k].clone()).collect();
    Ok((lanes, StreamKind::Exr(Head { names, depth, texts, tile: None })))
}

/// The longest side of a tile: its offsets in a file stay far below 2^31.
const LONGEST_SIDE: usize = 1 << 14;

/// Refuses tiles that a file cannot have.
pub(super) fn check_tile(tile: Size) -> Result<()> {
    if (1..=LONGEST_SIDE).contains(&tile.width) && (1..=LONGEST_SIDE).contains(&tile.height) {
        return Ok(());
    }
    Err(Error::usage(format!(
        "an EXR file has no tiles of {tile}: choose sides of 1 to {LONGEST_SIDE} texels, such as 256x256"
    )))
}

#[cfg(all(test, feature = "exr"))]
mod tests {
    use std::io::Cursor;

    use ::exr::block::UncompressedBlock;
    use ::exr::block::reader::ChunksReader;
    use ::exr::prelude::Vec2;
    use proptest::prelude::*;

    use super::*;
    use crate::field::{Basis, PlaneLayout};
    use crate::format::stream::Streamed;
    use crate::format::{FieldFormat, decode_field};
    use crate::job::Job;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::space::Space;

    fn field(size: Size, seed: u64) -> ReflectanceField {
        let mut stream = Stream::new(seed, Purpose::Sample, [0]);
        let data = (0..size.texels() * 9).map(|_| stream.unit() as f32).collect();
        let planes = Planes::from_vec(size, 9, data).unwrap();
        ReflectanceField::new(Basis::Ptm, PlaneLayout::LRGB, Space::Srgb, planes).unwrap()
    }

    /// A file of the size of the field itself, in tiles.
    fn tiled(field: &ReflectanceField, depth: ExrDepth, tile: Size) -> Vec<u8> {
        let streamed = Streamed::new(field, FieldFormat::Exr(depth), None, &Job::default()).unwrap();
        let streamed = streamed.in_tiles(tile).unwrap();
        let mut out = Cursor::new(Vec::new());
        let mut copy = |lane: usize, x: usize, y: usize, row: &mut [u8]| {
            streamed.lanes()[lane].copy_row(field.size().width, x, y, row);
            Ok(())
        };
        streamed.write(field.size(), &mut out, &mut copy).unwrap();
        out.into_inner()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        /// Tiles that divide the sides, tiles that do not, and tiles larger than the whole.
        #[test]
        fn a_tiled_file_holds_what_one_of_rows_does(
            (width, height, w, h) in (1usize..40, 1usize..40, 1usize..50, 1usize..50),
            (half, seed) in (any::<bool>(), any::<u64>()),
        ) {
            let field = field(Size::new(width, height), seed);
            let depth = if half { ExrDepth::Half } else { ExrDepth::Float };
            let job = Job::default();
            let rows = crate::format::encode_field(&field, FieldFormat::Exr(depth), None, &job).unwrap();
            let read = decode_field(&tiled(&field, depth, Size::new(w, h)), &job).unwrap();
            prop_assert_eq!(read, decode_field(&rows, &job).unwrap());
        }
    }

    /// A reader can find any tile by the table of offsets alone, with the texels of that place.
    #[test]
    fn every_tile_can_be_read_by_itself() {
        let (size, tile) = (Size::new(37, 29), Size::new(16, 11));
        let field = field(size, 3);
        let file = tiled(&field, ExrDepth::Float, tile);
        for (column, row) in (0..3).flat_map(|row| (0..3).map(move |column| (column, row))) {
            let wanted = Vec2(column * tile.width, row * tile.height);
            let reader = ::exr::block::read(Cursor::new(&file), true).unwrap();
            let mut one =
                reader.filter_chunks(true, |_, place, _| place.tile_index == Vec2(column, row)).unwrap();
            let meta = one.meta_data().clone();
            let chunk = one.read_next_chunk().unwrap().unwrap();
            assert!(one.read_next_chunk().is_none(), "one tile only");
            let block = UncompressedBlock::decompress_chunk(chunk, &meta, true).unwrap();
            assert_eq!(block.index.pixel_position, wanted);
            // The first channel by name is the blue of the colour.
            assert_eq!(meta.headers[0].channels.list[0].name.to_string(), "color.B");
            let first = f32::from_ne_bytes(block.data[..4].try_into().unwrap());
            assert_eq!(first, field.coefficients().at(8, wanted.x(), wanted.y()));
        }
    }

    #[test]
    fn tiles_without_texels_and_in_other_files_are_refused() {
        let field = field(Size::new(4, 4), 1);
        for (format, tile) in [
            (FieldFormat::Exr(ExrDepth::Half), Size::new(0, 4)),
            (FieldFormat::Exr(ExrDepth::Half), Size::new(4, LONGEST_SIDE + 1)),
            (FieldFormat::Ptm, Size::new(4, 4)),
        ] {
            let streamed = Streamed::new(&field, format, None, &Job::default()).unwrap();
            assert!(streamed.in_tiles(tile).is_err(), "{format:?}, {tile}");
        }
    }
}
