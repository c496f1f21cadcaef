//! Choosing a method by measuring: exemplars are analysed, textures are made in the ways suggested by the
//! analysis, and the one nearest to the exemplar is kept.
//!
//! The distance is that in appearance ([`crate::metric::texture::appearance`]) of index planes, that is of
//! functions, over all exemplars: shapes, colours at all scales, order, and repetition within the output, each in
//! units of the differences between parts of the exemplar. Verbatim copies have a small distance too: textures
//! with one piece larger than half of an exemplar are made again with another seed, and used only if all are
//! copies. When all suggestions have been tried, they are repeated with other seeds, because the seed alone
//! changes the distance.
//!
//! Large outputs are chosen at a smaller size ([`Auto::trial_size`]), a little larger than the exemplar, which
//! shows periods and repetition; the best ways are then taken at the full size (`full`). The cost is that of all
//! trials and their measures, and of one to four textures.
//!
//! The texture of an exemplar that changes plainly from side to side follows that trend.

mod full;

use std::collections::VecDeque;
use std::path::PathBuf;
use std::time::Instant;

use super::method::{LaidTiles, MadeTexture, Plan};
use super::sizes::Room;
use super::trend;
use crate::analysis::advice::Way;
use crate::analysis::{Advice, Analysis, advise, analyze};
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory::Footprint;
use crate::metric::texture::copying::copying;
use crate::metric::texture::{self, Appearance, LEAST_SIDE, Reference, SlicedOptions, Source, Sources};
use crate::numeric::random::{self, Purpose};
use crate::planes::Planes;
use crate::size::Size;
use crate::synthesis::elements::ElementOptions;
use crate::synthesis::options::Boundary;
use crate::synthesis::pixel::{PatchMatchOptions, WeiLevoyOptions};
use crate::synthesis::{Blend, BlockOptions, Exemplar, SourceMap, Texel, Tolerance, gather_index};

/// The largest piece that a texture may copy verbatim, as a fraction of the smallest exemplar.
pub const LARGEST_PIECE: f64 = 0.5;
/// The side of trials relative to the largest side of an exemplar, as a fraction: enough to show its periods, and
/// pieces laid more than once.
const TRIAL: (usize, usize) = (5, 4);
/// The least side of trials in texels.
const LEAST_TRIAL: usize = 256;
/// The seed of the measure. It differs from the one with which textures are customarily compared, so that the
/// choice does not bias that comparison.
const MEASURE_SEED: u64 = 1;

/// The number of textures to choose from, and their common options.
#[derive(Debug, Clone, PartialEq)]
pub struct Auto {
    tries: usize,
    blocks: BlockOptions,
    asked: Asked,
}

/// The options that are given and therefore not chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Asked {
    /// The side.
    pub block: Option<usize>,
    /// The overlap.
    pub overlap: Option<usize>,
    /// Whether the texture follows the trend of its exemplar; otherwise it does where that is plain.
    pub trend: bool,
}

impl Asked {
    fn is_about_blocks(self) -> bool {
        self.block.is_some() || self.overlap.is_some()
    }
}

/// The input of the textures and their measures.
#[derive(Debug, Clone, Copy)]
pub struct Exemplars<'a> {
    /// Their index planes, and the texels that may not be used.
    pub planes: &'a [Exemplar<'a>],
    /// Their files, named in errors; as many as there are exemplars, or none.
    pub files: &'a [PathBuf],
}

/// The texture kept, and how it was chosen.
#[derive(Debug, Clone)]
pub struct Chosen {
    /// The texture.
    pub made: MadeTexture,
    /// The choice.
    pub choice: Choice,
}

/// The measurements, the tries and the choice.
#[derive(Debug, Clone)]
pub struct Choice {
    /// The analysis of each exemplar.
    pub analyses: Vec<Analysis>,
    /// The suggestions.
    pub advice: Advice,
    /// The size of the tries in texels.
    pub trial: Size,
    /// Whether the texture follows the trend of its exemplar.
    pub follows_trend: bool,
    /// The tries, in order.
    pub tries: Vec<Try>,
    /// The index of the try that was kept.
    pub kept: usize,
}

/// A texture, and the number of the try that it is of.
type Numbered = (usize, MadeTexture);

