//! Files larger than memory: written row by row, or tile by tile, from samples copied in by a callback.
//!
//! A texture that copies the texels of a small one stores the same bytes for each of them. So the small one
//! is encoded once, into [`Lane`]s: for each texel a few bytes, rows from the top. [`Streamed::write`] then
//! requests the rows of the large file, one row of all lanes at a time, from the top or from the bottom as
//! the format requires, and keeps a few. A file of the size of the small texture is identical to that of
//! [`super::encode_field`], apart from the chunks of PNG files.
//!
//! A computed texture is encoded in pieces by [`Streamed::made`], whose lanes match.
//!
//! - PNG: one lane; ptm: one lane per block of the file, rows from the bottom; EXR: one lane per channel,
//!   blocks of 16 rows, or tiles ([`Streamed::in_tiles`]).

mod exr;
mod png;
mod ptm;

use std::io::{Read, Seek, Write};

use super::exr::Head;
use super::field_file::{Encoding, FieldFormat, constants, encode_field};
use super::ptm::{self as ptm_file, PtmEncoding, Under};
use super::rows::Rows;
use super::{Depth, PictureFormat};
use crate::error::{Error, Result};
use crate::field::ReflectanceField;
use crate::job::Job;
use crate::size::Size;

/// The bytes of the texels of a field as stored in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lane {
    /// Bytes of one texel.
    pub bytes_per_texel: usize,
    /// The bytes of all texels, rows from the top.
    pub data: Vec<u8>,
}

impl Lane {
    /// Copies texels from column `x` of row `y` on, of rows `width` texels wide.
    ///
    /// # Panics
    /// When the lane does not hold them.
    pub fn copy_row(&self, width: usize, x: usize, y: usize, out: &mut [u8]) {
        out.copy_from_slice(&self.data[(y * width + x) * self.bytes_per_texel..][..out.len()]);
    }
}

/// A field whose texels are copied by a large file.
#[derive(Debug, Clone, PartialEq)]
pub struct Streamed {
    lanes: Vec<Lane>,
    kind: StreamKind,
}

/// The information for the header of a file.
#[derive(Debug, Clone, PartialEq)]
enum StreamKind {
    Png { channels: usize, depth: Depth },
    Ptm { header: Vec<String> },
    Exr(Head<'static>),
}

impl Streamed {
    /// Encodes a field, as [`encode_field`] does, with the `encoding` of the file it was read from.
    ///
    /// # Errors
    /// When the format is not written in rows (JPEG, TIFF, PFM, Radiance) or cannot hold the field.
    pub fn new(
        field: &ReflectanceField,
        format: FieldFormat,
        encoding: Option<&Encoding>,
        job: &Job,
    ) -> Result<Self> {
        match format {
            FieldFormat::Ptm => Self::ptm(&encode_field(field, format, encoding, job)?, field.size()),
            _ => Self::made(field, format, None, job),
        }
    }

    /// Encodes a field of new values, such as a piece of a large one: the functions of a `.ptm` under the
    /// given scale, common to all pieces, or under one chosen for this field.
    ///
    /// # Errors
    /// As [`Streamed::new`].
    pub fn made(
        field: &ReflectanceField,
        format: FieldFormat,
        scale: Option<&PtmEncoding>,
        job: &Job,
    ) -> Result<Self> {
        job.check("writing the field", field.size(), 8 * field.coefficients().count() as u64)?;
        let (lanes, kind) = match format {
            FieldFormat::Ptm => {
                let bytes = ptm_file::encode(field, scale.map_or(Under::Chosen, Under::Given), job)?;
                return Self::ptm(&bytes, field.size());
            }
            FieldFormat::Exr(depth) | FieldFormat::Picture(PictureFormat::Exr(depth)) => {
                super::exr::count_clipped(field.coefficients(), depth, job);
                exr::lanes(field, depth)?
            }
            FieldFormat::Picture(PictureFormat::Png(depth)) => png::lanes(&constants(field)?, depth, job)?,
            FieldFormat::PtmJpeg { .. }
            | FieldFormat::Rti
            | FieldFormat::Hsh
            | FieldFormat::Picture(
                PictureFormat::Jpeg { .. }
                | PictureFormat::Tiff(_)
                | PictureFormat::Pfm
                | PictureFormat::Radiance,
            ) => {
                return Err(Error::usage(
                    "textures of any size are written row by row as .png, .ptm or .exr: name the file so",
                ));
            }
        };
        Ok(Self { lanes, kind })
    }

