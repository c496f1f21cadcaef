//! Texture optimisation with approximate patch search, coarse to fine, by copies alone.
//!
//! Kwatra, Essa, Bobick, Kwatra, "Texture Optimization for Example-based Synthesis", SIGGRAPH 2005:
//! patches of the output, every other texel along either side, are matched to patches of the
//! exemplars, and each texel becomes what the matches of the patches over it want; the two steps
//! alternate. As in Han, Zhou, Wei et al., "Fast Example-based Surface Texture Synthesis via Discrete
//! Optimization", The Visual Computer 2006, a texel is not their mean but the wanted exemplar texel
//! that is nearest to the mean, so that every texel stays a copy. Matches are found by propagation
//! and random search ([`search`]): Barnes, Shechtman, Finkelstein, Goldman, "PatchMatch", SIGGRAPH 2009.
//!
//! Different from them: distances are plain sums of squares of integers, without the robust exponent.
//!
//! The output is always a torus: it tiles.

pub mod search;
mod votes;

use serde::Serialize;

use super::efros_leung::check_output;
use super::lattice::Lattice;
use super::pyramid::{Level, halved_size, pyramid};
use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::numeric::random::Stream;
use crate::planes::Size;
use crate::progress::Progress;
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::Exemplar;
use crate::synthesis::source_map::{SourceMap, Texel};
use search::{Improvement, Matching, Patches};

pub use search::PatchSearch;

/// Texels between the middles of neighbouring patches.
const SPACING: usize = 2;

/// Options of [`patch_match`].
#[derive(Debug, Clone, PartialEq)]
pub struct PatchMatchOptions {
    /// Size of the output in texels.
    pub size: Size,
    /// Side of the patches at every level in texels: odd, at least 3.
    pub window: usize,
    /// Resolutions, each half the one before.
    pub levels: usize,
    /// How often matches and texels are improved at each level.
    pub rounds: usize,
    /// How matches are found.
    pub search: PatchSearch,
    /// How much parts of the exemplars are avoided that are used more than evenly; 0 not at all.
    pub uniformity: f64,
    /// Seed of the random choices.
    pub seed: u64,
}

impl Default for PatchMatchOptions {
    /// 256 x 256 texels, patches of 7 at 4 levels, 3 rounds, uniformity 0.3.
    fn default() -> Self {
        Self {
            size: Size::new(256, 256),
            window: 7,
            levels: 4,
            rounds: 3,
            search: PatchSearch::Propagation,
            uniformity: 0.3,
            seed: 0,
        }
    }
}

impl PatchMatchOptions {
    /// Checks the options by themselves; whether patches fit the exemplars shows when they are met.
    pub fn validate(&self) -> Result<()> {
        if self.levels == 0 || self.levels > 16 {
            return Err(Error::usage(format!("{} levels: choose 1 to 16", self.levels)));
        }
        if !self.uniformity.is_finite() || self.uniformity < 0.0 {
            return Err(Error::usage(format!(
                "a uniformity of {} has no meaning: it must be a number of at least 0",
                self.uniformity
            )));
        }
        if self.rounds == 0 {
            return Err(Error::usage("0 rounds make no texture: choose at least 1"));
        }
        let coarsest = (1..self.levels).fold(self.size, |size, _| halved_size(size));
        check_output(self.size, self.window, Boundary::Open)?;
        check_output(coarsest, self.window, Boundary::Torus).map_err(|_| {
            Error::usage(format!(
                "an output of {} texels is {coarsest} at the coarsest of {} levels, where a patch of {} would \
                 overlap itself: choose fewer levels, a smaller window or a larger output",
                self.size, self.levels, self.window
            ))
        })
    }
}

/// How an output came about.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Optimised {
    /// Patches of the exemplars at the finest level.
    pub positions: usize,
    /// Patches of the output at the finest level.
    pub patches: usize,
    /// Root mean square distance, over their texels in index space, of the last matches.
    pub distance: f64,
}

/// Makes an output by improving it as a whole, the coarsest level first.
///
/// The result depends on the exemplars and the options only, not on the number of threads.
///
/// # Errors
/// When the options mean nothing, no patch fits the exemplars at the coarsest level, or the limits
/// are exceeded.
pub fn patch_match(
    exemplars: &[Exemplar<'_>],
    options: &PatchMatchOptions,
    limits: &Limits,
    progress: &dyn Progress,
) -> Result<(SourceMap, Optimised)> {
    options.validate()?;
    let pyramid = pyramid(exemplars, options.levels, options.window, limits)?;
    let sizes: Vec<Size> = std::iter::successors(Some(options.size), |size| Some(halved_size(*size)))
        .take(options.levels)
        .collect();
    progress.start("improving matches", (options.levels * options.rounds) as u64);
    let mut optimised = Optimised { positions: 0, patches: 0, distance: 0.0 };
    let mut done: Option<Lattice> = None;
    for (number, (level, size)) in pyramid.iter().zip(sizes).enumerate().rev() {
        let patches = Patches::new(level, options.window, limits)?;
        let mut lattice = Lattice::new(size, level.exemplars.planes(), Boundary::Torus, limits)?;
        let seed = options.seed.wrapping_mul(31).wrapping_add((number * options.rounds) as u64);
        let mut matching = begin(&mut lattice, level, &patches, done.as_ref(), seed);
        for round in 0..options.rounds {
            let seed = seed.wrapping_add(round as u64);
            let how = Improvement { search: options.search, uniformity: options.uniformity, seed };
            matching.improve(&lattice, &patches, how);
            votes::cast(&mut lattice, level, &patches, &matching);
            progress.advance(1);
        }
        let texels = (matching.count() * options.window * options.window) as f64;
        let sum: f64 = matching.distances().map(|distance| distance as f64).sum();
        optimised = Optimised {
            positions: patches.count(),
            patches: matching.count(),
            distance: (sum / texels).sqrt() * level.exemplars.step(),
        };
        done = Some(lattice);
    }
    Ok((done.expect("there is at least one level").into_map(exemplars), optimised))
}

/// The first texels and matches of a level: those of the coarser one at twice the resolution, or
/// random patches side by side.
fn begin(
    lattice: &mut Lattice,
    level: &Level,
    patches: &Patches,
    coarser: Option<&Lattice>,
    seed: u64,
) -> Matching {
    let size = lattice.size();
    let random = |texel: usize| Stream::new(seed, texel as u64).below(patches.count());
    let finer = |coarser: &Lattice, x: usize, y: usize| {
        let Texel { exemplar, x: sx, y: sy } = coarser.source(coarser.size().index(x / 2, y / 2));
        let place = Texel { exemplar, x: 2 * sx + (x % 2) as u32, y: 2 * sy + (y % 2) as u32 };
        patches.number(place)
    };
    let mut numbers = Vec::with_capacity(Matching::cells(size).texels());
    for (x, y) in Matching::middles(size) {
        let found = coarser.and_then(|coarser| finer(coarser, x, y));
        numbers.push(found.unwrap_or_else(|| random(size.index(x, y))) as u32);
    }
    let matching = Matching::new(size, numbers);
    for texel in 0..size.texels() {
        let (x, y) = lattice.place(texel);
        let middle = (x / SPACING * SPACING, y / SPACING * SPACING);
        let source = patches.place(matching.at(middle)).offset(x - middle.0, y - middle.1);
        lattice.put(texel, source, &level.exemplars);
    }
    matching
}

#[cfg(test)]
mod tests;
