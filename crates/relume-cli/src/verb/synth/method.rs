//! The methods of `relume synth`: their options, checked, and what they say when they are done.

use clap::builder::{PossibleValuesParser, TypedValueParser};
use relume::synthesis::fill::{FillOptions, close};
use relume::synthesis::pixel::patch_match::Optimised;
use relume::synthesis::pixel::wei_levoy::Scanned;
use relume::synthesis::pixel::{
    EfrosLeungOptions, Growth, NeighbourSearch, PatchMatchOptions, WeiLevoyOptions, efros_leung, patch_match,
    wei_levoy,
};
use relume::synthesis::{BlockOptions, Boundary, Exemplar, SourceMap, synthesize};
use relume::{Error, ReflectanceField, Result, Size};
use serde_json::{Value, json};

use super::auto::Auto;
use super::roller::Laid;
use crate::context::Context;
use crate::report::Report;

/// Options that choose a method, and those of the methods that place texel after texel.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct Args {
    /// How the texture is made: from blocks, texel by texel, of tiles of whole periods, as an endless
    /// plane of noise, or in the way that measures best of those an analysis advises
    #[arg(long, default_value = "quilting", value_parser = method())]
    method: Method,
    /// Side of the window of texels that is compared, odd; alone it must hold the texture's largest
    /// thing, with several levels the coarsest one does [default: 11 for efros-leung, 5 for wei-levoy,
    /// 9 for patchmatch]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    neighbourhood: Option<usize>,
    /// Draw among windows up to (1 + E) times the squared distance of the best one [default: 0.1]
    #[arg(long, value_name = "E", help_heading = "Options of the pixel methods")]
    epsilon: Option<f64>,
    /// Resolutions, each half the one before [default: 4 for wei-levoy; for patchmatch 5, or as many as
    /// patches fit]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    levels: Option<usize>,
    /// Leaves of the tree in which neighbourhoods are looked for; 0 looks at all of them instead
    /// [default: 4096]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    codewords: Option<usize>,
    /// Look only among what continues a neighbour, and for each of these K - 1 exemplar texels that are
    /// like it: 1 is the fastest and keeps pieces together
    #[arg(long, value_name = "K", help_heading = "Options of the pixel methods")]
    coherence: Option<usize>,
    /// How often matches and texels are improved at each level, at most twice at the finest one
    /// [default: 5]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    rounds: Option<usize>,
    /// How much parts of the exemplar are avoided that are used more than evenly [default: 0.3]
    #[arg(long, value_name = "U", help_heading = "Options of the pixel methods")]
    uniformity: Option<f64>,
    /// Tiles of the Roller [default: 4]
    #[arg(long, value_name = "K", help_heading = "Options of the roller and of auto")]
    tiles: Option<usize>,
    /// Textures that auto makes to choose from; 1 takes what the analysis advises [default: 7]
    #[arg(long, value_name = "N", help_heading = "Options of the roller and of auto")]
    tries: Option<usize>,
}

/// What makes a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Method {
    Quilting,
    EfrosLeung,
    WeiLevoy,
    PatchMatch,
    Roller,
    Noise,
    Auto,
}

impl Method {
    const ALL: [Self; 7] = [
        Self::Quilting,
        Self::EfrosLeung,
        Self::WeiLevoy,
        Self::PatchMatch,
        Self::Roller,
        Self::Noise,
        Self::Auto,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Quilting => "quilting",
            Self::EfrosLeung => "efros-leung",
            Self::WeiLevoy => "wei-levoy",
            Self::PatchMatch => "patchmatch",
            Self::Roller => "roller",
            Self::Noise => "noise",
            Self::Auto => "auto",
        }
    }
}

fn method() -> impl TypedValueParser<Value = Method> {
    PossibleValuesParser::new(Method::ALL.map(Method::name)).map(|text| {
        let method = Method::ALL.into_iter().find(|method| method.name() == text);
        method.expect("only listed names are possible")
    })
}

/// A method with all its options.
pub enum Plan {
    /// Blocks joined along cuts or by ramps.
    Quilting(BlockOptions),
    /// Growth from a seed.
    EfrosLeung(EfrosLeungOptions),
    /// Scanlines from noise, coarse to fine.
    WeiLevoy(WeiLevoyOptions, Boundary),
    /// The whole improved by matches of its patches, coarse to fine.
    PatchMatch(PatchMatchOptions),
    /// Tiles of whole periods.
    Roller(Laid),
    /// The best by measure of several of these.
    Auto(Auto),
}

