//! The endless plane of a tile set: any window of it directly, identical however the plane is cut.
//!
//! Cells are rectangles, or oblique to follow oblique periods ([`crate::numeric::cells`]). The tile of each
//! cell is chosen by a hash of the seed and the column and row of the cell ([`crate::numeric::hash`]), so
//! nothing is precomputed or stored. Texels are copied row by row in runs as wide as a tile. A shader chooses
//! the same tiles:
//!
//! ```glsl
//! uint tileOf(ivec2 cell, uvec2 seed) { return (hash4(uvec4(cell, seed)).x >> 16) % tiles; }
//! ```
//!
//! Where the corners of tiles have colours, the hash gives the colour of a lattice point, and those of its four
//! corners the tile of a cell ([`crate::numeric::corner_colors`]).
//!
//! The upper half of the hash is used: the lowest bits of neighbouring seeds are not independent.

use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::cells::Cells;
use crate::numeric::corner_colors::CornerColors;
use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

/// A plane of tiles in all directions; the lattice point of the cell (0, 0) is the texel (0, 0). It repeats
/// after 2^32 cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Endless {
    cells: Cells,
    tiles: usize,
    seed: u64,
    corners: CornerColors,
    /// Columns and rows of cells after which the plane repeats, if it does before 2^32.
    repeats: Option<[i64; 2]>,
}

/// Consecutive texels of one row of one tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileRun {
    /// The number of the tile.
    pub tile: usize,
    /// The column of the first texel in the rectangle of the tile.
    pub x: usize,
    /// The row in the rectangle.
    pub y: usize,
    /// The number of texels.
    pub length: usize,
}

impl Endless {
    /// The plane of `tiles` tiles of one size under `seed`.
    ///
    /// # Errors
    /// When there are no tiles, or they have no texels.
    pub fn new(tile: Size, tiles: usize, seed: u64) -> Result<Self> {
        let cells = Cells::upright(tile).filter(|_| tiles > 0);
        let cells =
            cells.ok_or_else(|| Error::usage(format!("{tiles} tiles of {tile} texels make no plane")))?;
        Self::of(cells, tiles, seed)
    }

    /// The plane of `tiles` tiles, each of which fills a cell, under `seed`.
    ///
    /// # Errors
    /// When there are no tiles.
    pub fn of(cells: Cells, tiles: usize, seed: u64) -> Result<Self> {
        if tiles == 0 {
            return Err(Error::usage("no tiles make no plane"));
        }
        Ok(Self { cells, tiles, seed, corners: CornerColors::ALIKE, repeats: None })
    }

    /// The same with tiles that fit at corners of their colours only.
    #[must_use]
    pub fn with_corners(self, corners: CornerColors) -> Self {
        Self { corners, ..self }
    }

    /// The same, repeating after that many columns and rows of cells.
    #[must_use]
    pub fn repeating(self, columns: usize, rows: usize) -> Self {
        Self { repeats: Some([columns as i64, rows as i64]), ..self }
    }

    /// The size of the bounding rectangle of a tile.
    pub fn tile(&self) -> Size {
        self.cells.bounds()
    }

    /// The tile of a cell.
    pub fn tile_at(&self, column: i64, row: i64) -> usize {
        let wrapped = |[column, row]: [i64; 2]| match self.repeats {
            Some([columns, rows]) => [column.rem_euclid(columns), row.rem_euclid(rows)],
            None => [column, row],
        };
        self.corners.tile_at(self.tiles, self.seed, [column, row], wrapped)
    }

    /// The tile and its texel shown at (x, y) of the plane: the slow truth of [`Endless::runs`].
    pub fn texel_at(&self, x: i64, y: i64) -> TileRun {
        let place = self.cells.place([x, y]);
        let ([left, top], [column, row]) = (self.cells.origin(), place.cell);
        TileRun {
            tile: self.tile_at(column, row),
            x: (place.texel[0] - left) as usize,
            y: (place.texel[1] - top) as usize,
            length: 1,
        }
    }

    /// The runs of `width` texels from (x, y) to the right.
    pub fn runs(&self, x: i64, y: i64, width: usize) -> impl Iterator<Item = TileRun> {
        let (plane, mut done) = (*self, 0);
        std::iter::from_fn(move || {
            (done < width).then(|| {
                let first = plane.texel_at(x + done as i64, y);
                let run = TileRun { length: plane.rest_of_row(&first).min(width - done), ..first };
                done += run.length;
                run
            })
        })
    }

    /// The number of texels from the first one of a run to the end of the row of its cell.
    fn rest_of_row(&self, run: &TileRun) -> usize {
        let [left, top] = self.cells.origin();
        (self.cells.end_of_row(run.y as i64 + top) - left) as usize - run.x
    }

