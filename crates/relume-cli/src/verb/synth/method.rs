//! The options of `relume synth` that choose a method, and those of the methods that place texel
//! after texel.

use relume::workflow::options::Special;
use relume::workflow::{SynthOptions, SynthesisMethod};
use relume::{Error, Named, Result};

use crate::args;

/// Options that choose a method, and those of the methods that place texel after texel.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct Args {
    /// How the texture is made: from blocks, texel by texel, of tiles of whole periods, as an endless
    /// plane of noise, or in the way that measures best of those an analysis advises
    #[arg(long, default_value = "quilting", value_parser = args::named::<SynthesisMethod>())]
    method: SynthesisMethod,
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

impl Args {
    /// Whether noise is asked for.
    pub fn is_noise(&self) -> bool {
        self.method == SynthesisMethod::Noise
    }

    /// The options of the method, of which the caller adds its own.
    pub fn options(&self) -> SynthOptions {
        SynthOptions {
            method: self.method,
            neighbourhood: self.neighbourhood,
            epsilon: self.epsilon,
            levels: self.levels,
            codewords: self.codewords,
            coherence: self.coherence,
            rounds: self.rounds,
            uniformity: self.uniformity,
            tiles: self.tiles,
            tries: self.tries,
            ..SynthOptions::default()
        }
    }
}

/// Refuses options of another method than the chosen one.
pub fn refuse_strangers(options: &SynthOptions) -> Result<()> {
    let Some(Special { name, methods, .. }) = options.stranger() else { return Ok(()) };
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    Err(Error::usage(format!(
        "--{name} means nothing to --method {}: it is an option of {}",
        options.method.name(),
        names.join(" and ")
    )))
}
