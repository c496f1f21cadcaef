//! Matching each patch of the output to a patch of the exemplars.
//!
//! Propagation tries the matches of the four neighbours, shifted by their distance. Random search tries
//! patches around the best one so far, within half the distance each time (Barnes et al. 2009). Where we
//! differ from the paper, which visits the patches in order: they are improved in two sets, as the colours of
//! a chessboard, each in parallel and from the previous matches, so that the result does not depend on the
//! number of threads. The full search is the slow truth.
//!
//! Alone, this leads to repetitions of the part of the exemplar that matches itself best. As in Kaspar,
//! Neubert, Lischinski, Pauly, Kopf, "Self Tuning Texture Optimization", Computer Graphics Forum 2015,
//! matches therefore cost more where the exemplar is overused: the mean distance of the previous round times
//! the requested uniformity, for each time the even share of a block of 4 x 4 texels.

use serde::Serialize;

use super::super::canvas::PixelCanvas;
use super::super::vectors::LANES;
use super::SPACING;
use super::anchors::Anchors;
use super::patches::{self, ExemplarPatches};
use crate::error::Result;
use crate::job::Job;
use crate::numeric::hash;
use crate::parallel;
use crate::size::Size;
use crate::synthesis::source_map::Texel;

/// Cells that one thread looks at together.
const TOGETHER: usize = 64;

/// The methods of finding matches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum PatchSearch {
    /// By propagation and random search.
    Propagation,
    /// Among all patches, whatever their use.
    Full,
}

/// One round of [`Matching::improve`].
#[derive(Debug, Clone, Copy)]
pub struct Improvement {
    /// The method of finding matches.
    pub search: PatchSearch,
    /// The penalty for overused parts of the exemplars.
    pub uniformity: f64,
    /// The key of the hash of the random search: a different one in each round.
    pub key: u64,
}

/// A patch of the exemplars, and its distance from one of the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Match {
    /// Its top-left texel.
    pub corner: Texel,
    /// The squared distance when it was last compared.
    pub distance: u64,
}

/// For each patch of the output, with middles `SPACING` texels apart, its match.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Matching {
    size: Size,
    cells: Size,
    matches: Vec<Match>,
    /// The numbers of the patches that are matched, in order; the others lie among texels that stay.
    active: Vec<usize>,
}

impl Matching {
    /// Matches of all patches, given by their top-left texels, with unknown distances.
    pub fn new(size: Size, corners: Vec<Texel>) -> Self {
        let cells = Self::cells(size);
        assert_eq!(corners.len(), cells.texels(), "one match for each patch");
        let matches = corners.into_iter().map(|corner| Match { corner, distance: 0 }).collect();
        let active = (0..cells.texels()).collect();
        Self { size, cells, matches, active }
    }

    /// The same, matching only the patches with texels to be found.
    #[must_use]
    pub fn around(mut self, anchors: &Anchors, radius: usize) -> Self {
        let mut reached = vec![false; self.cells.texels()];
        let near = |at: usize, length: usize| {
            let around = (at + length - radius..=at + length + radius).map(move |at| at % length);
            around.filter(|at| at.is_multiple_of(SPACING)).map(|at| at / SPACING)
        };
        for texel in anchors.free() {
            let (x, y) = (texel % self.size.width, texel / self.size.width);
            for row in near(y, self.size.height) {
                near(x, self.size.width).for_each(|column| reached[self.cells.index(column, row)] = true);
            }
        }
        self.active.retain(|&cell| reached[cell]);
        self
    }

    /// The number of patches that are matched.
    pub fn in_use(&self) -> usize {
        self.active.len()
    }

    /// The numbers of the patches that are matched.
    pub fn active(&self) -> &[usize] {
        &self.active
    }

    /// Columns and rows of patches of an output.
    pub fn cells(size: Size) -> Size {
        Size::new(size.width.div_ceil(SPACING), size.height.div_ceil(SPACING))
    }

    /// The middles of the patches of an output in order.
    pub fn middles(size: Size) -> impl Iterator<Item = (usize, usize)> {
        let rows = (0..size.height).step_by(SPACING);
        rows.flat_map(move |y| (0..size.width).step_by(SPACING).map(move |x| (x, y)))
    }

    /// All matches, row by row.
    pub fn matches(&self) -> &[Match] {
        &self.matches
    }

    /// The matches of the patches whose middles lie in one row of the output.
    pub fn row(&self, y: usize) -> &[Match] {
        &self.matches[y / SPACING * self.cells.width..][..self.cells.width]
    }

    /// The match of the patch around a middle.
    pub fn at(&self, (x, y): (usize, usize)) -> Match {
        self.matches[self.cells.index(x / SPACING, y / SPACING)]
    }

    /// The mean squared distance of the patches that are matched.
    pub fn mean_distance(&self) -> f64 {
        let sum: u64 = self.active.iter().map(|&cell| self.matches[cell].distance).sum();
        sum as f64 / self.active.len().max(1) as f64
    }

    /// Improves all matches for the texels of a canvas.
    ///
    /// # Errors
    /// When the job is cancelled.
    pub fn improve(
        &mut self,
        canvas: &PixelCanvas,
        patches: &ExemplarPatches<'_>,
        how: Improvement,
        job: &Job,
    ) -> Result<()> {
        let costs = self.costs(patches, how.uniformity);
        for color in 0..2 {
            let cells: Vec<usize> =
                self.active.iter().copied().filter(|&cell| self.color(cell) == color).collect();
            let found = parallel::try_map(cells.chunks(TOGETHER), |cells| {
                job.proceed()?;
                let mut patch = Vec::new();
                let better = |&cell: &usize| self.better(cell, canvas, patches, &costs, how, &mut patch);
                Ok(cells.iter().map(better).collect::<Vec<Match>>())
            })?;
            let found = found.into_iter().flatten();
            cells.iter().zip(found).for_each(|(&cell, found)| self.matches[cell] = found);
        }
        Ok(())
    }

