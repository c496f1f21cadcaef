//! The part of an exemplar that makes the best tile: whole periods, of the requested size, and the origin at
//! which the overlaps differ least from their continuation.
//!
//! A tile of w x h texels with overlap d at the origin (x, y) uses the (w + d) x (h + d) texels from there.
//! Its two strips are compared with themselves one side farther: the left one of d x (h + d) texels with that
//! w to the right, the top one of (w + d) x d with that h down. For each side the squared differences go into
//! a summed-area table, so an origin costs eight look-ups; all origins of all pairs of sides are examined.
//! For oblique cells, the strips are oblique too: they consist of as many more rectangles as the sides have
//! steps. [`Strips::direct`] is the slow truth of one of them.

use serde::Serialize;

use super::profile::{Axis, squared_step};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::cells::Cells;
use crate::numeric::lattice::length;
use crate::numeric::periods::Pattern;
use crate::numeric::summed_area::SummedArea;
use crate::parallel;
use crate::size::Size;
use crate::synthesis::quantise::IndexTexels;

/// The number of sides tried along each axis: enough for the whole periods and the half-way minima of weaves
/// between them.
pub const SHORTLIST: usize = 6;

/// A part of an exemplar for a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Region {
    /// Left column of the tile, or of its bounding rectangle.
    pub x: usize,
    /// Top row.
    pub y: usize,
    /// The cell that it fills.
    pub cells: Cells,
    /// Texels by which it overlaps its continuation.
    pub overlap: usize,
    /// The sum of the squared differences over both strips.
    pub error: u64,
}

impl Region {
    /// The size of the tile, or of its bounding rectangle.
    pub fn tile(&self) -> Size {
        self.cells.bounds()
    }

    /// The texel of the exemplar at the lattice point of the cell.
    pub fn corner(&self) -> [i64; 2] {
        let [left, top] = self.cells.origin();
        [self.x as i64 - left, self.y as i64 - top]
    }

    /// The mean squared difference over the texels of both strips.
    pub fn mean_error(&self) -> f64 {
        let (width, height) = (self.cells.right()[0] as usize, self.cells.down()[1] as usize);
        self.error as f64 / (self.overlap * (width + height + 2 * self.overlap)) as f64
    }
}

/// The sides worth trying: the local minima of a profile from `least` to `longest`, best first.
pub fn sides(profile: &[f64], least: usize, longest: usize, is_whole: impl Fn(usize) -> bool) -> Vec<usize> {
    let at = |s: usize| profile.get(s).copied().unwrap_or(f64::INFINITY);
    let is_minimum = |s: &usize| at(*s) <= at(s - 1) && at(*s) <= at(s + 1);
    let range = || (least.max(1)..=longest).filter(|&s| is_whole(s));
    let mut found: Vec<usize> = range().filter(is_minimum).collect();
    if found.is_empty() {
        found.extend(range().min_by(|&a, &b| at(a).total_cmp(&at(b))));
    }
    found.sort_by(|&a, &b| at(a).total_cmp(&at(b)).then(b.cmp(&a)));
    found.truncate(SHORTLIST);
    found
}

/// The largest deviation of a shift from a whole number of periods, as a fraction of the shortest period:
/// small enough to exclude half periods, and large enough for the slight obliqueness of real captures. The
/// least error decides among the rest.
const NEAR: f64 = 0.2;

/// Whether a shift along an axis is near a whole number of periods; one texel is always near. Without periods
/// every shift is.
pub fn is_whole(pattern: Pattern, axis: Axis, shift: usize) -> bool {
    deviation(pattern, axis, shift).is_none_or(|(distance, shortest)| distance <= (NEAR * shortest).max(1.0))
}

/// Whether a shift along an axis is a whole number of periods, apart from the rounding to texels. Without periods
/// every shift is.
pub fn is_exactly_whole(pattern: Pattern, axis: Axis, shift: usize) -> bool {
    deviation(pattern, axis, shift).is_none_or(|(distance, _)| distance <= ROUNDING)
}

/// The deviation of texels from positions by rounding: half a texel along both axes.
pub const ROUNDING: f64 = 0.71;

