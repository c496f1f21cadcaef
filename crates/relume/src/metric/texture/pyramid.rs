//! Halving a texture: P. Burt, E. Adelson, The Laplacian pyramid as a compact image code, 1983, with the
//! kernel (1, 4, 6, 4, 1) / 16. At borders the weights that fall outside are dropped and the others
//! renormalised, so that a constant stays constant.

use crate::parallel;
use crate::planes::Planes;
use crate::size::Size;

const KERNEL: [f32; 5] = [1.0, 4.0, 6.0, 4.0, 1.0];

/// The texture at half its resolution; odd sides are rounded up.
pub fn halved(planes: &Planes) -> Planes {
    smoothed(planes, 1, 2)
}

/// Every `stride`-th texel along x and y of the texture under the kernel with gaps: its weights are `step` texels apart.
pub(super) fn smoothed(planes: &Planes, step: usize, stride: usize) -> Planes {
    let from = planes.size();
    let to = Size::new(from.width.div_ceil(stride), from.height.div_ceil(stride));
    let mut out = Planes::zeros(to, planes.count());
    parallel::for_each(out.iter_mut().zip(planes.iter()), |(out, plane)| {
        let rows: Vec<f32> = plane
            .chunks_exact(from.width)
            .flat_map(|row| (0..to.width).map(|x| smooth(from.width, stride * x, step, |i| row[i])))
            .collect();
        for (i, value) in out.iter_mut().enumerate() {
            let (x, y) = (i % to.width, i / to.width);
            *value = smooth(from.height, stride * y, step, |y| rows[y * to.width + x]);
        }
    });
    out
}

/// The weighted mean about place `at` of a line.
fn smooth(length: usize, at: usize, step: usize, value: impl Fn(usize) -> f32) -> f32 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for (k, weight) in KERNEL.into_iter().enumerate() {
        let place = (at + k * step).checked_sub(2 * step).filter(|place| *place < length);
        if let Some(place) = place {
            sum += weight * value(place);
            weights += weight;
        }
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_stay_and_ramps_keep_their_slope() {
        for (width, height) in [(1, 1), (2, 7), (9, 4), (13, 13)] {
            let flat = Planes::from_vec(Size::new(width, height), 2, vec![0.7; 2 * width * height]).unwrap();
            let half = halved(&flat);
            assert_eq!(half.size(), Size::new(width.div_ceil(2), height.div_ceil(2)));
            assert!(half.as_slice().iter().all(|v| (v - 0.7).abs() < 1e-6));
        }
        let size = Size::new(20, 20);
        let ramp =
            Planes::from_vec(size, 1, (0..400).map(|i| (i % 20) as f32 + 3.0 * (i / 20) as f32).collect())
                .unwrap();
        let half = halved(&ramp);
        assert!((half.at(0, 4, 5) - (8.0 + 30.0)).abs() < 1e-5);
    }
}
