//! The errors of a factorisation, on measured pairs and on those left out.

use serde::Serialize;

use crate::error::Result;
use crate::field::ReflectanceField;
use crate::fit::pair_errors::{Measurement, PairsReport, PolarReport};
use crate::fit::report::{Residual, residual};
use crate::job::Job;
use crate::raster::Raster;
use crate::space::Space;

/// The errors of a factorised texture of light and view.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LearnedReport {
    /// The space of the fitted and compared values.
    pub space: Space,
    /// Functions learned.
    pub functions: usize,
    /// Their singular values, largest first, as root mean squares of all values.
    pub singular_values: Vec<f64>,
    /// Texels of the field.
    pub texels: usize,
    /// Those inside the mask; all without one.
    pub texels_inside: usize,
    /// Texels compared, on a regular grid; all when equal to `texels_inside`.
    pub texels_measured: usize,
    /// The error over all texels inside of the photographs that took part, from the singular values: a difference of large
    /// sums, so that a root mean square below 3e-4 is rounding.
    pub error: Residual,
    /// The photographs that took part.
    pub fitted: PairsReport,
    /// The photographs left out, predicted by interpolation of the functions.
    pub held_out: Option<PairsReport>,
    /// All photographs by the polar angle of the view.
    pub by_view: Vec<PolarReport>,
    /// All photographs by the polar angle of the light.
    pub by_light: Vec<PolarReport>,
    /// The name of the photograph with the largest error.
    pub worst: String,
    /// Reasons for doubt, one sentence each.
    pub warnings: Vec<String>,
}

/// Compares a field with the samples kept of each photograph; `rmse` is that over all texels.
pub(super) fn report(
    measured: &Measurement<'_>,
    field: &ReflectanceField,
    kept: &[Raster],
    singular_values: &[f64],
    rmse: f64,
    job: &Job,
) -> Result<LearnedReport> {
    let (grid, layout) = (measured.grid, field.layout());
    let (n, channels) = (field.basis().len(), layout.channels());
    let coefficients = grid.planes(field.coefficients());
    let predict = |i: usize, out: &mut [f64]| {
        let weights = field.basis().weights(measured.pairs[i].1);
        for (channel, values) in out.chunks_exact_mut(grid.texels()).enumerate() {
            let weights = layout.weights(channel, n, &weights);
            for (texel, value) in values.iter_mut().enumerate() {
                let terms = weights.iter().enumerate();
                *value = terms.map(|(k, w)| w * f64::from(coefficients.plane(k)[texel])).sum();
            }
        }
        Ok(())
    };
    let errors = measured.errors(kept, &predict, job)?;
    let samples = grid.texels() * channels;
    let values = (measured.held_out.kept() * channels * grid.inside_texels()) as f64;
    Ok(LearnedReport {
        space: measured.levels.space(),
        functions: singular_values.len(),
        singular_values: singular_values.iter().map(|s| s / values.sqrt()).collect(),
        texels: grid.full_texels(),
        texels_inside: grid.inside_texels(),
        texels_measured: grid.texels(),
        error: residual(rmse * rmse * samples as f64, samples),
        fitted: errors.fitted,
        held_out: errors.held_out,
        by_view: errors.by_view,
        by_light: errors.by_light,
        worst: errors.worst,
        warnings: Vec::new(),
    })
}
