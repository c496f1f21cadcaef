//! Errors in decibels.

/// The peak signal-to-noise ratio, 10 log10(1 / MSE), of a mean square error of values with a peak of 1. An
/// error of zero gives infinity.
pub fn psnr_db(mean_square_error: f64) -> f64 {
    -10.0 * mean_square_error.log10()
}

/// The mean of ratios in decibels over pictures that have an error, and how many have none, whose ratios are infinite. Where no
/// picture has an error the mean is infinite.
pub fn mean_psnr_db(ratios: impl Iterator<Item = f64>) -> (f64, usize) {
    let (mut sum, mut count, mut exact) = (0.0, 0usize, 0);
    for ratio in ratios {
        if ratio == f64::INFINITY {
            exact += 1;
        } else {
            (sum, count) = (sum + ratio, count + 1);
        }
    }
    (if count == 0 { f64::INFINITY } else { sum / count as f64 }, exact)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_without_an_error_are_counted_and_do_not_make_the_mean_infinite() {
        assert_eq!(mean_psnr_db([30.0, f64::INFINITY, 40.0].into_iter()), (35.0, 1));
        assert_eq!(mean_psnr_db([f64::INFINITY; 2].into_iter()), (f64::INFINITY, 2));
        assert!(mean_psnr_db([f64::NAN, 1.0].into_iter()).0.is_nan());
    }
}
