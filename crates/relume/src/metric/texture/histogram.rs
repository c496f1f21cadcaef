//! Distance of the distributions of values, plane by plane: the mean over planes of the Wasserstein-1
//! distance, in standard deviations of the reference (the root of the mean variance of its planes).
//!
//! It detects other colours, brightness and contrast than those of the reference, and by definition ignores
//! their positions: a scrambled texture has distance 0.

use super::wasserstein::{self, sorted};
use crate::planes::Planes;

/// The distance; see the module.
///
/// # Panics
/// When the numbers of planes differ.
pub fn distance(reference: &Planes, other: &Planes) -> f64 {
    assert_eq!(reference.count(), other.count(), "as many planes");
    let planes = reference.iter().zip(other.iter());
    let ways = planes.map(|(a, b)| wasserstein::distance(&sorted(a.to_vec()), &sorted(b.to_vec())));
    ways.sum::<f64>() / reference.count().max(1) as f64 / super::deviation(reference)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    #[test]
    fn places_do_not_count_and_brightness_does() {
        let values: Vec<f32> = (0..48).map(|i| (i * 29 % 48) as f32 / 48.0).collect();
        let a = Planes::from_vec(Size::new(8, 6), 1, values.clone()).unwrap();
        let turned = Planes::from_vec(Size::new(6, 8), 1, values.iter().rev().copied().collect()).unwrap();
        assert_eq!(distance(&a, &turned), 0.0);
        let brighter =
            Planes::from_vec(Size::new(8, 6), 1, values.iter().map(|v| v + 0.1).collect()).unwrap();
        assert!((distance(&a, &brighter) - 0.1 / super::super::deviation(&a)).abs() < 1e-6);
        assert!((distance(&a, &a.repeated(2, 3))).abs() < 1e-9);
    }
}
