//! Errors in decibels.

/// The peak signal-to-noise ratio, 10 log10(1 / MSE), of a mean square error of values with a peak of 1. An
/// error of zero gives infinity.
pub fn psnr_db(mean_square_error: f64) -> f64 {
    -10.0 * mean_square_error.log10()
}
