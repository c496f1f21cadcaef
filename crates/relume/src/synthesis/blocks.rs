//! Block-based synthesis: block after block, each drawn at random from the candidates.
//!
//! Efros, Freeman, "Image Quilting for Texture Synthesis and Transfer", SIGGRAPH 2001, applied to
//! reflectance functions after Hel-Or, Malzbender, Gelb, "Synthesis of Reflectance Function Textures
//! from Examples", HPL-2003-16: blocks are compared and joined in an orthonormal basis of the
//! functions.

use std::time::Instant;

use super::alpha::ramps;
use super::canvas::BlockCanvas;
use super::cut::graph::{BYTES_PER_TEXEL, inside_seam};
use super::cut::{feather, inside_cuts};
use super::former::FormerBlocks;
use super::guidance::Guided;
use super::layout::{BlockLayout, PlacedBlock};
use super::options::{Blend, BlockOptions};
use super::positions::Positions;
use super::quantise::{Exemplar, Quantised};
use super::report::{Placement, RejectionCurve, StageTimes, Synthesis, SynthesisReport};
use super::search::plan::plan;
use super::search::{Acceptance, Avoided, BlockQuery, Effort, Found, Search};
use super::source_map::Texel;
use crate::error::Result;
use crate::job::Job;
use crate::numeric::random::{Purpose, Stream};
use crate::parallel;
use crate::size::Size;

/// The number of blocks on which the rejection curve is measured.
const CURVE_BLOCKS: usize = 16;

/// Memory of the shares of blended texels, a texel of the output: measured with ramps.
const MIX_BYTES: u64 = 40;

/// Blocks that are searched for together, between which a search can be stopped.
const TOGETHER: usize = 32;

/// Makes a map for an output of `options.size` texels from blocks of the exemplars.
///
/// The result depends on the exemplars and the options only, not on the number of threads.
///
/// # Errors
/// When the options are invalid, no block fits the exemplars, or the limits are exceeded.
pub fn synthesize(exemplars: &[Exemplar<'_>], options: &BlockOptions, job: &Job) -> Result<Synthesis> {
    options.validate()?;
    let begun = Instant::now();
    let guided = Guided::new(exemplars, options.guidance.as_ref(), options.size, job)?;
    let (quantised, guides) = guided.apart(job)?;
    let _codes = job.hold("the codes of the exemplars", quantised.bytes())?;
    let positions = Positions::new(exemplars, options.block)?;
    let layout = BlockLayout::new(options, job)?;
    let recipe = plan(options, &layout, &quantised);
    job.check_bytes("preparing the search", recipe.bytes(&quantised, guides.as_ref()))?;
    if options.blend == Blend::GraphCut {
        let at_once = BYTES_PER_TEXEL * rayon::current_num_threads() as u64;
        job.check("the graph of a block", Size::new(options.block, options.block), at_once)?;
    }
    let mut canvas = BlockCanvas::new(layout.size, quantised.planes(), job)?;
    let blends = options.blend == Blend::Alpha || options.feather > 0;
    let blended = if blends { MIX_BYTES * layout.size.texels() as u64 } else { 0 };
    let _blended = job.hold("the blended texels", blended)?;
    let _tables = job.hold("preparing the search", recipe.bytes(&quantised, guides.as_ref()))?;
    let search = recipe.prepare(&quantised, &positions, guides.as_ref(), job)?;
    let work = BlockWork { options, quantised: &quantised, positions: &positions, search: &*search };
    let prepare_s = begun.elapsed().as_secs_f64();
    let (report, search_s) = work.fill(&layout, &mut canvas, job)?;
    let times =
        StageTimes { prepare_s, search_s, join_s: begun.elapsed().as_secs_f64() - prepare_s - search_s };
    Ok(Synthesis { map: canvas.into_map(options.size, exemplars), report, times })
}

/// The data common to all blocks.
struct BlockWork<'a> {
    options: &'a BlockOptions,
    quantised: &'a Quantised,
    positions: &'a Positions,
    search: &'a dyn Search,
}

/// The choice for a block and its weight in each texel.
struct Decision {
    placement: Placement,
    weights: Vec<f32>,
    effort: Effort,
}

