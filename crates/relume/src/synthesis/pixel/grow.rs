//! Growth: unknown texels become known from the outside in, or from a seed outwards, each as a copy of one
//! drawn at random from those whose windows fit the known texels around it.

use serde::Serialize;

use super::canvas::PixelCanvas;
use super::front;
use super::plain::Matches;
use super::scan::Scan;
use super::window::{ComparedWindow, WindowQuery};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};
use crate::parallel;
use crate::size::Size;
use crate::synthesis::guidance::{Guidance, Guided};
use crate::synthesis::options::Boundary;
use crate::synthesis::positions::Positions;
use crate::synthesis::quantise::{Exemplar, Quantised};
use crate::synthesis::source_map::{SourceMap, Texel};

/// The number of nearest known texels whose continuations are tried as hints.
const HINTS: usize = 12;

/// A search for windows that fit a query, with hints.
pub type Matcher<'a> = dyn Fn(&WindowQuery, &[Texel]) -> Matches + Sync + 'a;

/// The report of a growth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Growth {
    /// The side of the compared windows, or of the largest blocks.
    pub window: usize,
    /// The number of window positions in the exemplars.
    pub positions: usize,
    /// The difference in index space of one code.
    pub step: f64,
    /// The number of texels grown.
    pub texels: u64,
    /// The number of candidate windows, over all texels.
    pub candidates: u64,
}

/// The input of an output: common to growth from a seed and hole filling.
#[derive(Debug)]
pub struct Task<'a> {
    /// The exemplars to copy from.
    pub exemplars: &'a [Exemplar<'a>],
    /// The guide that the output follows.
    pub guidance: Option<&'a Guidance>,
    /// Size of the output.
    pub size: Size,
    /// Whether it tiles.
    pub boundary: Boundary,
    /// The compared window.
    pub window: ComparedWindow,
    /// How much farther than the best a window may be, as a fraction of the best squared distance.
    pub epsilon: f64,
    /// Seed of the random choices.
    pub seed: u64,
}

impl Task<'_> {
    /// Makes an output: `work` sets the texels of a canvas on which only the guides are known.
    ///
    /// # Errors
    /// When options are invalid, no window fits the exemplars, guides do not match, or the limits are
    /// exceeded.
    pub fn run(
        &self,
        job: &Job,
        work: impl FnOnce(&Grower<'_>, &mut PixelCanvas, &Matcher<'_>) -> Result<Growth>,
    ) -> Result<(SourceMap, Growth)> {
        check_output(self.size, self.window.side(), self.boundary)?;
        check_epsilon(self.epsilon)?;
        let guided = Guided::new(self.exemplars, self.guidance, self.size, job)?;
        let (quantised, target) = guided.interleaved(job)?;
        let _codes = job.hold("the codes of the exemplars", quantised.bytes())?;
        let positions = Positions::of_windows(self.exemplars, self.window.side())?;
        let scan = Scan::guided(&quantised, &positions, guided.guides(), job)?;
        let mut canvas = PixelCanvas::new(self.size, quantised.planes(), self.boundary, job)?;
        if let Some(target) = &target {
            canvas.guide(target);
        }
        let (window, seed) = (&self.window, self.seed);
        let grower = Grower { exemplars: &quantised, positions: &positions, window, seed };
        let search = |query: &_, hints: &[_]| scan.matches(query, self.epsilon, hints);
        let growth = work(&grower, &mut canvas, &search)?;
        Ok((canvas.into_map(self.exemplars), growth))
    }
}

/// Refuses outputs without texels, windows without a middle, and windows that overlap themselves around a
/// torus.
pub(in crate::synthesis) fn check_output(size: Size, window: usize, boundary: Boundary) -> Result<()> {
    ComparedWindow::check_side(window)?;
    if size.width == 0 || size.height == 0 {
        return Err(Error::usage(format!("an output of {size} texels: both sides must be at least 1")));
    }
    if boundary == Boundary::Torus && size.width.min(size.height) < window {
        return Err(Error::usage(format!(
            "an output of {size} texels cannot tile with windows of {window}: a window would see itself; \
             choose a smaller window or a larger output"
        )));
    }
    Ok(())
}

/// Refuses values that are not numbers from 0 to a million.
pub(in crate::synthesis) fn check_epsilon(epsilon: f64) -> Result<()> {
    if (0.0..=1e6).contains(&epsilon) {
        return Ok(());
    }
    Err(Error::usage(format!(
        "an epsilon of {epsilon} has no meaning: expected a number from 0 to 1,000,000"
    )))
}

/// The data common to all texels.
#[derive(Debug, Clone, Copy)]
pub struct Grower<'a> {
    /// The exemplars.
    pub exemplars: &'a Quantised,
    /// The possible positions of windows in them.
    pub positions: &'a Positions,
    /// The compared window.
    pub window: &'a ComparedWindow,
    /// Seed of the random choices.
    pub seed: u64,
}

impl Grower<'_> {
    /// Makes every texel known, round after round.
    pub fn grow(&self, canvas: &mut PixelCanvas, matches: &Matcher<'_>, job: &Job) -> Result<Growth> {
        job.start("growing texels", canvas.unknown().count() as u64);
        let radius = self.window.radius();
        let (mut texels, mut candidates) = (0, 0);
        let mut scratch = vec![0; canvas.size().texels()];
        let mut round = front::first(canvas);
        while !round.is_empty() {
            let order = front::ordered(canvas, round, radius, self.seed);
            for batch in front::batches(canvas, &order, radius, &mut scratch) {
                let draw = |&texel: &usize| {
                    job.proceed()?;
                    Ok(self.draw(canvas, texel, matches))
                };
                let drawn: Vec<(Texel, usize)> = parallel::try_map(batch.iter(), draw)?;
                for (&texel, (corner, count)) in batch.iter().zip(drawn) {
                    canvas.put(texel, corner.offset(radius, radius), self.exemplars);
                    candidates += count as u64;
                }
                job.advance(batch.len() as u64)?;
            }
            texels += order.len() as u64;
            round = front::next(canvas, &order);
        }
        Ok(self.growth(texels, candidates))
    }

    /// The report of an output with the given number of texels grown.
    pub fn growth(&self, texels: u64, candidates: u64) -> Growth {
        Growth {
            window: self.window.side(),
            positions: self.positions.count(),
            step: self.exemplars.step(),
            texels,
            candidates,
        }
    }

    /// The top-left texel of a window that fits around a texel, and the number of candidates.
    pub fn draw(&self, canvas: &PixelCanvas, texel: usize, matches: &Matcher<'_>) -> (Texel, usize) {
        let query = self.window.query(canvas, texel);
        let fitting = matches(&query, &self.hints(canvas, texel)).positions;
        let mut stream = Stream::new(self.seed, Purpose::GrownTexel, [texel as u64]);
        (fitting[stream.below(fitting.len())], fitting.len())
    }

    /// The windows that continue those from which the nearest known texels come.
    fn hints(&self, canvas: &PixelCanvas, texel: usize) -> Vec<Texel> {
        let radius = self.window.radius().cast_signed();
        let taps = self.window.taps().iter().filter(|tap| (tap.dx, tap.dy) != (0, 0));
        let known = taps.filter_map(|tap| {
            let there = canvas.neighbour(texel, tap.dx, tap.dy).filter(|&there| canvas.is_known(there))?;
            canvas.source(there).moved(-tap.dx - radius, -tap.dy - radius)
        });
        let mut hints: Vec<Texel> =
            known.take(HINTS).filter(|&position| self.positions.contains(position)).collect();
        hints.sort_unstable();
        hints.dedup();
        hints
    }
}
