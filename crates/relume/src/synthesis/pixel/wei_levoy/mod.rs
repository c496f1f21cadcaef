//! Scanline synthesis: Wei, Levoy, "Fast Texture Synthesis using Tree-structured Vector
//! Quantization", SIGGRAPH 2000, on index planes.
//!
//! The output begins as noise: copies of random exemplar texels. Row by row each texel becomes a copy of the
//! exemplar texel with the most similar neighbourhood: the texels above and to the left, which are already
//! done, and with several levels also all texels around it at the next coarser resolution, which is
//! synthesised first ([`neighbourhood`]). The most similar one is found among all ([`full`]), by a tree
//! ([`super::tsvq`]), or among few candidates ([`coherence`]).
//!
//! The output is always treated as a torus, as in the paper. Its first rows are made next to noise and the
//! last ones do not see the first, so it tiles well only where the coarser levels carry the structure across;
//! `synthesis::fill::close` refills its border.
//!
//! Exemplars are never read beyond their edges; the paper wraps or pads them.

pub mod coherence;
pub mod full;
pub mod neighbourhood;

use serde::Serialize;

use super::canvas::PixelCanvas;
use super::grow::check_output;
use super::pyramid::{ExemplarLevel, guided_pyramid, halved_size};
use super::tsvq::Tsvq;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};
use crate::size::Size;
use crate::synthesis::guidance::{Guidance, Guided};
use crate::synthesis::options::Boundary;
use crate::synthesis::quantise::Exemplar;
use crate::synthesis::source_map::SourceMap;
use coherence::{Coherence, Draws, Here};
use full::Full;
use neighbourhood::{ScanNeighbourhood, ScanSamples};

/// The search for the most similar neighbourhood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NeighbourSearch {
    /// Among all.
    Full,
    /// By a tree with the given number of codewords at each level, 1 to 2^30, at most one for each
    /// neighbourhood.
    Tsvq(usize),
    /// Among texels that continue the surroundings, and for each of them a number of similar ones.
    Coherence {
        /// Candidates for each continuation, including itself: 1 to 256.
        candidates: usize,
        /// Codewords of the tree in whose leaves they are found, up to 2^30; 0 for all neighbourhoods.
        codewords: usize,
    },
}

impl NeighbourSearch {
    /// Leaves of a tree: the fastest number (docs/methods.md).
    pub const CODEWORDS: usize = 4096;
    /// Only the continuations of neighbours, for which no tree is needed: pieces stay together.
    pub const CONTINUED: Self = Self::Coherence { candidates: 1, codewords: Self::CODEWORDS };
    /// The most candidates for each continuation.
    const MOST_CANDIDATES: usize = 256;
    /// The most codewords: more than any exemplar has neighbourhoods.
    const MOST_CODEWORDS: usize = 1 << 30;

    fn validate(self) -> Result<()> {
        let (candidates, least, codewords) = match self {
            Self::Full => return Ok(()),
            Self::Tsvq(codewords) => (1, 1, codewords),
            Self::Coherence { candidates, codewords } => (candidates, 0, codewords),
        };
        if !(1..=Self::MOST_CANDIDATES).contains(&candidates) {
            return Err(Error::usage(format!(
                "a coherence of {candidates} candidates: choose 1 to {}",
                Self::MOST_CANDIDATES
            )));
        }
        if !(least..=Self::MOST_CODEWORDS).contains(&codewords) {
            return Err(Error::usage(format!(
                "a tree of {codewords} codewords: choose {least} to {}",
                Self::MOST_CODEWORDS
            )));
        }
        Ok(())
    }
}

/// Options of [`wei_levoy`].
#[derive(Debug, Clone, PartialEq)]
pub struct WeiLevoyOptions {
    /// Size of the output in texels.
    pub size: Size,
    /// Side of the neighbourhood at every level in texels: odd, 3 to 1023.
    pub window: usize,
    /// Resolutions, each half the one before.
    pub levels: usize,
    /// The search for the most similar neighbourhood.
    pub search: NeighbourSearch,
    /// The guide that the output follows.
    pub guidance: Option<Guidance>,
    /// Seed of the noise.
    pub seed: u64,
}

impl Default for WeiLevoyOptions {
    /// 256 x 256 texels, windows of 5 at 4 levels, continued pieces.
    fn default() -> Self {
        Self {
            size: Size::new(256, 256),
            window: 5,
            levels: 4,
            search: NeighbourSearch::CONTINUED,
            guidance: None,
            seed: 0,
        }
    }
}

impl WeiLevoyOptions {
    /// Checks the options in isolation; they are checked against the exemplars later.
    pub fn validate(&self) -> Result<()> {
        if self.levels == 0 || self.levels > 16 {
            return Err(Error::usage(format!("{} levels: choose 1 to 16", self.levels)));
        }
        self.search.validate()?;
        let coarsest = (1..self.levels).fold(self.size, |size, _| halved_size(size));
        check_output(self.size, self.window, Boundary::Open)?;
        check_output(coarsest, self.window, Boundary::Torus).map_err(|_| {
            Error::usage(format!(
                "an output of {} texels is {coarsest} at the coarsest of {} levels, where a window of {} would \
                 see itself: choose fewer levels, a smaller window or a larger output",
                self.size, self.levels, self.window
            ))
        })
    }
}

/// The report of a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Scanned {
    /// Neighbourhoods of the exemplars at the finest level.
    pub neighbourhoods: usize,
    /// Leaves of the tree at the finest level, 0 without a tree.
    pub codewords: usize,
    /// The number of texels made, over all levels.
    pub texels: u64,
    /// The sum of the squared distances, in codes, of the chosen neighbourhoods at the finest level.
    pub distance: u64,
}

