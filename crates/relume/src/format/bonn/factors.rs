//! The factors of a texture as functions of direction and planes of coefficients: what a learned basis is made of.

use super::color_model::BtfColorModel;
use super::factor::FactorMatrix;
use super::full::{Dfmf, Fmf, RowsOf};
use super::{BonnBtf, BtfBody};
use crate::direction::Directions;
use crate::error::{Error, Result};
use crate::job::Job;
use crate::memory;
use crate::planes::Planes;
use crate::size::Size;

/// What distinguishes the channels of factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FactorShape {
    /// Functions of the pair and the channel, and a plane of coefficients for each: the value of channel c for pair i
    /// is the sum of `functions[(i * channels + c) * count + k]` times plane k.
    Functions,
    /// Functions of the pair, and a plane of coefficients for each channel and function: the value is the sum of
    /// `functions[i * count + k]` times plane `c * count + k`.
    Coefficients,
}

/// A texture as a sum of `count` products of functions of direction and planes.
#[derive(Debug, Clone, PartialEq)]
pub struct BtfFactors {
    /// What the functions depend on.
    pub shape: FactorShape,
    /// The values of the functions; see [`FactorShape`] for the order.
    pub functions: Vec<f32>,
    /// The coefficients.
    pub coefficients: Planes,
    /// The singular value of each function as the file says it; no image depends on it.
    pub singular: Vec<f32>,
}

impl BtfFactors {
    /// The number of functions.
    pub fn count(&self) -> usize {
        self.singular.len()
    }

    /// The factors of the same texture without the cosine between light and normal in its values.
    ///
    /// # Errors
    /// A light within 1e-6 of the horizon, where nothing is left to divide; functions that are not those of `pairs`.
    pub fn without_cosine(mut self, pairs: &[Directions]) -> Result<Self> {
        let values = self.functions.len().checked_div(pairs.len()).unwrap_or(0);
        if values * pairs.len() != self.functions.len() || values == 0 {
            return Err(Error::invalid(format!(
                "{} values of functions are not those of {} pairs of light and view",
                self.functions.len(),
                pairs.len()
            )));
        }
        for (i, (pair, values)) in pairs.iter().zip(self.functions.chunks_exact_mut(values)).enumerate() {
            let cosine = pair.light.z();
            if cosine < 1e-6 {
                return Err(Error::unsupported(format!(
                    "the light of pair {i} lies on the horizon: its image cannot be divided by the cosine"
                )));
            }
            values.iter_mut().for_each(|value| *value = (f64::from(*value) / cosine) as f32);
        }
        Ok(self)
    }
}

impl BonnBtf {
    /// The factors, exactly and without an image, where values are linear in them.
    ///
    /// # Errors
    /// A file of images or of factors for each view, or one whose values are logarithms or products; limits.
    pub fn linear_factors(&self, job: &Job) -> Result<BtfFactors> {
        job.proceed()?;
        match &self.body {
            BtfBody::Fmf(fmf) if !fmf.logarithms => fmf.factors(self, job),
            BtfBody::Dfmf(dfmf) if dfmf.model.affine().is_some() => dfmf.joined(self, job),
            BtfBody::Dfmf(dfmf) => Err(not_linear(&format!("the colour model {}", dfmf.model.number()))),
            BtfBody::Fmf(_) => Err(not_linear("logarithms")),
            BtfBody::PerView(_) => Err(not_linear("factors for each view")),
            BtfBody::Images(_) => Err(not_linear("images")),
        }
    }

    /// The factors as stored: of all channels, or of each channel of the colour model. Of an FMF file whose values
    /// are logarithms, they are those of the logarithms.
    ///
    /// # Errors
    /// A file of images, or of factors for each view; limits.
    pub fn stored_factors(&self, job: &Job) -> Result<Vec<BtfFactors>> {
        job.proceed()?;
        match &self.body {
            BtfBody::Fmf(fmf) => Ok(vec![fmf.factors(self, job)?]),
            BtfBody::Dfmf(dfmf) => {
                dfmf.channels.iter().map(|channel| of_channel(channel, self.size(), job)).collect()
            }
            BtfBody::PerView(_) => Err(not_linear("factors for each view")),
            BtfBody::Images(_) => Err(not_linear("images")),
        }
    }
}

fn not_linear(what: &str) -> Error {
    Error::unsupported(format!(
        "the BTF file stores {what}: its values are not sums of functions times coefficients; factor its images \
         instead"
    ))
}

