//! Methods of synthesis as plans: the method with all its options, before anything is made.

use super::sizes::closing_window;
use super::tiling::MeasuredTiling;
use crate::error::{Error, ErrorKind, Result};
use crate::job::Job;
use crate::names::named;
use crate::planes::Planes;
use crate::size::Size;
use crate::synthesis::elements::{self, ElementOptions, ElementsLaid};
use crate::synthesis::fill::{FillMethod, FillOptions, close};
use crate::synthesis::pixel::patch_match::Optimised;
use crate::synthesis::pixel::wei_levoy::Scanned;
use crate::synthesis::pixel::{
    EfrosLeungOptions, Growth, PatchMatchOptions, WeiLevoyOptions, efros_leung, patch_match, wei_levoy,
};
use crate::synthesis::roller::{Rolled, RollerOptions, lay, roll};
use crate::synthesis::{
    BlockOptions, Boundary, Exemplar, Guidance, SourceMap, StageTimes, SynthesisReport, synthesize,
};

/// The methods of synthesis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SynthesisMethod {
    /// Blocks joined along cuts or by ramps.
    #[default]
    Quilting,
    /// Growth from a seed, texel by texel.
    EfrosLeung,
    /// Scanlines from noise, coarse to fine.
    WeiLevoy,
    /// The whole output improved by matching its patches.
    PatchMatch,
    /// Tiles of whole periods in random order.
    Roller,
    /// Whole elements of a lattice in random order.
    Elements,
    /// An endless plane of blended noise, which has no source map.
    Noise,
    /// The best by measurement of those suggested by an analysis.
    Auto,
}

named!(SynthesisMethod {
    Quilting => "quilting",
    EfrosLeung => "efros-leung",
    WeiLevoy => "wei-levoy",
    PatchMatch => "patchmatch",
    Roller => "roller",
    Elements => "elements",
    Noise => "noise",
    Auto => "auto",
});

impl SynthesisMethod {
    /// Whether every texel is a copy whose source is known: noise is blended.
    pub const fn has_source_map(self) -> bool {
        !matches!(self, Self::Noise)
    }
}

/// A method with all its options.
#[derive(Debug, Clone, PartialEq)]
pub enum Plan {
    /// Blocks joined along cuts or by ramps.
    Quilting(BlockOptions),
    /// Growth from a seed.
    EfrosLeung(EfrosLeungOptions),
    /// Scanlines from noise; if the output has to tile, its border is bridged.
    WeiLevoy(WeiLevoyOptions, Boundary),
    /// The whole output improved by matching its patches; it always tiles, and its border is bridged if it shows.
    PatchMatch(PatchMatchOptions),
    /// Tiles of whole periods in random order.
    Roller(LaidTiles),
    /// Whole elements of a lattice in random order.
    Elements(ElementOptions),
}

/// Tiles to make, and the texture to lay from them.
#[derive(Debug, Clone, PartialEq)]
pub struct LaidTiles {
    /// The options of the tiles.
    pub options: RollerOptions,
    /// Size of the texture in texels.
    pub size: Size,
    /// Whether it tiles.
    pub boundary: Boundary,
    /// Seed of the order of tiles.
    pub seed: u64,
}

impl LaidTiles {
    /// The default number of tiles of a set: each takes about a quarter of the exemplar.
    pub const TILES: usize = 4;

    /// The given number of tiles in a texture of that size, boundary and seed.
    pub fn new(tiles: usize, size: Size, boundary: Boundary, seed: u64) -> Self {
        // Only rectangles close on the sides of the output.
        let oblique = boundary == Boundary::Open;
        Self {
            options: RollerOptions { tiles, oblique, vary: true, ..RollerOptions::default() },
            size,
            boundary,
            seed,
        }
    }
}

/// A texture as a source map, and the report of its method.
#[derive(Debug, Clone, PartialEq)]
pub struct MadeTexture {
    /// Where each texel comes from.
    pub map: SourceMap,
    /// The report of the method.
    pub how: MethodReport,
}

