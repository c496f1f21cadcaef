//! The values of each texel under all of some pairs: photographs are read one batch at a time, and texels are fitted in
//! bands, so that memory is bounded whatever their number.

use super::encoded::{TexelReflectance, fit_texel};
use crate::error::Result;
use crate::fit::levels::SampleLevels;
use crate::fit::stream::{BATCH, PhotographStream};
use crate::job::Job;
use crate::numeric::levenberg_marquardt::LevenbergMarquardt;
use crate::parallel;
use crate::planes::Planes;

/// The most memory of the values of a band.
const BAND_BYTES: u64 = 1 << 27;
/// Texels fitted by one task.
const PART: usize = 64;

/// The photographs that the texels are fitted to.
pub(super) struct ChosenPhotographs<'a> {
    pub stream: &'a PhotographStream<'a>,
    pub levels: &'a SampleLevels,
    /// Their numbers.
    pub chosen: &'a [usize],
}

impl ChosenPhotographs<'_> {
    /// The texels of a band, of which all values are in memory.
    fn band_texels(&self, job: &Job) -> usize {
        let bytes = BAND_BYTES.min(job.free_bytes() / 2);
        let texels = bytes / (4 * self.values() as u64).max(1);
        usize::try_from(texels).unwrap_or(usize::MAX).clamp(1, self.stream.size().texels())
    }

    /// The values of a texel.
    fn values(&self) -> usize {
        self.chosen.len() * self.stream.channels()
    }

    /// Fits the texels band after band: `fit` turns the encoded values of a texel, all channels of a photograph
    /// adjacent, into its numbers.
    pub fn fit_bands(
        &self,
        planes: &mut Planes,
        fit: &(dyn Fn(&[f32]) -> Vec<f32> + Sync),
        job: &Job,
    ) -> Result<()> {
        let (texels, band) = (self.stream.size().texels(), self.band_texels(job));
        let _held = job.hold("the values of a band of texels", 4 * (band * self.values()) as u64)?;
        job.start("fitting texels", texels as u64);
        let mut values = Vec::new();
        for first in (0..texels).step_by(band) {
            let count = band.min(texels - first);
            self.gather(first, count, &mut values, job)?;
            self.fit_band(planes, first, &values, fit, job)?;
        }
        Ok(())
    }

    fn fit_band(
        &self,
        planes: &mut Planes,
        first: usize,
        values: &[f32],
        fit: &(dyn Fn(&[f32]) -> Vec<f32> + Sync),
        job: &Job,
    ) -> Result<()> {
        let (numbers, length) = (planes.count(), self.values());
        let of_part = |part: &[f32]| {
            let mut found = vec![0.0; part.len() / length * numbers];
            let texels = part.chunks_exact(length).zip(found.chunks_exact_mut(numbers));
            texels.for_each(|(values, out)| out.copy_from_slice(&fit(values)));
            job.advance((part.len() / length) as u64).map(|()| found)
        };
        let parts: Vec<Vec<f32>> = parallel::try_map(values.chunks(PART * length), of_part)?;
        for (i, texel) in parts.iter().flat_map(|part| part.chunks_exact(numbers)).enumerate() {
            texel.iter().enumerate().for_each(|(k, number)| planes.plane_mut(k)[first + i] = *number);
        }
        Ok(())
    }

    /// The values of `count` texels from `first` on.
    fn gather(&self, first: usize, count: usize, values: &mut Vec<f32>, job: &Job) -> Result<()> {
        let (channels, length) = (self.stream.channels(), self.values());
        values.clear();
        values.resize(count * length, 0.0);
        for (batch, chosen) in self.chosen.chunks(BATCH).enumerate() {
            let read = |i: &usize| job.proceed().and_then(|()| self.stream.read(*i));
            let read = parallel::try_map(chosen.iter(), read)?;
            let of_channels = read.iter().flat_map(|photograph| (0..channels).map(move |c| (photograph, c)));
            let rows = parallel::map(of_channels, |(photograph, channel)| {
                let mut row = vec![0.0; count];
                self.levels.channel(photograph, channel, first, &mut row);
                row
            });
            parallel::for_each(values.chunks_exact_mut(length).enumerate(), |(texel, values)| {
                let own = &mut values[batch * BATCH * channels..][..rows.len()];
                own.iter_mut().zip(&rows).for_each(|(value, row)| *value = row[texel]);
            });
        }
        Ok(())
    }
}

/// Steps of the fit of the mean of all texels.
const MEAN_STEPS: usize = 60;

/// Fits a model to each texel from parameters that fit the mean of all, with the colours of the texel.
pub(super) struct FromMean<'a, M> {
    model: &'a M,
    parameters: Vec<f64>,
    brightness: Vec<f64>,
    steps: usize,
}

impl<'a, M: TexelReflectance> FromMean<'a, M> {
    /// With so many steps for a texel; `mean` are the mean encoded values of all texels.
    pub fn new(model: &'a M, mean: &[f32], steps: usize) -> Self {
        let brightness = brightness(mean, model.channels());
        let parameters = best_of(model, &model.starts(mean, &brightness), mean, MEAN_STEPS);
        Self { model, parameters, brightness, steps }
    }

    /// The parameters of the mean.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Parameters from which the fit of a texel starts.
    pub fn start(&self, observed: &[f32]) -> Vec<f64> {
        let own = brightness(observed, self.model.channels());
        let ratios: Vec<f64> = own.iter().zip(&self.brightness).map(|(a, b)| a / b.max(1e-6)).collect();
        self.model.start_of_texel(&self.parameters, &ratios, observed)
    }

    /// The numbers of a texel.
    pub fn fit(&self, observed: &[f32]) -> Vec<f32> {
        let mut parameters = self.start(observed);
        let mut minimiser = LevenbergMarquardt::new(parameters.len());
        fit_texel(self.model, &mut minimiser, &mut parameters, observed, self.steps);
        self.model.numbers(&parameters, observed)
    }
}

/// The parameters of the best of several starts.
fn best_of(model: &impl TexelReflectance, starts: &[Vec<f64>], observed: &[f32], steps: usize) -> Vec<f64> {
    let mut best = (f64::INFINITY, Vec::new());
    for start in starts {
        let mut parameters = start.clone();
        let mut minimiser = LevenbergMarquardt::new(parameters.len());
        let reached = fit_texel(model, &mut minimiser, &mut parameters, observed, steps);
        if reached < best.0 || best.1.is_empty() {
            best = (reached, parameters);
        }
    }
    best.1
}

/// The mean linear value in each channel of encoded ones.
pub(super) fn brightness(observed: &[f32], channels: usize) -> Vec<f64> {
    let pairs = (observed.len() / channels).max(1) as f64;
    let of = |c: usize| {
        // Nearly the decoding of sRGB, which is enough for a start.
        observed.iter().skip(c).step_by(channels).map(|v| f64::from(v.max(0.0)).powf(2.2)).sum::<f64>()
            / pairs
    };
    (0..channels).map(of).collect()
}
