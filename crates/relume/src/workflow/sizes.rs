//! Sizes of blocks and windows, and numbers of levels, that fit exemplars and output.
//!
//! Blocks are those that the analysis suggests first ([`advice::first_block`]). The window of a pixel method
//! spans two features; its levels continue until the window spans three features and a period. All fit the
//! exemplars, outside their masks, and an output that tiles, so that any exemplar of 8 x 8 texels or more works
//! without a size being given.

use crate::analysis::{Analysis, Extents, advice};
use crate::error::Result;
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;
use crate::synthesis::{Boundary, Exemplar};

/// Features across a window that compares whole things.
const FEATURES: f64 = 2.0;
/// Features across a window at the coarsest level: as across a block.
const COARSE_FEATURES: f64 = 3.0;
/// The fraction of an exemplar that a block takes where a guide decides what comes where.
const GUIDED_PART: usize = 11;
/// Sides of windows texel by texel: below, textures fall apart; above, whole parts are copied and the time
/// grows with the square.
const WINDOW: (usize, usize) = (11, 21);
/// Levels from which scanlines and patches begin to add coarser ones, and at most.
const LEVELS: (usize, usize) = (4, 8);

/// The room for blocks and windows in exemplars and output.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    extents: Vec<Extents>,
    /// The shortest side of a square that fits every exemplar, and one of them outside its mask.
    side: usize,
    /// The shorter side of the smallest exemplar.
    exemplar: usize,
    /// The shorter side of the output.
    output: usize,
}

