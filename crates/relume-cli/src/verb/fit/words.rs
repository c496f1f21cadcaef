//! The errors of a fit in words.

use relume::Space;
use relume::fit::learned::{PairsReport, PolarReport};

use crate::decibels::{self, decibels};
use crate::report::counted;

/// The errors by the polar angle of the view, or of the light where all photographs have one view.
pub(super) fn by_polar_angle(views: &[PolarReport], lights: &[PolarReport]) -> String {
    let (what, angles) = if views.len() > 1 { ("view", views) } else { ("light", lights) };
    let sums = angles.iter().map(|p| (p.polar_deg, p.pairs, p.pairs as f64 * p.encoded.rmse.powi(2)));
    decibels::by_polar_angle(what, &sums.collect::<Vec<_>>(), |mean| decibels(-10.0 * mean.log10()))
}

/// The error of all photographs, by the measure of `relume compare`; and that of the values that were fitted, if they are others.
pub(super) fn relit(report: &PairsReport, space: Space) -> String {
    let error = &report.encoded;
    let lab = report.mae_lab.map_or(String::new(), |mae| format!(", mean difference {mae:.2} in CIE Lab"));
    let fitted = match space {
        Space::Srgb => String::new(),
        Space::Linear => format!("; of linear values, which were fitted: {}", decibels(report.error.psnr_db)),
    };
    let (psnr, rmse) = (decibels(error.psnr_db), error.rmse);
    format!(
        "relit photographs, encoded: {psnr} PSNR, RMSE {rmse:.4} ({:.2} of 255){lab}{fitted}",
        255.0 * rmse
    )
}

/// The texels on which errors were measured.
pub(super) fn measured(measured: usize, inside: usize, all: usize) -> String {
    let of =
        if inside == all { format!("{all}") } else { format!("{inside} texels inside the mask, of {all}") };
    let texels = if inside == all { " texels" } else { "" };
    format!("measured on {measured} of {of}{texels}, before rounding to the file's depth")
}

/// The errors of photographs left out.
pub(super) fn predicted(left_out: &PairsReport, fitted: &PairsReport) -> String {
    let lab = left_out.mae_lab.map_or(String::new(), |mae| format!(", mean difference {mae:.2} in CIE Lab"));
    format!(
        "{} left out and predicted, encoded: {}, RMSE {:.4}{lab} ({} for those fitted)",
        counted(left_out.pairs, "photograph"),
        decibels(left_out.encoded.psnr_db),
        left_out.encoded.rmse,
        decibels(fitted.encoded.psnr_db)
    )
}