/// The deviation of a shift along an axis from whole periods, and the shortest period; `None` without periods.
fn deviation(pattern: Pattern, axis: Axis, shift: usize) -> Option<(f64, f64)> {
    let place = if axis == Axis::X { [shift as f64, 0.0] } else { [0.0, shift as f64] };
    match pattern {
        Pattern::None => None,
        Pattern::Stripes([x, y]) => {
            let periods = (place[0] * x + place[1] * y) / (x * x + y * y);
            Some(((periods - periods.round()).abs() * length([x, y]), length([x, y])))
        }
        Pattern::Lattice(lattice) => {
            let nearest = lattice.nearest(place);
            let [a, b] = lattice.basis().map(length);
            Some((length([nearest[0] - place[0], nearest[1] - place[1]]), a.min(b)))
        }
    }
}

/// The differences of an exemplar from its shifted copies, as tables.
pub struct Strips<'a> {
    texels: &'a IndexTexels,
    overlap: usize,
    excluded: Option<SummedArea>,
}

impl<'a> Strips<'a> {
    /// Prepares an exemplar, with texels that no tile may contain.
    pub fn new(texels: &'a IndexTexels, excluded: Option<&[bool]>, overlap: usize) -> Self {
        let table = |mask: &[bool]| {
            let counts: Vec<u64> = mask.iter().map(|&excluded| u64::from(excluded)).collect();
            SummedArea::new(texels.size(), &counts)
        };
        Self { texels, overlap, excluded: excluded.map(table) }
    }

    /// Whether the rectangle of `size` texels at (x, y) may be used.
    pub fn allows(&self, x: usize, y: usize, size: Size) -> bool {
        self.excluded.as_ref().is_none_or(|table| table.sum(x, y, size.width, size.height) == 0)
    }

    /// The best origin of cells by their steps to the right and down, for each pair that has one.
    ///
    /// # Errors
    /// When the job is cancelled.
    pub fn best_origins(&self, pairs: &[Cells], job: &Job) -> Result<Vec<Region>> {
        let mut steps: Vec<[i64; 2]> = pairs.iter().flat_map(|cells| [cells.right(), cells.down()]).collect();
        steps.sort_unstable();
        steps.dedup();
        let differences = |&step: &[i64; 2]| {
            job.proceed()?;
            Ok(self.differences(step))
        };
        let tables: Vec<SummedArea> = parallel::try_map(steps.iter(), differences)?;
        let table = |step: [i64; 2]| &tables[steps.binary_search(&step).expect("a table for each step")];
        let best = |cells: &Cells| {
            job.proceed()?;
            Ok(self.best_origin(cells, table(cells.right()), table(cells.down())))
        };
        let regions = parallel::try_map(pairs.iter(), best)?;
        Ok(regions.into_iter().flatten().collect())
    }

    fn best_origin(&self, cells: &Cells, across: &SummedArea, down: &SummedArea) -> Option<Region> {
        let (left, top) = (self.left_strip(cells), self.top_strip(cells));
        let [dx, dy] = cells.origin();
        let regions = self.origins(cells).map(|(x, y)| {
            let sum = |table: &SummedArea, strip: &[[i64; 4]]| -> u64 {
                let place = |base: usize, origin: i64, offset: i64| (base as i64 - origin + offset) as usize;
                let part = |&[i, j, width, height]: &[i64; 4]| {
                    table.sum(place(x, dx, i), place(y, dy, j), width as usize, height as usize)
                };
                strip.iter().map(part).sum()
            };
            let error = sum(across, &left) + sum(down, &top);
            Region { x, y, cells: *cells, overlap: self.overlap, error }
        });
        regions.min_by_key(|region| (region.error, region.y, region.x))
    }

    /// The left strip as rectangles of column, row, width and height relative to the lattice point of the
    /// cell.
    fn left_strip(&self, cells: &Cells) -> Vec<[i64; 4]> {
        let d = self.overlap as i64;
        let stretches = stretches(cells.down()[1] + d, |y| cells.left_side(y));
        stretches.into_iter().map(|(y, length, side)| [side, y, d, length]).collect()
    }

    /// The top strip in the same way.
    fn top_strip(&self, cells: &Cells) -> Vec<[i64; 4]> {
        let d = self.overlap as i64;
        let stretches = stretches(cells.right()[0] + d, |x| cells.upper_side(x));
        stretches.into_iter().map(|(x, length, side)| [x, side, length, d]).collect()
    }

