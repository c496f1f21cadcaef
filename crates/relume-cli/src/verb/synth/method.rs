//! The options of `relume synth` that choose a method, and those of the pixel methods.

use relume::numeric::lattice::Lattice;
use relume::workflow::options::Special;
use relume::workflow::{SynthOptions, SynthesisMethod};
use relume::{Error, Named, Result};

use crate::args;

/// Options that choose a method, and those of the pixel methods.
#[derive(Debug, Clone, clap::Args)]
#[group(skip)]
pub struct Args {
    /// The method: blocks, texel by texel, tiles of whole periods,
    /// whole elements of a lattice, an endless plane of noise, or the best by
    /// measurement of those suggested by an analysis [default: quilting]
    #[arg(long, value_parser = args::named::<SynthesisMethod>())]
    method: Option<SynthesisMethod>,
    /// Side of the window of compared texels, odd; it must contain the largest feature of the texture, with
    /// several levels at the coarsest one [default: for efros-leung two features, 11 to 21; 5 for wei-levoy,
    /// 9 for patchmatch; less for tiny exemplars]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    neighbourhood: Option<usize>,
    /// Draw from windows up to (1 + E) times the squared distance of the best one [default: 0.1]
    #[arg(long, value_name = "E", help_heading = "Options of the pixel methods")]
    epsilon: Option<f64>,
    /// Number of resolutions, each half the one before [default: until windows span three features
    /// and a period, at least 4, as far as they fit]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    levels: Option<usize>,
    /// Leaves of the tree that is searched for neighbourhoods; 0 searches all of them instead [default: no
    /// search, as --coherence 1]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    codewords: Option<usize>,
    /// Search only the continuations of neighbours, and for each of these K - 1 similar exemplar texels: 1 is
    /// the fastest and keeps pieces together [default: 1; with --codewords alone the tree is searched instead]
    #[arg(long, value_name = "K", help_heading = "Options of the pixel methods")]
    coherence: Option<usize>,
    /// Number of improvements of matches and texels at each level, at most two at the finest one [default: 5]
    #[arg(long, value_name = "N", help_heading = "Options of the pixel methods")]
    rounds: Option<usize>,
    /// Penalty for overused parts of the exemplar [default: 0.3]
    #[arg(long, value_name = "U", help_heading = "Options of the pixel methods")]
    uniformity: Option<f64>,
    /// Number of tiles of the Roller [default: 4]
    #[arg(long, value_name = "K", help_heading = "Options of the roller and of auto")]
    tiles: Option<usize>,
    /// The periods, instead of measured ones: W,H in texels, or two shifts X,Y,X,Y to the right and down
    #[arg(long, value_name = "W,H", value_parser = args::lattice, allow_hyphen_values = true)]
    #[arg(help_heading = "Options of the roller and of elements")]
    period: Option<Lattice>,
    /// Number of textures from which auto chooses; 1 follows the analysis without measuring [default: 7]
    #[arg(long, value_name = "N", help_heading = "Options of the roller and of auto")]
    tries: Option<usize>,
}

impl Args {
    /// Whether noise is requested.
    pub fn is_noise(&self) -> bool {
        self.method == Some(SynthesisMethod::Noise)
    }

    /// Whether a method for exemplars is asked for.
    pub fn is_given(&self) -> bool {
        self.method.is_some_and(|method| method != SynthesisMethod::Noise)
    }

    /// Whether blocks are placed.
    pub fn is_of_blocks(&self) -> bool {
        matches!(self.method, None | Some(SynthesisMethod::Quilting | SynthesisMethod::Auto))
    }

    /// The options of the method, to which the caller adds its own.
    pub fn options(&self) -> SynthOptions {
        SynthOptions {
            method: self.method.unwrap_or_default(),
            neighbourhood: self.neighbourhood,
            epsilon: self.epsilon,
            levels: self.levels,
            codewords: self.codewords,
            coherence: self.coherence,
            rounds: self.rounds,
            uniformity: self.uniformity,
            tiles: self.tiles,
            period: self.period,
            tries: self.tries,
            ..SynthOptions::default()
        }
    }
}

/// Refuses options of methods other than the chosen one.
pub fn refuse_strangers(options: &SynthOptions) -> Result<()> {
    let Some(Special { name, methods, .. }) = options.stranger() else { return Ok(()) };
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    Err(Error::usage(format!(
        "--{name} does not apply to --method {}: it is an option of {}",
        options.method.name(),
        names.join(" and ")
    )))
}
