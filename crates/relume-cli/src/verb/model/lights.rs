//! Options of models per light instead of a joint one.

use relume::workflow::model::LightModels;
use relume::{Direction, Error, Named, Result};

use crate::args;

/// Arguments for fields under moving light.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct LightArgs {
    /// Model functions of light direction jointly, or as the pictures under several lights
    #[arg(long, value_name = "HOW", default_value = "joint", value_parser = args::named::<Modelled>())]
    fields: Modelled,
    /// Direction towards a light for --fields per-light; repeat it for several [default: twelve spread over
    /// the hemisphere]
    #[arg(long, value_name = "X,Y,Z", value_parser = args::light, allow_hyphen_values = true)]
    light: Vec<Direction>,
}

/// The ways of modelling functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Modelled {
    Joint,
    PerLight,
}

impl Named for Modelled {
    const ALL: &'static [Self] = &[Self::Joint, Self::PerLight];

    fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint",
            Self::PerLight => "per-light",
        }
    }
}

impl LightArgs {
    /// The requested way of modelling functions.
    pub fn chosen(&self) -> Result<LightModels> {
        match (self.fields, self.light.is_empty()) {
            (Modelled::PerLight, _) => Ok(LightModels::PerLight(self.light.clone())),
            (Modelled::Joint, true) => Ok(LightModels::Joint),
            (Modelled::Joint, false) => {
                Err(Error::usage("--light belongs to --fields per-light: give both or neither"))
            }
        }
    }
}
