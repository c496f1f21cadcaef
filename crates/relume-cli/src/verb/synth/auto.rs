//! `relume synth --method auto`: the exemplars are measured, textures are made in the ways that the
//! analysis advises, and the one that is nearest to the exemplar is kept.
//!
//! Near is the multi-scale patch distance between index planes, so that of functions, over all
//! exemplars. Such a measure is best for a verbatim copy: textures in which one piece is larger than
//! half of an exemplar are made again with another seed, and taken only where all are so. When the
//! advised ways are through, they come again with other seeds, for the seed alone changes the distance
//! by a tenth to a third. The cost is that of all textures and their measures.

use std::collections::VecDeque;
use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

use relume::analysis::advice::Way;
use relume::analysis::{Advice, Analysis, advise, analyze};
use relume::field::IndexSpace;
use relume::metric::texture::copying::copying;
use relume::metric::texture::{SlicedOptions, Source, Sources, sliced};
use relume::numeric::random::{self, Purpose};
use relume::synthesis::pixel::{NeighbourSearch, PatchMatchOptions, WeiLevoyOptions};
use relume::synthesis::{Blend, BlockOptions, Exemplar, SourceMap, gather};
use relume::{Error, Job, ReflectanceField, Result};
use serde_json::{Value, json};

use super::method::Plan;
use super::roller::Laid;
use crate::context::Context;
use crate::report::Report;
use crate::verb::analyze;

/// Textures made unless asked otherwise: all that is advised at most.
const TRIES: usize = 7;
/// The most textures that may be asked for.
const MOST_TRIES: usize = 1000;
/// The largest piece that a texture may copy as it stands, as a part of the smallest exemplar.
const LARGEST_PIECE: f64 = 0.5;
/// The search of scanlines that continue what is beside them: no other candidates, which need no tree.
const CONTINUED: NeighbourSearch = NeighbourSearch::Coherence { candidates: 1, codewords: 4096 };
/// Seed of the measure: another than that of `relume compare`, so that what is chosen by this is not
/// flattered by that.
const MEASURE_SEED: u64 = 1;

/// How many textures to choose from, and what all of them share.
#[derive(Debug)]
pub struct Auto {
    tries: usize,
    blocks: BlockOptions,
}

impl Auto {
    /// Checks the number of tries; what the blocks' size and overlap mean shows with the exemplar.
    pub fn new(tries: Option<usize>, blocks: BlockOptions) -> Result<Self> {
        let tries = tries.unwrap_or(TRIES);
        if !(1..=MOST_TRIES).contains(&tries) {
            return Err(Error::usage(format!("--tries {tries}: choose 1 to {MOST_TRIES}")));
        }
        Ok(Self { tries, blocks })
    }