/// The report of a method.
#[derive(Debug, Clone, PartialEq)]
pub enum MethodReport {
    /// Blocks, and their cost.
    Quilting(SynthesisReport, StageTimes),
    /// Texels one after another.
    EfrosLeung(Growth),
    /// Rows.
    WeiLevoy(Scanned),
    /// Rounds of improvement.
    PatchMatch(Optimised),
    /// The tiles.
    Roller(Box<Rolled>),
    /// The elements.
    Elements(ElementsLaid),
}

impl Plan {
    /// The method.
    pub fn method(&self) -> SynthesisMethod {
        match self {
            Self::Quilting(_) => SynthesisMethod::Quilting,
            Self::EfrosLeung(_) => SynthesisMethod::EfrosLeung,
            Self::WeiLevoy(..) => SynthesisMethod::WeiLevoy,
            Self::PatchMatch(_) => SynthesisMethod::PatchMatch,
            Self::Roller(_) => SynthesisMethod::Roller,
            Self::Elements(_) => SynthesisMethod::Elements,
        }
    }

    /// Seed of the random choices.
    pub fn seed(&self) -> u64 {
        match self {
            Self::Quilting(options) => options.seed,
            Self::EfrosLeung(options) => options.seed,
            Self::WeiLevoy(options, _) => options.seed,
            Self::PatchMatch(options) => options.seed,
            Self::Roller(laid) => laid.seed,
            Self::Elements(options) => options.seed,
        }
    }

    /// The same with another seed.
    #[must_use]
    pub fn with_seed(&self, seed: u64) -> Self {
        let mut plan = self.clone();
        match &mut plan {
            Self::Quilting(options) => options.seed = seed,
            Self::EfrosLeung(options) => options.seed = seed,
            Self::WeiLevoy(options, _) => options.seed = seed,
            Self::PatchMatch(options) => options.seed = seed,
            Self::Roller(laid) => laid.seed = seed,
            Self::Elements(options) => options.seed = seed,
        }
        plan
    }

    /// The same at another size, to be looked at: whole tiles are not required.
    #[must_use]
    pub fn trial(&self, size: Size) -> Self {
        let mut plan = self.clone();
        match &mut plan {
            Self::Quilting(options) => options.size = size,
            Self::EfrosLeung(options) => options.size = size,
            Self::WeiLevoy(options, _) => options.size = size,
            Self::PatchMatch(options) => options.size = size,
            Self::Elements(options) if options.size != size => {
                (options.size, options.boundary) = (size, Boundary::Open);
            }
            Self::Roller(laid) if laid.size != size => {
                (laid.size, laid.boundary) = (size, Boundary::Open);
            }
            Self::Elements(_) | Self::Roller(_) => {}
        }
        plan
    }

    /// Whether the texture tiles.
    pub fn tiles(&self) -> bool {
        match self {
            Self::Quilting(BlockOptions { boundary, .. })
            | Self::EfrosLeung(EfrosLeungOptions { boundary, .. })
            | Self::WeiLevoy(_, boundary)
            | Self::Elements(ElementOptions { boundary, .. })
            | Self::PatchMatch(PatchMatchOptions { boundary, .. })
            | Self::Roller(LaidTiles { boundary, .. }) => *boundary == Boundary::Torus,
        }
    }

    /// Checks the options in isolation; they are checked against the exemplars later.
    ///
    /// # Errors
    /// Options without meaning.
    pub fn validate(&self) -> Result<()> {
        match self {
            Self::Quilting(options) => options.validate(),
            Self::EfrosLeung(options) => options.validate(),
            Self::WeiLevoy(options, _) => options.validate(),
            Self::PatchMatch(options) => options.validate(),
            Self::Roller(laid) => laid.options.validate(),
            Self::Elements(options) => options.validate(),
        }
    }

