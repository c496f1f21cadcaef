//! A lattice to a fraction of a texel, by least squares over the peaks at its points.
//!
//! The position of a peak is known to about a tenth of a texel; far lattice points divide that error by their
//! multiple. The fit begins with the nearest points and goes outwards, so that the prediction of each step is
//! accurate enough to find the next peaks.

use super::peaks::{self, Peak};
use crate::numeric::autocorrelation::Autocorrelation;
use crate::numeric::lattice::{Lattice, length};

/// Farthest multiples used.
const FARTHEST: i32 = 12;
/// A peak belongs to a lattice point when its distance is at most this fraction of the shorter vector.
const NEAR: f64 = 0.2;

/// The lattice fitted to the peaks near its points.
pub fn lattice(correlation: &Autocorrelation, first: Lattice) -> Lattice {
    let mut lattice = first;
    for span in 1..=FARTHEST {
        let shortest = lattice.basis().map(length).into_iter().fold(f64::INFINITY, f64::min);
        let points = Lattice::half(span).filter_map(|ij| {
            let place = lattice.point(ij);
            // At least two texels, the width of a peak, whatever the period.
            let peak = peaks::near(correlation, place, (NEAR * shortest).clamp(1.0, 4.0))?;
            Some((ij, peak))
        });
        match fit(points) {
            Some(fitted) => lattice = fitted,
            None => break,
        }
    }
    lattice
}

/// The vectors a, b with the least sum of w |p - i a - j b|^2; the weights are the peaks' heights.
fn fit(points: impl Iterator<Item = ([f64; 2], Peak)>) -> Option<Lattice> {
    let (mut ii, mut ij, mut jj, mut ip, mut jp) = (0.0, 0.0, 0.0, [0.0; 2], [0.0; 2]);
    for ([i, j], peak) in points {
        let w = peak.height;
        ii += w * i * i;
        ij += w * i * j;
        jj += w * j * j;
        for c in 0..2 {
            ip[c] += w * i * peak.shift[c];
            jp[c] += w * j * peak.shift[c];
        }
    }
    let whole = ii * jj - ij * ij;
    if whole <= 1e-9 * ii * jj {
        return None;
    }
    let a = [0, 1].map(|c| (jj * ip[c] - ij * jp[c]) / whole);
    let b = [0, 1].map(|c| (ii * jp[c] - ij * ip[c]) / whole);
    Lattice::new(a, b)
}