impl Room {
    /// Measures the extents of exemplars.
    ///
    /// # Errors
    /// Exemplars with values that are not finite, and limits exceeded.
    pub fn measure(exemplars: &[Exemplar<'_>], output: Size, job: &Job) -> Result<Self> {
        let extents = exemplars.iter().map(|exemplar| Extents::measure(exemplar.index, job));
        Ok(Self::new(extents.collect::<Result<_>>()?, exemplars, output))
    }

    /// Exemplars that have been analysed.
    pub fn of(analyses: &[Analysis], exemplars: &[Exemplar<'_>], output: Size) -> Self {
        let extents = analyses.iter().zip(exemplars).map(|(found, e)| Extents::of(found, e.index.size()));
        Self::new(extents.collect(), exemplars, output)
    }

    fn new(extents: Vec<Extents>, exemplars: &[Exemplar<'_>], output: Size) -> Self {
        let exemplar = exemplars.iter().map(|e| shorter(e.index.size())).min().unwrap_or(0);
        let clear = exemplars.iter().map(clear_side).max().unwrap_or(0);
        Self { extents, side: exemplar.min(clear), exemplar, output: shorter(output) }
    }

    /// The lengths measured on each exemplar.
    pub fn extents(&self) -> &[Extents] {
        &self.extents
    }

    /// The side of blocks: at least twice the least overlap, where that fits.
    pub fn block(&self, overlap: usize, boundary: Boundary, is_guided: bool) -> usize {
        let advised = match is_guided {
            true => (self.side / GUIDED_PART).max(4),
            false => advice::first_block(&self.extents, self.side),
        };
        advised.max(2 * overlap).min(self.most_block(boundary))
    }

    /// The largest side of blocks: two of them fit an output that tiles.
    pub fn most_block(&self, boundary: Boundary) -> usize {
        let most = match boundary {
            Boundary::Torus => self.side.min(self.output / 2),
            Boundary::Open => self.side,
        };
        most.max(2)
    }

    /// The side of a window that is compared texel by texel.
    pub fn window(&self) -> usize {
        let (least, most) = WINDOW;
        let spanned = (FEATURES * self.feature()).min(most as f64).round() as usize;
        odd(spanned.max(least).min(self.side / 2).min(self.output))
    }

    /// The side of scanline windows or patches, customarily `side`.
    pub fn small_window(&self, side: usize) -> usize {
        odd(side.min(self.side / 2).min(self.output))
    }

    /// Levels at the coarsest of which a window spans three features and a period, as far as it fits.
    pub fn levels(&self, window: usize) -> usize {
        let period = self.extents.iter().filter_map(|found| found.period).fold(0.0, f64::max);
        let span = (COARSE_FEATURES * self.feature()).max(period);
        let (least, most) = LEVELS;
        let needed = (span / window as f64).log2().ceil().max(0.0) as usize + 1;
        let coarser = |side: &usize| Some(side.div_ceil(2));
        let sides = std::iter::successors(Some(self.exemplar.min(self.output)), coarser);
        let fitting = sides.take(most).take_while(|side| *side >= window).count();
        needed.max(least).min(fitting.max(1))
    }

    /// The largest feature, at most half an exemplar.
    fn feature(&self) -> f64 {
        let half = self.exemplar as f64 / 2.0;
        self.extents.iter().map(|found| found.feature.unwrap_or(half)).fold(0.0, f64::max)
    }
}

/// The side of patches that refill the border of an output, customarily `side`.
pub(super) fn closing_window(side: usize, exemplars: &[Exemplar<'_>], output: Size) -> usize {
    Room::new(Vec::new(), exemplars, output).small_window(side)
}

/// The side of windows that fill the holes of a texture, whatever the holes hold; fitted to the texels outside
/// them and to the mask of those that may not be copied.
///
/// # Errors
/// As [`Room::measure`].
pub fn filling_window(index: &Planes, holes: &[bool], excluded: Option<&[bool]>, job: &Job) -> Result<usize> {
    job.check("the texture without its holes", index.size(), 4 * index.count() as u64)?;
    let mut even = index.clone();
    for plane in even.iter_mut() {
        let known = || plane.iter().zip(holes).filter(|(_, hole)| !**hole);
        let sum: f64 = known().map(|(&value, _)| f64::from(value)).sum();
        let mean = (sum / known().count().max(1) as f64) as f32;
        plane.iter_mut().zip(holes).filter(|(_, hole)| **hole).for_each(|(value, _)| *value = mean);
    }
    let unusable: Vec<bool> = match excluded {
        Some(excluded) => holes.iter().zip(excluded).map(|(hole, excluded)| hole | excluded).collect(),
        None => holes.to_vec(),
    };
    let source = Exemplar { index: &even, excluded: Some(&unusable) };
    Ok(Room::measure(&[source], index.size(), job)?.window())
}

fn shorter(size: Size) -> usize {
    size.width.min(size.height)
}

/// The largest odd side of a window up to `side`, at least 3.
fn odd(side: usize) -> usize {
    (side - usize::from(side.is_multiple_of(2) && side > 0)).max(3)
}

/// The side of the largest square without excluded texels, by the squares that end at each texel.
fn clear_side(exemplar: &Exemplar<'_>) -> usize {
    let size = exemplar.index.size();
    let Some(excluded) = exemplar.excluded else { return shorter(size) };
    let (mut above, mut most) = (vec![0usize; size.width + 1], 0);
    for row in excluded.chunks_exact(size.width) {
        let mut corner = 0;
        for (x, &excluded) in row.iter().enumerate() {
            let side = if excluded { 0 } else { 1 + above[x + 1].min(above[x]).min(corner) };
            corner = std::mem::replace(&mut above[x + 1], side);
            most = most.max(side);
        }
    }
    most
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room(side: usize, feature: Option<f64>, period: Option<f64>, output: usize) -> Room {
        let extents = vec![Extents { feature, period, repeats: [None; 2], is_small_sample: false }];
        Room { extents, side, exemplar: side, output }
    }

    #[test]
    fn blocks_are_the_first_that_the_analysis_suggests() {
        let block = |room: &Room| room.block(1, Boundary::Open, false);
        assert_eq!(block(&room(1024, Some(20.0), None, 2048)), 256);
        assert_eq!(block(&room(256, Some(30.0), None, 512)), 90);
        assert_eq!(block(&room(256, Some(5.0), Some(100.0), 512)), 100);
        assert_eq!(block(&room(32, None, None, 512)), 16);
        assert_eq!(block(&room(8, None, None, 512)), 4);
        // A tile has room for two, a guide decides more often, and an overlap fits into a block twice.
        assert_eq!(room(256, Some(5.0), None, 64).block(1, Boundary::Torus, false), 32);
        assert_eq!(room(256, Some(5.0), None, 512).block(1, Boundary::Open, true), 23);
        assert_eq!(room(256, Some(5.0), None, 512).block(40, Boundary::Open, false), 80);
    }

    #[test]
    fn windows_span_features_and_fit() {
        assert_eq!(room(256, Some(3.0), None, 512).window(), 11);
        assert_eq!(room(256, Some(7.5), None, 512).window(), 15);
        assert_eq!(room(256, None, None, 512).window(), 21);
        assert_eq!(room(8, None, None, 64).window(), 3);
        assert_eq!(room(256, Some(5.0), None, 6).window(), 5);
        assert_eq!(room(256, Some(5.0), None, 512).small_window(9), 9);
        assert_eq!(room(9, Some(5.0), None, 512).small_window(9), 3);
    }

    #[test]
    fn levels_span_features_and_fit() {
        assert_eq!(room(256, Some(5.0), None, 512).levels(5), 4);
        // 3 x 40 texels: windows of 5 at six levels.
        assert_eq!(room(1024, Some(40.0), None, 2048).levels(5), 6);
        assert_eq!(room(1024, Some(5.0), Some(300.0), 2048).levels(9), 7);
        // 8, 4: one level for windows of 5, two for 3.
        assert_eq!(room(8, None, None, 64).levels(5), 1);
        assert_eq!(room(8, None, None, 64).levels(3), 2);
        assert_eq!(room(256, None, None, 20).levels(5), 3);
    }

    #[test]
    fn the_largest_square_outside_a_mask_is_that_of_trying_all() {
        use crate::numeric::random::{Purpose, Stream};
        let size = Size::new(13, 11);
        let planes = Planes::zeros(size, 1);
        for seed in 0..40 {
            let mut random = Stream::new(seed, Purpose::Sample, [0]);
            let mask: Vec<bool> = (0..size.texels()).map(|_| random.unit() < 0.02 * seed as f64).collect();
            let fits = |side: usize, x: usize, y: usize| {
                (y..y + side).all(|y| (x..x + side).all(|x| !mask[size.index(x, y)]))
            };
            let found = |side: &usize| {
                (0..=size.height - side).any(|y| (0..=size.width - side).any(|x| fits(*side, x, y)))
            };
            let truth = (1..=11).rev().find(found).unwrap_or(0);
            let exemplar = Exemplar { index: &planes, excluded: Some(&mask) };
            assert_eq!(clear_side(&exemplar), truth, "seed {seed}");
        }
    }

    #[test]
    fn what_a_hole_holds_does_not_choose_the_window() {
        let size = Size::new(60, 50);
        let holes: Vec<bool> = (0..size.texels()).map(|i| i % 60 < 20 && i / 60 < 20).collect();
        let window = |held: f32| {
            let value = |i: usize| if holes[i] { held } else { ((i % 60 / 5 + i / 300) % 2) as f32 };
            let planes = Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap();
            filling_window(&planes, &holes, None, &Job::default()).unwrap()
        };
        assert_eq!([window(f32::NAN), window(1e9)], [window(0.5); 2]);
    }
}