/// One texture, or the reason why it was not made.
#[derive(Debug, Clone)]
pub struct Try {
    /// Its plan.
    pub plan: Plan,
    /// Its score.
    pub outcome: Result<Score>,
    /// Its score at the full size, where that is larger and it was made.
    pub full: Option<Score>,
    /// The time of making and measuring.
    pub seconds: f64,
}

/// The measures of a texture; empty for a single one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// The mean distance to the exemplars in appearance.
    pub appearance: Option<Appearance>,
    /// The largest piece copied, as a fraction of the smallest exemplar.
    pub largest_piece: Option<f64>,
}

impl Auto {
    /// The default number of textures: at most all that is suggested.
    pub const TRIES: usize = 7;
    /// The largest number of textures that may be requested.
    pub const MOST_TRIES: usize = 1000;

    /// Checks the number of tries; the size and overlap of the blocks are checked later, with the exemplar.
    ///
    /// # Errors
    /// Numbers of tries other than 1 to [`Auto::MOST_TRIES`].
    pub fn new(tries: Option<usize>, blocks: BlockOptions, asked: Asked) -> Result<Self> {
        let tries = tries.unwrap_or(Self::TRIES);
        if !(1..=Self::MOST_TRIES).contains(&tries) {
            let most = Self::MOST_TRIES;
            return Err(Error::usage(format!("{tries} tries cannot be made: choose 1 to {most}")));
        }
        Ok(Self { tries, blocks, asked })
    }

    /// Makes all trials, and the texture of the best way.
    ///
    /// # Errors
    /// Exemplars that cannot be analysed; if no texture could be made, the error of the first.
    pub fn run(&self, exemplars: &Exemplars<'_>, job: &Job) -> Result<Chosen> {
        self.foresee(exemplars, job)?;
        let analyses = exemplars.analyses(job)?;
        match self.followed(&analyses, exemplars, job)? {
            Some(guided) => {
                guided.foresee(exemplars, job)?;
                guided.choose(analyses, true, exemplars, job)
            }
            None => self.choose(analyses, false, exemplars, job),
        }
    }

    /// The same guided by the trend of the exemplar, where that is asked for or plain.
    fn followed(&self, analyses: &[Analysis], exemplars: &Exemplars<'_>, job: &Job) -> Result<Option<Self>> {
        let BlockOptions { size, boundary, ref guidance, .. } = self.blocks;
        if !self.asked.trend && (guidance.is_some() || !trend::is_plain(analyses, boundary)) {
            return Ok(None);
        }
        let guidance = Some(trend::guidance(exemplars.planes, size, boundary, job)?);
        let asked = Asked { trend: true, ..self.asked };
        Ok(Some(Self { asked, blocks: BlockOptions { guidance, ..self.blocks.clone() }, ..self.clone() }))
    }

    fn choose(
        &self,
        analyses: Vec<Analysis>,
        follows_trend: bool,
        exemplars: &Exemplars<'_>,
        job: &Job,
    ) -> Result<Chosen> {
        let sizes = exemplars.planes.iter().map(|exemplar| exemplar.index.size());
        let advice = advise(&analyses.iter().zip(sizes).collect::<Vec<_>>());
        let room = Room::of(&analyses, exemplars.planes, self.blocks.size);
        let trial = self.trial_size(exemplars);
        let references = self.references(exemplars, job)?;
        let (mut tries, best) = self.tries(self.plans(&advice, &room), trial, &references, exemplars, job)?;
        let (kept, made) = match best {
            Some(made) if trial == self.blocks.size => made,
            _ => full::make(&mut tries, trial, &references, exemplars, job)?,
        };
        Ok(Chosen { made, choice: Choice { analyses, advice, trial, follows_trend, tries, kept } })
    }

    /// The size at which textures are compared: that of the output, but no larger than `TRIAL` times the
    /// largest side of an exemplar, and at least `LEAST_TRIAL`. Guided textures, which have to follow their
    /// guide, and a single one are made at the size of the output.
    pub fn trial_size(&self, exemplars: &Exemplars<'_>) -> Size {
        let size = self.blocks.size;
        if self.blocks.guidance.is_some() || self.tries == 1 {
            return size;
        }
        let sides = exemplars.planes.iter().map(|exemplar| exemplar.index.size());
        let largest = sides.map(|size| size.width.max(size.height)).max().unwrap_or(0);
        let most = (largest * TRIAL.0 / TRIAL.1).max(LEAST_TRIAL);
        Size::new(size.width.min(most), size.height.min(most))
    }

