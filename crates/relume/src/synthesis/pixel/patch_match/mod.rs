//! Texture optimisation with approximate patch search, coarse to fine, by copies alone.
//!
//! Kwatra, Essa, Bobick, Kwatra, "Texture Optimization for Example-based Synthesis", SIGGRAPH 2005: patches
//! of the output, at every other texel along either side, are matched to patches of the exemplars, and each
//! texel becomes what the matches of the patches over it propose; the two steps alternate. As in Han, Zhou,
//! Wei et al., "Fast Example-based Surface Texture Synthesis via Discrete Optimization", The Visual Computer
//! 2006, a texel is not their mean but the proposed exemplar texel nearest to the mean, so that every texel
//! stays a copy. Matches are found by propagation and random search ([`search`]): Barnes, Shechtman,
//! Finkelstein, Goldman, "PatchMatch", SIGGRAPH 2009.
//!
//! The votes of good matches have larger weights, like the robust distance of Kwatra et al. ([`votes`]).
//!
//! Where we differ: distances are plain sums of squares of integers, and with the mean squared distance m a
//! match of distance d has the weight m / (d + m / 20), at the finest level the square of that. The coarser
//! levels thus agree on positions, and the finest one keeps the result sharp.
//!
//! The output is always a torus, at every level, and tiles whatever its size: where a side does not halve
//! evenly, `finer` drops a seam of least error. Texels with `anchors` stay as they are, so that the same
//! method completes a hole.

pub mod anchors;
mod finer;
mod open;
pub mod patches;
pub mod plain;
pub mod search;
pub mod votes;

use serde::Serialize;

use super::canvas::PixelCanvas;
use super::grow::check_output;
use super::pyramid::{ExemplarLevel, guided_pyramid, halved_size};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream, key};
use crate::size::Size;
use crate::synthesis::guidance::{Guidance, Guided};
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::Exemplar;
use crate::synthesis::source_map::{SourceMap, Texel};
use anchors::Anchors;
use finer::finer;
use open::{with_margin, without_margin};
use patches::ExemplarPatches;
use search::{Improvement, Matching};

pub use search::PatchSearch;

/// Texels between the middles of neighbouring patches.
const SPACING: usize = 2;

/// Rounds at the finest level, which only has to sharpen.
const FINEST_ROUNDS: usize = 2;

/// Options of [`patch_match`].
#[derive(Debug, Clone, PartialEq)]
pub struct PatchMatchOptions {
    /// Size of the output in texels.
    pub size: Size,
    /// Side of the patches at every level in texels: odd, 3 to 1023.
    pub window: usize,
    /// The most resolutions, each half the one before; fewer where a patch no longer fits.
    pub levels: usize,
    /// The number of improvements of matches and texels at each level, at most two at the finest one: 1 to
    /// 1000.
    pub rounds: usize,
    /// How matches are found.
    pub search: PatchSearch,
    /// The penalty for overused parts of the exemplars: 0, none, to 1000.
    pub uniformity: f64,
    /// The guide that the output follows.
    pub guidance: Option<Guidance>,
    /// Whether the output closes around its borders. It costs nothing; a border costs a margin.
    pub boundary: Boundary,
    /// Seed of the random choices.
    pub seed: u64,
}

impl Default for PatchMatchOptions {
    /// 256 x 256 texels, patches of 9 at 5 levels, 5 rounds, uniformity 0.3, closing around the borders.
    fn default() -> Self {
        Self {
            size: Size::new(256, 256),
            window: 9,
            levels: 5,
            rounds: 5,
            search: PatchSearch::Propagation,
            uniformity: 0.3,
            guidance: None,
            boundary: Boundary::Torus,
            seed: 0,
        }
    }
}

impl PatchMatchOptions {
    /// Checks the options in isolation; they are checked against the exemplars later.
    pub fn validate(&self) -> Result<()> {
        if self.levels == 0 || self.levels > 16 {
            return Err(Error::usage(format!("{} levels: choose 1 to 16", self.levels)));
        }
        if !(0.0..=1000.0).contains(&self.uniformity) {
            return Err(Error::usage(format!(
                "a uniformity of {} has no meaning: expected a number from 0 to 1000",
                self.uniformity
            )));
        }
        if !(1..=1000).contains(&self.rounds) {
            return Err(Error::usage(format!("{} rounds: choose 1 to 1000", self.rounds)));
        }
        check_output(self.size, self.window, Boundary::Torus)
    }