    /// The texels around the rectangle of a tile that its cuts may reach: beside it and above it as many as
    /// its sides step within the overlap, and the overlap at the right and below.
    fn margins(&self, cells: &Cells) -> [usize; 2] {
        let d = self.overlap as i64;
        let margin =
            |aside: i64, along: i64| if aside == 0 { 0 } else { (aside.abs() * d / along) as usize + 2 };
        [margin(cells.down()[0], cells.down()[1]), margin(cells.right()[1], cells.right()[0])]
    }

    /// The origins at which a tile and its overlaps lie inside and cover nothing excluded.
    fn origins(&self, cells: &Cells) -> impl Iterator<Item = (usize, usize)> {
        let (size, tile, [mx, my]) = (self.texels.size(), cells.bounds(), self.margins(cells));
        let d = self.overlap;
        let needed = Size::new(tile.width + d + 2 * mx, tile.height + d + 2 * my);
        let columns = (size.width + 1).saturating_sub(needed.width);
        let rows = (size.height + 1).saturating_sub(needed.height);
        let all = (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)));
        all.filter(move |&(x, y)| self.allows(x, y, needed)).map(move |(x, y)| (x + mx, y + my))
    }

    /// Whether the exemplar has room for such cells.
    pub fn holds(&self, cells: &Cells) -> bool {
        let (size, tile, [mx, my]) = (self.texels.size(), cells.bounds(), self.margins(cells));
        tile.width + self.overlap + 2 * mx <= size.width && tile.height + self.overlap + 2 * my <= size.height
    }

    /// Sums of the squared differences from the texels one step farther; 0 where there are none.
    fn differences(&self, step: [i64; 2]) -> SummedArea {
        let size = self.texels.size();
        let mut values = vec![0; size.texels()];
        overlapping(size, step).for_each(|[x, y]| {
            values[size.index(x as usize, y as usize)] = squared_step(self.texels, [x, y], step)
        });
        SummedArea::new(size, &values)
    }

    /// The slow truth of the error of a region: the sum over all texels of both strips.
    pub fn direct(&self, corner: [i64; 2], cells: &Cells) -> u64 {
        let sum = |strip: Vec<[i64; 4]>, step: [i64; 2]| -> u64 {
            let texels = strip.into_iter().flat_map(|[i, j, width, height]| {
                (j..j + height).flat_map(move |y| (i..i + width).map(move |x| [x, y]))
            });
            texels.map(|[x, y]| squared_step(self.texels, [corner[0] + x, corner[1] + y], step)).sum()
        };
        sum(self.left_strip(cells), cells.right()) + sum(self.top_strip(cells), cells.down())
    }
}

/// The texels of a picture with another texel one step farther.
pub fn overlapping(size: Size, [dx, dy]: [i64; 2]) -> impl Iterator<Item = [i64; 2]> {
    let range = |side: usize, d: i64| (-d).max(0)..(side as i64 - d.max(0));
    let (columns, rows) = (range(size.width, dx), range(size.height, dy));
    rows.flat_map(move |y| columns.clone().map(move |x| [x, y]))
}

/// The stretches of 0 to `length` over which a function is constant: beginning, length and value of each.
fn stretches(length: i64, value: impl Fn(i64) -> i64) -> Vec<(i64, i64, i64)> {
    let values: Vec<(i64, i64)> = (0..length).map(|along| (along, value(along))).collect();
    let equal = values.chunk_by(|a, b| a.1 == b.1);
    equal.map(|part| (part[0].0, part.len() as i64, part[0].1)).collect()
}