    /// The extra cost of a match in each block of the exemplars.
    fn costs(&self, patches: &ExemplarPatches<'_>, uniformity: f64) -> Vec<u64> {
        let (blocks, in_use) = patches.blocks();
        let mut used = vec![0u64; blocks];
        self.matches.iter().for_each(|found| used[patches.block(found.corner)] += 1);
        let even = self.matches.len() as f64 / in_use as f64;
        let share = uniformity * self.mean_distance() / even;
        used.into_iter().map(|used| (share * used as f64) as u64).collect()
    }

    fn color(&self, cell: usize) -> usize {
        (cell % self.cells.width + cell / self.cells.width) % 2
    }

    fn middle(&self, cell: usize) -> (usize, usize) {
        (cell % self.cells.width * SPACING, cell / self.cells.width * SPACING)
    }

    /// The match of least cost found for one patch, at most that of the present one.
    fn better(
        &self,
        cell: usize,
        canvas: &PixelCanvas,
        patches: &ExemplarPatches<'_>,
        costs: &[u64],
        how: Improvement,
        patch: &mut Vec<i16>,
    ) -> Match {
        patches.of_output(canvas, self.middle(cell), patch);
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            return simd.vectorize(
                #[inline(always)]
                || {
                    self.better_with(cell, patches, costs, how, patch, |sums, a, b, length| {
                        patches::avx2(simd, sums, a, b, length)
                    })
                },
            );
        }
        self.better_with(cell, patches, costs, how, patch, patches::portable)
    }

    #[inline(always)]
    fn better_with(
        &self,
        cell: usize,
        patches: &ExemplarPatches<'_>,
        costs: &[u64],
        how: Improvement,
        patch: &[i16],
        squares: impl Fn(&mut [u32; LANES / 2], &[i16], &[i16], usize) + Copy,
    ) -> Match {
        let present = self.matches[cell].corner;
        let mut contest = Contest::new(patches, costs, patch, squares, present);
        if how.search == PatchSearch::Full {
            for corner in patches.iter() {
                contest.attempt(corner);
            }
            return contest.best;
        }
        for corner in self.of_neighbours(self.middle(cell), patches).into_iter().flatten() {
            contest.attempt(corner);
        }
        let mut reach = patches.reach();
        while reach > 0 {
            let [a, b, ..] = hash::of_place(how.key, cell as i64, reach as i64);
            let (dx, dy) = (step(a, reach), step(b, reach));
            if let Some(corner) = patches.moved(contest.best.corner, dx, dy) {
                contest.attempt(corner);
            }
            reach /= 2;
        }
        contest.best
    }

    /// The matches that continue those of the four neighbours.
    #[inline(always)]
    fn of_neighbours(&self, (x, y): (usize, usize), patches: &ExemplarPatches<'_>) -> [Option<Texel>; 4] {
        let Size { width, height } = self.size;
        let (left, right) = (away(x, width, true), away(x, width, false));
        let (above, below) = (away(y, height, true), away(y, height, false));
        [
            patches.moved(self.at((left.0, y)).corner, left.1, 0),
            patches.moved(self.at((right.0, y)).corner, right.1, 0),
            patches.moved(self.at((x, above.0)).corner, 0, above.1),
            patches.moved(self.at((x, below.0)).corner, 0, below.1),
        ]
    }
}

/// A random step of up to `reach` either way.
fn step(random: u32, reach: usize) -> isize {
    ((u64::from(random) * (2 * reach as u64 + 1)) >> 32) as isize - reach.cast_signed()
}

/// A search for the match of least cost of one patch.
struct Contest<'a, S> {
    patches: &'a ExemplarPatches<'a>,
    costs: &'a [u64],
    patch: &'a [i16],
    squares: S,
    best: Match,
    cost: u64,
}

impl<'a, S: Fn(&mut [u32; LANES / 2], &[i16], &[i16], usize) + Copy> Contest<'a, S> {
    #[inline(always)]
    fn new(
        patches: &'a ExemplarPatches<'a>,
        costs: &'a [u64],
        patch: &'a [i16],
        squares: S,
        present: Texel,
    ) -> Self {
        let distance = patches.distance(patch, present, u64::MAX, squares).expect("nothing is that far");
        let cost = distance + costs[patches.block(present)];
        Self { patches, costs, patch, squares, best: Match { corner: present, distance }, cost }
    }

    #[inline(always)]
    fn attempt(&mut self, corner: Texel) {
        let more = self.costs[self.patches.block(corner)];
        if corner == self.best.corner || more >= self.cost {
            return;
        }
        if let Some(distance) = self.patches.distance(self.patch, corner, self.cost - more, self.squares) {
            self.best = Match { corner, distance };
            self.cost = distance + more;
        }
    }
}

/// The next middle along an axis, before or after one, and the offset from there, around a torus.
fn away(at: usize, length: usize, before: bool) -> (usize, isize) {
    let last = (length - 1) / SPACING * SPACING;
    match before {
        true if at >= SPACING => (at - SPACING, SPACING.cast_signed()),
        true => (last, (at + length - last).cast_signed()),
        false if at + SPACING < length => (at + SPACING, -SPACING.cast_signed()),
        false => (0, at.cast_signed() - length.cast_signed()),
    }
}
