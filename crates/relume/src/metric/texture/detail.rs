//! Statistics of the steps between neighbours at one resolution: how strong they are, and in which direction.
//!
//! The strength is the logarithm of the gradient's magnitude over all planes. Its distribution tells smooth
//! parts from rough ones, so it shows a blur, noise in what was smooth, and missing joints, whatever the
//! contrast. The direction is that of the structure tensor (J. Bigün, G. Granlund, Optimal orientation detection
//! of linear symmetry, 1987), as the vector of its anisotropy: a quarter turn reverses it.

use super::resolutions::{Resolution, sampled};
use super::wasserstein::{self, sorted};
use crate::planes::Planes;
use crate::size::Size;

/// Steps below this fraction of the root mean square step of the reference are alike.
const NEGLIGIBLE: f64 = 0.02;
/// Steps far below this one are rounding: a constant texture has no detail and no direction.
const ROUNDING: f64 = 1e-5;
/// As many steps as [`distance`] sorts.
const MOST_STEPS: usize = 1 << 16;

/// The steps of one texture.
#[derive(Debug, Clone)]
pub(super) struct Detail {
    /// Squared magnitudes in increasing order, evenly sampled.
    squares: Vec<f32>,
    /// The root mean square magnitude.
    rms: f64,
    /// Twice the cosine and sine of the double angle, weighted by energy: anisotropy along x, and along the
    /// diagonal.
    direction: [f64; 2],
}

impl Detail {
    /// Measures at most `most` steps.
    ///
    /// # Panics
    /// When a side is a single texel.
    pub(super) fn new(level: &Resolution, most: usize) -> Self {
        let Resolution { ref planes, step } = *level;
        let size = planes.size();
        let inner = Size::new(size.width - step, size.height - step);
        let (mut across, mut along, mut sum) = (0.0f64, 0.0f64, 0.0f64);
        let mut squares = Vec::with_capacity(inner.texels().min(most));
        for i in sampled(inner, most) {
            let at = size.index(i % inner.width, i / inner.width);
            let mut square = 0.0;
            for plane in planes.iter() {
                let x = f64::from(plane[at + step]) - f64::from(plane[at]);
                let y = f64::from(plane[at + step * size.width]) - f64::from(plane[at]);
                across += x * x - y * y;
                along += 2.0 * x * y;
                square += x * x + y * y;
            }
            sum += square;
            squares.push(square as f32);
        }
        let count = squares.len() as f64;
        let direction = [across, along].map(|part| part / (sum + count * ROUNDING.powi(2)));
        let rms = (sum / count).sqrt();
        Self { squares: sorted(squares), rms, direction }
    }

    /// The distance of the distributions of the logarithms of the magnitudes, and that of the directions.
    pub(super) fn distances(&self, other: &Self) -> [f64; 2] {
        let turned = (self.direction[0] - other.direction[0]).hypot(self.direction[1] - other.direction[1]);
        [self.strength(other, (NEGLIGIBLE * self.rms).max(ROUNDING)), turned]
    }

    /// The distance of the distributions of the logarithms of the magnitudes; magnitudes below `least` are alike.
    fn strength(&self, other: &Self, least: f64) -> f64 {
        let logs = |of: &Self| -> Vec<f32> {
            let log = |&square: &f32| (f64::from(square).sqrt() + least).max(f64::MIN_POSITIVE).ln() as f32;
            of.squares.iter().map(log).collect()
        };
        wasserstein::distance(&logs(self), &logs(other))
    }
}

/// How far the distributions of the steps between neighbours are apart, as the mean difference of the logarithms of their
/// magnitudes over all planes (the first Wasserstein distance), where steps below `least` are alike.
///
/// # Panics
/// When a side is a single texel.
pub fn distance(reference: &Planes, other: &Planes, least: f64) -> f64 {
    let [reference, other] =
        [reference, other].map(|planes| Detail::new(&Resolution::finest(planes), MOST_STEPS));
    reference.strength(&other, least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;

    fn planes(f: impl Fn(usize, usize) -> f32) -> Planes {
        Planes::from_vec(Size::new(40, 40), 1, (0..1600).map(|i| f(i % 40, i / 40)).collect()).unwrap()
    }

    #[test]
    fn twice_the_contrast_is_the_logarithm_of_two_and_a_quarter_turn_reverses() {
        let wave = |x: usize, y: usize| (x as f32 * 0.8).sin() + 0.1 * (y as f32 * 1.3).sin();
        let detail = |planes: &Planes| Detail::new(&Resolution::finest(planes), 10_000);
        let a = detail(&planes(wave));
        assert_eq!(a.distances(&a), [0.0; 2]);
        let [strength, turn] = a.distances(&detail(&planes(|x, y| 2.0 * wave(x, y))));
        assert!((strength - 2.0f64.ln()).abs() < 0.1 && turn < 1e-6, "{strength} {turn}");
        let [strength, turn] = a.distances(&detail(&planes(|x, y| wave(y, x))));
        assert!(strength < 0.02 && turn > 1.5, "{strength} {turn}");
    }

    #[test]
    fn steps_that_nobody_sees_are_alike() {
        let faint = |at: usize| 0.001 * (at % 3) as f32;
        let edges = |x: usize| if (x / 10).is_multiple_of(2) { 0.2 } else { 0.8 };
        let (clean, noisy) = (planes(|x, _| edges(x)), planes(|x, y| edges(x) + faint(x + y)));
        assert!(distance(&clean, &noisy, 0.0001) > 1.0);
        assert!(distance(&clean, &noisy, 0.03) < 0.1);
        assert!(distance(&clean, &planes(|_, _| 0.5), 0.03) > 0.2, "the edges are missing");
    }

    #[test]
    fn constant_planes_have_no_steps() {
        let flat = Detail::new(&Resolution::finest(&planes(|_, _| 0.5)), 100);
        assert_eq!(flat.distances(&flat), [0.0; 2]);
        assert!(
            flat.distances(&Detail::new(&Resolution::finest(&planes(|x, _| x as f32)), 100))[0].is_finite()
        );
    }
}