impl Fmf {
    fn factors(&self, btf: &BonnBtf, job: &Job) -> Result<BtfFactors> {
        let (size, channels, count) = (btf.size(), btf.channels().len(), self.matrix.components);
        let singular = self.matrix.singular.clone();
        match self.rows {
            RowsOf::Pairs => Ok(BtfFactors {
                shape: FactorShape::Functions,
                functions: copied(&self.matrix.u, job)?,
                coefficients: transposed(&self.matrix.sxv, 1, count, size, job)?,
                singular,
            }),
            RowsOf::Texels => Ok(BtfFactors {
                shape: FactorShape::Coefficients,
                functions: copied(&self.matrix.sxv, job)?,
                coefficients: transposed(&self.matrix.u, channels, count, size, job)?,
                singular,
            }),
        }
    }
}

/// The factors of one channel.
fn of_channel((matrix, rows): &(FactorMatrix, RowsOf), size: Size, job: &Job) -> Result<BtfFactors> {
    let (functions, texels) = by_pairs(matrix, *rows);
    Ok(BtfFactors {
        shape: FactorShape::Coefficients,
        functions: copied(functions, job)?,
        coefficients: transposed(texels, 1, matrix.components, size, job)?,
        singular: matrix.singular.clone(),
    })
}

/// The factors that belong to pairs, and those of texels.
fn by_pairs(matrix: &FactorMatrix, rows: RowsOf) -> (&[f32], &[f32]) {
    match rows {
        RowsOf::Pairs => (&matrix.u, &matrix.sxv),
        RowsOf::Texels => (&matrix.sxv, &matrix.u),
    }
}

impl Dfmf {
    /// All channels in one sum: the functions of a channel of the colour model have a value for each channel of RGB,
    /// and the mean is a function of its own.
    fn joined(&self, btf: &BonnBtf, job: &Job) -> Result<BtfFactors> {
        let (size, channels, pairs) = (btf.size(), self.channels.len(), btf.pairs().len());
        let mean = self.model.affine().map_or([0.0; 3], |(_, mean)| mean);
        let components: usize = self.channels.iter().map(|(matrix, _)| matrix.components).sum();
        let count = components + usize::from(mean != [0.0; 3]);
        job.check_bytes("the functions of the BTF", 4 * (pairs * channels * count) as u64)?;
        let mut functions = memory::zeros("the functions of the BTF", pairs * channels * count)?;
        let mut coefficients = Planes::zeros_within(job, "the coefficients of the BTF", size, count)?;
        let (mut singular, mut first) = (Vec::with_capacity(count), 0);
        for (from, (matrix, rows)) in self.channels.iter().enumerate() {
            let (values, texels) = by_pairs(matrix, *rows);
            let width = matrix.components;
            for (row, out) in functions.chunks_exact_mut(count).enumerate() {
                let factor = weight(self.model, row % channels, from);
                let values = &values[row / channels * width..][..width];
                out[first..first + width].iter_mut().zip(values).for_each(|(out, v)| *out = factor * v);
            }
            (0..width).for_each(|k| fill(coefficients.plane_mut(first + k), texels, width, k));
            singular.extend(&matrix.singular);
            first += width;
        }
        if count > components {
            functions
                .chunks_exact_mut(count)
                .enumerate()
                .for_each(|(row, out)| out[first] = mean[row % channels]);
            coefficients.plane_mut(first).fill(1.0);
            singular.push(0.0);
        }
        Ok(BtfFactors { shape: FactorShape::Functions, functions, coefficients, singular })
    }
}

/// The share of a channel of the model in a channel of the image.
fn weight(model: BtfColorModel, channel: usize, from: usize) -> f32 {
    match model.affine() {
        Some((matrix, _)) if model != BtfColorModel::Rgb => matrix[channel][from],
        _ => f32::from(u8::from(channel == from)),
    }
}

fn copied(values: &[f32], job: &Job) -> Result<Vec<f32>> {
    const WHAT: &str = "the functions of the BTF";
    job.check_bytes(WHAT, 4 * values.len() as u64)?;
    let mut copy = memory::with_capacity(WHAT, values.len())?;
    copy.extend_from_slice(values);
    Ok(copy)
}

/// Planes of rows of components: row `c + channels * texel` belongs to plane `c * count + k`.
fn transposed(rows: &[f32], channels: usize, count: usize, size: Size, job: &Job) -> Result<Planes> {
    let mut planes = Planes::zeros_within(job, "the coefficients of the BTF", size, channels * count)?;
    for (number, plane) in planes.iter_mut().enumerate() {
        let (c, k) = (number / count, number % count);
        fill(plane, &rows[c * count..], channels * count, k);
    }
    Ok(planes)
}

/// Fills a plane by number `k` of rows that are `stride` apart.
fn fill(plane: &mut [f32], rows: &[f32], stride: usize, k: usize) {
    plane.iter_mut().enumerate().for_each(|(texel, value)| *value = rows[texel * stride + k]);
}
