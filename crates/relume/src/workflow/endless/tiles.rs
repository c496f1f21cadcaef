//! Windows of the plane of a tile set.

use std::sync::Arc;

use super::{Drawing, FileTarget, PlaneWindow};
use crate::error::Result;
use crate::format::{FieldFile, Streamed};
use crate::job::Job;
use crate::numeric::cells::Cells;
use crate::numeric::corner_colors::CornerColors;
use crate::synthesis::roller::Endless;

/// The plane of a tile set.
#[derive(Debug)]
pub struct TilePlane<'a> {
    /// All tiles, one below the other.
    pub file: &'a FieldFile,
    /// The number of tiles.
    pub count: usize,
    /// The cells that they fill.
    pub cells: Cells,
    /// The colours of their corners.
    pub corners: CornerColors,
    /// Seed of the order of tiles.
    pub seed: u64,
}

impl<'a> TilePlane<'a> {
    /// A window of the plane: tiles copied into place, as the bytes stored in the file.
    ///
    /// # Errors
    /// A number of tiles without a plane, and a format that cannot hold them.
    pub fn drawing(&self, window: PlaneWindow, target: &FileTarget, job: &'a Job) -> Result<Drawing<'a>> {
        let plane = Endless::of(self.cells, self.count, self.seed)?.with_corners(self.corners);
        let encoding = Some(&self.file.encoding);
        let streamed =
            Arc::new(target.laid(Streamed::new(&self.file.field, target.format, encoding, job)?)?);
        let source = Arc::clone(&streamed);
        let rows = move |lane: usize, x: usize, y: usize, row: &mut [u8]| {
            let (lane, x, y) = (&source.lanes()[lane], window.x + x as i64, window.y + y as i64);
            plane.copy_row(&lane.data, lane.bytes_per_texel, x, y, row);
            Ok(())
        };
        Ok(Drawing::of_rows(streamed, window.size, job, Box::new(rows)))
    }
}
