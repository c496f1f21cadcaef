//! Levels of detail: each half the one before, by the mean over the area of a texel.

use super::KtxContent;
use crate::planes::Planes;
use crate::size::Size;
use crate::space::{linear_from_srgb, srgb_from_linear};

/// Shares of the texels along a line that one of the next level covers.
struct CoveredTexels {
    first: usize,
    shares: Vec<f32>,
}

/// The next level: sides are halved and rounded down, to one at least.
pub(super) fn halved(planes: &Planes, content: KtxContent) -> Planes {
    let from = planes.size();
    let size = Size::new((from.width / 2).max(1), (from.height / 2).max(1));
    let (across, down) = (covered(from.width, size.width), covered(from.height, size.height));
    let mut made = Planes::zeros(size, planes.count());
    for (k, (to, plane)) in made.iter_mut().zip(planes.iter()).enumerate() {
        let is_encoded = content == KtxContent::Color && k < 3;
        for (row, y) in to.chunks_exact_mut(size.width).zip(&down) {
            for (out, x) in row.iter_mut().zip(&across) {
                let mean = mean(plane, from.width, x, y, is_encoded);
                *out = if is_encoded { srgb_from_linear(mean) } else { mean };
            }
        }
    }
    if content == KtxContent::Normals {
        normalise(&mut made);
    }
    made
}

/// The texels that each of `to` covers of a line of `from`, with shares whose sum is 1.
fn covered(from: usize, to: usize) -> Vec<CoveredTexels> {
    let width = from as f64 / to as f64;
    let one = |i: usize| {
        let (begin, end) = (i as f64 * width, (i + 1) as f64 * width);
        let first = begin as usize;
        let last = (end.ceil() as usize).min(from);
        let share = |t: usize| (((t + 1) as f64).min(end) - (t as f64).max(begin)) / width;
        CoveredTexels { first, shares: (first..last).map(|t| share(t) as f32).collect() }
    };
    (0..to).map(one).collect()
}

fn mean(plane: &[f32], width: usize, x: &CoveredTexels, y: &CoveredTexels, is_encoded: bool) -> f32 {
    let value = |v: f32| if is_encoded { linear_from_srgb(v) } else { v };
    let row = |(j, share): (usize, &f32)| {
        let row = &plane[(y.first + j) * width + x.first..][..x.shares.len()];
        share * row.iter().zip(&x.shares).map(|(v, share)| share * value(*v)).sum::<f32>()
    };
    y.shares.iter().enumerate().map(row).sum()
}

/// Makes packed vectors unit vectors; one without a direction points up.
fn normalise(planes: &mut Planes) {
    for texel in 0..planes.size().texels() {
        let vector: [f32; 3] = std::array::from_fn(|k| 2.0 * planes.plane(k)[texel] - 1.0);
        let length = vector.iter().map(|v| v * v).sum::<f32>().sqrt();
        let unit = if length > 1e-6 { vector.map(|v| v / length) } else { [0.0, 0.0, 1.0] };
        (0..3).for_each(|k| planes.plane_mut(k)[texel] = 0.5 * unit[k] + 0.5);
    }
}
