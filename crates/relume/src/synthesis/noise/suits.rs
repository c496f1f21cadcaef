//! Whether a texture is stochastic enough for noise: it neither repeats nor has a direction.

use serde::Serialize;

use crate::error::Result;
use crate::job::Job;
use crate::numeric::periods::{self, Pattern, Periods};
use crate::planes::Planes;

/// The measurements of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Suitability {
    /// Its periods.
    pub periods: Periods,
    /// The degree to which its gradients prefer one direction: the difference of the eigenvalues of their
    /// mean outer product divided by their sum, 0 (isotropic) to 1 (stripes). J. Bigun, G. Granlund, "Optimal
    /// Orientation Detection of Linear Symmetry", ICCV 1987.
    pub coherence: f64,
}

/// The largest coherence that counts as isotropic. Photographs of moss, gravel, grass and rust measure 0.04,
/// 0.04, 0.18 and 0.22, the built-in sponge 0.01; bark 0.48, bricks 0.65.
const MOST_COHERENCE: f64 = 0.3;

impl Suitability {
    /// The reason against noise, with advice; `None` if there is none.
    pub fn objection(&self) -> Option<&'static str> {
        if self.periods.pattern != Pattern::None {
            return Some(
                "this texture repeats, and noise would dissolve its pattern: make tiles with relume roll, or use \
                 the method quilting",
            );
        }
        if self.coherence > MOST_COHERENCE {
            return Some(
                "this texture has a direction, and noise would break its lines: use the method quilting",
            );
        }
        None
    }
}

/// Measures index planes.
///
/// # Errors
/// When the limits are exceeded.
pub fn suits(index: &Planes, job: &Job) -> Result<Suitability> {
    Ok(Suitability { periods: periods::of(index, job)?, coherence: coherence(index) })
}

/// See [`Suitability::coherence`].
fn coherence(index: &Planes) -> f64 {
    let size = index.size();
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for plane in index.iter() {
        for (x, y) in (1..size.height).flat_map(|y| (1..size.width).map(move |x| (x, y))) {
            let at = |x: usize, y: usize| f64::from(plane[size.index(x, y)]);
            // Differences across the same square of four texels.
            let dx = at(x, y) + at(x, y - 1) - at(x - 1, y) - at(x - 1, y - 1);
            let dy = at(x, y) + at(x - 1, y) - at(x, y - 1) - at(x - 1, y - 1);
            (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        }
    }
    let sum = xx + yy;
    if sum > 0.0 { (xx - yy).hypot(2.0 * xy) / sum } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};
    use crate::size::Size;

    fn planes(value: impl FnMut(usize) -> f32) -> Planes {
        let size = Size::new(64, 64);
        Planes::from_vec(size, 1, (0..size.texels()).map(value).collect()).unwrap()
    }

    #[test]
    fn noise_suits_and_patterns_and_lines_do_not() {
        let job = Job::default();
        let mut stream = Stream::new(2, Purpose::Sample, [0]);
        let noise = suits(&planes(|_| stream.unit() as f32), &job).unwrap();
        assert!(noise.objection().is_none() && noise.coherence < 0.05, "{noise:?}");
        let checks = suits(&planes(|t| ((t / 8 + t / 64 / 8) % 2) as f32), &job).unwrap();
        assert!(checks.objection().unwrap().contains("repeats"), "{checks:?}");
        let lines: Vec<f32> = (0..64).map(|_| stream.unit() as f32).collect();
        let streaks = suits(&planes(|t| lines[t % 64] + 0.2 * stream.unit() as f32), &job).unwrap();
        assert!(streaks.objection().is_some() && streaks.coherence > 0.8, "{streaks:?}");
        let flat = suits(&planes(|_| 0.5), &job).unwrap();
        assert_eq!(flat.coherence, 0.0);
    }
}
