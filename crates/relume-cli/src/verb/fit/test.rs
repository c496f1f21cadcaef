//! The result of a fit under lights that took no part in it.

use relume::capture::Capture;
use relume::direction::Directions;
use relume::workflow::tested::{self, TestReport};
use relume::{ReflectanceField, Result};

use super::Args;
use crate::context::Context;
use crate::output::CaptureFiles;

/// The test that was asked for.
pub(super) fn run(args: &Args, field: &ReflectanceField, context: &Context) -> Result<Option<TestReport>> {
    let Some(path) = &args.test else { return Ok(None) };
    let capture = Capture::open_paired(path, args.pair)?;
    let files = CaptureFiles::of(&capture)?;
    let pairs: Vec<(String, Directions)> =
        capture.lights().into_iter().map(|(name, light)| (name, light.into())).collect();
    let load = |i: usize| {
        let path = &capture.photographs[i].path;
        let photograph = files.raster(path, &context.job)?;
        let cropped = args.crop.map(|r| photograph.crop(r.x, r.y, r.size));
        cropped.unwrap_or(Ok(photograph)).map_err(|e| e.at(path))
    };
    tested::test(field, &pairs, &load, &context.job).map_err(|e| e.at(&capture.light_file)).map(Some)
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