    /// Makes all textures and keeps the best.
    pub fn run(
        &self,
        args: &super::Args,
        fields: &[&ReflectanceField],
        exemplars: &[Exemplar<'_>],
        context: &Context,
    ) -> Result<(SourceMap, Report)> {
        let analyses = exemplars.iter().zip(&args.exemplars);
        let found: Vec<Analysis> = analyses
            .map(|(exemplar, path)| analyze(exemplar.index, &context.job).map_err(|e| e.at(path)))
            .collect::<Result<_>>()?;
        let sizes = exemplars.iter().map(|exemplar| exemplar.index.size());
        let advice = advise(&found.iter().zip(sizes).collect::<Vec<_>>());
        let space = args.metric.space(fields[0], args.domain)?;
        let mut best: Option<(Score, usize, SourceMap, Report)> = None;
        let mut tries = Vec::new();
        let mut waiting = VecDeque::from(self.ways(args, &advice));
        while let Some(attempt) = waiting.pop_front() {
            let (number, started) = (tries.len(), Instant::now());
            let made = attempt.plan().and_then(|plan| plan.run(args, fields, exemplars, context));
            let measured = made.and_then(|(map, report)| {
                let score = self.score(&map, fields, exemplars, &space, &context.job)?;
                Ok((score, map, report))
            });
            let outcome = measured.as_ref().map(|(score, ..)| *score).map_err(Error::clone);
            if outcome.as_ref().is_ok_and(Score::is_copy) && number < self.tries {
                // The first block came from a corner, where the exemplar goes on longest, and does so at
                // any size of blocks: another seed.
                waiting.push_back(attempt.with_seed(further_seed(
                    attempt.blocks().seed,
                    Purpose::CopiedAgain,
                    [],
                )));
            }
            tries.push(Try { command: attempt.command(), outcome, seconds: started.elapsed().as_secs_f64() });
            if let Ok((score, map, report)) = measured
                && best.as_ref().is_none_or(|(least, ..)| score.is_better_than(least))
            {
                best = Some((score, number, map, report));
            }
        }
        let Some((_, kept, map, report)) = best else {
            // Nothing was made: the first reason speaks for all.
            let reason = tries.into_iter().find_map(|one| one.outcome.err());
            return Err(reason.unwrap_or_else(|| Error::usage("there was nothing to try")));
        };
        let choice = Choice { files: args.exemplars.clone(), found, advice, tries, kept };
        Ok((map, choice.report(report)))
    }

    /// What to try, in order. Blocks as they are asked for; else all that is advised, and where there
    /// are tries left the same again with other seeds.
    fn ways(&self, args: &super::Args, advice: &Advice) -> Vec<Attempt> {
        let joined = self.blocks.blend != Blend::Cut || self.blocks.feather > 0;
        let guided = self.blocks.guidance.is_some();
        let asked = args.block.is_some() || args.overlap.is_some() || args.delta.is_some() || joined;
        let advised = advice.ways.iter().filter_map(|way| match *way {
            Way::Quilting { block, overlap } if args.block.is_none() => {
                let overlap = args.overlap.unwrap_or(overlap);
                Some(Attempt::Blocks(BlockOptions { block, overlap, ..self.blocks.clone() }))
            }
            Way::PatchMatch if !asked => Some(Attempt::Patches(self.blocks.clone())),
            Way::Scanlines if !asked => Some(Attempt::Scanlines(self.blocks.clone())),
            Way::Roller { tiles } if !asked && !guided => Some(Attempt::Tiles(tiles, self.blocks.clone())),
            _ => None,
        });
        let mut ways: Vec<Attempt> = advised.collect();
        if args.block.is_some() {
            ways.push(Attempt::Blocks(self.blocks.clone()));
        }
        let (count, seed) = (ways.len(), self.blocks.seed);
        let seed_of = |round: usize| match round {
            0 => seed,
            _ => further_seed(seed, Purpose::Tries, [round as u64]),
        };
        (0..self.tries).map(|n| ways[n % count].with_seed(seed_of(n / count))).collect()
    }

    /// How near a texture is to the exemplars, and whether it is a copy of one.
    fn score(
        &self,
        map: &SourceMap,
        fields: &[&ReflectanceField],
        exemplars: &[Exemplar<'_>],
        space: &IndexSpace,
        job: &Job,
    ) -> Result<Score> {
        if self.tries == 1 {
            return Ok(Score::UNMEASURED);
        }
        let texels: Vec<Source> =
            map.copies().iter().map(|t| Source { exemplar: t.exemplar, x: t.x, y: t.y }).collect();
        let sources = Sources::new(map.size(), &texels, map.exemplars())?;
        let smallest = map.exemplars().iter().map(|size| size.texels()).min().unwrap_or(1);
        let piece = copying(&sources).largest_piece as f64 / smallest as f64;
        let made = space.index_planes(&gather(map, fields, job)?);
        let options = SlicedOptions { seed: MEASURE_SEED, ..SlicedOptions::default() };
        let mut sum = 0.0;
        for exemplar in exemplars {
            let levels = sliced::levels(exemplar.index, &made, &options, job)?;
            sum += levels.iter().sum::<f64>() / levels.len() as f64;
        }
        Ok(Score { patches: Some(sum / exemplars.len() as f64), piece: Some(piece) })
    }
}

/// One texture to make.
#[derive(Debug, Clone)]
enum Attempt {
    Blocks(BlockOptions),
    Patches(BlockOptions),
    Scanlines(BlockOptions),
    Tiles(usize, BlockOptions),
}

/// The seed of another try, printed so that it makes the texture again: 32 bits, which are short to type
/// and exact in any JSON reader.
fn further_seed<const N: usize>(seed: u64, purpose: Purpose, place: [u64; N]) -> u64 {
    random::key(seed, purpose, place) >> 32
}

impl Attempt {
    fn blocks(&self) -> &BlockOptions {
        match self {
            Self::Blocks(options)
            | Self::Patches(options)
            | Self::Scanlines(options)
            | Self::Tiles(_, options) => options,
        }
    }

    fn with_seed(&self, seed: u64) -> Self {
        let options = BlockOptions { seed, ..self.blocks().clone() };
        match self {
            Self::Blocks(_) => Self::Blocks(options),
            Self::Patches(_) => Self::Patches(options),
            Self::Scanlines(_) => Self::Scanlines(options),
            Self::Tiles(tiles, _) => Self::Tiles(*tiles, options),
        }
    }

    fn plan(&self) -> Result<Plan> {
        match self {
            Self::Blocks(options) => options.validate().map(|()| Plan::Quilting(options.clone())),
            Self::Patches(o) => {
                let (size, guidance, seed) = (o.size, o.guidance.clone(), o.seed);
                let options = PatchMatchOptions { size, guidance, seed, ..PatchMatchOptions::default() };
                options.validate().map(|()| Plan::PatchMatch(options))
            }
            Self::Scanlines(o) => {
                let (size, guidance, seed) = (o.size, o.guidance.clone(), o.seed);
                let search = CONTINUED;
                let options = WeiLevoyOptions { size, search, guidance, seed, ..WeiLevoyOptions::default() };
                options.validate().map(|()| Plan::WeiLevoy(options, o.boundary))
            }
            Self::Tiles(tiles, options) => Laid::new(*tiles, options).map(Plan::Roller),
        }
    }

    /// The options that make this texture at once.
    fn command(&self) -> String {
        match self {
            Self::Blocks(o) => format!("--block {} --overlap {} --seed {}", o.block, o.overlap, o.seed),
            Self::Patches(o) => format!("--method patchmatch --seed {}", o.seed),
            Self::Scanlines(o) => format!("--method wei-levoy --coherence 1 --seed {}", o.seed),
            Self::Tiles(tiles, o) => format!("--method roller --tiles {tiles} --seed {}", o.seed),
        }
    }
}

/// What was measured of a texture; nothing where it is the only one.
#[derive(Debug, Clone, Copy)]
struct Score {
    /// The patch distance to the exemplars, the mean.
    patches: Option<f64>,
    /// The largest piece copied, as a part of the smallest exemplar.
    piece: Option<f64>,
}

impl Score {
    const UNMEASURED: Self = Self { patches: None, piece: None };

    /// Textures that are no verbatim copies first, then the nearest.
    fn is_better_than(&self, other: &Self) -> bool {
        let key = |score: &Self| (score.is_copy(), score.patches.unwrap_or(0.0));
        key(self) < key(other)
    }

    /// Whether most of an exemplar is copied as it stands.
    fn is_copy(&self) -> bool {
        self.piece.is_some_and(|piece| piece > LARGEST_PIECE)
    }
}

/// One texture that was made, or why it was not.
struct Try {
    command: String,
    outcome: Result<Score>,
    seconds: f64,
}

impl Try {
    fn json(&self) -> Value {
        let score = self.outcome.as_ref().ok();
        json!({
            "options": self.command,
            "patches": score.and_then(|s| s.patches),
            "largest_piece": score.and_then(|s| s.piece),
            "error": self.outcome.as_ref().err().map(ToString::to_string),
            "seconds": self.seconds,
        })
    }

    fn line(&self, is_kept: bool) -> String {
        let what = match &self.outcome {
            Ok(Score { patches: Some(patches), piece: Some(piece) }) => {
                format!("patch distance {patches:.4}, largest piece {:.0} % of the exemplar", 100.0 * piece)
            }
            Ok(_) => "not measured".to_owned(),
            Err(error) => error.to_string(),
        };
        let mark = if is_kept { "*" } else { " " };
        format!("\n {mark} {:<38} {what}, {:.1} s", self.command, self.seconds)
    }
}

/// What was measured, tried and kept.
struct Choice {
    /// The exemplars, and what was found of each.
    files: Vec<PathBuf>,
    found: Vec<Analysis>,
    advice: Advice,
    tries: Vec<Try>,
    kept: usize,
}

impl Choice {
    /// The report of the kept texture, and how it was chosen.
    fn report(&self, kept: Report) -> Report {
        let mut text = format!("{}\n{}", kept.text, self.advice.reason);
        for (file, found) in self.files.iter().zip(&self.found) {
            if self.files.len() > 1 {
                let _ = write!(text, "\n{}", file.display());
            }
            let _ = write!(text, "\n{}", analyze::describe(found));
        }
        let _ = write!(text, "\nmade {}, kept the nearest to the exemplar (*):", self.tries.len());
        for (number, one) in self.tries.iter().enumerate() {
            text.push_str(&one.line(number == self.kept));
        }
        self.found.iter().for_each(|found| text.push_str(&analyze::warnings(found)));
        let mut json = kept.json;
        json["auto"] = json!({
            "analyses": self.found,
            "advice": self.advice,
            "tries": self.tries.iter().map(Try::json).collect::<Vec<_>>(),
            "kept": self.kept,
            "options": self.tries[self.kept].command,
        });
        Report::new(text, json)
    }
}
