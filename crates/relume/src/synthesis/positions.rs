//! Possible positions of a block: all at which it lies inside an exemplar and covers no excluded texel.

use super::quantise::Exemplar;
use super::source_map::Texel;
use crate::error::{Error, Result};
use crate::size::Size;

/// Consecutive positions in one row of an exemplar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PositionRun {
    /// The leftmost position.
    pub first: Texel,
    /// The number of positions.
    pub length: usize,
}

/// The valid positions of the top-left texel of a block, in the order of exemplar, row, column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Positions {
    runs: Vec<PositionRun>,
    /// The number of the first position of each run.
    starts: Vec<usize>,
    count: usize,
}

impl Positions {
    /// The positions of blocks of `block` x `block` texels.
    ///
    /// # Errors
    /// When an exemplar is smaller than the block, or none has room for it.
    pub fn new(exemplars: &[Exemplar<'_>], block: usize) -> Result<Self> {
        Self::of_areas(&areas(exemplars), block, "block")
    }

    /// The positions of windows of `window` x `window` texels.
    ///
    /// # Errors
    /// As [`Positions::new`].
    pub fn of_windows(exemplars: &[Exemplar<'_>], window: usize) -> Result<Self> {
        Self::of_areas(&areas(exemplars), window, "window")
    }

    /// The positions of blocks, named `what` in errors, in areas with excluded texels.
    pub(in crate::synthesis) fn of_areas(areas: &[MaskedArea<'_>], block: usize, what: &str) -> Result<Self> {
        let mut runs = Vec::new();
        for (number, &(size, mask)) in areas.iter().enumerate() {
            let most = size.width.min(size.height);
            if most < if what == "window" { 3 } else { 2 } {
                return Err(Error::usage(format!(
                    "exemplar {} of {size} texels is too small for any {what}: give a larger one",
                    number + 1
                )));
            }
            if most < block {
                return Err(Error::usage(format!(
                    "a {what} of {block} x {block} texels does not fit exemplar {} of {size}: choose a \
                     {what} of at most {}",
                    number + 1,
                    if what == "window" && most.is_multiple_of(2) { most - 1 } else { most }
                )));
            }
            let mut rejected = Rejected::new(size, mask, block);
            for y in 0..=size.height - block {
                rejected.advance(y);
                let at = |x: usize| Texel { exemplar: number as u32, y: y as u32, x: x as u32 };
                let mut x = 0;
                while x <= size.width - block {
                    let end = (x..=size.width - block).find(|&x| rejected.covers(x));
                    let end = end.unwrap_or(size.width - block + 1);
                    if end > x {
                        runs.push(PositionRun { first: at(x), length: end - x });
                    }
                    x = end + 1;
                }
            }
        }
        let mut count = 0;
        let mut starts = Vec::with_capacity(runs.len());
        for run in &runs {
            starts.push(count);
            count += run.length;
        }
        if count == 0 {
            return Err(Error::usage(format!(
                "the masks leave no place for a {what} of {block} x {block} texels: exclude less or choose \
                 a smaller {what}"
            )));
        }
        Ok(Self { runs, starts, count })
    }

    /// Those whose column and row are multiples of a number, divided by it; `None` if there are none.
    pub(in crate::synthesis) fn every(&self, factor: usize) -> Option<Self> {
        let (mut runs, mut starts, mut count) = (Vec::new(), Vec::new(), 0);
        for PositionRun { first, length } in &self.runs {
            let (begin, end) = (first.x as usize, first.x as usize + length);
            let (from, to) = (begin.div_ceil(factor), (end - 1) / factor + 1);
            if (first.y as usize).is_multiple_of(factor) && from < to {
                let first = Texel { y: first.y / factor as u32, x: from as u32, ..*first };
                runs.push(PositionRun { first, length: to - from });
                starts.push(count);
                count += to - from;
            }
        }
        (count > 0).then_some(Self { runs, starts, count })
    }

    /// The positions as runs along rows.
    pub fn runs(&self) -> &[PositionRun] {
        &self.runs
    }

    /// The number of positions; at least one.
    pub fn count(&self) -> usize {
        self.count
    }

    /// All positions in order.
    pub fn iter(&self) -> impl Iterator<Item = Texel> {
        self.runs.iter().flat_map(|run| (0..run.length).map(|x| run.first.offset(x, 0)))
    }

    /// Whether a texel is one of the positions.
    pub fn contains(&self, texel: Texel) -> bool {
        self.number(texel).is_some()
    }

    /// The number of a position.
    pub fn number(&self, texel: Texel) -> Option<usize> {
        let run = self.runs.partition_point(|run| run.first <= texel).checked_sub(1)?;
        let PositionRun { first, length } = self.runs[run];
        let along = texel.x.checked_sub(first.x)? as usize;
        let inside = (first.exemplar, first.y) == (texel.exemplar, texel.y) && along < length;
        inside.then(|| self.starts[run] + along)
    }

    /// The position of the given number.
    ///
    /// # Panics
    /// When `number` is not below [`Positions::count`].
    pub fn nth(&self, number: usize) -> Texel {
        let mut rest = number;
        for run in &self.runs {
            if rest < run.length {
                return Texel { x: run.first.x + rest as u32, ..run.first };
            }
            rest -= run.length;
        }
        panic!("position {number} of {}", self.count)
    }
}

/// The size of an exemplar, and its excluded texels.
pub(in crate::synthesis) type MaskedArea<'a> = (Size, Option<&'a [bool]>);

fn areas<'a>(exemplars: &[Exemplar<'a>]) -> Vec<MaskedArea<'a>> {
    exemplars.iter().map(|exemplar| (exemplar.index.size(), exemplar.excluded)).collect()
}

