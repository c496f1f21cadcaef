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
//! The output is always a torus: it tiles.

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
    /// Seed of the random choices.
    pub seed: u64,
}

impl Default for PatchMatchOptions {
    /// 256 x 256 texels, patches of 9 at 5 levels, 5 rounds, uniformity 0.3.
    fn default() -> Self {
        Self {
            size: Size::new(256, 256),
            window: 9,
            levels: 5,
            rounds: 5,
            search: PatchSearch::Propagation,
            uniformity: 0.3,
            guidance: None,
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
    options.validate()?;
    let levels = options.fitting_levels(exemplars);
    let guided = Guided::new(exemplars, options.guidance.as_ref(), options.size, job)?;
    let (pyramid, targets) = guided_pyramid(&guided, levels, options.window, job)?;
    let _codes = job.hold("the codes of the exemplars", pyramid.iter().map(ExemplarLevel::bytes).sum())?;
    let sizes: Vec<Size> =
        std::iter::successors(Some(options.size), |size| Some(halved_size(*size))).take(levels).collect();
    job.start("improving matches", levels as u64);
    let mut optimised = Optimised { levels, positions: 0, patches: 0, distance: 0.0 };
    let mut done: Option<PixelCanvas> = None;
    for (number, (level, size)) in pyramid.iter().zip(sizes).enumerate().rev() {
        let patches = ExemplarPatches::new(level, options.window, job)?;
        let mut canvas = PixelCanvas::new(size, level.exemplars.planes(), Boundary::Torus, job)?;
        if let Some(target) = &targets[number] {
            canvas.guide(target);
        }
        let place = number as u64;
        let mut matching = begin(&mut canvas, &patches, done.as_ref(), (options.seed, place));
        let rounds = if number == 0 { options.rounds.min(FINEST_ROUNDS) } else { options.rounds };
        for round in 0..rounds {
            let key = key(options.seed, Purpose::PatchSearch, [place, round as u64]);
            let how = Improvement { search: options.search, uniformity: options.uniformity, key };
            matching.improve(&canvas, &patches, how, job)?;
            let weights = votes::weights(&matching, &patches, number == 0);
            votes::cast(&mut canvas, &patches, &matching, &weights);
            job.proceed()?;
        }
        job.advance(1)?;
        optimised.positions = patches.count();
        optimised.patches = matching.matches().len();
        let texels = (options.window * options.window) as f64;
        optimised.distance = (matching.mean_distance() / texels).sqrt() * level.exemplars.step();
        done = Some(canvas);
    }
    Ok((done.expect("there is at least one level").into_map(exemplars), optimised))
}

/// The initial texels and matches of a level: those of the coarser one at twice the resolution, or random
/// patches side by side, drawn for the level of that number.
fn begin(
    canvas: &mut PixelCanvas,
    patches: &ExemplarPatches<'_>,
    coarser: Option<&PixelCanvas>,
    (seed, level): (u64, u64),
) -> Matching {
    let (size, radius) = (canvas.size(), patches.radius());
    let random = |texel: usize| {
        let mut stream = Stream::new(seed, Purpose::FirstPatch, [level, texel as u64]);
        patches.nth(stream.below(patches.count()))
    };
    let finer = |coarser: &PixelCanvas, x: usize, y: usize| {
        let source = coarser.source(coarser.size().index(x / 2, y / 2));
        let place = Texel { x: 2 * source.x, y: 2 * source.y, ..source }.offset(x % 2, y % 2);
        patches.moved(place, -radius.cast_signed(), -radius.cast_signed())
    };
    let corner = |(x, y)| {
        let found = coarser.and_then(|coarser| finer(coarser, x, y));
        found.unwrap_or_else(|| random(size.index(x, y)))
    };
    let matching = Matching::new(size, Matching::middles(size).map(corner).collect());
    for texel in 0..size.texels() {
        let (x, y) = canvas.place(texel);
        let middle = (x / SPACING * SPACING, y / SPACING * SPACING);
        let source = matching.at(middle).corner.offset(radius + x - middle.0, radius + y - middle.1);
        canvas.put(texel, source, &patches.level().exemplars);
    }
    matching
}

#[cfg(test)]
mod tests;
