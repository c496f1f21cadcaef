//! The size of features: the distance over which a texture stays similar to itself.
//!
//! Twice the shift at which the autocorrelation, averaged over directions, falls to one half. For round
//! stones of one size it is 0.8 of their diameter, for squares of random shades 0.9 of their side, for smooth
//! stripes a little under half their period.

use std::f64::consts::PI;

use crate::numeric::autocorrelation::Autocorrelation;

/// Directions over half a turn; the other half is a mirror image.
const DIRECTIONS: u32 = 32;

/// The size in texels; `None` where the correlation stays above one half up to half the smaller side.
pub fn size(correlation: &Autocorrelation) -> Option<f64> {
    let size = correlation.size();
    let reach = size.width.min(size.height) / 2;
    let ring = |radius: f64| {
        let angle = |k: u32| PI * f64::from(k) / f64::from(DIRECTIONS);
        let around =
            (0..DIRECTIONS).map(|k| correlation.sample([radius * angle(k).cos(), radius * angle(k).sin()]));
        around.sum::<f64>() / f64::from(DIRECTIONS)
    };
    let mut before = 1.0;
    for radius in (1..reach).map(|r| r as f64) {
        let here = ring(radius);
        if here <= 0.5 {
            return Some(2.0 * (radius - 1.0 + (before - 0.5) / (before - here)));
        }
        before = here;
    }
    None
}
