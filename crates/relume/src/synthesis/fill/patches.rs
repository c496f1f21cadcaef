//! Filling by patches in order of priority: Criminisi, Perez, Toyama, "Region Filling and Object
//! Removal by Exemplar-Based Image Inpainting", IEEE Transactions on Image Processing 13(9), 2004.
//!
//! Of the texels at the edge of the hole the one with the largest priority C D comes next: the confidence C
//! is the mean over its patch of the confidences of the known texels (1 outside the holes), and the data term
//! D is the strength of an edge running into the hole there. The unknown texels of its patch are copied from
//! the window that fits the known ones best.
//!
//! Where we differ: the strength of an edge is the length of the component of the gradient along the front
//! over all index planes, taken within two texels; and a thousandth is added to D, so that confidence decides
//! where no edge leads in.

use super::super::pixel::canvas::PixelCanvas;
use super::super::pixel::front;
use super::super::pixel::grow::{Grower, Growth, Matcher};
use super::super::quantise::MAX_CODE;
use crate::error::Result;
use crate::job::Job;

/// The constant added to the data term.
const FLOOR: f64 = 1e-3;

/// The distance from the front, in texels, within which an edge is searched.
const REACH: isize = 2;

/// Fills all unknown texels of a canvas.
pub fn fill(
    grower: &Grower<'_>,
    canvas: &mut PixelCanvas,
    matches: &Matcher<'_>,
    job: &Job,
) -> Result<Growth> {
    let unknown: Vec<usize> = canvas.unknown().collect();
    job.start("filling patches", unknown.len() as u64);
    let mut confidence = vec![1.0; canvas.size().texels()];
    unknown.iter().for_each(|&texel| confidence[texel] = 0.0);
    let mut candidates = 0;
    let mut front = front::first(canvas);
    while let Some((texel, sure)) = most_urgent(grower, canvas, &front, &confidence) {
        let (corner, count) = grower.draw(canvas, texel, matches);
        candidates += count as u64;
        let mut filled = Vec::new();
        for tap in grower.window.taps() {
            let there = canvas.neighbour(texel, tap.dx, tap.dy);
            if let Some(there) = there.filter(|&there| !canvas.is_known(there)) {
                let (x, y) = grower.window.place(tap);
                canvas.put(there, corner.offset(x, y), grower.exemplars);
                confidence[there] = sure;
                filled.push(there);
            }
        }
        job.advance(filled.len() as u64)?;
        front.extend(front::next(canvas, &filled));
        front.retain(|&texel| !canvas.is_known(texel));
        front.sort_unstable();
        front.dedup();
    }
    Ok(grower.growth(unknown.len() as u64, candidates))
}

/// The texel of the front with the largest priority, the first among equals, and its confidence.
fn most_urgent(
    grower: &Grower<'_>,
    canvas: &PixelCanvas,
    front: &[usize],
    confidence: &[f64],
) -> Option<(usize, f64)> {
    let taps = grower.window.taps();
    let priority = |&texel: &usize| {
        let patch = taps.iter().filter_map(|tap| canvas.neighbour(texel, tap.dx, tap.dy));
        let sure = patch.map(|there| confidence[there]).sum::<f64>() / taps.len() as f64;
        (sure * (data(canvas, texel) + FLOOR), texel, sure)
    };
    let first_largest = |a: (f64, usize, f64), b: (f64, usize, f64)| if a.0 >= b.0 { a } else { b };
    let most = front.iter().map(priority).reduce(first_largest);
    most.map(|(_, texel, sure)| (texel, sure))
}

/// The largest length, over the texels nearby, of the component of the gradient along the front, as a
/// fraction of the largest code.
fn data(canvas: &PixelCanvas, texel: usize) -> f64 {
    let known = |dx, dy| match canvas.neighbour(texel, dx, dy) {
        Some(there) => f64::from(u8::from(canvas.is_known(there))),
        None => 0.0,
    };
    let (nx, ny) = (known(1, 0) - known(-1, 0), known(0, 1) - known(0, -1));
    let length = (nx * nx + ny * ny).sqrt();
    if length == 0.0 {
        return 0.0;
    }
    let along = (-ny / length, nx / length);
    let places = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| (dx, dy)));
    let nearby = places.filter_map(|(dx, dy)| canvas.neighbour(texel, dx, dy));
    let strongest = nearby.map(|there| edge(canvas, there, along)).fold(0.0, f64::max);
    strongest.sqrt() / (2.0 * f64::from(MAX_CODE))
}

/// The squared length of the component, along the front, of the central differences of a texel, that is
/// across an isophote that runs into the hole. Zero where a neighbour is not known.
fn edge(canvas: &PixelCanvas, texel: usize, along: (f64, f64)) -> f64 {
    let codes = |dx, dy| {
        let there = canvas.neighbour(texel, dx, dy).filter(|&there| canvas.is_known(there))?;
        Some(canvas.copied_codes(there))
    };
    let all = [codes(1, 0), codes(-1, 0), codes(0, 1), codes(0, -1)];
    let [Some(right), Some(left), Some(below), Some(above)] = all else { return 0.0 };
    let square = |k: usize| {
        let (dx, dy) = (f64::from(right[k] - left[k]), f64::from(below[k] - above[k]));
        (dx * along.0 + dy * along.1).powi(2)
    };
    (0..right.len()).map(square).sum()
}
