//! Distributions of values along the principal axes of the reference, at several resolutions.
//!
//! Along the axes even faint changes of hue are apart from the changes of brightness that hide them in single
//! channels. At coarse resolutions the values are the brightness and colour of whole regions: their distribution
//! tells an even texture from one with patches of light and dark.

use super::resolutions::sampled;
use super::wasserstein::{self, sorted};
use crate::numeric::Matrix;
use crate::planes::Planes;

/// The values of one texture at one resolution along each axis, in increasing order.
#[derive(Debug, Clone)]
pub(super) struct Colours(Vec<Vec<f32>>);

impl Colours {
    /// At most `most` values along each of the `axes`, which are rows.
    pub(super) fn new(planes: &Planes, axes: &Matrix, most: usize) -> Self {
        let along = |axis: &[f64]| {
            let value = |texel: usize| {
                let weighted = planes.iter().zip(axis).map(|(plane, &weight)| weight as f32 * plane[texel]);
                weighted.sum()
            };
            sorted(sampled(planes.size(), most).map(value).collect())
        };
        Self((0..planes.count()).map(|k| along(axes.row(k))).collect())
    }

    /// The distance of the distributions along each axis.
    pub(super) fn distances<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = f64> + 'a {
        self.0.iter().zip(&other.0).map(|(a, b)| wasserstein::distance(a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::principal;
    use crate::size::Size;

    #[test]
    fn a_change_of_hue_is_along_the_faint_axis_alone() {
        let grey = |i: usize| (i * 37 % 100) as f32 / 100.0;
        let colours = |tint: f32| {
            let values = (0..200).map(|i| grey(i % 100) + if i < 100 { tint } else { -tint });
            Planes::from_vec(Size::new(10, 10), 2, values.collect()).unwrap()
        };
        let (a, b) = (colours(0.0), colours(0.05));
        let axes = principal::axes(&a).1;
        let found: Vec<f64> =
            Colours::new(&a, &axes, 1000).distances(&Colours::new(&b, &axes, 1000)).collect();
        assert!(found[0] < 1e-5 && (found[1] - 0.05 * 2.0f64.sqrt()).abs() < 1e-5, "{found:?}");
    }
}
