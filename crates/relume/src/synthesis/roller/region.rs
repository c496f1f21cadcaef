//! The part of an exemplar that makes the best tile: whole periods, as large as asked for, and the
//! origin where the overlaps with the part's own continuation differ least.
//!
//! A tile of w x h texels with overlap d at the origin (x, y) takes the (w + d) x (h + d) texels
//! from there. Its two strips are compared with themselves one side further: the left one of
//! d x (h + d) texels with that w to the right, the top one of (w + d) x d with that h down. For each
//! side the squared differences go into a summed-area table, so an origin costs eight look-ups; all
//! origins of all pairs of sides are looked at. [`Strips::direct`] is the slow truth of one of them.

use rayon::prelude::*;
use serde::Serialize;

use super::profile::Axis;
use crate::numeric::lattice::length;
use crate::numeric::periods::Pattern;
use crate::numeric::summed_area::SummedArea;
use crate::planes::Size;
use crate::synthesis::quantise::IndexTexels;

/// Sides that are tried along each axis: enough for the whole periods and the half-way minima of
/// weaves between them.
pub const SHORTLIST: usize = 6;

/// A part of an exemplar that is to become a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Region {
    /// Left column.
    pub x: usize,
    /// Top row.
    pub y: usize,
    /// Width of the tile.
    pub width: usize,
    /// Height of the tile.
    pub height: usize,
    /// Texels by which it overlaps its continuation.
    pub overlap: usize,
    /// Sum of the squared differences over both strips.
    pub error: u64,
}

impl Region {
    /// The size of the tile.
    pub fn tile(&self) -> Size {
        Size::new(self.width, self.height)
    }

    /// The mean squared difference over the texels of both strips.
    pub fn mean_error(&self) -> f64 {
        let texels = self.overlap * (self.width + self.height + 2 * self.overlap);
        self.error as f64 / texels as f64
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

/// How near to a whole number of periods a shift must come, as a share of the shortest period: near
/// enough to be no half one, and far enough for the slight obliqueness of real captures. The least
/// error settles the rest.
const NEAR: f64 = 0.2;

/// Whether a shift along an axis comes near a whole number of periods, a texel being always near;
/// every shift does where there are no periods.
pub fn is_whole(pattern: Pattern, axis: Axis, shift: usize) -> bool {
    let place = if axis == Axis::X { [shift as f64, 0.0] } else { [0.0, shift as f64] };
    let (distance, shortest) = match pattern {
        Pattern::None => return true,
        Pattern::Stripes([x, y]) => {
            let periods = (place[0] * x + place[1] * y) / (x * x + y * y);
            ((periods - periods.round()).abs() * length([x, y]), length([x, y]))
        }
        Pattern::Lattice(lattice) => {
            let nearest = lattice.nearest(place);
            let [a, b] = lattice.basis().map(length);
            (length([nearest[0] - place[0], nearest[1] - place[1]]), a.min(b))
        }
    };
    distance <= (NEAR * shortest).max(1.0)
}

/// The differences of an exemplar with its shifts, as tables.
pub struct Strips<'a> {
    texels: &'a IndexTexels,
    overlap: usize,
    excluded: Option<SummedArea>,
}

impl<'a> Strips<'a> {
    /// Prepares an exemplar, with texels that no tile may hold.
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

    /// The best origin for each pair of sides, where there is one.
    pub fn best_origins(&self, widths: &[usize], heights: &[usize]) -> Vec<Region> {
        let tables = |axis: Axis, sides: &[usize]| -> Vec<(usize, SummedArea)> {
            sides.par_iter().map(|&side| (side, self.differences(axis, side))).collect()
        };
        let (by_width, by_height) = (tables(Axis::X, widths), tables(Axis::Y, heights));
        let pairs: Vec<_> =
            by_width.iter().flat_map(|across| by_height.iter().map(move |down| (across, down))).collect();
        let best = |((width, across), (height, down)): &(&(usize, SummedArea), &(usize, SummedArea))| {
            let (width, height, d) = (*width, *height, self.overlap);
            let regions = self.origins(Size::new(width, height)).map(|(x, y)| {
                let error = across.sum(x, y, d, height + d) + down.sum(x, y, width + d, d);
                Region { x, y, width, height, overlap: d, error }
            });
            regions.min_by_key(|region| (region.error, region.y, region.x))
        };
        pairs.par_iter().filter_map(best).collect()
    }

