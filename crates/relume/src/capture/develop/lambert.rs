//! Matt surfaces fitted to few texels: what light of known direction explains, and what it does not.

use crate::numeric::small::solve_spd;

/// Values outside are in shadow or saturated, in the space of their files.
pub(super) const DARK: f64 = 0.02;
pub(super) const BRIGHT: f64 = 0.98;
/// The part of the sorted values of a texel that is used: below are shadows, above highlights.
const LOW: f64 = 0.3;
const HIGH: f64 = 0.9;
/// The fewest values of a texel.
const FEWEST: usize = 5;

/// Which values of a texel are used; `None` where they are too few.
pub(super) fn used(values: &[f64]) -> Option<Vec<usize>> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&i, &j| values[i].total_cmp(&values[j]).then(i.cmp(&j)));
    let low = (LOW * values.len() as f64) as usize;
    let high = (HIGH * values.len() as f64).ceil() as usize;
    let mut kept: Vec<usize> =
        order[low..high].iter().copied().filter(|&i| (DARK..BRIGHT).contains(&values[i])).collect();
    kept.sort_unstable();
    (kept.len() >= FEWEST).then_some(kept)
}

/// Albedo times normal of a matt texel, by least squares over some of its values.
pub(super) fn solve(lights: &[[f64; 3]], values: &[f64], used: &[usize]) -> Option<[f64; 3]> {
    let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
    for &k in used {
        for i in 0..3 {
            right[i] += lights[k][i] * values[k];
            (0..3).for_each(|j| matrix[i][j] += lights[k][i] * lights[k][j]);
        }
    }
    solve_spd(&matrix, &right)
}

/// The value of a matt texel under a light.
pub(super) fn shaded(texel: &[f64; 3], light: &[f64; 3]) -> f64 {
    texel.iter().zip(light).map(|(b, l)| b * l).sum()
}
