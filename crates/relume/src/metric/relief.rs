//! The error of an estimated shape against the true one.

use crate::error::{Error, Result};
use crate::planes::Planes;

/// Errors of heights, in the unit of the heights; the mean of both is removed first, because no method based
/// on shading determines it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct HeightError {
    /// Root of the mean squared difference.
    pub rmse: f64,
    /// Standard deviation of the true heights: the error of a level surface.
    pub true_deviation: f64,
    /// The correlation of both, 1 where they agree up to a factor.
    pub correlation: f64,
}

/// Angles between estimated and true normals, in degrees.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct AngleError {
    /// The mean.
    pub mean_deg: f64,
    /// The error that half of the texels stay below.
    pub median_deg: f64,
    /// The error that 95 % of the texels stay below.
    pub p95_deg: f64,
}

/// Compares one plane of heights with the truth.
///
/// # Errors
/// When sizes or numbers of planes differ.
pub fn height_error(found: &Planes, truth: &Planes) -> Result<HeightError> {
    check(found, truth, 1)?;
    let centred = |plane: &[f32]| -> Vec<f64> {
        let mean = plane.iter().map(|&v| f64::from(v)).sum::<f64>() / plane.len() as f64;
        plane.iter().map(|&v| f64::from(v) - mean).collect()
    };
    let (found, truth) = (centred(found.plane(0)), centred(truth.plane(0)));
    let mean = |terms: &mut dyn Iterator<Item = f64>| terms.sum::<f64>() / truth.len() as f64;
    let square_found = mean(&mut found.iter().map(|v| v * v));
    let square_truth = mean(&mut truth.iter().map(|v| v * v));
    let product = mean(&mut found.iter().zip(&truth).map(|(a, b)| a * b));
    let below = (square_found * square_truth).sqrt();
    Ok(HeightError {
        rmse: mean(&mut found.iter().zip(&truth).map(|(a, b)| (a - b).powi(2))).sqrt(),
        true_deviation: square_truth.sqrt(),
        correlation: if below > 0.0 { product / below } else { 0.0 },
    })
}

/// Compares three planes of normals of any length with the truth.
///
/// # Errors
/// When sizes or numbers of planes differ.
pub fn angle_error(found: &Planes, truth: &Planes) -> Result<AngleError> {
    check(found, truth, 3)?;
    let mut angles: Vec<f64> = (0..truth.size().texels())
        .map(|texel| {
            let [a, b] = [found, truth].map(|n| [0, 1, 2].map(|k| f64::from(n.plane(k)[texel])));
            let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            // Accurate for small angles, unlike an arc cosine.
            dot(cross, cross).sqrt().atan2(dot(a, b)).to_degrees()
        })
        .collect();
    angles.sort_by(f64::total_cmp);
    let at = |share: f64| angles[((angles.len() - 1) as f64 * share).round() as usize];
    let mean_deg = angles.iter().sum::<f64>() / angles.len() as f64;
    Ok(AngleError { mean_deg, median_deg: at(0.5), p95_deg: at(0.95) })
}

fn check(found: &Planes, truth: &Planes, count: usize) -> Result<()> {
    if found.size() == truth.size() && found.count() == count && truth.count() == count {
        return Ok(());
    }
    Err(Error::invalid(format!(
        "{} planes of {} cannot be compared with {} planes of {}: expected {count} of one size each",
        found.count(),
        found.size(),
        truth.count(),
        truth.size()
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    fn planes(count: usize, data: &[f32]) -> Planes {
        Planes::from_vec(Size::new(data.len() / count, 1), count, data.to_vec()).unwrap()
    }

    #[test]
    fn heights_are_compared_without_their_mean() {
        let truth = planes(1, &[0.0, 2.0, 4.0, 2.0]);
        let same = height_error(&planes(1, &[10.0, 12.0, 14.0, 12.0]), &truth).unwrap();
        assert_eq!((same.rmse, same.correlation), (0.0, 1.0));
        assert!((same.true_deviation - 2f64.sqrt()).abs() < 1e-12);
        let half = height_error(&planes(1, &[0.0, 1.0, 2.0, 1.0]), &truth).unwrap();
        assert!((half.rmse - 0.5f64.sqrt()).abs() < 1e-12 && (half.correlation - 1.0).abs() < 1e-12);
        assert!(height_error(&planes(1, &[0.0; 3]), &truth).is_err());
    }

    #[test]
    fn angles_are_those_between_the_normals() {
        let truth = planes(3, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
        // Straight up, 90 and 45 degrees off.
        let found = planes(3, &[0.0, 2.0, 0.0, 0.0, 0.0, -3.0, 1.0, 0.0, 3.0]);
        let error = angle_error(&found, &truth).unwrap();
        assert!((error.mean_deg - 45.0).abs() < 1e-9 && (error.median_deg - 45.0).abs() < 1e-9);
        assert!((error.p95_deg - 90.0).abs() < 1e-9);
        assert!(angle_error(&truth, &planes(1, &[0.0; 3])).is_err());
    }
}