    /// The number of resolutions at which patches fit the exemplars and do not overlap themselves in the
    /// output; at least one.
    fn fitting_levels(&self, exemplars: &[Exemplar<'_>]) -> usize {
        let sides = exemplars.iter().map(|exemplar| exemplar.index.size()).chain([self.size]);
        let least = sides.map(|size| size.width.min(size.height)).min().expect("the output has a size");
        let coarser = |side: &usize| Some(side.div_ceil(2));
        let levels = std::iter::successors(Some(least), coarser).take(self.levels);
        levels.take_while(|side| *side >= self.window).count().max(1)
    }
}

/// The report of an optimisation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Optimised {
    /// Resolutions.
    pub levels: usize,
    /// Patches of the exemplars at the finest level.
    pub positions: usize,
    /// Patches of the output at the finest level.
    pub patches: usize,
    /// The root mean square distance of the last matches, over their texels in index space.
    pub distance: f64,
}

/// Makes an output by improving it as a whole, the coarsest level first.
///
/// The result depends on the exemplars and the options only, not on the number of threads.
///
/// # Errors
/// When the options are invalid, no patch fits the exemplars, or the limits are exceeded.
pub fn patch_match(
    exemplars: &[Exemplar<'_>],
    options: &PatchMatchOptions,
    job: &Job,
) -> Result<(SourceMap, Optimised)> {
    if options.boundary == Boundary::Torus {
        let done = complete(exemplars, options, None, job)?;
        return Ok((done.map, done.optimised));
    }
    options.validate()?;
    let done = complete(exemplars, &with_margin(options), None, job)?;
    Ok((without_margin(&done.map, options.size), done.optimised))
}

/// What [`complete`] made.
pub(in crate::synthesis) struct Completed {
    /// Where each texel comes from.
    pub map: SourceMap,
    /// The report.
    pub optimised: Optimised,
    /// The difference in index space of one code.
    pub step: f64,
}

/// As [`patch_match`], but texels with anchors stay as they are; what lies between them continues them.
///
/// # Errors
/// As [`patch_match`].
pub(in crate::synthesis) fn complete(
    exemplars: &[Exemplar<'_>],
    options: &PatchMatchOptions,
    anchors: Option<Anchors>,
    job: &Job,
) -> Result<Completed> {
    options.validate()?;
    let levels = options.fitting_levels(exemplars);
    let guided = Guided::new(exemplars, options.guidance.as_ref(), options.size, job)?;
    let (mut pyramid, targets) = guided_pyramid(&guided, levels, options.window, job)?;
    drop_crowded(&mut pyramid, options.window);
    let _codes = job.hold("the codes of the exemplars", pyramid.iter().map(ExemplarLevel::bytes).sum())?;
    let (mut levels, mut size, mut anchors) = (Vec::new(), options.size, anchors);
    for _ in &pyramid {
        let coarser = anchors.as_ref().map(Anchors::halved);
        levels.push((size, std::mem::replace(&mut anchors, coarser)));
        size = halved_size(size);
    }
    job.start("improving matches", levels.len() as u64);
    let mut optimised = Optimised { levels: levels.len(), positions: 0, patches: 0, distance: 0.0 };
    let mut done: Option<PixelCanvas> = None;
    for (number, (level, (size, anchors))) in pyramid.iter().zip(levels).enumerate().rev() {
        let patches = ExemplarPatches::new(level, options.window, job)?;
        let mut canvas = PixelCanvas::new(size, level.exemplars.planes(), Boundary::Torus, job)?;
        if let Some(target) = &targets[number] {
            canvas.guide(target);
        }
        let sources = match &done {
            Some(coarser) => finer(coarser, level, size, anchors.as_ref()),
            None => random_patches(size, &patches, options.seed, number as u64),
        };
        let mut work = LevelWork { options, number, patches, anchors, job };
        let matching = work.run(&mut canvas, &sources)?;
        job.advance(1)?;
        optimised.positions = work.patches.count();
        optimised.patches = matching.in_use();
        let texels = (options.window * options.window) as f64;
        optimised.distance = (matching.mean_distance() / texels).sqrt() * level.exemplars.step();
        done = Some(canvas);
    }
    let map = done.expect("there is at least one level").into_map(exemplars);
    Ok(Completed { map, optimised, step: pyramid[0].exemplars.step() })
}

/// Removes the levels, from the first coarser one on, at which excluded texels leave no place for a patch.
fn drop_crowded(pyramid: &mut Vec<ExemplarLevel>, window: usize) {
    let has_room = |level: &ExemplarLevel| level.positions(window).is_ok();
    let fitting = pyramid.iter().skip(1).take_while(|level| has_room(level)).count();
    pyramid.truncate(1 + fitting);
}

/// Random whole patches side by side: the texels with which the coarsest level begins. Smaller pieces would leave
/// little but means, which draw the matches to blank parts.
fn random_patches(size: Size, patches: &ExemplarPatches<'_>, seed: u64, level: u64) -> Vec<Texel> {
    let side = patches.window();
    let cells = Size::new(size.width.div_ceil(side), size.height.div_ceil(side));
    let corner = |cell: usize| {
        let mut stream = Stream::new(seed, Purpose::FirstPatch, [level, cell as u64]);
        patches.nth(stream.below(patches.count()))
    };
    let corners: Vec<Texel> = (0..cells.texels()).map(corner).collect();
    let source = |(x, y): (usize, usize)| corners[cells.index(x / side, y / side)].offset(x % side, y % side);
    (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))).map(source).collect()
}

