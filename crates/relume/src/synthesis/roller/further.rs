//! Other parts of the exemplar that fit the border of the first tile.
//!
//! The error of a part is the sum of squared differences from the first tile over its border band. All parts
//! are evaluated at once by correlation, |t - s|^2 = |t|^2 + |s|^2 - 2 t.s, in 64-bit floating point with a
//! stated error; those that could be the best within it are decided by their exact sums.
//! [`SharedBorder::direct`] is the slow truth.

use realfft::num_complex::Complex64;
use serde::Serialize;

use super::profile::squared_distance;
use crate::numeric::cells::Cells;
use crate::numeric::fourier::Fourier;
use crate::numeric::summed_area::SummedArea;
use crate::size::Size;
use crate::synthesis::quantise::{IndexTexels, squared_length, squared_lengths};

/// Error of a correlation relative to the product of the lengths of its factors, as in
/// [`crate::synthesis::search::fft`].
pub(super) const RELATIVE_ERROR: f64 = 1e-13;

/// A part of the exemplar with the size of the rectangle of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct TilePart {
    /// Left column.
    pub x: usize,
    /// Top row.
    pub y: usize,
    /// The sum of the squared differences from the first tile over its border band.
    pub border_error: u64,
}

/// The border band of the first tile, compared with all parts of the exemplar.
pub struct SharedBorder<'a> {
    exemplar: &'a IndexTexels,
    planes: usize,
    cells: Cells,
    band: usize,
    codes: &'a [i16],
    /// The approximate error of the part at each position, row by row of the exemplar.
    errors: Vec<f64>,
    /// The largest error of those values.
    margin: f64,
}

impl<'a> SharedBorder<'a> {
    /// Compares the outermost `band` + 1 texels of a tile with all parts of the exemplar. The codes of the
    /// bounding rectangle of the tile are given texel by texel.
    pub fn new(
        exemplar: &'a IndexTexels,
        planes: usize,
        cells: Cells,
        band: usize,
        codes: &'a [i16],
    ) -> Self {
        let mut border = Self { exemplar, planes, cells, band, codes, errors: Vec::new(), margin: 0.0 };
        border.compare();
        border
    }