    /// The same with the texels of each tile together, so that a reader can load any part of the file alone.
    ///
    /// # Errors
    /// When the file is not an EXR file, or cannot have such tiles.
    pub fn in_tiles(mut self, tile: Size) -> Result<Self> {
        let StreamKind::Exr(head) = &mut self.kind else {
            return Err(Error::usage("only EXR files are written in tiles here: name the file .exr"));
        };
        exr::check_tile(tile)?;
        head.tile = Some(tile);
        Ok(self)
    }

    /// The texels of a file of `size` texels that are requested together: whole rows or a tile.
    pub fn block(&self, size: Size) -> Size {
        match &self.kind {
            StreamKind::Exr(head) => head.block(size),
            StreamKind::Png { .. } | StreamKind::Ptm { .. } => Size::new(size.width, 1),
        }
    }

    fn ptm(file: &[u8], size: Size) -> Result<Self> {
        let (lanes, kind) = ptm::lanes(file, size)?;
        Ok(Self { lanes, kind })
    }

    /// The bytes of the texels of the field.
    pub fn lanes(&self) -> &[Lane] {
        &self.lanes
    }

    /// Writes a file of `size` texels whose rows are copied from the lanes.
    ///
    /// # Errors
    /// When the size does not fit the format, or the file cannot be written.
    pub fn write(&self, size: Size, out: impl Read + Write + Seek, rows: &mut Rows<'_>) -> Result<()> {
        match &self.kind {
            StreamKind::Png { channels, depth } => png::write(size, *channels, *depth, out, rows),
            StreamKind::Ptm { header } => ptm::write(header, &self.lanes, size, out, rows),
            StreamKind::Exr(head) => super::exr::write_blocks(head, size, out, rows),
        }
    }

