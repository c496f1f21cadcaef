//! The shortest way through the library: a capture is fitted, and a texture synthesised from the fit.
//!
//! Each function has a variant that takes a [`Job`]: limits, progress, and cancellation.

use super::auto::{Choice, Exemplars};
use super::method::{MethodReport, Plan};
use super::options::SynthOptions;
use crate::capture::Capture;
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::fit::{self, Fit, FitOptions};
use crate::format::read_raster;
use crate::job::Job;
use crate::synthesis::{Exemplar, SourceMap, gather};

/// A synthesised texture.
#[derive(Debug, Clone)]
pub struct Synthesized {
    /// The texture.
    pub field: ReflectanceField,
    /// The source of each of its texels: applies to everything registered with the exemplar.
    pub map: SourceMap,
    /// The plan it was made by.
    pub plan: Plan,
    /// The report of the method.
    pub report: MethodReport,
    /// How the plan was chosen, where several were tried.
    pub choice: Option<Choice>,
}

/// Fits functions of light direction to the photographs of a capture.
///
/// # Errors
/// Photographs that cannot be read or differ in size, lights that do not determine the functions, and
/// the default limits exceeded.
pub fn fit(capture: &Capture, options: &FitOptions) -> Result<Fit> {
    fit_with(capture, options, &Job::default())
}

/// [`fit`](fn@fit) as a part of a job.
///
/// # Errors
/// As [`fit`](fn@fit), within the job's limits; a cancelled job.
pub fn fit_with(capture: &Capture, options: &FitOptions, job: &Job) -> Result<Fit> {
    let load = |i: usize| read_raster(&capture.photographs[i].path, job);
    fit::fit(&capture.lights(), &load, options, job).map_err(|e| e.at(&capture.light_file))
}

/// Makes a texture from an exemplar. The result depends on the exemplar and the options only.
///
/// # Errors
/// Options without meaning or too large for the exemplar, and the default limits exceeded.
pub fn synthesize(exemplar: &ReflectanceField, options: &SynthOptions) -> Result<Synthesized> {
    synthesize_with(exemplar, options, &Job::default())
}

/// [`synthesize`] as a part of a job.
///
/// # Errors
/// As [`synthesize`], within the job's limits; a cancelled job.
pub fn synthesize_with(
    exemplar: &ReflectanceField,
    options: &SynthOptions,
    job: &Job,
) -> Result<Synthesized> {
    let approach = options.approach()?;
    let space = options.metric.space(exemplar, options.domain)?;
    let index = space.index_planes_within(exemplar, job, "the index of the exemplar")?;
    let exemplars = Exemplars { planes: &[Exemplar { index: &index, excluded: None }], files: &[] };
    let outcome = approach.run(&exemplars, job)?;
    let field = gather(&outcome.made.map, &[exemplar], job)?;
    let (map, report) = (outcome.made.map, outcome.made.how);
    Ok(Synthesized { field, map, plan: outcome.plan, report, choice: outcome.choice })
}
