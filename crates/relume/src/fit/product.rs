//! Three channel functions to a luminance function and a colour, closest in the least-squares sense over the
//! photographs.
//!
//! The squared error of coefficients c' instead of the fitted c exceeds the least one by (c' - c)' A'A (c' -
//! c). So with A = Q R the coordinates R c are orthonormal for it, and the closest product l x colour is the
//! leading singular pair of the coordinates of the three channels (see [`crate::field::lrgb`]). The colour
//! needs their 3 x 3 inner products; the luminance is a combination of the channels, the same for coordinates
//! and coefficients.

use super::design::Design;
use crate::field::lrgb::leading_color;
use crate::parallel;
use crate::planes::Planes;

/// Texels per band: its rows of inner products stay in the first-level cache.
const BAND: usize = 512;

/// Replaces 3 n planes of channel functions by n planes of luminance and three of colour, in place.
pub(super) fn to_products(planes: &mut Planes, design: &Design) {
    let n = design.functions();
    let whitening: Vec<Vec<f32>> =
        (0..n).map(|j| design.whitening().row(j).iter().map(|&r| r as f32).collect()).collect();
    parallel::for_each(planes.bands_mut(BAND), |mut band| {
        let texels = band[0].len();
        let inner = inner_products(&band, &whitening);
        let mut colors = [[0.0f32; BAND]; 3];
        for t in 0..texels {
            let color = leading_color(std::array::from_fn(|p| inner[p][t]));
            (0..3).for_each(|c| colors[c][t] = color[c]);
        }
        for k in 0..n {
            for t in 0..texels {
                let [r, g, b] = [colors[0][t], colors[1][t], colors[2][t]];
                let sum = band[k][t] * r + band[n + k][t] * g + band[2 * n + k][t] * b;
                band[k][t] = sum / (r * r + g * g + b * b);
            }
        }
        for (c, color) in colors.iter().enumerate() {
            band[n + c].copy_from_slice(&color[..texels]);
        }
    });
}

/// The inner products rr, rg, rb, gg, gb, bb of the orthonormal coordinates of the channels.
fn inner_products(band: &[&mut [f32]], whitening: &[Vec<f32>]) -> [[f32; BAND]; 6] {
    let n = whitening.len();
    let mut inner = [[0.0f32; BAND]; 6];
    for (j, row) in whitening.iter().enumerate() {
        let mut coordinates = [[0.0f32; BAND]; 3];
        for (c, coordinate) in coordinates.iter_mut().enumerate() {
            for k in (j..n).filter(|k| row[*k] != 0.0) {
                coordinate.iter_mut().zip(&*band[c * n + k]).for_each(|(y, v)| *y += row[k] * v);
            }
        }
        let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        for (sum, (a, b)) in inner.iter_mut().zip(pairs) {
            let (a, b) = (&coordinates[a], &coordinates[b]);
            (0..BAND).for_each(|t| sum[t] += a[t] * b[t]);
        }
    }
    inner
}