impl Plan {
    /// The options of the chosen method; size, boundary and seed are those of the blocks.
    ///
    /// # Errors
    /// When they mean nothing, or options of another method are given.
    pub fn new(synth: &super::Args, blocks: BlockOptions) -> Result<Self> {
        let args = &synth.method;
        args.refuse_strangers(&synth.of_blocks())?;
        let (size, boundary, seed) = (blocks.size, blocks.boundary, blocks.seed);
        match args.method {
            Method::Quilting => {
                blocks.validate()?;
                Ok(Self::Quilting(blocks))
            }
            Method::EfrosLeung => {
                let default = EfrosLeungOptions::default();
                let window = args.neighbourhood.unwrap_or(default.window);
                let epsilon = args.epsilon.unwrap_or(default.epsilon);
                let guidance = blocks.guidance;
                let options = EfrosLeungOptions { size, window, epsilon, boundary, guidance, seed };
                options.validate()?;
                Ok(Self::EfrosLeung(options))
            }
            Method::WeiLevoy => {
                let default = WeiLevoyOptions::default();
                let search = args.neighbour_search(default.search);
                let window = args.neighbourhood.unwrap_or(default.window);
                let levels = args.levels.unwrap_or(default.levels);
                let guidance = blocks.guidance;
                let options = WeiLevoyOptions { size, window, levels, search, guidance, seed };
                options.validate()?;
                Ok(Self::WeiLevoy(options, boundary))
            }
            Method::PatchMatch => {
                let default = PatchMatchOptions::default();
                let options = PatchMatchOptions {
                    size,
                    window: args.neighbourhood.unwrap_or(default.window),
                    levels: args.levels.unwrap_or(default.levels),
                    rounds: args.rounds.unwrap_or(default.rounds),
                    uniformity: args.uniformity.unwrap_or(default.uniformity),
                    guidance: blocks.guidance,
                    seed,
                    ..default
                };
                options.validate()?;
                Ok(Self::PatchMatch(options))
            }
            Method::Roller => {
                let tiles = args.tiles.unwrap_or(Laid::TILES);
                Ok(Self::Roller(Laid::new(tiles, &blocks)?))
            }
            Method::Auto => Ok(Self::Auto(Auto::new(args.tries, blocks)?)),
            Method::Noise => Err(Error::usage("--method noise makes windows of an endless plane only")),
        }
    }