    /// Makes and measures all trials; the best, and its number.
    fn tries(
        &self,
        plans: Vec<Plan>,
        trial: Size,
        references: &[Reference],
        exemplars: &Exemplars<'_>,
        job: &Job,
    ) -> Result<(Vec<Try>, Option<Numbered>)> {
        let mut best: Option<(Score, Numbered)> = None;
        let mut tries = Vec::new();
        let mut waiting = VecDeque::from(plans);
        while let Some(plan) = waiting.pop_front() {
            let (number, started) = (tries.len(), Instant::now());
            let made = plan.validate().and_then(|()| plan.trial(trial).run(exemplars.planes, job));
            let measured = made.and_then(|made| Ok((score(&made.map, references, exemplars, job)?, made)));
            let outcome = measured.as_ref().map(|(score, _)| *score).map_err(Error::clone);
            if outcome.as_ref().is_ok_and(Score::is_copy) && number < self.tries {
                // The first block came from a corner, where the exemplar continues the longest, at any size
                // of blocks: use another seed.
                waiting.push_back(plan.with_seed(further_seed(plan.seed(), Purpose::CopiedAgain, [])));
            }
            tries.push(Try { plan, outcome, full: None, seconds: started.elapsed().as_secs_f64() });
            if let Ok((score, made)) = measured
                && best.as_ref().is_none_or(|(least, ..)| score.is_better_than(least))
            {
                best = Some((score, (number, made)));
            }
        }
        Ok((tries, best.map(|(_, made)| made)))
    }

    /// The measured exemplars; none for a single try, which is not measured.
    fn references(&self, exemplars: &Exemplars<'_>, job: &Job) -> Result<Vec<Reference>> {
        let measured = if self.tries == 1 { &[] } else { exemplars.planes };
        measured.iter().map(|exemplar| Reference::new(exemplar.index, MEASURE_SEED, job)).collect()
    }

    /// Refuses tries that could be made, but not measured within the memory: beside the best so far, the try,
    /// the index planes of its texture, and the patches of both.
    fn foresee(&self, exemplars: &Exemplars<'_>, job: &Job) -> Result<()> {
        if self.tries == 1 {
            return Ok(());
        }
        let (trial, planes) = (self.trial_size(exemplars), exemplars.planes[0].index.count());
        let size = if full::is_measured(self.blocks.size, trial) { self.blocks.size } else { trial };
        let texel = 2 * size_of::<Texel>() + size_of::<Source>() + 4 * planes;
        let held = Footprint::of_texels(size, texel as u64, texel as u64);
        let sizes = exemplars.planes.iter().map(|exemplar| [exemplar.index.size(), size]);
        let measure = |sizes| texture::bytes(sizes, planes, &SlicedOptions::default());
        let peak = sizes.map(measure).max().unwrap_or(0);
        job.check_bytes("the tries and their measures", held.then(Footprint { peak, kept: 0 }).peak)
    }

    /// The plans, in order: blocks as requested, otherwise all suggestions, and for the remaining tries the
    /// same again with other seeds.
    fn plans(&self, advice: &Advice, room: &Room) -> Vec<Plan> {
        let mut plans: Vec<Plan> = Vec::new();
        for plan in advice.ways.iter().filter_map(|way| self.plan(*way, room)) {
            // Blocks limited by the output may be the same.
            if !plans.contains(&plan) {
                plans.push(plan);
            }
        }
        if self.asked.block.is_some() {
            plans.push(Plan::Quilting(self.blocks.clone()));
        }
        let (count, seed) = (plans.len(), self.blocks.seed);
        let seed_of = |round: usize| match round {
            0 => seed,
            _ => further_seed(seed, Purpose::Tries, [round as u64]),
        };
        (0..self.tries).map(|n| plans[n % count].with_seed(seed_of(n / count))).collect()
    }

