//! The errors of a factorisation, on measured pairs and on those left out.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::held_out::HeldOut;
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::field::ReflectanceField;
use crate::fit::levels::SampleLevels;
use crate::fit::report::{Residual, residual};
use crate::fit::sample::Grid;
use crate::job::Job;
use crate::lab;
use crate::planes::Planes;
use crate::raster::Raster;
use crate::space::Space;

/// The error of the photographs with one polar angle of light or view.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PolarReport {
    /// The angle from the zenith, in degrees, rounded to a tenth.
    pub polar_deg: f64,
    /// Photographs.
    pub pairs: usize,
    /// Their error.
    #[serde(flatten)]
    pub error: Residual,
}

/// The error of a set of photographs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PairsReport {
    /// Photographs.
    pub pairs: usize,
    /// The error of values clamped to 0..1, on the texels measured.
    #[serde(flatten)]
    pub error: Residual,
    /// The mean absolute difference of CIE L*, a* and b*, for photographs in colour.
    pub mae_lab: Option<f64>,
}

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
    /// Texels compared, on a regular grid; all when equal to `texels`.
    pub texels_measured: usize,
    /// The error over all texels of the photographs that took part, from the singular values: a difference of large
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
}

/// The inputs of the error measurement.
pub(super) struct Measurement<'a> {
    pub pairs: &'a [(String, Directions)],
    pub grid: &'a Grid,
    pub levels: &'a SampleLevels,
    pub held_out: &'a HeldOut,
}

/// ErrorSums over the samples of a photograph.
#[derive(Debug, Clone, Copy, Default)]
struct ErrorSums {
    squares: f64,
    lab: f64,
    pairs: usize,
}

impl ErrorSums {
    fn plus(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            lab: self.lab + other.lab,
            pairs: self.pairs + other.pairs,
        }
    }
}

impl Measurement<'_> {
    /// Compares a field with the samples kept of each photograph.
    pub fn report(
        &self,
        field: &ReflectanceField,
        kept: &[Raster],
        singular_values: &[f64],
        rmse: f64,
        job: &Job,
    ) -> Result<LearnedReport> {
        let coefficients = self.grid.planes(field.coefficients());
        let sums_of = |i: usize| job.proceed().map(|()| self.sums(i, field, &coefficients, &kept[i]));
        let sums = (0..kept.len()).into_par_iter().map(sums_of).collect::<Result<Vec<ErrorSums>>>()?;
        let channels = field.layout().channels();
        let samples = (self.grid.texels() * channels) as f64;
        let of = |out: bool| {
            let chosen = sums.iter().enumerate().filter(|(i, _)| self.held_out.is_out(*i) == out);
            self.pairs_report(chosen.fold(ErrorSums::default(), |sum, (_, one)| sum.plus(*one)), channels)
        };
        let worst = (0..sums.len()).fold(0, |w, i| if sums[i].squares > sums[w].squares { i } else { w });
        let values = (self.held_out.kept() * channels * self.grid.full_texels()) as f64;
        Ok(LearnedReport {
            space: self.levels.space(),
            functions: singular_values.len(),
            singular_values: singular_values.iter().map(|s| s / values.sqrt()).collect(),
            texels: self.grid.full_texels(),
            texels_measured: self.grid.texels(),
            error: residual(rmse * rmse * samples, samples as usize),
            fitted: of(false),
            held_out: (self.held_out.kept() < kept.len()).then(|| of(true)),
            by_view: self.by_polar_angle(&sums, samples as usize, |pair| pair.view),
            by_light: self.by_polar_angle(&sums, samples as usize, |pair| pair.light),
            worst: self.pairs[worst].0.clone(),
        })
    }

    fn pairs_report(&self, sums: ErrorSums, channels: usize) -> PairsReport {
        let texels = sums.pairs * self.grid.texels();
        PairsReport {
            pairs: sums.pairs,
            error: residual(sums.squares, texels * channels),
            mae_lab: (channels == 3).then(|| sums.lab / (3 * texels) as f64),
        }
    }

    fn by_polar_angle(
        &self,
        sums: &[ErrorSums],
        samples: usize,
        direction: impl Fn(&Directions) -> Direction,
    ) -> Vec<PolarReport> {
        let mut groups: BTreeMap<i64, ErrorSums> = BTreeMap::new();
        for ((_, pair), sums) in self.pairs.iter().zip(sums) {
            let degrees = direction(pair).polar_rad().to_degrees();
            let group = groups.entry((10.0 * degrees).round() as i64).or_default();
            *group = group.plus(*sums);
        }
        let report = |(tenths, sums): (i64, ErrorSums)| PolarReport {
            polar_deg: tenths as f64 / 10.0,
            pairs: sums.pairs,
            error: residual(sums.squares, samples * sums.pairs),
        };
        groups.into_iter().map(report).collect()
    }

    /// The errors of one photograph.
    fn sums(
        &self,
        i: usize,
        field: &ReflectanceField,
        coefficients: &Planes,
        photograph: &Raster,
    ) -> ErrorSums {
        let weights = field.basis().weights(self.pairs[i].1);
        let (n, channels, texels) = (field.basis().len(), field.layout().channels(), self.grid.texels());
        let mut measured = vec![0.0f32; channels * texels];
        for (channel, values) in measured.chunks_exact_mut(texels).enumerate() {
            self.levels.channel(photograph, channel, 0, values);
        }
        let predicted = |channel: usize, texel: usize| {
            let weights = field.layout().weights(channel, n, &weights).iter().enumerate();
            let value: f64 = weights.map(|(k, w)| w * f64::from(coefficients.plane(k)[texel])).sum();
            value.clamp(0.0, 1.0)
        };
        let mut sums = ErrorSums { pairs: 1, ..ErrorSums::default() };
        for texel in 0..texels {
            let value = |channel: usize| f64::from(measured[channel * texels + texel]);
            for channel in 0..channels {
                sums.squares += (predicted(channel, texel) - value(channel)).powi(2);
            }
            if channels == 3 {
                let lab = |value: &dyn Fn(usize) -> f64| {
                    lab::from_linear(std::array::from_fn(|c| {
                        f64::from(field.space().to_linear(value(c) as f32))
                    }))
                };
                let [a, b] = [lab(&|c| predicted(c, texel)), lab(&value)];
                sums.lab += a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
            }
        }
        sums
    }
}
