//! Edges of a picture: places where its steepness is largest along the gradient (J. Canny, A computational approach to
//! edge detection, IEEE PAMI 8(6), 1986), to a fraction of a pixel.

use crate::size::Size;

/// A point of an edge in pixels, and the unit vector across the edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EdgePoint {
    pub x: f64,
    pub y: f64,
    pub across_x: f64,
    pub across_y: f64,
}

/// The blur before differences are taken, in pixels (standard deviation).
const BLUR: f64 = 1.5;

/// The steepest edges of a plane of values: this part of all.
pub(super) fn edges(values: &[f64], size: Size, kept: f64) -> Vec<EdgePoint> {
    let smooth = blurred(values, size);
    let gradient = Gradient::of(&smooth, size);
    let mut found = Vec::new();
    for y in 3..size.height.saturating_sub(3) {
        for x in 3..size.width.saturating_sub(3) {
            found.extend(gradient.edge(x, y));
        }
    }
    let mut steepness: Vec<f64> = found.iter().map(|(steepness, _)| *steepness).collect();
    if steepness.is_empty() {
        return Vec::new();
    }
    let place = ((1.0 - kept) * (steepness.len() - 1) as f64) as usize;
    let least = *steepness.select_nth_unstable_by(place, f64::total_cmp).1;
    found.into_iter().filter(|(steepness, _)| *steepness >= least).map(|(_, edge)| edge).collect()
}

/// Differences along x and y.
struct Gradient {
    size: Size,
    x: Vec<f64>,
    y: Vec<f64>,
    length: Vec<f64>,
}

impl Gradient {
    fn of(values: &[f64], size: Size) -> Self {
        let difference = |step: usize, length: usize| -> Vec<f64> {
            let at = |texel: usize| {
                let position = texel / step % length;
                let (low, high) = (position.saturating_sub(1), (position + 1).min(length - 1));
                let value = |p: usize| values[texel - position * step + p * step];
                (value(high) - value(low)) / (high - low).max(1) as f64
            };
            (0..values.len()).map(at).collect()
        };
        let (x, y) = (difference(1, size.width), difference(size.width, size.height));
        let length = x.iter().zip(&y).map(|(x, y)| x.hypot(*y)).collect();
        Self { size, x, y, length }
    }

    /// The edge in a pixel, with its steepness, if the steepness is largest there along the gradient.
    fn edge(&self, x: usize, y: usize) -> Option<(f64, EdgePoint)> {
        let texel = self.size.index(x, y);
        let here = self.length[texel];
        if here <= 0.0 {
            return None;
        }
        let (across_x, across_y) = (self.x[texel] / here, self.y[texel] / here);
        let (x, y) = (x as f64, y as f64);
        let ahead = self.steepness(x + across_x, y + across_y);
        let behind = self.steepness(x - across_x, y - across_y);
        if !(here >= ahead && here > behind) {
            return None;
        }
        // The top of the parabola through the three.
        let offset = 0.5 * (ahead - behind) / (2.0 * here - ahead - behind);
        let place = |at: f64, across: f64| at + 0.5 + across * offset;
        Some((here, EdgePoint { x: place(x, across_x), y: place(y, across_y), across_x, across_y }))
    }

    /// The bilinear interpolation of the steepness, inside the picture.
    fn steepness(&self, x: f64, y: f64) -> f64 {
        let (column, row) = (x.floor() as usize, y.floor() as usize);
        let (s, t) = (x - column as f64, y - row as f64);
        let at = |dx: usize, dy: usize| self.length[self.size.index(column + dx, row + dy)];
        (1.0 - t) * ((1.0 - s) * at(0, 0) + s * at(1, 0)) + t * ((1.0 - s) * at(0, 1) + s * at(1, 1))
    }
}

/// A Gaussian blur, with the values at the borders repeated beyond them.
fn blurred(values: &[f64], size: Size) -> Vec<f64> {
    let reach = (3.0 * BLUR).ceil() as isize;
    let weight = |d: isize| (-0.5 * (d as f64 / BLUR).powi(2)).exp();
    let sum: f64 = (-reach..=reach).map(weight).sum();
    let weights: Vec<f64> = (-reach..=reach).map(|d| weight(d) / sum).collect();
    let along = |values: &[f64], step: usize, length: usize| -> Vec<f64> {
        let at = |texel: usize| {
            let position = texel / step % length;
            let start = texel - position * step;
            let value = |d: isize| {
                let place = (position as isize + d).clamp(0, length as isize - 1) as usize;
                values[start + place * step]
            };
            (-reach..=reach).zip(&weights).map(|(d, w)| w * value(d)).sum()
        };
        (0..values.len()).map(at).collect()
    };
    along(&along(values, 1, size.width), size.width, size.height)
}
