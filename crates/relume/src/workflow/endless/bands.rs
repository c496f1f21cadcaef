//! Rows of a computed window, one band at a time, each band made of adjacent pieces.

use super::PlaneWindow;
use crate::error::Result;
use crate::format::{Lane, Streamed};
use crate::job::Job;
use crate::size::Size;

/// The bytes of the rows of a band as stored in the file.
const BAND_BYTES: u64 = 64 << 20;

/// The most bytes for making a piece.
const PIECE_BYTES: u64 = 256 << 20;

/// The bytes of a texel.
#[derive(Debug, Clone, Copy)]
pub struct Cost {
    /// In the file.
    pub stored: usize,
    /// While it is made.
    pub made: u64,
}

/// The division of a window.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BandLayout {
    /// Rows of a band.
    rows: usize,
    /// Columns of a piece.
    columns: usize,
    /// Rows of the first band that lie above the window, so that bands begin where cells do.
    above: usize,
    /// The same for columns and pieces.
    before: usize,
}

impl BandLayout {
    /// Bands and pieces along the borders of cells of `cell` texels a side, or bands of whole tiles of the
    /// file, given the cost of a texel.
    ///
    /// # Errors
    /// When a band is larger than the limits allow.
    pub fn new(window: &PlaneWindow, cell: usize, tile: Option<Size>, cost: Cost, job: &Job) -> Result<Self> {
        let Cost { stored, made } = cost;
        let room = PIECE_BYTES.min(job.limits().max_bytes / 4);
        let line = (window.size.width as u64).saturating_mul(stored as u64).max(1);
        // Pieces should be several cells wide, since their surroundings are made as well.
        let fitting = (BAND_BYTES / line).min(room / (made * 4 * cell as u64).max(1)).min(1024) as usize;
        let step = tile.map_or(cell, |tile| tile.height);
        let rows = (fitting / step * step).max(step);
        let columns = ((room / (made * rows as u64).max(1)) as usize / cell * cell).max(cell);
        job.check_bytes("a band of the output", line.saturating_mul(rows.min(window.size.height) as u64))?;
        let behind = |place: i64, step: usize| place.rem_euclid(step as i64) as usize;
        let above = if tile.is_some() { 0 } else { behind(window.y, rows) };
        Ok(Self { rows, columns, above, before: behind(window.x, columns) })
    }

    /// The range of texels along one axis that part number `number` covers.
    fn part(number: usize, step: usize, before: usize, length: usize) -> std::ops::Range<usize> {
        (number * step).saturating_sub(before)..((number + 1) * step - before).min(length)
    }
}

/// Makes the texels of a part of a window, as stored in the file.
pub type Make<'a> = dyn Fn(&PlaneWindow) -> Result<Streamed> + 'a;

/// The rows of a window, of which one band is kept in memory.
pub struct RowBands<'a> {
    window: PlaneWindow,
    cut: BandLayout,
    make: Box<Make<'a>>,
    /// The number of the current band, and its bytes.
    current: Option<(usize, Vec<Lane>)>,
}

impl<'a> RowBands<'a> {
    /// The rows of a window; nothing is made yet.
    pub fn new(window: PlaneWindow, cut: BandLayout, make: Box<Make<'a>>) -> Self {
        Self { window, cut, make, current: None }
    }

    /// Copies texels of a lane, from column `x` of row `y` on.
    pub fn row(&mut self, lane: usize, x: usize, y: usize, row: &mut [u8]) -> Result<()> {
        let number = (y + self.cut.above) / self.cut.rows;
        let rows = BandLayout::part(number, self.cut.rows, self.cut.above, self.window.size.height);
        let lanes = match self.current.take() {
            Some((current, lanes)) if current == number => lanes,
            // The current band is dropped before another is made.
            _ => self.band(rows.clone())?,
        };
        lanes[lane].copy_row(self.window.size.width, x, y - rows.start, row);
        self.current = Some((number, lanes));
        Ok(())
    }

    /// Makes a range of rows piece by piece.
    fn band(&self, rows: std::ops::Range<usize>) -> Result<Vec<Lane>> {
        let PlaneWindow { x, y, size } = self.window;
        let mut band: Vec<Lane> = Vec::new();
        for number in 0..(size.width + self.cut.before).div_ceil(self.cut.columns) {
            let columns = BandLayout::part(number, self.cut.columns, self.cut.before, size.width);
            let part = PlaneWindow {
                x: x + columns.start as i64,
                y: y + rows.start as i64,
                size: Size::new(columns.len(), rows.len()),
            };
            let piece = (self.make)(&part)?;
            if band.is_empty() {
                band =
                    piece.lanes().iter().map(|lane| blank(lane, Size::new(size.width, rows.len()))).collect();
            }
            band.iter_mut()
                .zip(piece.lanes())
                .for_each(|(to, from)| paste(from, columns.clone(), to, size.width));
        }
        Ok(band)
    }
}