    /// The plan of a suggested method; `None` if the request excludes it.
    fn plan(&self, way: Way, room: &Room) -> Option<Plan> {
        let BlockOptions { size, boundary, ref guidance, seed, .. } = self.blocks;
        let is_joined_otherwise = self.blocks.blend != Blend::Cut || self.blocks.feather > 0;
        let is_about_blocks = is_joined_otherwise
            || self.asked.is_about_blocks()
            || matches!(self.blocks.tolerance, Tolerance::Absolute(_));
        match way {
            Way::Quilting { block, overlap } if self.asked.block.is_none() => {
                let block = block.min(room.most_block(boundary));
                let overlap = self.asked.overlap.unwrap_or(overlap.min(block / 2));
                Some(Plan::Quilting(BlockOptions { block, overlap, ..self.blocks.clone() }))
            }
            Way::PatchMatch if !is_about_blocks => {
                let boundary = if self.asked.trend { Boundary::Open } else { Boundary::Torus };
                let default = PatchMatchOptions {
                    size,
                    seed,
                    boundary,
                    guidance: guidance.clone(),
                    ..Default::default()
                };
                let window = room.small_window(default.window);
                Some(Plan::PatchMatch(PatchMatchOptions { window, levels: room.levels(window), ..default }))
            }
            Way::Scanlines if !is_about_blocks && guidance.is_none() => {
                let default = WeiLevoyOptions { size, seed, ..Default::default() };
                let window = room.small_window(default.window);
                let options = WeiLevoyOptions { window, levels: room.levels(window), ..default };
                Some(Plan::WeiLevoy(options, boundary))
            }
            Way::Elements if !is_about_blocks && guidance.is_none() => {
                Some(Plan::Elements(ElementOptions { size, boundary, lattice: None, seed }))
            }
            Way::Roller { tiles } if !is_about_blocks && guidance.is_none() => {
                Some(Plan::Roller(LaidTiles::new(tiles, size, boundary, seed)))
            }
            _ => None,
        }
    }
}

/// How near a texture is to the exemplars, if they were measured, and whether it is a copy of one.
fn score(map: &SourceMap, references: &[Reference], exemplars: &Exemplars<'_>, job: &Job) -> Result<Score> {
    let Size { width, height } = map.size();
    if references.is_empty() || width.min(height) < LEAST_SIDE {
        return Ok(Score::UNMEASURED);
    }
    let index: Vec<&Planes> = exemplars.planes.iter().map(|exemplar| exemplar.index).collect();
    let made = gather_index(map, &index, job)?;
    let distances: Vec<Appearance> =
        references.iter().map(|reference| reference.distance(&made, job)).collect::<Result<_>>()?;
    Ok(Score { appearance: Appearance::mean(&distances), largest_piece: Some(largest_piece(map)?) })
}

/// The largest piece copied, as a fraction of the smallest exemplar.
fn largest_piece(map: &SourceMap) -> Result<f64> {
    let texels: Vec<Source> =
        map.copies().iter().map(|t| Source { exemplar: t.exemplar, x: t.x, y: t.y }).collect();
    let sources = Sources::new(map.size(), &texels, map.exemplars())?;
    let smallest = map.exemplars().iter().map(|size| size.texels()).min().unwrap_or(1);
    Ok(copying(&sources).largest_piece as f64 / smallest as f64)
}

/// The seed of another try, printed so that it makes the texture again: 32 bits, which are short to type and
/// exact in any JSON reader.
fn further_seed<const N: usize>(seed: u64, purpose: Purpose, place: [u64; N]) -> u64 {
    random::key(seed, purpose, place) >> 32
}

impl Exemplars<'_> {
    fn analyses(&self, job: &Job) -> Result<Vec<Analysis>> {
        let analysis = |(number, exemplar): (usize, &Exemplar<'_>)| {
            analyze(exemplar.index, job).map_err(|e| match self.files.get(number) {
                Some(file) => e.at(file),
                None => e,
            })
        };
        self.planes.iter().enumerate().map(analysis).collect()
    }
}

impl Score {
    const UNMEASURED: Self = Self { appearance: None, largest_piece: None };

    /// Textures that are not verbatim copies first, then the nearest.
    fn is_better_than(&self, other: &Self) -> bool {
        self.key() < other.key()
    }

    fn key(&self) -> (bool, f64) {
        (self.is_copy(), self.appearance.map_or(0.0, |appearance| appearance.distance))
    }

    /// Whether it is a verbatim copy of most of an exemplar.
    pub fn is_copy(&self) -> bool {
        self.largest_piece.is_some_and(|piece| piece > LARGEST_PIECE)
    }
}