    /// The texels of the border by column and row in the rectangle of the tile.
    fn border_texels(&self) -> impl Iterator<Item = (usize, usize)> + use<'_> {
        let width = self.cells.bounds().width;
        let is_border = |p: [i64; 2]| self.cells.depth(p).is_some_and(|depth| depth <= self.band);
        let all = self.cells.rectangle().enumerate().filter(move |&(_, p)| is_border(p));
        all.map(move |(t, _)| (t % width, t / width))
    }

    fn tile_texel(&self, x: usize, y: usize) -> &[i16] {
        &self.codes[self.cells.bounds().index(x, y) * self.planes..][..self.planes]
    }

    /// The border as rectangles, each of column, row, width and height.
    fn border_rectangles(&self) -> Vec<[usize; 4]> {
        let texels: Vec<(usize, usize)> = self.border_texels().collect();
        let runs = texels.chunk_by(|a, b| a.1 == b.1 && a.0 + 1 == b.0);
        let mut rectangles: Vec<[usize; 4]> = Vec::new();
        for run in runs {
            let ((x, y), width) = (run[0], run.len());
            let above = |r: &&mut [usize; 4]| r[0] == x && r[2] == width && r[1] + r[3] == y;
            match rectangles.iter_mut().find(above) {
                Some(rectangle) => rectangle[3] += 1,
                None => rectangles.push([x, y, width, 1]),
            }
        }
        rectangles
    }

    /// Correlates plane after plane.
    fn compare(&mut self) {
        let size = self.exemplar.size();
        let transform = Fourier::new(size);
        let mut product = vec![Complex64::ZERO; transform.columns() * size.height];
        for k in 0..self.planes {
            let mut image = vec![0.0; size.texels()];
            for (x, y) in self.border_texels() {
                image[size.index(x, y)] = f64::from(self.tile_texel(x, y)[k]);
            }
            let codes = self.exemplar.codes()[k..].iter().step_by(self.planes).take(size.texels());
            let (border, whole) =
                (transform.forward(image), transform.forward(codes.map(|&c| f64::from(c)).collect()));
            product.iter_mut().zip(border.iter().zip(&whole)).for_each(|(sum, (t, s))| *sum += t.conj() * s);
        }
        let codes = &self.exemplar.codes()[..size.texels() * self.planes];
        let squares = squared_lengths(codes, self.planes);
        let norm: u64 = squares.iter().sum();
        let own: u64 = self.border_texels().map(|(x, y)| squared_length(self.tile_texel(x, y))).sum();
        let there = self.border_sums(&SummedArea::new(size, &squares));
        self.errors = transform.inverse(product);
        self.errors.iter_mut().zip(there).for_each(|(v, there)| *v = (own + there) as f64 - 2.0 * *v);
        let factors = (norm as f64).sqrt() * (own as f64).sqrt() * (self.planes as f64).sqrt();
        self.margin = 2.0 * RELATIVE_ERROR * factors + 0.5;
    }

    /// The sum of squares under the border at each position where the tile lies inside, otherwise 0.
    fn border_sums(&self, squares: &SummedArea) -> Vec<u64> {
        let (size, Size { width, height }) = (self.exemplar.size(), self.cells.bounds());
        let rectangles = self.border_rectangles();
        let sum = |t: usize| {
            let (x, y) = (t % size.width, t / size.width);
            if x + width > size.width || y + height > size.height {
                return 0;
            }
            rectangles.iter().map(|&[left, top, w, h]| squares.sum(x + left, y + top, w, h)).sum()
        };
        (0..size.texels()).map(sum).collect()
    }

    /// The allowed part that fits best; the topmost, then leftmost of equals.
    pub fn best(&self, allowed: impl Fn(usize, usize) -> bool) -> Option<TilePart> {
        let (size, tile) = (self.exemplar.size(), self.cells.bounds());
        let rows = 0..(size.height + 1).saturating_sub(tile.height);
        let places = rows.flat_map(|y| (0..(size.width + 1).saturating_sub(tile.width)).map(move |x| (x, y)));
        let places: Vec<(usize, usize)> = places.filter(|&(x, y)| allowed(x, y)).collect();
        let approximate = |&(x, y): &(usize, usize)| self.errors[size.index(x, y)];
        let least = places.iter().map(approximate).min_by(f64::total_cmp)?;
        let near = places.iter().filter(|place| approximate(place) <= least + 2.0 * self.margin);
        near.map(|&(x, y)| TilePart { x, y, border_error: self.direct(x, y) })
            .min_by_key(|part| (part.border_error, part.y, part.x))
    }

    /// The slow truth of the error of a part: the sum over the texels of the border.
    pub fn direct(&self, x: usize, y: usize) -> u64 {
        self.border_texels()
            .map(|(i, j)| squared_distance(self.tile_texel(i, j), self.exemplar.run(x + i, y + j, 1)))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::synthesis::roller::tests::noise;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn the_best_part_is_that_of_all_direct_sums(
            (extra_w, extra_h, planes, band) in (0usize..9, 0usize..9, 1usize..4, 1usize..3),
            (s, t, seed) in (-3i64..4, -3i64..4, any::<u64>()),
        ) {
            let cells = Cells::new([2 * band as i64 + 5, t], [s, 2 * band as i64 + 6]).unwrap();
            let tile = cells.bounds();
            let size = Size::new(tile.width + extra_w, tile.height + extra_h);
            let exemplar = noise(size, planes, seed);
            let mut stream = Stream::new(seed, Purpose::Sample, [1]);
            let codes: Vec<i16> = (0..tile.texels() * planes).map(|_| stream.below(4096) as i16).collect();
            let border = SharedBorder::new(&exemplar.texels()[0], planes, cells, band, &codes);
            let allowed = |x: usize, y: usize| (x + 2 * y) % 3 != 1;
            let places = (0..=extra_h).flat_map(|y| (0..=extra_w).map(move |x| (x, y)));
            let sums = places.filter(|&(x, y)| allowed(x, y)).map(|(x, y)| (border.direct(x, y), y, x));
            let truth = sums.min().unwrap();
            let found = border.best(allowed).unwrap();
            prop_assert_eq!((found.border_error, found.y, found.x), truth);
            for (t, error) in border.errors.iter().enumerate() {
                let (x, y) = (t % size.width, t / size.width);
                if x <= extra_w && y <= extra_h {
                    prop_assert!((error - border.direct(x, y) as f64).abs() <= border.margin);
                }
            }
            prop_assert!(border.best(|_, _| false).is_none());
        }
    }
}
