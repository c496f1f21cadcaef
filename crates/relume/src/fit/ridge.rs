//! Ridge: smooth functions where many of them meet few lights.
//!
//! Least squares with many functions for the lights follows noise, most of all between the lights and beyond the
//! outermost. The ridge adds w N c' D c to the squared error of N photographs, where c' D c is the roughness of the
//! function ([`Basis::roughness`](crate::field::Basis::roughness)): (Hoerl, Kennard, "Ridge Regression: Biased Estimation
//! for Nonorthogonal Problems", Technometrics 12, 1970; with a matrix D, after Tikhonov). The weight w is given, or is
//! the one of a series by which each photograph is best predicted from all others (PRESS; Allen, "The Relationship
//! between Variable Selection and Data Augmentation and a Method for Prediction", Technometrics 16, 1974): with the hat
//! matrix H of a weight, the error of photograph i left out is that of the fit divided by 1 - H_ii, and its sum of squares
//! over texels needs the inner products of the photographs only.

use super::design::Design;
use super::levels::SampleLevels;
use super::products::BAND;
use crate::error::{Error, Result};
use crate::numeric::Matrix;
use crate::parallel;
use crate::planes::Planes;
use crate::raster::Raster;

/// Texels of each photograph from which the weight is chosen.
pub(super) const SAMPLE_TEXELS: usize = 4096;

/// The weights to choose from: half decades. Larger ones leave the smoothest functions alone.
const WEIGHTS: [f64; 13] = [1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0];

/// Beyond this weight nothing is left but the smoothest function, and sums lose their digits.
const LARGEST_WEIGHT: f64 = 1e6;

/// The penalty on rough functions.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ridge {
    /// None: least squares.
    #[default]
    None,
    /// The weight by which each photograph is best predicted from the others.
    LeaveOneOut,
    /// A weight, positive.
    Weight(f64),
}

impl Ridge {
    /// Checks the weight.
    ///
    /// # Errors
    /// A weight that is not positive, or so large that it leaves no function.
    pub fn validate(self) -> Result<()> {
        match self {
            Self::Weight(weight) if !(weight > 0.0 && weight <= LARGEST_WEIGHT) => Err(Error::usage(
                format!("the ridge needs a weight above 0 and up to {LARGEST_WEIGHT}, found {weight}"),
            )),
            _ => Ok(()),
        }
    }
}

/// The weight of a series, or none, with the least squared error of photographs predicted from the others.
pub(super) fn best_weight(
    design: &Design,
    roughness: &Matrix,
    photographs: &[Raster],
    levels: &SampleLevels,
) -> Result<Option<f64>> {
    let products = inner_products(photographs, levels);
    let mut best = (predicted_error(design, &products), None);
    for weight in WEIGHTS {
        let error = predicted_error(&design.with_ridge(roughness, weight)?, &products);
        if error < best.0 {
            best = (error, Some(weight));
        }
    }
    Ok(best.1)
}

/// sum_i of the squared errors of photograph i predicted from the others, from the inner products of the photographs.
fn predicted_error(design: &Design, products: &Matrix) -> f64 {
    let n = products.rows();
    let values = Matrix::from_fn(n, design.functions(), |i, k| design.values(i)[k]);
    let shares = Matrix::from_fn(design.functions(), n, |k, i| design.share(k, i));
    let hat = values.times(&shares);
    let rest = Matrix::from_fn(n, n, |i, j| f64::from(u8::from(i == j)) - hat[(i, j)]);
    let part = rest.times(products);
    let error = |i: usize| {
        let square: f64 = part.row(i).iter().zip(rest.row(i)).map(|(a, b)| a * b).sum();
        square / (1.0 - hat[(i, i)]).max(1e-9).powi(2)
    };
    (0..n).map(error).sum()
}

/// The inner products of all pairs of photographs over their samples.
fn inner_products(photographs: &[Raster], levels: &SampleLevels) -> Matrix {
    let row = |photograph: &Raster| {
        let texels = photograph.size().texels();
        let mut row = vec![0.0f32; texels * photograph.channels()];
        for (channel, out) in row.chunks_exact_mut(texels).enumerate() {
            levels.channel(photograph, channel, 0, out);
        }
        row
    };
    let rows: Vec<Vec<f32>> = parallel::map(photographs.iter(), row);
    let dot = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(x, y)| f64::from(*x) * f64::from(*y)).sum::<f64>();
    let half: Vec<Vec<f64>> =
        parallel::map(rows.iter().enumerate(), |(i, a)| rows[..=i].iter().map(|b| dot(a, b)).collect());
    Matrix::from_fn(rows.len(), rows.len(), |i, j| half[i.max(j)][i.min(j)])
}

/// Turns the coefficients of least squares into those of the ridge, in place: (A'A + R)^-1 A'A c.
pub(super) fn apply(sums: &mut Planes, channels: usize, least_squares: &Design, ridge: &Design) {
    let n = ridge.functions();
    let values = Matrix::from_fn(ridge.lights(), n, |i, k| least_squares.values(i)[k]);
    let shares = Matrix::from_fn(n, ridge.lights(), |k, i| ridge.share(k, i));
    let turn = shares.times(&values);
    parallel::for_each(sums.bands_mut(BAND), |mut band| {
        for planes in band.chunks_mut(n).take(channels) {
            let before: Vec<Vec<f32>> = planes.iter().map(|plane| plane.to_vec()).collect();
            for (j, plane) in planes.iter_mut().enumerate() {
                plane.fill(0.0);
                for (factor, source) in turn.row(j).iter().zip(&before) {
                    plane.iter_mut().zip(source).for_each(|(sum, value)| *sum += *factor as f32 * value);
                }
            }
        }
    });
}
