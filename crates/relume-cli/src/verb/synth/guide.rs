//! Guides for the output of `relume synth`.

use std::path::{Path, PathBuf};

use relume::synthesis::Guidance;
use relume::{Error, Planes, Result};

use crate::context::Context;
use crate::input;

/// Options for guides.
#[derive(Debug, Clone, clap::Args)]
#[group(skip)]
pub struct Args {
    /// Label maps or other images registered with the exemplars, one for each in turn; the output follows
    /// --guide-target in the same terms
    #[arg(long, value_name = "IMAGE", num_args = 1.., requires = "guide_target")]
    guide_source: Vec<PathBuf>,
    /// An image of the size of the output that steers its layout, in terms of --guide-source
    #[arg(long, value_name = "IMAGE", requires = "guide_source")]
    guide_target: Option<PathBuf>,
    /// Weight of a difference of the guides relative to one of the texture [default: 1]
    #[arg(long, value_name = "W", requires = "guide_target")]
    guide_weight: Option<f64>,
    /// Let the output change from side to side as the exemplar does, stretched to its size: a fire stays dark above and
    /// bright below. --method auto does so where the change is plain
    #[arg(long, conflicts_with = "guide_target")]
    pub follow_trend: bool,
}

impl Args {
    /// The files to read.
    pub fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.guide_source.iter().chain(&self.guide_target).map(PathBuf::as_path)
    }

    /// The option that turns guidance on, and whether it is given.
    pub fn given(&self) -> (&'static str, bool) {
        ("--guide-source", self.guide_target.is_some())
    }

    /// Reads the guides of the given number of exemplars.
    pub fn read(&self, exemplars: usize, context: &Context) -> Result<Option<Guidance>> {
        let Some(target) = &self.guide_target else { return Ok(None) };
        if self.guide_source.len() != exemplars {
            return Err(Error::usage(format!(
                "--guide-source has {} images for {exemplars} exemplars: give one for each in turn",
                self.guide_source.len()
            )));
        }
        let planes = |path: &PathBuf| -> Result<Planes> {
            Ok(input::registered(path, &context.job)?.field.coefficients().clone())
        };
        Ok(Some(Guidance {
            sources: self.guide_source.iter().map(planes).collect::<Result<_>>()?,
            target: planes(target)?,
            weight: self.guide_weight.unwrap_or(1.0),
        }))
    }
}