/// The largest region whose mean error is at most (1 + slack) times the least; the better one among
/// equally large ones.
pub fn largest(regions: &[Region], slack: f64) -> Option<Region> {
    let least = regions.iter().map(Region::mean_error).min_by(f64::total_cmp)?;
    let good = regions.iter().filter(|region| region.mean_error() <= (1.0 + slack) * least);
    good.min_by_key(|region| (std::cmp::Reverse(region.cells.texels()), region.error)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::lattice::Lattice;
    use crate::synthesis::roller::tests::noise;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn the_best_origin_is_that_of_all_direct_sums(
            (width, height, planes, seed) in (12usize..22, 12usize..22, 1usize..4, any::<u64>()),
            (overlap, masked, s, t) in (1usize..4, any::<bool>(), -2i64..3, -2i64..3),
        ) {
            let exemplar = noise(Size::new(width, height), planes, seed);
            let texels = &exemplar.texels()[0];
            let mask: Vec<bool> = (0..width * height).map(|t| t == width * (height / 2) + 1).collect();
            let strips = Strips::new(texels, masked.then_some(&mask[..]), overlap);
            let pair = |w: i64, h: i64| Cells::new([w, t], [s, h]).unwrap();
            let all: Vec<Cells> = (4..18).flat_map(|w| (4..18).map(move |h| pair(w, h))).collect();
            let found = strips.best_origins(&all, &Job::default()).unwrap();
            let mut number = 0;
            for cells in all {
                let ([mx, my], [dx, dy], tile) = (strips.margins(&cells), cells.origin(), cells.bounds());
                let clear = |x: usize, y: usize| {
                    let (right, bottom) = (x + tile.width + overlap + mx, y + tile.height + overlap + my);
                    !(masked && (x - mx..right).contains(&1) && (y - my..bottom).contains(&(height / 2)))
                };
                let fits = |side: usize, tile: usize, margin: usize| {
                    margin..(side + 1).saturating_sub(tile + overlap + margin)
                };
                let rows = fits(height, tile.height, my);
                let origins = rows.flat_map(|y| fits(width, tile.width, mx).map(move |x| (x, y)));
                let corner = |x: usize, y: usize| [x as i64 - dx, y as i64 - dy];
                let sums = origins
                    .filter(|&(x, y)| clear(x, y))
                    .map(|(x, y)| (strips.direct(corner(x, y), &cells), y, x));
                if let Some((error, y, x)) = sums.min() {
                    let region = found[number];
                    prop_assert_eq!((region.cells, region.error, region.y, region.x), (cells, error, y, x));
                    number += 1;
                }
            }
            prop_assert_eq!(number, found.len());
        }
    }

    #[test]
    fn sides_are_local_minima_and_whole_periods_where_asked() {
        let profile: Vec<f64> = (0..40).map(|s| f64::from((s % 8 - 4i32).abs())).map(|v| 4.0 - v).collect();
        assert_eq!(sides(&profile, 10, 33, |_| true), [32, 24, 16]);
        assert_eq!(sides(&profile, 10, 33, |s| s % 16 == 0), [32, 16]);
        assert_eq!(sides(&profile, 17, 19, |_| true), [17], "no minimum: the least there is");
        assert!(sides(&profile, 17, 19, |_| false).is_empty());
    }

    #[test]
    fn oblique_periods_are_whole_where_they_meet_an_axis() {
        // 2 (5, 2) - (-1, 4) = (11, 0), and (5, 2) + 5 (-1, 4) = (0, 22).
        let pattern = Pattern::Lattice(Lattice::new([5.0, 2.0], [-1.0, 4.0]).unwrap());
        let whole = |axis| (1..70).filter(|&s| is_whole(pattern, axis, s)).collect::<Vec<_>>();
        assert!([11, 22, 33].iter().all(|s| whole(Axis::X).contains(s)));
        assert!([22, 44].iter().all(|s| whole(Axis::Y).contains(s)));
        for s in whole(Axis::X) {
            let near = (-30i32..30).flat_map(|m| (-30i32..30).map(move |n| (m, n))).any(|(m, n)| {
                let (x, y) = (5 * m - n, 2 * m + 4 * n);
                f64::from(x - s as i32).hypot(f64::from(y)) <= 1.0
            });
            assert!(near, "{s}");
        }
    }

    #[test]
    fn stripes_bind_one_axis_and_no_period_none() {
        let upright = Pattern::Stripes([8.0, 0.0]);
        let whole = |pattern, axis| (1..30).filter(|&s| is_whole(pattern, axis, s)).collect::<Vec<_>>();
        assert_eq!(whole(upright, Axis::X), [1, 7, 8, 9, 15, 16, 17, 23, 24, 25]);
        assert_eq!(whole(upright, Axis::Y).len(), 29);
        assert_eq!(whole(Pattern::None, Axis::X).len(), 29);
    }

    #[test]
    fn the_largest_good_region_wins() {
        let cells = |width| Cells::upright(Size::new(width, 10)).unwrap();
        let region = |width, error| Region { x: 0, y: 0, cells: cells(width), overlap: 2, error };
        let all = [region(10, 1000), region(20, 1450), region(30, 3000)];
        assert_eq!(largest(&all, 0.1).unwrap().cells.right(), [20, 0]);
        assert_eq!(largest(&all, 1.0).unwrap().cells.right(), [30, 0]);
        assert_eq!(largest(&[], 0.1), None);
    }
}
