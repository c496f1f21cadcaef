//! The report of a fit.

use serde::Serialize;

use super::design::Design;
use super::leave_one_out::coefficients_without;
use super::levels::SampleLevels;
use super::residual::{Lamp, squared_error, squared_error_near};
use super::robust::{Robust, TexelFitReport};
use super::sample::Grid;
use super::stream::PhotographStream;
use crate::direction::Direction;
use crate::error::Result;
use crate::field::PlaneLayout;
use crate::job::Job;
use crate::lamps::LampPositions;
use crate::numeric::decibel::psnr_db;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::Raster;
use crate::space::Space;

/// Condition numbers above this give a warning. Lights all over the hemisphere have about 11, rings at 40 and
/// 50 degrees 25; rings at 44 and 45 degrees, or lights within 10 degrees, about 220.
const POOR_CONDITION: f64 = 100.0;

/// An error of values with a peak of 1, clamped to 0..1, in the space of the report.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Residual {
    /// The root mean square error.
    pub rmse: f64,
    /// 20 log10(1 / RMSE); infinite (in JSON: null) for an error of zero.
    pub psnr_db: f64,
}

/// The relighting error of one photograph.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct LightReport {
    /// The name of the photograph.
    pub name: String,
    /// The unit vector towards the light.
    pub direction: [f64; 3],
    /// How much the photograph determines its own prediction: 0 not at all, 1 entirely.
    pub leverage: f64,
    /// The error of the field.
    #[serde(flatten)]
    pub error: Residual,
    /// The error of a field fitted to all other photographs, where requested and where they suffice.
    pub leave_one_out: Option<Residual>,
}

/// The relighting errors of a fitted field.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct FitReport {
    /// The space of the fitted and compared values.
    pub space: Space,
    /// Texels of the field.
    pub texels: usize,
    /// Those inside the mask; all without one.
    pub texels_inside: usize,
    /// Texels compared, on a regular grid; all when equal to `texels_inside`.
    pub texels_measured: usize,
    /// The condition number of the matrix of the fit, in the Frobenius norm.
    pub condition_number: f64,
    /// The weight of the ridge, if there is one.
    pub ridge: Option<f64>,
    /// Which photographs counted at a texel.
    pub robust: Robust,
    /// What a robust fit, or one under near lamps, did.
    pub texel_fit: Option<TexelFitReport>,
    /// The error over all photographs.
    pub error: Residual,
    /// The error over all photographs, each predicted from the others; those for which the others do not
    /// suffice are left out.
    pub leave_one_out: Option<Residual>,
    /// The index in `lights` of the photograph with the largest error, the first of equals.
    pub worst: usize,
    /// Each photograph, in the order given.
    pub lights: Vec<LightReport>,
    /// Reasons to doubt the figures or the coefficients, one sentence each.
    pub warnings: Vec<String>,
}

impl FitReport {
    /// The photograph with the largest error.
    pub fn worst_light(&self) -> &LightReport {
        &self.lights[self.worst]
    }
}

/// The inputs of the error measurement.
pub(super) struct FitMeasurement<'a> {
    pub lights: &'a [(String, Direction)],
    pub layout: &'a PlaneLayout,
    pub grid: &'a Grid,
    pub levels: &'a SampleLevels,
    pub design: &'a Design,
    pub robust: Robust,
    pub texel_fit: Option<TexelFitReport>,
    /// Lamps whose light has another direction at each texel.
    pub lamps: Option<&'a LampPositions>,
    /// The texels of the grid in every photograph; empty where they are too many to keep.
    pub kept: &'a [Raster],
}

/// Sums of squared errors of one photograph.
struct Errors {
    fit: f64,
    leave_one_out: Option<f64>,
}