    /// Makes the texture, and says how it came about. `fields` are what the exemplars are index planes of.
    pub fn run(
        &self,
        args: &super::Args,
        fields: &[&ReflectanceField],
        exemplars: &[Exemplar<'_>],
        context: &Context,
    ) -> Result<(SourceMap, Report)> {
        let job = &context.job;
        let (map, (how, json)) = match self {
            Self::Quilting(options) => {
                let made = synthesize(exemplars, options, job)?;
                let report = super::report(args, options, &made);
                return Ok((made.map, report));
            }
            Self::EfrosLeung(options) => {
                let (map, growth) = efros_leung(exemplars, options, job)?;
                (map, describe_growth(options, &growth))
            }
            Self::WeiLevoy(options, boundary) => {
                let (map, scanned) = wei_levoy(exemplars, options, job)?;
                let described = describe_scan(options, &scanned);
                match boundary {
                    Boundary::Open => (map, described),
                    Boundary::Torus => (closed(&map, options, exemplars, context)?, described),
                }
            }
            Self::PatchMatch(options) => {
                let (map, optimised) = patch_match(exemplars, options, job)?;
                (map, describe_optimisation(options, &optimised))
            }
            Self::Roller(laid) => return laid.run(args, exemplars, context),
            Self::Auto(auto) => return auto.run(args, fields, exemplars, context),
        };
        let report = texel_report(args, map.size(), &how, json);
        Ok((map, report))
    }
}

/// Texels along each edge that are filled anew where scanlines are to tile: their last rows do not see
/// the first.
const CLOSED: usize = 16;

/// The same texture, tiling.
fn closed(
    map: &SourceMap,
    options: &WeiLevoyOptions,
    exemplars: &[Exemplar<'_>],
    context: &Context,
) -> Result<SourceMap> {
    let Size { width, height } = options.size;
    let band = (width.min(height) / 8).clamp(1, CLOSED);
    let guidance = options.guidance.clone();
    let filling = FillOptions { guidance, seed: options.seed, ..FillOptions::default() };
    Ok(close(map, exemplars, band, &filling, &context.job)?.0)
}

fn describe_growth(options: &EfrosLeungOptions, growth: &Growth) -> (String, Value) {
    let how = format!(
        "grown texel by texel from windows of {}, drawn from {} positions, {:.1} candidates a texel",
        options.window,
        growth.positions,
        growth.candidates as f64 / growth.texels.max(1) as f64
    );
    (how, json!({ "window": options.window, "epsilon": options.epsilon, "synthesis": growth }))
}

fn describe_scan(options: &WeiLevoyOptions, scanned: &Scanned) -> (String, Value) {
    let WeiLevoyOptions { window, levels, search, .. } = *options;
    let how = format!(
        "row by row at {levels} levels from windows of {window}, near ones of {} neighbourhoods",
        scanned.neighbourhoods
    );
    (how, json!({ "window": window, "levels": levels, "search": search, "synthesis": scanned }))
}

fn describe_optimisation(options: &PatchMatchOptions, optimised: &Optimised) -> (String, Value) {
    let PatchMatchOptions { window, rounds, uniformity, .. } = *options;
    let levels = optimised.levels;
    let how = format!(
        "improved up to {rounds} times at {levels} levels by patches of {window}, matched to {} positions",
        optimised.positions
    );
    let json = json!({
        "window": window,
        "levels": levels,
        "rounds": rounds,
        "uniformity": uniformity,
        "synthesis": optimised,
    });
    (how, json)
}

/// What a pixel method says of itself.
fn texel_report(args: &super::Args, size: Size, how: &str, special: Value) -> Report {
    let closed = args.tile || args.method.method == Method::PatchMatch;
    let tiles = if closed { "; tiles without a seam" } else { "" };
    let text = format!("{}: {size} texels {how}{tiles}", args.output.display());
    let mut json = json!({
        "width": size.width,
        "height": size.height,
        "method": args.method.method.name(),
        "tile": closed,
        "seed": args.seed,
    });
    for (name, value) in special.as_object().into_iter().flatten() {
        json[name] = value.clone();
    }
    Report::new(text, json)
}

impl Args {
    /// Whether noise is asked for.
    pub fn is_noise(&self) -> bool {
        self.method == Method::Noise
    }

    /// How Wei-Levoy searches.
    fn neighbour_search(&self, default: NeighbourSearch) -> NeighbourSearch {
        let customary = match default {
            NeighbourSearch::Tsvq(codewords) => codewords,
            _ => 0,
        };
        match (self.coherence, self.codewords.unwrap_or(customary)) {
            (Some(candidates), codewords) => NeighbourSearch::Coherence { candidates, codewords },
            (None, 0) => NeighbourSearch::Full,
            (None, codewords) => NeighbourSearch::Tsvq(codewords),
        }
    }

    /// Options of some methods, whether they are given, and whose they are.
    fn special(&self) -> [(&'static str, bool, &'static [Method]); 9] {
        use Method::{EfrosLeung, PatchMatch, WeiLevoy};
        [
            ("--tiles", self.tiles.is_some(), &[Method::Roller]),
            ("--tries", self.tries.is_some(), &[Method::Auto]),
            ("--neighbourhood", self.neighbourhood.is_some(), &[EfrosLeung, WeiLevoy, PatchMatch]),
            ("--epsilon", self.epsilon.is_some(), &[EfrosLeung]),
            ("--levels", self.levels.is_some(), &[WeiLevoy, PatchMatch]),
            ("--codewords", self.codewords.is_some(), &[WeiLevoy]),
            ("--coherence", self.coherence.is_some(), &[WeiLevoy]),
            ("--rounds", self.rounds.is_some(), &[PatchMatch]),
            ("--uniformity", self.uniformity.is_some(), &[PatchMatch]),
        ]
    }

    /// Options of some methods, and whether they are given.
    pub fn given(&self) -> impl Iterator<Item = (&'static str, bool)> {
        self.special().into_iter().map(|(name, given, _)| (name, given))
    }

    /// Refuses options of another method than the chosen one.
    fn refuse_strangers(&self, of_blocks: &[(&'static str, bool)]) -> Result<()> {
        let blocks =
            of_blocks.iter().map(|(name, given)| (*name, *given, &[Method::Quilting, Method::Auto][..]));
        let given = blocks.chain(self.special());
        for (name, _, methods) in given.filter(|(_, given, _)| *given) {
            if !methods.contains(&self.method) {
                let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
                return Err(Error::usage(format!(
                    "{name} means nothing to --method {}: it is an option of {}",
                    self.method.name(),
                    names.join(" and ")
                )));
            }
        }
        Ok(())
    }
}
