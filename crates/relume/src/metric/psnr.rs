//! Root mean square error and peak signal-to-noise ratio.
//!
//! Both compare sample by sample, all planes together, and ignore the space: compare encoded values with
//! encoded values. Sums are in `f64`, in storage order.

use crate::error::{Error, Result};
use crate::numeric::decibel::psnr_db;
use crate::planes::Planes;

/// The root of the mean squared difference of all samples.
///
/// # Errors
/// When sizes or numbers of planes differ.
pub fn rmse(a: &Planes, b: &Planes) -> Result<f64> {
    mean_square(a, b).map(f64::sqrt)
}

/// The peak signal-to-noise ratio in dB, for a peak of 1: 20 log10(1 / RMSE). Infinite for equal
/// planes.
///
/// # Errors
/// When sizes or numbers of planes differ.
pub fn psnr(a: &Planes, b: &Planes) -> Result<f64> {
    mean_square(a, b).map(psnr_db)
}

fn mean_square(a: &Planes, b: &Planes) -> Result<f64> {
    if (a.size(), a.count()) != (b.size(), b.count()) {
        return Err(Error::usage(format!(
            "{} planes of {} cannot be compared with {} planes of {}: both must have the same size",
            a.count(),
            a.size(),
            b.count(),
            b.size()
        )));
    }
    let squares = a.as_slice().iter().zip(b.as_slice()).map(|(x, y)| (f64::from(*x) - f64::from(*y)).powi(2));
    Ok(squares.sum::<f64>() / a.as_slice().len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    fn planes(values: &[f32]) -> Planes {
        Planes::from_vec(Size::new(values.len(), 1), 1, values.to_vec()).unwrap()
    }

    #[test]
    fn known_differences_have_known_errors() {
        let (a, b) = (planes(&[0.0, 0.5, 1.0, 0.25]), planes(&[0.1, 0.4, 0.9, 0.35]));
        assert!((rmse(&a, &b).unwrap() - 0.1).abs() < 1e-7);
        assert!((psnr(&a, &b).unwrap() - 20.0).abs() < 1e-5);
        assert_eq!(psnr(&a, &a).unwrap(), f64::INFINITY);
        let one_off = planes(&[0.0, 0.5, 1.0, 0.75]);
        assert!((rmse(&a, &one_off).unwrap() - 0.25).abs() < 1e-12);
    }

    #[test]
    fn planes_of_other_sizes_are_refused() {
        assert!(rmse(&planes(&[0.0; 4]), &planes(&[0.0; 3])).is_err());
        assert!(psnr(&planes(&[0.0; 4]), &Planes::zeros(Size::new(2, 2), 1)).is_err());
    }
}
