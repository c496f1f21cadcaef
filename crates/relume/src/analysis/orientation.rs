//! The main direction of a texture, and the distribution of its steps.
//!
//! The structure tensor is the sum over texels and planes of the outer products of gradients (M. Kass, A.
//! Witkin, Analyzing oriented patterns, 1987; J. Bigun, G. H. Granlund, 1987). Its minor axis is parallel to
//! lines and grain; coherence is the difference of its eigenvalues divided by their sum: 0 without a
//! direction, 1 for straight lines. It does not detect textures with two equal directions, such as a plain
//! weave.

use serde::Serialize;

use crate::planes::Planes;

/// The main direction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Orientation {
    /// Along lines and grain, in degrees from x (right) towards y (up), 0 to 180.
    pub angle_deg: f64,
    /// 0 without a direction, 1 for straight lines.
    pub coherence: f64,
}

/// Steps to the right and down from every texel but the last row and column.
fn steps(plane: &[f32], width: usize) -> impl Iterator<Item = (f64, f64)> + '_ {
    let rows = plane.len() / width;
    (0..rows.saturating_sub(1)).flat_map(move |y| {
        (0..width - 1).map(move |x| {
            let at = |x: usize, y: usize| f64::from(plane[y * width + x]);
            // Means over two rows and two columns: both steps refer to the same position.
            let (a, b, c, d) = (at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1));
            (0.5 * (b - a + d - c), 0.5 * (c - a + d - b))
        })
    })
}

/// The main direction of planes.
pub fn of(planes: &Planes) -> Orientation {
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for (x, y) in planes.iter().flat_map(|plane| steps(plane, planes.size().width)) {
        xx += x * x;
        xy += x * y;
        yy += y * y;
    }
    let whole = xx + yy;
    let apart = (xx - yy).hypot(2.0 * xy);
    // Rows run down, so the sign of the angle changes. Lines are perpendicular to the gradient.
    let gradient_deg = -0.5 * f64::atan2(2.0 * xy, xx - yy).to_degrees();
    let angle_deg = (gradient_deg + 90.0).rem_euclid(180.0);
    Orientation { angle_deg, coherence: if whole > 0.0 { apart / whole } else { 0.0 } }
}

/// The kurtosis of the steps along x and y, averaged over planes and directions with their variances as
/// weights. A texture with random phases (B. Galerne, Y. Gousseau, J.-M. Morel, Random phase textures, 2011)
/// has normal steps: 3.
pub fn kurtosis(planes: &Planes) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for plane in planes.iter() {
        let mut moments = [(0.0, 0.0); 2];
        let mut count = 0.0;
        for (x, y) in steps(plane, planes.size().width) {
            count += 1.0;
            for (moment, step) in moments.iter_mut().zip([x, y]) {
                moment.0 += step * step;
                moment.1 += step.powi(4);
            }
        }
        for (second, fourth) in moments.into_iter().filter(|(second, _)| *second > 0.0) {
            sum += second * (count * fourth / (second * second));
            weights += second;
        }
    }
    if weights > 0.0 { sum / weights } else { 3.0 }
}