    /// The origins at which a tile and its overlaps lie inside and cover nothing excluded.
    fn origins(&self, tile: Size) -> impl Iterator<Item = (usize, usize)> {
        let size = self.texels.size();
        let needed = Size::new(tile.width + self.overlap, tile.height + self.overlap);
        let columns = (size.width + 1).saturating_sub(needed.width);
        let rows = (size.height + 1).saturating_sub(needed.height);
        let all = (0..rows).flat_map(move |y| (0..columns).map(move |x| (x, y)));
        all.filter(move |&(x, y)| self.allows(x, y, needed))
    }

    /// Sums of the squared differences with the texels one `side` further along an axis.
    fn differences(&self, axis: Axis, side: usize) -> SummedArea {
        let size = self.texels.size();
        let (width, height) = match axis {
            Axis::X => (size.width - side, size.height),
            Axis::Y => (size.width, size.height - side),
        };
        let places = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let values: Vec<u64> = places.map(|(x, y)| axis.squared_step(self.texels, x, y, side)).collect();
        SummedArea::new(Size::new(width, height), &values)
    }

    /// The slow truth of a region's error: the sum over all texels of both strips.
    pub fn direct(&self, x: usize, y: usize, tile: Size) -> u64 {
        let d = self.overlap;
        let sum = |axis: Axis, side: usize, width: usize, height: usize| -> u64 {
            let places = (y..y + height).flat_map(|j| (x..x + width).map(move |i| (i, j)));
            places.map(|(i, j)| axis.squared_step(self.texels, i, j, side)).sum()
        };
        sum(Axis::X, tile.width, d, tile.height + d) + sum(Axis::Y, tile.height, tile.width + d, d)
    }
}

/// The largest region whose mean error is at most (1 + slack) times the least; the better one among
/// equally large ones.
pub fn largest(regions: &[Region], slack: f64) -> Option<Region> {
    let least = regions.iter().map(Region::mean_error).min_by(f64::total_cmp)?;
    let good = regions.iter().filter(|region| region.mean_error() <= (1.0 + slack) * least);
    good.min_by_key(|region| (std::cmp::Reverse(region.tile().texels()), region.error)).copied()
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
            (width, height, planes, seed) in (9usize..22, 9usize..22, 1usize..4, any::<u64>()),
            (overlap, masked) in (1usize..4, any::<bool>()),
        ) {
            let exemplar = noise(Size::new(width, height), planes, seed);
            let texels = &exemplar.texels()[0];
            let mask: Vec<bool> = (0..width * height).map(|t| t == width * (height / 2) + 1).collect();
            let strips = Strips::new(texels, masked.then_some(&mask[..]), overlap);
            let widths: Vec<usize> = (4..=width - overlap).collect();
            let heights: Vec<usize> = (4..=height - overlap).collect();
            let found = strips.best_origins(&widths, &heights);
            let mut number = 0;
            for tile in widths.iter().flat_map(|&w| heights.iter().map(move |&h| Size::new(w, h))) {
                let clear = |x: usize, y: usize| {
                    let (right, bottom) = (x + tile.width + overlap, y + tile.height + overlap);
                    !(masked && (x..right).contains(&1) && (y..bottom).contains(&(height / 2)))
                };
                let rows = 0..=height - tile.height - overlap;
                let origins = rows.flat_map(|y| (0..=width - tile.width - overlap).map(move |x| (x, y)));
                let sums = origins.filter(|&(x, y)| clear(x, y)).map(|(x, y)| (strips.direct(x, y, tile), y, x));
                if let Some((error, y, x)) = sums.min() {
                    let region = found[number];
                    prop_assert_eq!((region.tile(), region.error, region.y, region.x), (tile, error, y, x));
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
        let region = |width, error| Region { x: 0, y: 0, width, height: 10, overlap: 2, error };
        let all = [region(10, 1000), region(20, 1450), region(30, 3000)];
        assert_eq!(largest(&all, 0.1).unwrap().width, 20);
        assert_eq!(largest(&all, 1.0).unwrap().width, 30);
        assert_eq!(largest(&[], 0.1), None);
    }
}
