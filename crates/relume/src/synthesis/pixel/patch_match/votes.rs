//! From matches to texels: each becomes the exemplar texel, among those proposed by the matches of the
//! patches over it, that is nearest to their weighted mean.
//!
//! Rows of the output are processed in parallel. Each collects the sums of all matches that reach it, run
//! after run, and goes through the same runs again to find the nearest. A match that only continues the one
//! to its left proposes the same texels there, which need no second comparison.

use super::super::canvas::PixelCanvas;
use super::SPACING;
use super::anchors::Anchors;
use super::patches::ExemplarPatches;
use super::search::{Match, Matching};
use crate::parallel;
use crate::synthesis::quantise::MAX_CODE;
use crate::synthesis::source_map::Texel;

/// The weight of a match with the mean distance, before softening.
const UNIT: f64 = 16.0;

/// The fraction of the mean distance added to each distance, so that perfect matches have at most 20 times,
/// or at the finest level 400 times, the weight of one with the mean distance.
const SOFTNESS: f64 = 0.05;

/// The weight of each match: the mean distance divided by its own, or the square of that; 0 for patches that
/// are not matched.
pub fn weights(matching: &Matching, patches: &ExemplarPatches<'_>, squared: bool) -> Vec<u32> {
    let mean = matching.mean_distance().max(1.0);
    let votes = patches.window().div_ceil(SPACING).pow(2) as u32;
    let most = i32::MAX.unsigned_abs() / u32::from(MAX_CODE.unsigned_abs()) / votes;
    let weight = |found: &Match| {
        let ratio = mean / (found.distance as f64 + SOFTNESS * mean);
        let raised = if squared { ratio * ratio } else { ratio };
        ((UNIT * raised) as u32).clamp(1, most)
    };
    let mut weights = vec![0; matching.matches().len()];
    matching.active().iter().for_each(|&cell| weights[cell] = weight(&matching.matches()[cell]));
    weights
}

/// Sets every texel without an anchor anew; each match has a vote of the given weight.
pub fn cast(
    canvas: &mut PixelCanvas,
    patches: &ExemplarPatches<'_>,
    matching: &Matching,
    weights: &[u32],
    anchors: Option<&Anchors>,
) {
    let size = canvas.size();
    let is_free = |texel: usize| anchors.is_none_or(|anchors| anchors.source(texel).is_none());
    let row = |y: usize| {
        let has_free = (0..size.width).any(|x| is_free(size.index(x, y)));
        let elected = has_free.then(|| VoteRow::new(canvas, patches, matching, weights, y).elect());
        elected.unwrap_or_else(|| canvas.sources(y).to_vec())
    };
    let sources = parallel::map(0..size.height, row);
    for (texel, source) in sources.into_iter().flatten().enumerate().filter(|(texel, _)| is_free(*texel)) {
        canvas.put(texel, source, &patches.level().exemplars);
    }
}

/// One row of the output: the rows of patches that reach it.
struct VoteRow<'a> {
    patches: &'a ExemplarPatches<'a>,
    width: usize,
    planes: usize,
    /// The number of the first planes, which are copied.
    copied: usize,
    /// Matches with their weights, and the row of the patch that lies here.
    reaching: Vec<(&'a [Match], &'a [u32], usize)>,
}

impl<'a> VoteRow<'a> {
    fn new(
        canvas: &PixelCanvas,
        patches: &'a ExemplarPatches<'a>,
        matching: &'a Matching,
        weights: &'a [u32],
        y: usize,
    ) -> Self {
        let size = canvas.size();
        let middle = |dy: usize| (y + size.height + patches.radius() - dy) % size.height;
        let rows =
            (0..patches.window()).map(|dy| (dy, middle(dy))).filter(|(_, y)| y.is_multiple_of(SPACING));
        let columns = size.width.div_ceil(SPACING);
        let row =
            |(dy, y): (usize, usize)| (matching.row(y), &weights[y / SPACING * columns..][..columns], dy);
        let reaching = rows.map(row).collect();
        let planes = patches.level().exemplars.planes();
        Self { patches, width: size.width, planes, copied: planes - canvas.guides(), reaching }
    }

