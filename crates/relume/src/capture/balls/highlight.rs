//! The place of the highlight in a mirror ball, to a fraction of a pixel.
//!
//! The highlight is the brightest spot of the disk after a small blur. Its place is the centroid of the pixels that
//! belong to it: those connected to the peak that are brighter than [`SHARE`] of the way from the ball's median to
//! the peak, weighted by how much. Streaks of polished metal and reflections of reflections are dimmer. Where these are
//! few, they are saturated and say little of parts of a pixel: the dimmer ones around them count as well.

use std::fmt;

use serde::Serialize;

use super::{HORIZON, MirrorBall};
use crate::planes::Planes;
use crate::size::Size;

/// A highlight in a ball, in pixels from the upper left corner of the photograph.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Highlight {
    /// The column.
    pub x: f64,
    /// The row.
    pub y: f64,
    /// The number of pixels that it covers.
    pub pixels: usize,
}

/// Why a ball shows no usable highlight.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum NoHighlight {
    /// Nothing in it is much brighter than the rest.
    Dark,
    /// The bright part is too large for the mirror image of a lamp.
    Wide,
    /// It is so near the outline that the lamp is below the surface.
    Below,
}

impl fmt::Display for NoHighlight {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Dark => "has no highlight",
            Self::Wide => "has no highlight but a wide bright area",
            Self::Below => "shows its lamp below the surface",
        })
    }
}

/// The pixels of a highlight are those above this share of the way from the median to the peak.
const SHARE: f32 = 0.8;
/// The share where a highlight has fewer pixels than [`FEW`].
const SHARE_OF_FEW: f32 = 0.15;
const FEW: usize = 25;
/// The part of the disk that is searched, in radii: its rim mirrors what is beside and behind the ball.
const SEARCHED: f64 = 0.97;
/// A peak below this luminance, or this multiple of the median, is none.
const LEAST_PEAK: f32 = 0.01;
const LEAST_CONTRAST: f32 = 4.0;
/// The largest part of the disk that a lamp covers.
const WIDEST: f64 = 0.06;

/// The highlight of a ball in the luminance of the square of pixels at `corner`.
pub(super) fn find(
    luminance: &Planes,
    corner: (usize, usize),
    ball: &MirrorBall,
) -> Result<Highlight, NoHighlight> {
    let size = luminance.size();
    let inside = |texel: usize| {
        let (x, y) = middle(size, texel, corner);
        (x - ball.x).hypot(y - ball.y) < SEARCHED * ball.radius
    };
    let disk: Vec<bool> = (0..size.texels()).map(inside).collect();
    let masked = luminance.plane(0).iter().zip(&disk).map(|(v, inside)| if *inside { *v } else { 0.0 });
    let values: Vec<f32> = masked.collect();
    let (peak, top) = peak(&values, size, (ball.radius / 60.0).round() as usize);
    let median = median(&values, &disk);
    if !(top > LEAST_PEAK && top > LEAST_CONTRAST * median) {
        return Err(NoHighlight::Dark);
    }
    let spot_above = |share: f32| {
        let level = median + share * (top - median);
        (connected(&values, size, peak, level), level)
    };
    let (mut spot, mut level) = spot_above(SHARE);
    if spot.len() < FEW {
        (spot, level) = spot_above(SHARE_OF_FEW);
    }
    let pixels = disk.iter().filter(|inside| **inside).count();
    if spot.len() as f64 > (WIDEST * pixels as f64).max(4.0) {
        return Err(NoHighlight::Wide);
    }
    let (mut sum, mut sum_x, mut sum_y) = (0.0, 0.0, 0.0);
    for &texel in &spot {
        let ((x, y), weight) = (middle(size, texel, corner), f64::from(values[texel] - level + 1e-4));
        (sum, sum_x, sum_y) = (sum + weight, sum_x + weight * x, sum_y + weight * y);
    }
    let found = Highlight { x: sum_x / sum, y: sum_y / sum, pixels: spot.len() };
    match (found.x - ball.x).hypot(found.y - ball.y) < HORIZON * ball.radius {
        true => Ok(found),
        false => Err(NoHighlight::Below),
    }
}

/// The middle of a pixel of the square, in the photograph.
fn middle(size: Size, texel: usize, (x, y): (usize, usize)) -> (f64, f64) {
    ((x + texel % size.width) as f64 + 0.5, (y + texel / size.width) as f64 + 0.5)
}

/// The brightest place after a blur by a square of `2 * reach + 1` pixels, and the brightest value in that square.
fn peak(values: &[f32], size: Size, reach: usize) -> (usize, f32) {
    let along = |values: &[f32], step: usize, length: usize| -> Vec<f32> {
        let at = |texel: usize| {
            let position = texel / step % length;
            let (low, high) = (position.saturating_sub(reach), (position + reach).min(length - 1));
            (low..=high).map(|p| values[texel - position * step + p * step]).sum()
        };
        (0..values.len()).map(at).collect()
    };
    let blurred = along(&along(values, 1, size.width), size.width, size.height);
    let brightest = (0..blurred.len()).max_by(|a, b| blurred[*a].total_cmp(&blurred[*b]).then(b.cmp(a)));
    let (x, y) = (brightest.unwrap_or(0) % size.width, brightest.unwrap_or(0) / size.width);
    let columns = x.saturating_sub(reach)..=(x + reach).min(size.width - 1);
    let rows = y.saturating_sub(reach)..=(y + reach).min(size.height - 1);
    let square = rows.flat_map(|y| columns.clone().map(move |x| size.index(x, y)));
    let top = square.max_by(|a, b| values[*a].total_cmp(&values[*b]).then(b.cmp(a))).unwrap_or(0);
    (top, values[top])
}

fn median(values: &[f32], disk: &[bool]) -> f32 {
    let inside = values.iter().zip(disk).filter(|(_, inside)| **inside);
    let mut inside: Vec<f32> = inside.map(|(value, _)| *value).collect();
    if inside.is_empty() {
        return 0.0;
    }
    let middle = inside.len() / 2;
    *inside.select_nth_unstable_by(middle, f32::total_cmp).1
}

/// The pixels at or above a level that are connected with a place.
fn connected(values: &[f32], size: Size, from: usize, level: f32) -> Vec<usize> {
    let mut taken = vec![false; values.len()];
    let (mut spot, mut open) = (Vec::new(), vec![from]);
    taken[from] = true;
    while let Some(texel) = open.pop() {
        spot.push(texel);
        let (x, y) = (texel % size.width, texel / size.width);
        let beside = [
            (x > 0).then(|| texel - 1),
            (x + 1 < size.width).then(|| texel + 1),
            (y > 0).then(|| texel - size.width),
            (y + 1 < size.height).then(|| texel + size.width),
        ];
        for next in beside.into_iter().flatten().filter(|&next| values[next] >= level) {
            if !std::mem::replace(&mut taken[next], true) {
                open.push(next);
            }
        }
    }
    spot.sort_unstable();
    spot
}