/// The improvement of one level.
struct LevelWork<'a> {
    options: &'a PatchMatchOptions,
    /// The number of the level, 0 for the finest.
    number: usize,
    patches: ExemplarPatches<'a>,
    anchors: Option<Anchors>,
    job: &'a Job,
}

impl LevelWork<'_> {
    /// Improves a canvas that begins with these sources.
    fn run(&mut self, canvas: &mut PixelCanvas, sources: &[Texel]) -> Result<Matching> {
        let (options, place) = (self.options, self.number as u64);
        let mut matching = self.begin(canvas, sources);
        let rounds = if self.number == 0 { options.rounds.min(FINEST_ROUNDS) } else { options.rounds };
        for round in 0..rounds {
            let key = key(options.seed, Purpose::PatchSearch, [place, round as u64]);
            let how = Improvement { search: options.search, uniformity: options.uniformity, key };
            matching.improve(canvas, &self.patches, how, self.job)?;
            let weights = votes::weights(&matching, &self.patches, self.number == 0);
            votes::cast(canvas, &self.patches, &matching, &weights, self.anchors.as_ref());
            self.job.proceed()?;
        }
        Ok(matching)
    }

    /// Puts the first texels, and matches each patch to the one around the source of its middle: the nearest
    /// inside the exemplar, or a random one where that contains excluded texels.
    fn begin(&self, canvas: &mut PixelCanvas, sources: &[Texel]) -> Matching {
        let size = canvas.size();
        for (texel, source) in sources.iter().enumerate() {
            let anchor = self.anchors.as_ref().and_then(|anchors| anchors.source(texel));
            canvas.put(texel, anchor.unwrap_or(*source), &self.patches.level().exemplars);
        }
        let corner = |(x, y)| {
            let around = self.patches.around(canvas.source(size.index(x, y)));
            around.unwrap_or_else(|| {
                let place = [self.number as u64, size.index(x, y) as u64, 0];
                let mut stream = Stream::new(self.options.seed, Purpose::FirstPatch, place);
                self.patches.nth(stream.below(self.patches.count()))
            })
        };
        let matching = Matching::new(size, Matching::middles(size).map(corner).collect());
        match &self.anchors {
            Some(anchors) => matching.around(anchors, self.patches.radius()),
            None => matching,
        }
    }
}

#[cfg(test)]
mod tests;