    /// The bytes kept while writing a file of `size` texels, apart from the lanes.
    pub fn working_bytes(&self, size: Size) -> u64 {
        let texel: usize = self.lanes.iter().map(|lane| lane.bytes_per_texel).sum();
        // EXR blocks are compressed on several threads, a few blocks each.
        let blocks = if matches!(self.kind, StreamKind::Exr(_)) { 64 } else { 8 };
        let Size { width, height } = self.block(size);
        (width.min(size.width) * height.min(size.height) * texel * blocks) as u64
    }
}

fn unwritable(error: &std::io::Error) -> Error {
    Error::io("cannot write the file", error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Basis, PlaneLayout};
    use crate::format::{ExrDepth, decode_field};
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;
    use crate::space::Space;
    use std::io::Cursor;

    fn field(basis: Basis, color: PlaneLayout, space: Space, size: Size) -> ReflectanceField {
        let mut stream = Stream::new(4, Purpose::Sample, [0]);
        let count = color.planes(basis.len());
        let data = (0..size.texels() * count).map(|_| stream.unit() as f32).collect();
        ReflectanceField::new(basis, color, space, Planes::from_vec(size, count, data).unwrap()).unwrap()
    }

    /// Every field with every format that can hold it.
    fn cases(size: Size) -> Vec<(ReflectanceField, FieldFormat)> {
        let mut cases = Vec::new();
        for color in [PlaneLayout::LUMINANCE, PlaneLayout::RGB, PlaneLayout::LRGB] {
            cases.push((field(Basis::Ptm, color.clone(), Space::Srgb, size), FieldFormat::Ptm));
            for depth in [ExrDepth::Half, ExrDepth::Float] {
                cases.push((field(Basis::Ptm, color.clone(), Space::Linear, size), FieldFormat::Exr(depth)));
            }
            if color != PlaneLayout::LRGB {
                for depth in [Depth::Eight, Depth::Sixteen] {
                    let format = FieldFormat::Picture(PictureFormat::Png(depth));
                    cases.push((field(Basis::Constant, color.clone(), Space::Srgb, size), format));
                }
                let linear = field(Basis::Constant, color.clone(), Space::Linear, size);
                cases.push((linear, FieldFormat::Exr(ExrDepth::Float)));
            }
        }
        cases
    }

    #[test]
    fn a_file_of_the_fields_own_size_is_that_written_at_once() {
        for size in [Size::new(7, 5), Size::new(37, 41), Size::new(1, 1)] {
            for (field, format) in cases(size) {
                let job = Job::default();
                let expected = encode_field(&field, format, None, &job).unwrap();
                let streamed = Streamed::new(&field, format, None, &job).unwrap();
                let mut out = Cursor::new(Vec::new());
                let mut copy = |lane: usize, x: usize, y: usize, row: &mut [u8]| {
                    streamed.lanes()[lane].copy_row(size.width, x, y, row);
                    Ok(())
                };
                streamed.write(size, &mut out, &mut copy).unwrap();
                let written = out.into_inner();
                let same = match format {
                    FieldFormat::Picture(_) => {
                        decode_field(&written, &job).unwrap() == decode_field(&expected, &job).unwrap()
                    }
                    _ => written == expected,
                };
                assert!(same, "{format:?}, {:?}, {size}", field.layout());
            }
        }
    }

    #[test]
    fn a_larger_file_is_that_of_the_repeated_field() {
        let size = Size::new(9, 6);
        for (field, format) in cases(size) {
            let job = Job::default();
            let streamed = Streamed::new(&field, format, None, &job).unwrap();
            let mut out = Cursor::new(Vec::new());
            let mut copy = |lane: usize, x: usize, y: usize, row: &mut [u8]| {
                assert_eq!(x, 0, "whole rows");
                let source = &streamed.lanes()[lane];
                let line = &source.data[y % 6 * 9 * source.bytes_per_texel..][..9 * source.bytes_per_texel];
                row.chunks_mut(line.len()).for_each(|piece| piece.copy_from_slice(&line[..piece.len()]));
                Ok(())
            };
            streamed.write(Size::new(23, 40), &mut out, &mut copy).unwrap();
            let written = decode_field(&out.into_inner(), &job).unwrap().field;
            let once = encode_field(&field, format, None, &job).unwrap();
            let once = decode_field(&once, &job).unwrap().field;
            let repeated = once.coefficients().repeated(3, 7).crop(0, 0, Size::new(23, 40)).unwrap();
            assert!(*written.coefficients() == repeated, "{format:?}, {:?}", field.layout());
        }
    }

    #[test]
    fn the_error_of_a_row_ends_the_writing() {
        let size = Size::new(9, 6);
        for (field, format) in cases(size) {
            let streamed = Streamed::new(&field, format, None, &Job::default()).unwrap();
            let mut out = Cursor::new(Vec::new());
            let mut rows = |_: usize, _: usize, y: usize, _: &mut [u8]| {
                if y == 3 { Err(Error::invalid("the third row is missing")) } else { Ok(()) }
            };
            let error = streamed.write(size, &mut out, &mut rows).unwrap_err();
            assert_eq!(error.message(), "the third row is missing", "{format:?}");
        }
    }

    #[test]
    fn formats_that_are_not_written_in_rows_are_refused() {
        let field = field(Basis::Constant, PlaneLayout::RGB, Space::Srgb, Size::new(3, 3));
        for format in [
            PictureFormat::Jpeg { quality: 90 },
            PictureFormat::Tiff(Depth::Eight),
            PictureFormat::Pfm,
            PictureFormat::Radiance,
        ] {
            let error = Streamed::new(&field, FieldFormat::Picture(format), None, &Job::default());
            assert!(error.unwrap_err().message().contains(".png"));
        }
    }
}