    /// The sources of the texels of the row.
    fn elect(&self) -> Vec<Texel> {
        let window = self.patches.window();
        let mut sums = vec![0i32; (self.width + window) * self.planes];
        let mut totals = vec![0i32; self.width + window];
        self.add(&mut sums, &mut totals);
        self.wrap(&mut sums, self.planes);
        self.wrap(&mut totals, 1);
        let mut nearest = vec![(u64::MAX, Texel::default()); self.width + window];
        self.compare(&sums, &totals, &mut nearest);
        let radius = self.patches.radius();
        for i in (0..radius).chain(self.width + radius..self.width + window) {
            let inside = radius + (i + self.width - radius) % self.width;
            nearest[inside] = nearest[inside].min(nearest[i]);
        }
        nearest[radius..][..self.width].iter().map(|(_, source)| *source).collect()
    }

    /// Sums of weighted codes and of weights, from a radius left of the first column.
    fn add(&self, sums: &mut [i32], totals: &mut [i32]) {
        let window = self.patches.window();
        for (matches, weights, dy) in &self.reaching {
            let cells = matches.iter().zip(*weights).enumerate().filter(|(_, (_, weight))| **weight > 0);
            for (cell, (found, &weight)) in cells {
                let start = cell * SPACING;
                let weight = weight.cast_signed();
                totals[start..][..window].iter_mut().for_each(|total| *total += weight);
                let codes = self.run(found.corner, *dy);
                let sums = &mut sums[start * self.planes..][..window * self.planes];
                sums.iter_mut().zip(codes).for_each(|(sum, &code)| *sum += weight * i32::from(code));
            }
        }
    }

    /// Adds the sums beyond the edges to their places around the torus, and copies them back.
    fn wrap(&self, values: &mut [i32], planes: usize) {
        let (radius, window) = (self.patches.radius(), self.patches.window());
        let outside = || (0..radius).chain(self.width + radius..self.width + window);
        let inside = |i: usize| radius + (i + self.width - radius) % self.width;
        for (i, k) in outside().flat_map(|i| (0..planes).map(move |k| (i, k))) {
            values[inside(i) * planes + k] += values[i * planes + k];
        }
        for (i, k) in outside().flat_map(|i| (0..planes).map(move |k| (i, k))) {
            values[i * planes + k] = values[inside(i) * planes + k];
        }
    }

    /// Keeps the proposal nearest to the mean at each texel, the first of the texels of the exemplars among
    /// equals.
    fn compare(&self, sums: &[i32], totals: &[i32], nearest: &mut [(u64, Texel)]) {
        let window = self.patches.window();
        for (matches, weights, dy) in &self.reaching {
            let mut before = None;
            for (cell, (found, &weight)) in matches.iter().zip(*weights).enumerate() {
                if weight == 0 {
                    before = None;
                    continue;
                }
                let continues = before == Some(found.corner);
                before = Some(found.corner.offset(SPACING, 0));
                let first = if continues { window - SPACING } else { 0 };
                let codes = self.run(found.corner, *dy);
                for dx in first..window {
                    let at = cell * SPACING + dx;
                    let mean = &sums[at * self.planes..][..self.copied];
                    let codes = &codes[dx * self.planes..][..self.copied];
                    let distance = distance(codes, mean, totals[at]);
                    if distance <= nearest[at].0 {
                        nearest[at] = nearest[at].min((distance, found.corner.offset(dx, *dy)));
                    }
                }
            }
        }
    }

    /// The codes of one row of a patch.
    fn run(&self, corner: Texel, dy: usize) -> &[i16] {
        let exemplar = &self.patches.level().exemplars.texels()[corner.exemplar as usize];
        exemplar.run(corner.x as usize, corner.y as usize + dy, self.patches.window())
    }
}

/// The squared distance of a texel from a mean, times the square of the weight of the mean.
#[inline(always)]
fn distance(codes: &[i16], sums: &[i32], total: i32) -> u64 {
    let square = |(&code, &sum): (&i16, &i32)| i64::from(i32::from(code) * total - sum).pow(2).unsigned_abs();
    codes.iter().zip(sums).map(square).sum()
}
