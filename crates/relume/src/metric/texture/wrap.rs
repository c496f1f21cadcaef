//! Whether a texture tiles: the step across its borders compared with the steps inside.
//!
//! The root mean square step between the last column and the first, divided by that between neighbouring
//! columns inside; likewise for rows. At 1 the border is as smooth as the inside. The ratio measures the
//! visibility of the seam on average; the rank, the share of the inner lines with a smaller step, shows
//! whether such a step is unusual for the texture: mortar and yarns have large steps of their own. It detects
//! jumps of value, but not kinks or features cut in two without a jump.

use serde::Serialize;

use super::steps::{NeighbourSteps, ratio};
use crate::parallel;
use crate::planes::Planes;

/// Columns whose steps are added up together: a row of them is some lines of the cache.
const COLUMNS_TOGETHER: usize = 256;

/// The step across one pair of borders.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Wrap {
    /// The root mean square step across the border divided by that inside; 1 is seamless.
    pub ratio: f64,
    /// The share of inner lines with a smaller step than the border, 0 to 1.
    pub rank: f64,
}

/// The steps from the right border to the left one, and from the bottom to the top. Sides of one
/// texel have no inside and are seamless.
pub fn wrap(planes: &Planes) -> [Wrap; 2] {
    [judge(&steps_across(planes)), judge(&steps_down(planes))]
}

/// The steps from each column to the next, from the last one to the first. Rows are read along themselves, some columns at
/// a time: down a column every value comes from another part of the memory.
fn steps_across(planes: &Planes) -> Vec<NeighbourSteps> {
    let size = planes.size();
    let mut columns = vec![NeighbourSteps::default(); size.width];
    parallel::for_each(columns.chunks_mut(COLUMNS_TOGETHER).enumerate(), |(part, columns)| {
        for y in 0..size.height {
            for (x, steps) in (part * COLUMNS_TOGETHER..).zip(columns.iter_mut()) {
                steps.add(planes, size.index(x, y), size.index((x + 1) % size.width, y));
            }
        }
    });
    columns
}

/// The steps from each row to the next, from the last one to the first.
fn steps_down(planes: &Planes) -> Vec<NeighbourSteps> {
    let size = planes.size();
    let row = |y: usize| {
        let mut steps = NeighbourSteps::default();
        let below = (y + 1) % size.height;
        (0..size.width).for_each(|x| steps.add(planes, size.index(x, y), size.index(x, below)));
        steps
    };
    parallel::map(0..size.height, row)
}

/// `lines` has the step from each line to the next; that of the last one is the wrap.
fn judge(lines: &[NeighbourSteps]) -> Wrap {
    let (across, inner) = lines.split_last().expect("a texture has lines");
    let across = across.rms();
    let mut inside = NeighbourSteps::default();
    inner.iter().for_each(|steps| inside.merge(*steps));
    if inner.is_empty() {
        return Wrap { ratio: 1.0, rank: 0.0 };
    }
    let smaller = inner.iter().filter(|steps| steps.rms() < across).count();
    Wrap { ratio: ratio(across, inside.rms()), rank: smaller as f64 / inner.len() as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::size::Size;
    use std::f32::consts::TAU;

    #[test]
    fn whole_periods_wrap_and_broken_ones_do_not() {
        let size = Size::new(40, 30);
        let wave =
            |i: usize| ((i % 40) as f32 * TAU / 20.0).sin() + ((i / 40) as f32 * TAU * 1.5 / 30.0).sin();
        let planes = Planes::from_vec(size, 1, (0..size.texels()).map(wave).collect()).unwrap();
        let [x, y] = wrap(&planes);
        assert!((x.ratio - 1.0).abs() < 0.5 && x.rank < 1.0, "{x:?}");
        // Down, 29 steps of a wave and a half end far from where they began: 29 / 30 of a full turn
        // and a half is a jump of the step itself only when the number of waves is whole.
        let slope = Planes::from_vec(size, 1, (0..size.texels()).map(|i| (i / 40) as f32).collect()).unwrap();
        let [across, down] = wrap(&slope);
        assert_eq!((across.ratio, across.rank), (1.0, 0.0));
        assert_eq!((down.ratio, down.rank), (29.0, 1.0));
        assert!(y.ratio.is_finite());
    }

    #[test]
    fn steps_across_are_those_of_each_column() {
        let size = Size::new(COLUMNS_TOGETHER + 37, 19);
        let value = |i: usize| ((i * i) % 101) as f32 / 17.0;
        let planes = Planes::from_vec(size, 2, (0..2 * size.texels()).map(value).collect()).unwrap();
        for (x, found) in steps_across(&planes).into_iter().enumerate() {
            let mut steps = NeighbourSteps::default();
            let next = (x + 1) % size.width;
            (0..size.height).for_each(|y| steps.add(&planes, size.index(x, y), size.index(next, y)));
            assert_eq!((found.rms().to_bits(), found.count()), (steps.rms().to_bits(), steps.count()));
        }
    }

    #[test]
    fn flat_and_thin_textures_are_seamless() {
        for (width, height) in [(1, 1), (1, 9), (5, 4)] {
            let flat = Planes::zeros(Size::new(width, height), 2);
            assert_eq!(wrap(&flat).map(|w| w.ratio), [1.0, 1.0]);
        }
    }
}