    /// Copies texels of the plane from (x, y) to the right into `out`. The tiles lie one below the
    /// other in `stacked`, with `samples` numbers a texel.
    ///
    /// # Panics
    /// When `stacked` does not hold all tiles, or `out` does not hold a whole number of texels.
    pub fn copy_row<T: Copy>(&self, stacked: &[T], samples: usize, x: i64, y: i64, out: &mut [T]) {
        assert_eq!(stacked.len(), self.tile().texels() * self.tiles * samples, "all tiles");
        assert!(out.len().is_multiple_of(samples), "whole texels");
        let (tile, mut rest) = (self.tile(), out);
        for run in self.runs(x, y, rest.len() / samples) {
            let (now, later) = rest.split_at_mut(run.length * samples);
            let start = tile.index(run.x, run.tile * tile.height + run.y) * samples;
            now.copy_from_slice(&stacked[start..][..now.len()]);
            rest = later;
        }
    }

    /// The window of `size` texels whose top left texel is (x, y), from tiles stacked one below the other.
    ///
    /// # Errors
    /// When the planes do not hold these tiles, or the window exceeds the limits.
    pub fn window(&self, stacked: &Planes, x: i64, y: i64, size: Size, job: &Job) -> Result<Planes> {
        let expected = Size::new(self.tile().width, self.tile().height * self.tiles);
        if stacked.size() != expected {
            return Err(Error::usage(format!(
                "{} tiles of {} lie in {expected} texels, found {}",
                self.tiles,
                self.tile(),
                stacked.size()
            )));
        }
        let mut window = Planes::zeros_within(job, "the window", size, stacked.count())?;
        let (width, height) = (size.width, size.height);
        parallel::for_each(window.as_mut_slice().chunks_exact_mut(width).enumerate(), |(number, row)| {
            let (k, line) = (number / height, number % height);
            self.copy_row(stacked.plane(k), 1, x, y + line as i64, row);
        });
        Ok(window)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::Limits;
    use crate::numeric::random::{Purpose, Stream};
    use proptest::prelude::*;

    fn tiles(tile: Size, count: usize, planes: usize) -> Planes {
        let mut stream = Stream::new(8, Purpose::Sample, [0]);
        let size = Size::new(tile.width, tile.height * count);
        let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Every texel of every window depends on its position alone.
        #[test]
        fn windows_are_identical_however_they_are_cut(
            (w, h, s, t) in (1i64..9, 1i64..9, -8i64..9, -8i64..9),
            (count, planes, leans) in (1usize..6, 1usize..3, any::<bool>()),
            (x, y, width, height) in (-40i64..40, -40i64..40, 1usize..30, 1usize..30),
            (far, seed) in (prop_oneof![Just(0i64), Just(1 << 40), Just(-(1 << 40))], any::<u64>()),
        ) {
            let (s, t) = if leans { (s % h, t % w) } else { (0, 0) };
            let plane = Endless::of(Cells::new([w, t], [s, h]).unwrap(), count, seed).unwrap();
            let tile = plane.tile();
            let stacked = tiles(tile, count, planes);
            let (x, y) = (x + far, y - far);
            let window = plane.window(&stacked, x, y, Size::new(width, height), &Job::default()).unwrap();
            for (i, j) in (0..height).flat_map(|j| (0..width).map(move |i| (i, j))) {
                let from = plane.texel_at(x + i as i64, y + j as i64);
                for k in 0..planes {
                    prop_assert_eq!(window.at(k, i, j), stacked.at(k, from.x, from.tile * tile.height + from.y));
                }
            }
        }
    }

    #[test]
    fn tiles_are_chosen_evenly_and_by_seed() {
        let plane = |seed| Endless::new(Size::new(4, 4), 4, seed).unwrap();
        let mut counts = [0u32; 4];
        let mut equal = 0;
        for place in 0..10_000i64 {
            let (column, row) = (place % 100 - 50, place / 100 - 50);
            counts[plane(1).tile_at(column, row)] += 1;
            equal += u32::from(plane(1).tile_at(column, row) == plane(2).tile_at(column, row));
        }
        // Five standard deviations: 5 * sqrt(10000 * 3/16).
        assert!(counts.iter().all(|c| c.abs_diff(2500) < 217) && equal.abs_diff(2500) < 217, "{counts:?}");
    }

    #[test]
    fn what_makes_no_plane_is_refused() {
        assert!(Endless::new(Size::new(4, 4), 0, 0).is_err() && Endless::new(Size::new(0, 4), 1, 0).is_err());
        let plane = Endless::new(Size::new(4, 4), 2, 0).unwrap();
        let stacked = tiles(Size::new(4, 4), 2, 1);
        let tight = Job::new(Limits { max_bytes: 99, ..Limits::default() });
        assert!(plane.window(&stacked, 0, 0, Size::new(5, 5), &tight).is_err());
        assert!(plane.window(&stacked, 0, 0, Size::new(0, 5), &Job::default()).is_err());
        let error = plane.window(&tiles(Size::new(4, 4), 3, 1), 0, 0, Size::new(5, 5), &Job::default());
        assert!(error.unwrap_err().message().contains("4 x 8"));
    }
}
