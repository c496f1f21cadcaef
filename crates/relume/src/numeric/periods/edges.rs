//! The strength of edges: where elements differ in shade, their joints repeat and their values do not. It is
//! smoothed, so that the two edges of a joint are one line.

use crate::error::Result;
use crate::job::Job;
use crate::planes::Planes;
use crate::size::Size;

/// The radius of the smoothing as a fraction of the smaller side: with two repeats a joint is narrower than twice
/// this.
const RADIUS: f64 = 1.0 / 48.0;

/// The length of the gradient over all planes, by central differences; at the border by one-sided ones.
///
/// # Errors
/// When the plane exceeds the limits.
pub fn strength(planes: &Planes, job: &Job) -> Result<Planes> {
    let size = planes.size();
    let mut out = Planes::zeros_within(job, "the edges of the texture", size, 1)?;
    let squares = out.plane_mut(0);
    for plane in planes.iter() {
        for (t, square) in squares.iter_mut().enumerate() {
            let (x, y) = (t % size.width, t / size.width);
            let at = |x: usize, y: usize| plane[size.index(x.min(size.width - 1), y.min(size.height - 1))];
            let across = at(x + 1, y) - at(x.saturating_sub(1), y);
            let down = at(x, y + 1) - at(x, y.saturating_sub(1));
            *square += across * across + down * down;
        }
    }
    squares.iter_mut().for_each(|square| *square = square.sqrt());
    let radius = ((RADIUS * size.width.min(size.height) as f64).round() as usize).max(1);
    // Each pass turns the picture, so that two smooth both axes.
    let turned = smoothed(squares, size, radius);
    let smooth = smoothed(&turned, Size::new(size.height, size.width), radius);
    squares.copy_from_slice(&smooth);
    Ok(out)
}

/// Means over `radius` texels to either side along the rows, as the columns of the result.
fn smoothed(values: &[f32], size: Size, radius: usize) -> Vec<f32> {
    let mut out = vec![0.0; values.len()];
    for (y, row) in values.chunks_exact(size.width).enumerate() {
        let mut sums = vec![0.0; size.width + 1];
        row.iter().enumerate().for_each(|(x, v)| sums[x + 1] = sums[x] + f64::from(*v));
        for x in 0..size.width {
            let (left, right) = (x.saturating_sub(radius), (x + radius + 1).min(size.width));
            out[x * size.height + y] = ((sums[right] - sums[left]) / (right - left) as f64) as f32;
        }
    }
    out
}
