//! Options of models per light instead of a joint one.

use relume::workflow::model::LightModels;
use relume::{Direction, Error, Named, Result};

use crate::args;

/// Arguments for fields under moving light.
#[derive(Debug, clap::Args)]
#[group(skip)]
pub struct LightArgs {
    /// Model functions of light direction jointly, or as the pictures under several lights; photographs of light and view as
    /// the pictures of clusters of them, with a range map (clusters)
    #[arg(long, value_name = "HOW", default_value = "joint", value_parser = args::named::<Modelled>())]
    fields: Modelled,
    /// Direction towards a light for --fields per-light; repeat it for several [default: twelve spread over
    /// the hemisphere]
    #[arg(long, value_name = "X,Y,Z", value_parser = args::light, allow_hyphen_values = true)]
    light: Vec<Direction>,
    /// Clusters of photographs for --fields clusters [default: 20]
    #[arg(long, value_name = "N")]
    pub image_clusters: Option<usize>,
    /// Leave out the range map of --fields clusters
    #[arg(long)]
    pub no_range: bool,
}

/// The ways of modelling functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Modelled {
    Joint,
    PerLight,
    Clusters,
}

impl Named for Modelled {
    const ALL: &'static [Self] = &[Self::Joint, Self::PerLight, Self::Clusters];

    fn name(self) -> &'static str {
        match self {
            Self::Joint => "joint",
            Self::PerLight => "per-light",
            Self::Clusters => "clusters",
        }
    }
}

impl LightArgs {
    /// Whether pictures of clusters of photographs are modelled.
    pub fn are_clusters(&self) -> bool {
        self.fields == Modelled::Clusters
    }

    /// The requested way of modelling functions.
    pub fn chosen(&self) -> Result<LightModels> {
        if !self.are_clusters() && (self.image_clusters.is_some() || self.no_range) {
            return Err(Error::usage(
                "--image-clusters and --no-range belong to --fields clusters: give it as well",
            ));
        }
        match (self.fields, self.light.is_empty()) {
            (Modelled::Clusters, true) => Ok(LightModels::Joint),
            (Modelled::PerLight, _) => Ok(LightModels::PerLight(self.light.clone())),
            (Modelled::Joint, true) => Ok(LightModels::Joint),
            (Modelled::Joint | Modelled::Clusters, false) => {
                Err(Error::usage("--light belongs to --fields per-light: give both or neither"))
            }
        }
    }
}