impl FitMeasurement<'_> {
    /// Compares the final `coefficients` with all photographs, and those without each photograph, which are
    /// derived from the channel coefficients `linear` if given. Both are on the grid.
    pub fn report(
        &self,
        stream: &PhotographStream,
        coefficients: &Planes,
        linear: Option<&Planes>,
        job: &Job,
    ) -> Result<FitReport> {
        let lights = self.lights;
        let errors_of = |i: usize| {
            job.proceed()?;
            self.errors(i, stream, coefficients, linear)
        };
        let errors: Vec<Result<Errors>> = parallel::map(0..lights.len(), errors_of);
        let errors = errors.into_iter().collect::<Result<Vec<Errors>>>()?;
        let samples = self.grid.texels() * stream.channels();
        let light = |(i, error): (usize, &Errors)| LightReport {
            name: lights[i].0.clone(),
            direction: lights[i].1.to_array(),
            leverage: self.design.leverage(i),
            error: residual(error.fit, samples),
            leave_one_out: error.leave_one_out.map(|sum| residual(sum, samples)),
        };
        let predicted: Vec<f64> = errors.iter().filter_map(|e| e.leave_one_out).collect();
        let worst = (0..errors.len()).fold(0, |w, i| if errors[i].fit > errors[w].fit { i } else { w });
        Ok(FitReport {
            space: self.levels.space(),
            texels: self.grid.full_texels(),
            texels_inside: self.grid.inside_texels(),
            texels_measured: self.grid.texels(),
            condition_number: self.design.condition_number(),
            ridge: self.design.ridge_weight(),
            robust: self.robust,
            texel_fit: self.texel_fit,
            error: residual(errors.iter().map(|e| e.fit).sum(), samples * errors.len()),
            leave_one_out: (!predicted.is_empty())
                .then(|| residual(predicted.iter().sum(), samples * predicted.len())),
            worst,
            lights: errors.iter().enumerate().map(light).collect(),
            warnings: self.warnings(lights.len(), !predicted.is_empty()),
        })
    }

    fn errors(
        &self,
        i: usize,
        stream: &PhotographStream,
        field: &Planes,
        linear: Option<&Planes>,
    ) -> Result<Errors> {
        let read = |i| Ok(self.grid.raster(&stream.read(i)?));
        let read = if self.kept.is_empty() { Some(read(i)?) } else { None };
        let photograph = read.as_ref().unwrap_or_else(|| &self.kept[i]);
        let error = |planes: &Planes| match self.lamps {
            Some(lamps) => {
                let lamp = Lamp { lamps, number: i, grid: self.grid, basis: self.design.basis() };
                squared_error_near(planes, self.layout, &lamp, photograph, self.levels)
            }
            None => squared_error(planes, self.layout, self.design.values(i), photograph, self.levels),
        };
        let without =
            |linear| coefficients_without(i, photograph, linear, self.layout, self.design, self.levels);
        Ok(Errors { fit: error(field), leave_one_out: linear.and_then(without).as_ref().map(error) })
    }

    fn warnings(&self, photographs: usize, are_predicted: bool) -> Vec<String> {
        let mut warnings = Vec::from_iter(self.texel_fit.and_then(|fit| fit.warning(self.robust)));
        let is_plain = self.design.interpolated().is_none() && self.design.ridge_weight().is_none();
        let condition = self.design.condition_number();
        if condition > POOR_CONDITION {
            warnings.push(format!(
                "the lights distinguish some functions poorly (condition number {condition:.0}): noise in the \
                 photographs is amplified, more so under lights unlike those of the capture"
            ));
        }
        if self.design.interpolated().is_some() && !are_predicted {
            warnings.push(
                "the photographs themselves are the coefficients, so the errors under their lights say nothing about \
                 other lights: measure each photograph predicted from the others, or others that were not fitted"
                    .to_owned(),
            );
        } else if is_plain && photographs == self.design.functions() {
            warnings.push(format!(
                "{photographs} photographs are just enough for {photographs} functions: the fit passes through \
                 them, so its errors say nothing about other lights"
            ));
        }
        if is_plain && photographs > self.design.functions() && 2 * self.design.functions() > photographs {
            warnings.push(format!(
                "{} functions are many for {photographs} photographs, and may follow noise between their lights: compare \
                 with a ridge (--ridge auto)",
                self.design.functions()
            ));
        }
        warnings
    }
}

/// The error of samples from the sum of its squares.
pub(super) fn residual(sum_of_squares: f64, samples: usize) -> Residual {
    let mean = sum_of_squares / samples as f64;
    Residual { rmse: mean.sqrt(), psnr_db: psnr_db(mean) }
}
