//! The result of a fit under lights that took no part in it.

use relume::direction::Directions;
use relume::workflow::tested::{self, TestReport};
use relume::{ReflectanceField, Result};

use super::Args;
use crate::context::Context;
use crate::photographs::{PhotographArgs, PhotographSet};

/// The test that was asked for.
pub(super) fn run(args: &Args, field: &ReflectanceField, context: &Context) -> Result<Option<TestReport>> {
    let Some(path) = &args.test else { return Ok(None) };
    // What belongs to each light of the fitted capture is not of the lights of another.
    let photographs =
        PhotographArgs { intensities: None, align: false, equalize: false, ..args.photographs.clone() };
    let set = PhotographSet::open(path, &photographs, &context.job)?;
    let pairs: Vec<(String, Directions)> =
        set.lights().iter().map(|(name, light)| (name.clone(), (*light).into())).collect();
    let load = |i: usize| set.photograph(i, &context.job);
    tested::test(field, &pairs, &load, &context.job).map_err(|e| e.at(&set.capture.light_file)).map(Some)
}

/// The test in words, as a line of its own.
pub(super) fn summary(report: &TestReport) -> String {
    let worst = &report.lights[report.worst];
    format!(
        "\n{} photographs that were not fitted: {:.2} dB PSNR (mean over pictures); worst: {}, {:.2} dB",
        report.lights.len(),
        report.psnr_db,
        worst.name,
        worst.psnr_db
    )
}