/// Counts of excluded texels in the rows of the block, for one row of positions after another.
struct Rejected<'a> {
    size: Size,
    mask: Option<&'a [bool]>,
    block: usize,
    /// The number of excluded texels of the rows of the block before column x.
    before: Vec<usize>,
}

impl<'a> Rejected<'a> {
    fn new(size: Size, mask: Option<&'a [bool]>, block: usize) -> Self {
        Self { size, mask, block, before: vec![0; size.width + 1] }
    }

    fn advance(&mut self, y: usize) {
        let Some(mask) = self.mask else { return };
        let size = self.size;
        let mut sum = 0;
        for x in 0..size.width {
            sum += (y..y + self.block).filter(|&row| mask[size.index(x, row)]).count();
            self.before[x + 1] = sum;
        }
    }

    /// Whether a block at column x covers an excluded texel.
    fn covers(&self, x: usize) -> bool {
        self.before[x + self.block] > self.before[x]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::planes::Planes;

    #[test]
    fn positions_are_those_that_cover_no_excluded_texel() {
        let sizes = [Size::new(9, 7), Size::new(5, 11)];
        for seed in 0..20 {
            let mut stream = Stream::new(seed, Purpose::Sample, [0]);
            let planes = sizes.map(|size| Planes::zeros(size, 1));
            let masks: Vec<Vec<bool>> =
                sizes.iter().map(|s| (0..s.texels()).map(|_| stream.below(12) == 0).collect()).collect();
            let exemplars = [0, 1].map(|e| Exemplar { index: &planes[e], excluded: Some(&masks[e]) });
            let block = 3;
            let mut truth = Vec::new();
            for (e, size) in sizes.iter().enumerate() {
                for y in 0..=size.height - block {
                    for x in 0..=size.width - block {
                        let free = (0..9).all(|i| !masks[e][size.index(x + i % 3, y + i / 3)]);
                        if free {
                            truth.push(Texel { exemplar: e as u32, y: y as u32, x: x as u32 });
                        }
                    }
                }
            }
            let found = Positions::new(&exemplars, block);
            if truth.is_empty() {
                assert!(found.is_err());
                continue;
            }
            let found = found.unwrap();
            assert_eq!((0..found.count()).map(|n| found.nth(n)).collect::<Vec<_>>(), truth);
            assert_eq!(found.iter().collect::<Vec<_>>(), truth);
            assert!(truth.iter().enumerate().all(|(n, texel)| found.number(*texel) == Some(n)));
            for (e, size) in sizes.iter().enumerate() {
                let texels = (0..12).flat_map(|y| (0..12).map(move |x| Texel { exemplar: e as u32, y, x }));
                assert!(texels.into_iter().all(|t| found.contains(t) == truth.contains(&t)), "{size}");
            }
        }
    }

    #[test]
    fn blocks_larger_than_an_exemplar_are_refused() {
        let small = Planes::zeros(Size::new(4, 8), 1);
        let error = Positions::new(&[Exemplar { index: &small, excluded: None }], 5).unwrap_err();
        assert!(error.message().contains("4 x 8"));
        assert_eq!(Positions::new(&[Exemplar { index: &small, excluded: None }], 4).unwrap().count(), 5);
    }
}