/// Makes an output in scanline order, the coarsest level first.
///
/// The result depends on the exemplars and the options only.
///
/// # Errors
/// When the options are invalid, no window fits the exemplars at the coarsest level, or the limits are
/// exceeded.
pub fn wei_levoy(
    exemplars: &[Exemplar<'_>],
    options: &WeiLevoyOptions,
    job: &Job,
) -> Result<(SourceMap, Scanned)> {
    options.validate()?;
    let guided = Guided::new(exemplars, options.guidance.as_ref(), options.size, job)?;
    let guides = guided.guides();
    let (pyramid, targets) = guided_pyramid(&guided, options.levels, options.window, job)?;
    let _codes = job.hold("the codes of the exemplars", pyramid.iter().map(ExemplarLevel::bytes).sum())?;
    let sizes: Vec<Size> = std::iter::successors(Some(options.size), |size| Some(halved_size(*size)))
        .take(options.levels)
        .collect();
    job.start("synthesising rows", sizes.iter().map(|size| size.height as u64).sum());
    let mut scanned = Scanned { neighbourhoods: 0, codewords: 0, texels: 0, distance: 0 };
    let mut done: Option<PixelCanvas> = None;
    for (number, (level, size)) in pyramid.iter().zip(sizes).enumerate().rev() {
        let neighbourhood = ScanNeighbourhood::new(options.window, done.is_some(), guides);
        let samples = ScanSamples::new(&neighbourhood, level, pyramid.get(number + 1), job)?;
        let draws = Draws { seed: options.seed, level: number as u64 };
        let causal = neighbourhood.causal();
        let search = PreparedSearch::new(options.search, &samples, &causal, level, draws, job)?;
        let _search = job.hold("the search of neighbourhoods", search.bytes())?;
        let mut canvas = noise(level, &samples, size, draws, job)?;
        if let Some(target) = &targets[number] {
            canvas.guide(target);
        }
        let mut query = Vec::new();
        scanned.distance = 0;
        for texel in 0..size.texels() {
            neighbourhood.of_output(&canvas, done.as_ref(), texel, &mut query);
            let (number, distance) =
                search.near(&query, Here { canvas: &canvas, coarser: done.as_ref(), texel });
            canvas.put(texel, samples.places[number], &level.exemplars);
            scanned.distance += distance;
            if (texel + 1).is_multiple_of(size.width) {
                job.advance(1)?;
            }
        }
        scanned.texels += size.texels() as u64;
        scanned.neighbourhoods = samples.places.len();
        scanned.codewords = search.codewords();
        done = Some(canvas);
    }
    let canvas = done.expect("there is at least one level");
    Ok((canvas.into_map(exemplars), scanned))
}

/// A search over the neighbourhoods of one level.
enum PreparedSearch<'a> {
    Full(Full<'a>),
    Tsvq(Tsvq),
    Coherence(Coherence<'a>),
}

impl<'a> PreparedSearch<'a> {
    fn new(
        search: NeighbourSearch,
        samples: &'a ScanSamples,
        causal: &'a [(isize, isize)],
        level: &ExemplarLevel,
        draws: Draws,
        job: &Job,
    ) -> Result<Self> {
        Ok(match search {
            NeighbourSearch::Full => Self::Full(Full { vectors: &samples.vectors }),
            NeighbourSearch::Tsvq(codewords) => {
                job.check_bytes("the tree of the neighbourhoods", Tsvq::bytes(&samples.vectors, codewords))?;
                Self::Tsvq(Tsvq::new(&samples.vectors, codewords, job)?)
            }
            NeighbourSearch::Coherence { candidates, codewords } => {
                let sizes: Vec<Size> = level.exemplars.texels().iter().map(|texels| texels.size()).collect();
                let sets = (candidates, codewords);
                Self::Coherence(Coherence::new(samples, causal, &sizes, sets, draws, job)?)
            }
        })
    }

    fn near(&self, query: &[i16], here: Here<'_>) -> (usize, u64) {
        match self {
            Self::Full(full) => full.nearest(query),
            Self::Tsvq(tree) => tree.near(query),
            Self::Coherence(coherence) => coherence.near(query, here),
        }
    }

    /// Memory besides the samples.
    fn bytes(&self) -> u64 {
        match self {
            Self::Full(_) => 0,
            Self::Tsvq(tree) => tree.held_bytes(),
            Self::Coherence(coherence) => coherence.bytes(),
        }
    }

    fn codewords(&self) -> usize {
        match self {
            Self::Full(_) | Self::Coherence(_) => 0,
            Self::Tsvq(tree) => tree.codewords(),
        }
    }
}

/// A torus of copies of random exemplar texels; each row has its own stream.
fn noise(
    level: &ExemplarLevel,
    samples: &ScanSamples,
    size: Size,
    draws: Draws,
    job: &Job,
) -> Result<PixelCanvas> {
    let mut canvas = PixelCanvas::new(size, level.exemplars.planes(), Boundary::Torus, job)?;
    for y in 0..size.height {
        let mut stream = Stream::new(draws.seed, Purpose::ScanlineNoise, [draws.level, y as u64]);
        for x in 0..size.width {
            let source = samples.places[stream.below(samples.places.len())];
            canvas.put(size.index(x, y), source, &level.exemplars);
        }
    }
    Ok(canvas)
}

#[cfg(test)]
mod tests;