/// A lane of the same kind, of zeros.
fn blank(like: &Lane, size: Size) -> Lane {
    let bytes_per_texel = like.bytes_per_texel;
    Lane { bytes_per_texel, data: vec![0; size.texels() * bytes_per_texel] }
}

/// Copies a piece into a range of columns of a lane of `width` columns.
fn paste(piece: &Lane, columns: std::ops::Range<usize>, to: &mut Lane, width: usize) {
    let texel = to.bytes_per_texel;
    let lines = to.data.chunks_exact_mut(width * texel).zip(piece.data.chunks_exact(columns.len() * texel));
    lines.for_each(|(to, from)| to[columns.start * texel..columns.end * texel].copy_from_slice(from));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::ReflectanceField;
    use crate::format::{Depth, FieldFormat, PictureFormat};
    use crate::limits::Limits;
    use crate::picture::Picture;
    use crate::planes::Planes;
    use crate::space::Space;

    /// A texture that is a function of position.
    fn piece(part: &PlaneWindow) -> Result<Streamed> {
        let value = |i: usize| {
            let (i, j) = ((i % part.size.width) as i64, (i / part.size.width) as i64);
            ((part.x + i) * 37 + (part.y + j) * 101).rem_euclid(256) as f32 / 255.0
        };
        let planes = Planes::from_vec(part.size, 1, (0..part.size.texels()).map(value).collect())?;
        let field = ReflectanceField::from_picture(Picture { planes, space: Space::Srgb });
        let format = FieldFormat::Picture(PictureFormat::Png(Depth::Eight));
        Streamed::made(&field, format, None, &Job::default())
    }

    #[test]
    fn bands_and_pieces_pave_the_window_whatever_its_place_and_order() {
        for (x, y) in [(0, 0), (-13, 5), (7, -22), (-1, -1)] {
            for (rows, columns) in [(1, 1), (4, 8), (8, 4), (64, 64), (5, 64)] {
                let window = PlaneWindow { x, y, size: Size::new(23, 17) };
                let behind = |place: i64, step: usize| place.rem_euclid(step as i64) as usize;
                let cut = BandLayout { rows, columns, above: behind(y, rows), before: behind(x, columns) };
                let whole = piece(&window).unwrap();
                let mut bands = RowBands::new(window, cut, Box::new(piece));
                for y in (0..17).rev().chain(0..17) {
                    let mut row = vec![0; 23];
                    bands.row(0, 0, y, &mut row).unwrap();
                    let mut part = vec![0; 9];
                    bands.row(0, 5, y, &mut part).unwrap();
                    assert_eq!(part, row[5..14]);
                    assert_eq!(row, whole.lanes()[0].data[y * 23..][..23], "{window:?} {cut:?} {y}");
                }
            }
        }
    }

    #[test]
    fn wide_windows_are_cut_into_pieces_of_bounded_size() {
        let job = Job::new(Limits { max_bytes: 1 << 50, ..Limits::default() });
        for (width, stored, made) in [(1, 3, 120), (16_384, 3, 120), (131_072, 72, 720)] {
            let window = PlaneWindow { x: -5, y: 900, size: Size::new(width, 9000) };
            let cost = Cost { stored, made };
            for (tile, step) in [(None, 128), (Some(Size::new(50, 70)), 70), (Some(Size::new(9, 4000)), 4000)]
            {
                let cut = BandLayout::new(&window, 128, tile, cost, &job).unwrap();
                assert!(cut.rows.is_multiple_of(step) && cut.columns.is_multiple_of(128), "{cut:?}");
                let band = (cut.rows * width * stored) as u64;
                assert!(cut.rows == step || band <= BAND_BYTES, "{cut:?}");
                assert!(
                    cut.columns == 128 || (cut.rows * cut.columns) as u64 * made <= PIECE_BYTES,
                    "{cut:?}"
                );
            }
        }
    }

    #[test]
    fn bands_larger_than_the_memory_are_refused() {
        let window = PlaneWindow { x: 0, y: 0, size: Size::new(100_000, 4000) };
        let cost = Cost { stored: 72, made: 720 };
        let tight = Job::new(Limits { max_bytes: 1 << 28, ..Limits::default() });
        let tall = Some(Size::new(64, 4000));
        assert!(BandLayout::new(&window, 128, tall, cost, &tight).unwrap_err().message().contains("memory"));
        assert!(BandLayout::new(&window, 128, None, cost, &Job::default()).is_ok());
    }
}
