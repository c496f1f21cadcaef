//! Where a block can be taken from: all positions at which it lies inside an exemplar and covers
//! no excluded texel.

use super::quantise::Exemplar;
use super::source_map::Texel;
use crate::error::{Error, Result};

/// Neighbouring positions in one row of an exemplar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Run {
    /// The leftmost position.
    pub first: Texel,
    /// How many there are.
    pub length: usize,
}

/// The valid positions of a block's top-left texel, in the order of exemplar, row, column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Positions {
    runs: Vec<Run>,
    count: usize,
}

impl Positions {
    /// The positions of blocks of `block` x `block` texels.
    ///
    /// # Errors
    /// When an exemplar is smaller than the block, or none leaves room for it.
    pub fn new(exemplars: &[Exemplar<'_>], block: usize) -> Result<Self> {
        let mut runs = Vec::new();
        for (number, exemplar) in exemplars.iter().enumerate() {
            let size = exemplar.index.size();
            if size.width < block || size.height < block {
                return Err(Error::usage(format!(
                    "a block of {block} x {block} texels does not fit exemplar {} of {size}: choose a \
                     block of at most {}",
                    number + 1,
                    size.width.min(size.height)
                )));
            }
            let mut rejected = Rejected::new(exemplar, block);
            for y in 0..=size.height - block {
                rejected.advance(y);
                let at = |x: usize| Texel { exemplar: number as u32, y: y as u32, x: x as u32 };
                let mut x = 0;
                while x <= size.width - block {
                    let end = (x..=size.width - block).find(|&x| rejected.covers(x));
                    let end = end.unwrap_or(size.width - block + 1);
                    if end > x {
                        runs.push(Run { first: at(x), length: end - x });
                    }
                    x = end + 1;
                }
            }
        }
        let count = runs.iter().map(|run| run.length).sum();
        if count == 0 {
            return Err(Error::usage(format!(
                "the masks leave no place for a block of {block} x {block} texels: exclude less or choose \
                 a smaller block"
            )));
        }
        Ok(Self { runs, count })
    }

    /// The positions as runs along rows.
    pub fn runs(&self) -> &[Run] {
        &self.runs
    }

    /// How many positions there are; at least one.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Whether a block can be taken from `position`.
    pub fn contains(&self, position: Texel) -> bool {
        let after = self.runs.partition_point(|run| run.first <= position);
        let Some(run) = after.checked_sub(1).map(|i| self.runs[i]) else { return false };
        let Texel { exemplar, y, x } = run.first;
        (exemplar, y) == (position.exemplar, position.y) && ((position.x - x) as usize) < run.length
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

/// Counts of excluded texels in the block's rows, for one row of positions after another.
struct Rejected<'a> {
    exemplar: &'a Exemplar<'a>,
    block: usize,
    /// Before column x: excluded texels of the block's rows.
    before: Vec<usize>,
}

impl<'a> Rejected<'a> {
    fn new(exemplar: &'a Exemplar<'a>, block: usize) -> Self {
        Self { exemplar, block, before: vec![0; exemplar.index.size().width + 1] }
    }

    fn advance(&mut self, y: usize) {
        let Some(mask) = self.exemplar.excluded else { return };
        let size = self.exemplar.index.size();
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
    use crate::numeric::random::Stream;
    use crate::planes::{Planes, Size};

    #[test]
    fn positions_are_those_that_cover_no_excluded_texel() {
        let sizes = [Size::new(9, 7), Size::new(5, 11)];
        for seed in 0..20 {
            let mut stream = Stream::new(seed, 0);
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
            for exemplar in 0..3 {
                for (y, x) in (0..12).flat_map(|y| (0..10).map(move |x| (y, x))) {
                    let position = Texel { exemplar, y, x };
                    assert_eq!(found.contains(position), truth.contains(&position));
                }
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
