//! The errors of a texture of light and view on the photographs of its pairs: of those that were fitted, of those left out,
//! and by the polar angles of view and light.

use std::collections::BTreeMap;

use serde::Serialize;

use super::held_out::HeldOut;
use super::levels::SampleLevels;
use super::report::{Residual, residual};
use super::sample::Grid;
use crate::direction::{Direction, Directions};
use crate::error::Result;
use crate::job::Job;
use crate::lab;
use crate::parallel;
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
    /// The same error of encoded values.
    pub encoded: Residual,
}

/// The error of a set of photographs.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PairsReport {
    /// Photographs.
    pub pairs: usize,
    /// The error of values clamped to 0..1, those of photographs too, on the texels measured.
    #[serde(flatten)]
    pub error: Residual,
    /// The same error of encoded values, as `relume compare` measures it.
    pub encoded: Residual,
    /// The mean absolute difference of CIE L*, a* and b*, for photographs in colour.
    pub mae_lab: Option<f64>,
}

/// The errors of all photographs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MeasuredErrors {
    pub fitted: PairsReport,
    pub held_out: Option<PairsReport>,
    pub by_view: Vec<PolarReport>,
    pub by_light: Vec<PolarReport>,
    /// The name of the photograph with the largest error.
    pub worst: String,
}

/// Writes the values of the texels of the grid for pair `i`, channel after channel, in the space of the levels.
pub(super) type Predict<'a> = dyn Fn(usize, &mut [f64]) -> Result<()> + Sync + 'a;

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
    encoded: f64,
    lab: f64,
    pairs: usize,
}

impl ErrorSums {
    fn plus(self, other: Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            encoded: self.encoded + other.encoded,
            lab: self.lab + other.lab,
            pairs: self.pairs + other.pairs,
        }
    }
}

impl Measurement<'_> {
    /// Compares what is predicted with the samples kept of each photograph.
    pub fn errors(&self, kept: &[Raster], predict: &Predict<'_>, job: &Job) -> Result<MeasuredErrors> {
        let channels = kept.first().map_or(0, Raster::channels);
        let sums_of = |i: usize| job.proceed().and_then(|()| self.sums(i, &kept[i], predict));
        let sums = parallel::try_map(0..kept.len(), sums_of)?;
        let samples = self.grid.texels() * channels;
        let of = |out: bool| {
            let chosen = sums.iter().enumerate().filter(|(i, _)| self.held_out.is_out(*i) == out);
            self.pairs_report(chosen.fold(ErrorSums::default(), |sum, (_, one)| sum.plus(*one)), channels)
        };
        let worst = (0..sums.len()).fold(0, |w, i| if sums[i].squares > sums[w].squares { i } else { w });
        Ok(MeasuredErrors {
            fitted: of(false),
            held_out: (self.held_out.kept() < kept.len()).then(|| of(true)),
            by_view: self.by_polar_angle(&sums, samples, |pair| pair.view),
            by_light: self.by_polar_angle(&sums, samples, |pair| pair.light),
            worst: self.pairs[worst].0.clone(),
        })
    }

    fn pairs_report(&self, sums: ErrorSums, channels: usize) -> PairsReport {
        let texels = sums.pairs * self.grid.texels();
        PairsReport {
            pairs: sums.pairs,
            error: residual(sums.squares, texels * channels),
            encoded: residual(sums.encoded, texels * channels),
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
            encoded: residual(sums.encoded, samples * sums.pairs),
        };
        groups.into_iter().map(report).collect()
    }

    /// The errors of one photograph.
    fn sums(&self, i: usize, photograph: &Raster, predict: &Predict<'_>) -> Result<ErrorSums> {
        let (channels, texels) = (photograph.channels(), self.grid.texels());
        let mut measured = vec![0.0f32; channels * texels];
        for (channel, values) in measured.chunks_exact_mut(texels).enumerate() {
            self.levels.channel(photograph, channel, 0, values);
            values.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
        }
        let mut predicted = vec![0.0f64; channels * texels];
        predict(i, &mut predicted)?;
        predicted.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
        let mut sums = ErrorSums { pairs: 1, ..ErrorSums::default() };
        let space = self.levels.space();
        let encoded = |value: f64| match space {
            Space::Srgb => value,
            Space::Linear => f64::from(Space::Srgb.from_linear(value as f32)),
        };
        for texel in 0..texels {
            for channel in 0..channels {
                let k = channel * texels + texel;
                sums.squares += (predicted[k] - f64::from(measured[k])).powi(2);
                sums.encoded += (encoded(predicted[k]) - encoded(f64::from(measured[k]))).powi(2);
            }
            if channels == 3 {
                let lab = |value: &dyn Fn(usize) -> f64| {
                    lab::from_linear(std::array::from_fn(|c| {
                        f64::from(self.levels.space().to_linear(value(c * texels + texel) as f32))
                    }))
                };
                let [a, b] = [lab(&|k| predicted[k]), lab(&|k| f64::from(measured[k]))];
                sums.lab += a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f64>();
            }
        }
        Ok(sums)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Samples;
    use crate::size::Size;

    /// A fault: highlights of floating-point photographs counted as errors beyond the white to which predictions are clamped.
    #[test]
    fn values_brighter_than_white_are_white_on_both_sides() {
        let pairs = [("a".to_owned(), Directions::from(Direction::ZENITH))];
        let held_out = HeldOut::new(&[pairs[0].1], None).unwrap();
        let grid = Grid::new(Size::new(2, 1), 9);
        let levels = SampleLevels::new(Space::Linear);
        let measured = Measurement { pairs: &pairs, grid: &grid, levels: &levels, held_out: &held_out };
        let photograph = Raster::new(Size::new(2, 1), 1, Samples::F32(vec![2.5, 0.25])).unwrap();
        let predict = |_: usize, out: &mut [f64]| {
            out.copy_from_slice(&[1.7, 0.75]);
            Ok(())
        };
        let errors = measured.errors(&[photograph], &predict, &Job::default()).unwrap();
        assert!((errors.fitted.error.rmse - (0.5f64 * 0.25).sqrt()).abs() < 1e-9, "{errors:?}");
    }
}