impl BlockWork<'_> {
    /// Places all blocks, wave after wave: the blocks of a wave do not touch. Returns the report and the
    /// seconds spent searching.
    fn fill(
        &self,
        layout: &BlockLayout,
        canvas: &mut BlockCanvas,
        job: &Job,
    ) -> Result<(SynthesisReport, f64)> {
        job.start("synthesising blocks", layout.sequence.len() as u64);
        let mut placements: Vec<Option<Placement>> = vec![None; layout.sequence.len()];
        let mut effort = Effort::default();
        let mut search_s = 0.0;
        let mut curve = None;
        let sampled = layout.sequence.len().div_ceil(CURVE_BLOCKS);
        let mut former = FormerBlocks::new(self.options, self.quantised, layout);
        for wave in &layout.waves {
            let blocks: Vec<&PlacedBlock> = wave.iter().map(|&index| &layout.sequence[index]).collect();
            let queries: Vec<BlockQuery> =
                parallel::map(blocks.iter(), |block| self.query(block, canvas, &former));
            let begun = Instant::now();
            let found = self.search(&queries, &former, job)?;
            search_s += begun.elapsed().as_secs_f64();
            if self.options.search.curve {
                let chosen = wave.iter().map(|index| index % sampled == sampled / 2);
                chosen.zip(&queries).zip(&found).filter(|((chosen, _), _)| *chosen).for_each(
                    |((_, query), found)| {
                        self.measure(query, found.as_ref(), &mut curve);
                    },
                );
            }
            let jobs = blocks.iter().zip(&queries).zip(found);
            let decisions = parallel::map(jobs, |((block, query), found)| self.draw(block, query, found));
            job.advance(wave.len() as u64)?;
            for (&index, decision) in wave.iter().zip(decisions) {
                let source = decision.placement.source;
                effort.add(&decision.effort);
                former.add(&layout.sequence[index], source, decision.placement.best);
                canvas.paste(&layout.sequence[index], self.quantised, source, &decision.weights);
                placements[index] = Some(decision.placement);
            }
        }
        let placements: Vec<Placement> = placements.into_iter().flatten().collect();
        let report = SynthesisReport {
            columns: layout.columns,
            rows: layout.rows,
            positions: self.positions.count(),
            step: self.quantised.step(),
            candidates: placements.iter().skip(1).map(|p| p.candidates as u64).sum(),
            effort,
            curve,
            placements,
        };
        Ok((report, search_s))
    }

    /// The candidates of blocks that do not touch; `None` for the first block, which fits anywhere unless it
    /// follows a guide.
    fn search(&self, queries: &[BlockQuery], former: &FormerBlocks, job: &Job) -> Result<Vec<Option<Found>>> {
        if queries[0].neighbourhood.is_empty() && self.options.guidance.is_none() {
            return Ok(vec![None]);
        }
        let mut found = Vec::with_capacity(queries.len());
        for some in queries.chunks(TOGETHER) {
            job.proceed()?;
            let mut fitting = self.search.candidates(some);
            self.search_again(some, &mut fitting, former);
            found.extend(fitting.into_iter().map(Some));
        }
        Ok(found)
    }

    /// Takes blocks that fit much worse than usual from all positions, where they fit much better then.
    fn search_again(&self, queries: &[BlockQuery], found: &mut [Found], former: &FormerBlocks) {
        let is_poor = |query: &BlockQuery, found: &Found| {
            !query.avoided.is_empty() && former.is_poor(self.distance(query, found))
        };
        let poor = queries.iter().zip(found).filter(|(query, found)| is_poor(query, found));
        let poor =
            poor.map(|(query, found)| (BlockQuery { avoided: Avoided::default(), ..query.clone() }, found));
        let (again, poor): (Vec<BlockQuery>, Vec<&mut Found>) = poor.unzip();
        if again.is_empty() {
            return;
        }
        let others = self.search.candidates(&again);
        for ((query, found), other) in again.iter().zip(poor).zip(others) {
            if FormerBlocks::is_much_nearer(self.distance(query, &other), self.distance(query, found)) {
                *found = other;
            }
        }
    }

    /// The root mean square distance of the best candidate over the texels of the neighbourhood.
    fn distance(&self, query: &BlockQuery, found: &Found) -> f64 {
        let texels = query.neighbourhood.texels().max(1) as f64;
        (found.candidates.best as f64 / texels).sqrt() * self.quantised.step()
    }

    /// Adds a block to the rejection curve.
    fn measure(&self, query: &BlockQuery, found: Option<&Found>, curve: &mut Option<RejectionCurve>) {
        let remaining = found.and_then(|found| self.search.rejection_curve(query, found.candidates.best));
        let Some(remaining) = remaining else { return };
        let empty = || RejectionCurve { blocks: 0, positions: 0, remaining: vec![0; remaining.len()] };
        curve.get_or_insert_with(empty).add(self.positions.count(), &remaining);
    }

    /// The query of a block.
    fn query(&self, block: &PlacedBlock, canvas: &BlockCanvas, former: &FormerBlocks) -> BlockQuery {
        let (texels, step) = (block.neighbourhood.texels(), self.quantised.step());
        let likely = canvas.continuations(block);
        BlockQuery {
            neighbourhood: block.neighbourhood,
            place: [block.x, block.y],
            codes: canvas.patch(block),
            acceptance: Acceptance::new(self.options.tolerance, texels, step),
            avoided: former.avoided(block, &likely, self.positions.count()),
            likely,
        }
    }

    /// Draws one of the candidates, or one of all positions if there is nothing to match.
    fn draw(&self, block: &PlacedBlock, query: &BlockQuery, found: Option<Found>) -> Decision {
        let mut stream = Stream::new(self.options.seed, Purpose::Block, [block.number as u64]);
        let (source, candidates, best, effort) = match found {
            None => {
                let count = self.positions.count();
                (self.positions.nth(stream.below(count)), count, 0.0, Effort::default())
            }
            Some(found) => {
                let best = self.distance(query, &found);
                let Found { candidates, effort } = found;
                let fitting = candidates.positions;
                (fitting[stream.below(fitting.len())], fitting.len(), best, effort)
            }
        };
        Decision {
            placement: Placement { x: block.x, y: block.y, source, candidates, best },
            weights: self.weights(query, source),
            effort,
        }
    }

    /// The weight of the block from `source` in each texel.
    fn weights(&self, query: &BlockQuery, source: Texel) -> Vec<f32> {
        let shape = &query.neighbourhood;
        let from = &self.quantised.texels()[source.exemplar as usize];
        let planes = self.quantised.planes();
        let error = |x: usize, y: usize| {
            let new = from.run(source.x as usize + x, source.y as usize + y, 1);
            let old = &query.codes[shape.extent.index(x, y) * planes..][..planes];
            new.iter().zip(old).map(|(a, b)| i64::from(a - b).pow(2).unsigned_abs()).sum()
        };
        let new = match self.options.blend {
            Blend::Alpha => return ramps(shape),
            Blend::Cut => inside_cuts(shape, error),
            Blend::GraphCut => inside_seam(shape, error),
        };
        feather(shape, &new, self.options.feather)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planes::Planes;
    use crate::synthesis::options::{Boundary, Tolerance};
    use crate::synthesis::search::plain::Plain;
    use crate::synthesis::search::{SearchMethod, SearchOptions};
    use proptest::prelude::*;

    fn options() -> impl Strategy<Value = BlockOptions> {
        let ways = (any::<bool>(), 0usize..5, any::<bool>(), any::<u64>());
        (2usize..12, 0usize..9, 1usize..50, 1usize..50, ways).prop_map(|(block, overlap, w, h, ways)| {
            let (torus, join, absolute, seed) = ways;
            let least = if torus { block } else { 1 };
            let blends = [Blend::Cut, Blend::GraphCut, Blend::Cut, Blend::GraphCut, Blend::Alpha];
            BlockOptions {
                size: Size::new(w.max(least), h.max(least)),
                block,
                overlap: 1 + overlap % (block / 2),
                tolerance: if absolute { Tolerance::Absolute(0.3) } else { Tolerance::Relative(0.1) },
                blend: blends[join],
                feather: usize::from(join == 2 || join == 3),
                boundary: if torus { Boundary::Torus } else { Boundary::Open },
                guidance: None,
                seed,
                search: SearchOptions::default(),
            }
        })
    }

    fn noise(size: Size, planes: usize, seed: u64) -> Planes {
        let mut stream = Stream::new(seed, Purpose::Sample, [1]);
        let data = (0..size.texels() * planes).map(|_| stream.unit() as f32).collect();
        Planes::from_vec(size, planes, data).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        /// Several threads with the fast searches, compared with one block after another with the slow one.
        #[test]
        fn equals_the_sequential_synthesis_at_any_number_of_threads(
            options in options(),
            (planes, extra, several, masked) in (1usize..19, 0usize..12, 1usize..3, any::<bool>()),
        ) {
            let side = options.block + extra;
            let fields: Vec<Planes> = (0..several)
                .map(|e| noise(Size::new(side + e, side + 2 * e), planes, options.seed ^ e as u64))
                .collect();
            let mut stream = Stream::new(options.seed, Purpose::Sample, [u64::MAX]);
            let mut mask = |field: &Planes| -> Vec<bool> {
                (0..field.size().texels()).map(|_| masked && stream.below(300) == 0).collect()
            };
            let masks: Vec<Vec<bool>> = fields.iter().map(&mut mask).collect();
            let with_mask = |(index, mask)| Exemplar { index, excluded: Some(Vec::as_slice(mask)) };
            let exemplars: Vec<Exemplar<'_>> = fields.iter().zip(&masks).map(with_mask).collect();
            let job = Job::default();
            let quantised = Quantised::new(&exemplars, &job).unwrap();
            let Ok(positions) = Positions::new(&exemplars, options.block) else { return Ok(()) };
            let layout = BlockLayout::new(&options, &job).unwrap();
            let mut canvas = BlockCanvas::new(layout.size, planes, &job).unwrap();
            let search = Plain { exemplars: &quantised, positions: &positions };
            let work = BlockWork { options: &options, quantised: &quantised, positions: &positions, search: &search };
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            let (report, _) = alone.install(|| work.fill(&layout, &mut canvas, &Job::default()).unwrap());
            let map = canvas.into_map(options.size, &exemplars);
            for threads in [1, 2, 5] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                for method in [SearchMethod::Projection, SearchMethod::Fft, SearchMethod::Brute] {
                    let search = SearchOptions { method, ..options.search };
                    let options = BlockOptions { search, ..options.clone() };
                    let found = pool.install(|| synthesize(&exemplars, &options, &job).unwrap());
                    prop_assert_eq!(&found.map, &map, "{:?}, {} threads", method, threads);
                    prop_assert_eq!(&found.report.placements, &report.placements);
                }
            }
        }
    }
}