    /// Makes the texture. The result depends on the exemplars and the plan only.
    ///
    /// # Errors
    /// Options without meaning, exemplars unsuitable for the method, and limits exceeded.
    pub fn run(&self, exemplars: &[Exemplar<'_>], job: &Job) -> Result<MadeTexture> {
        match self {
            Self::Quilting(options) => {
                let made = synthesize(exemplars, options, job)?;
                Ok(MadeTexture { map: made.map, how: MethodReport::Quilting(made.report, made.times) })
            }
            Self::EfrosLeung(options) => {
                let (map, growth) = efros_leung(exemplars, options, job)?;
                Ok(MadeTexture { map, how: MethodReport::EfrosLeung(growth) })
            }
            Self::WeiLevoy(options, boundary) => {
                let (map, scanned) = wei_levoy(exemplars, options, job)?;
                let map = match boundary {
                    Boundary::Open => map,
                    Boundary::Torus => closed(&map, options.guidance.clone(), options.seed, exemplars, job)?,
                };
                Ok(MadeTexture { map, how: MethodReport::WeiLevoy(scanned) })
            }
            Self::PatchMatch(options) => {
                let (map, optimised) = patch_match(exemplars, options, job)?;
                let map = match options.boundary {
                    Boundary::Open => map,
                    Boundary::Torus => closed_if_it_shows(map, options, exemplars, job)?,
                };
                Ok(MadeTexture { map, how: MethodReport::PatchMatch(optimised) })
            }
            Self::Roller(laid) => laid.run(exemplars, job),
            Self::Elements(options) => {
                let [exemplar] = exemplars else {
                    return Err(Error::usage("the method elements lays those of one exemplar: give one"));
                };
                let (map, laid) = elements::lay(exemplar, options, job)?;
                Ok(MadeTexture { map, how: MethodReport::Elements(laid) })
            }
        }
    }
}

impl LaidTiles {
    fn run(&self, exemplars: &[Exemplar<'_>], job: &Job) -> Result<MadeTexture> {
        let [exemplar] = exemplars else {
            return Err(Error::usage("the method roller makes tiles of one exemplar: give one"));
        };
        let rolled = roll(exemplar, &self.options, job)?;
        let map = lay(&rolled.tiles, self.size, self.boundary, self.seed, job)?;
        Ok(MadeTexture { map, how: MethodReport::Roller(Box::new(rolled)) })
    }
}

/// The width of the band along each edge within which the border of a texture that has to tile is bridged: the
/// last rows of scanlines do not see the first, and an optimisation may end with a border that shows.
const CLOSED: usize = 16;

/// The texture of an optimisation, with its border bridged if it shows and there is room for bridges.
fn closed_if_it_shows(
    map: SourceMap,
    options: &PatchMatchOptions,
    exemplars: &[Exemplar<'_>],
    job: &Job,
) -> Result<SourceMap> {
    let index: Vec<&Planes> = exemplars.iter().map(|exemplar| exemplar.index).collect();
    if !MeasuredTiling::measure(&map, &index, job)?.shows {
        return Ok(map);
    }
    match closed(&map, options.guidance.clone(), options.seed, exemplars, job) {
        Err(error) if error.kind() == ErrorKind::Usage => Ok(map),
        closed => closed,
    }
}

/// The same texture, tiling.
fn closed(
    map: &SourceMap,
    guidance: Option<Guidance>,
    seed: u64,
    exemplars: &[Exemplar<'_>],
    job: &Job,
) -> Result<SourceMap> {
    let Size { width, height } = map.size();
    let band = (width.min(height) / 8).clamp(1, CLOSED);
    let default = FillOptions::default();
    let window = closing_window(default.window, exemplars, map.size());
    let filling = FillOptions { method: FillMethod::Bridges, window, guidance, seed, ..default };
    Ok(close(map, exemplars, band, &filling, job)?.0)
}
