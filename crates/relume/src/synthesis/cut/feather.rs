//! Feathering: a linear ramp of the weight of the new block across its seam, in index space.

use super::depths;
use crate::size::Size;
use crate::synthesis::neighbourhood::Neighbourhood;

/// The weight of the new block at each texel: from 0 to 1 in equal steps within `texels` of the seam on
/// either side, and exactly 0 or 1 farther away.
///
/// A texel at k steps (right, down, left or up) from the nearest texel of the other region lies k - 1/2 from
/// the seam. The share of the other region in it falls from 1/2 on the seam to zero at `texels` + 1/2:
/// (n + 1 - k) / (2 n + 1). If the other block ends earlier, at m steps, the ramp falls to zero there,
/// m / (2 m + 2 k - 1). Beyond the edges of filled margins all is old; texels that are not filled are
/// new, with weight 1.
pub fn feather(shape: &Neighbourhood, new: &[bool], texels: usize) -> Vec<f32> {
    if texels == 0 {
        return new.iter().map(|&new| f32::from(u8::from(new))).collect();
    }
    let size = shape.extent;
    let at = |x: usize, y: usize| size.index(x, y);
    let to_old = steps(size, |x, y| !new[at(x, y)]);
    let to_new = steps(size, |x, y| new[at(x, y)]);
    let to_unfilled = steps(size, |x, y| !shape.contains(x, y));
    let weight = |x: usize, y: usize| {
        let texel = at(x, y);
        let edge = depths(shape, x, y).min().unwrap_or(FAR);
        if new[texel] {
            1.0 - other_share(to_old[texel].min(edge), to_unfilled[texel], texels)
        } else {
            other_share(to_new[texel], edge, texels)
        }
    };
    (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y))).map(|(x, y)| weight(x, y)).collect()
}

/// More steps than any block has texels.
const FAR: usize = 1 << 40;

/// The share of the other region in a texel `steps` from it, if the other block ends `end` steps away.
fn other_share(steps: usize, end: usize, texels: usize) -> f32 {
    if steps > texels {
        return 0.0;
    }
    let ramp = (texels + 1 - steps) as f32 / (2 * texels + 1) as f32;
    ramp.min(end as f32 / (2 * end + 2 * steps - 1) as f32)
}

/// The steps from each texel to the nearest `target`, right, down, left and up.
///
/// Two passes are exact for this distance: Rosenfeld, Pfaltz, "Sequential Operations in Digital
/// Picture Processing", Journal of the ACM 13(4), 1966.
fn steps(size: Size, target: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let mut steps = vec![FAR; size.texels()];
    let texels = || (0..size.height).flat_map(|y| (0..size.width).map(move |x| (x, y)));
    for (x, y) in texels() {
        let left = if x > 0 { steps[size.index(x - 1, y)] + 1 } else { FAR };
        let above = if y > 0 { steps[size.index(x, y - 1)] + 1 } else { FAR };
        steps[size.index(x, y)] = if target(x, y) { 0 } else { left.min(above) };
    }
    for (x, y) in texels().collect::<Vec<_>>().into_iter().rev() {
        let right = if x + 1 < size.width { steps[size.index(x + 1, y)] + 1 } else { FAR };
        let below = if y + 1 < size.height { steps[size.index(x, y + 1)] + 1 } else { FAR };
        let own = &mut steps[size.index(x, y)];
        *own = (*own).min(right).min(below);
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::cut::graph::inside_seam;
    use crate::synthesis::cut::inside_cuts;
    use crate::synthesis::neighbourhood::Margins;
    use proptest::prelude::*;

    /// A strip 9 deep on the left, new from column `from`.
    fn straight(from: usize, texels: usize) -> Vec<f32> {
        let margins = Margins { left: 9, ..Margins::default() };
        let shape = Neighbourhood { extent: Size::new(12, 3), margins };
        let new: Vec<bool> = (0..36).map(|t| t % 12 >= from).collect();
        let weights = feather(&shape, &new, texels);
        assert_eq!(weights[..12], weights[24..], "all rows are alike");
        weights[..12].to_vec()
    }

    #[test]
    fn across_a_straight_seam_weights_rise_linearly() {
        let fifths = straight(4, 2);
        let expected = [0.0, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
        fifths.iter().zip(expected).for_each(|(w, e)| assert!((w - e).abs() < 1e-6, "{fifths:?}"));
        assert_eq!(straight(3, 0), [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        for (from, texels) in (0..=9).flat_map(|from| (0..9).map(move |texels| (from, texels))) {
            let weights = straight(from, texels);
            assert!(weights.windows(2).all(|w| w[0] <= w[1]), "{from} {texels}: {weights:?}");
        }
    }

    #[test]
    fn ramps_end_where_a_block_ends() {
        // Old at column 0 alone: half a texel inside the seam, one and a half from the side of the old block.
        let weights = straight(1, 4);
        assert!((weights[0] - 1.0 / 3.0).abs() < 1e-6 && (weights[1] - 5.0 / 9.0).abs() < 1e-6);
        // New at the last column of the strip alone.
        let weights = straight(8, 4);
        assert!((weights[7] - 4.0 / 9.0).abs() < 1e-6 && (weights[8] - 2.0 / 3.0).abs() < 1e-6);
        assert_eq!(weights[9..], [1.0; 3]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn only_texels_near_the_seam_are_blended(
            (width, height, texels) in (4usize..18, 4usize..18, 0usize..9),
            (filled, seed) in (any::<[bool; 4]>(), any::<u64>()),
        ) {
            let margin = |i: usize, side: usize| if filled[i] { side / (2 + i) } else { 0 };
            let margins = Margins {
                left: margin(0, width),
                top: margin(1, height),
                right: margin(2, width),
                bottom: margin(3, height),
            };
            let shape = Neighbourhood { extent: Size::new(width, height), margins };
            let hash = |x: usize, y: usize| {
                (seed ^ (x * 31 + y) as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 58
            };
            let new = if seed % 2 == 0 { inside_seam(&shape, hash) } else { inside_cuts(&shape, hash) };
            let places: Vec<(usize, usize)> =
                (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).collect();
            for (&(x, y), weight) in places.iter().zip(feather(&shape, &new, texels)) {
                let own = new[shape.extent.index(x, y)];
                let others = places.iter().filter(|(a, b)| new[shape.extent.index(*a, *b)] != own);
                let inside = others.map(|(a, b)| a.abs_diff(x) + b.abs_diff(y)).min();
                let edge = depths(&shape, x, y).min().filter(|_| own);
                let near = inside.into_iter().chain(edge).any(|steps| steps <= texels);
                let blended = weight > 0.0 && weight < 1.0;
                prop_assert_eq!(blended, near && shape.contains(x, y), "({}, {}): {}", x, y, weight);
                prop_assert!(blended || weight == f32::from(u8::from(own)));
            }
        }
    }
}
