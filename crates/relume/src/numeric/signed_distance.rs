//! Distances to the boundary of a part of a picture, positive inside.
//!
//! The distance to the nearest texel of the other kind, exact and Euclidean, less the half texel from its centre to the
//! boundary, up to a reach: in each row first, then down the columns over the rows within reach (T. Saito, J. Toriwaki,
//! "New algorithms for Euclidean distance transformation of an n-dimensional digitized picture", Pattern Recognition 27,
//! 1994). Beyond the borders of the picture nothing is known, and nothing is near.

use crate::size::Size;

/// Distances in texels, from -`reach` to `reach`, of each texel, row by row.
///
/// # Panics
/// When `inside` is not of the texels of the size, or the reach is over 100.
pub fn signed_distances(size: Size, inside: &[bool], reach: usize) -> Vec<f32> {
    assert_eq!(inside.len(), size.texels(), "a flag for each texel");
    assert!(reach <= 100, "a reach in texels");
    let across = distances_in_rows(size.width, inside, reach + 1);
    let distance = |texel: usize| {
        let square = square_of_nearest(size, inside, &across, texel, reach);
        let far = ((square as f32).sqrt() - 0.5).min(reach as f32);
        if inside[texel] { far } else { -far }
    };
    (0..size.texels()).map(distance).collect()
}

/// The distance to the nearest texel of the other kind in the same row, at most `most`.
fn distances_in_rows(width: usize, inside: &[bool], most: usize) -> Vec<u8> {
    let mut across = vec![most as u8; inside.len()];
    for (row, across) in inside.chunks(width).zip(across.chunks_mut(width)) {
        for x in 1..width {
            let far = if row[x] == row[x - 1] { across[x - 1].saturating_add(1) } else { 1 };
            across[x] = far.min(most as u8);
        }
        for x in (1..width).rev() {
            let far = if row[x] == row[x - 1] { across[x].saturating_add(1) } else { 1 };
            across[x - 1] = across[x - 1].min(far);
        }
    }
    across
}

/// The squared distance to the nearest texel of the other kind, at most that of reach + 1.
fn square_of_nearest(size: Size, inside: &[bool], across: &[u8], texel: usize, reach: usize) -> usize {
    let (y, kind) = (texel / size.width, inside[texel]);
    let mut nearest = (reach + 1).pow(2);
    let mut meet = |other: usize, down: usize| {
        let across = if inside[other] == kind { usize::from(across[other]) } else { 0 };
        nearest = nearest.min(across * across + down * down);
        nearest
    };
    let mut down = 0;
    while down * down < meet(texel, 0) && down <= reach {
        if down <= y {
            meet(texel - down * size.width, down);
        }
        if y + down < size.height {
            meet(texel + down * size.width, down);
        }
        down += 1;
    }
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    /// The slow truth: over all texels of the other kind.
    fn truth(size: Size, inside: &[bool], reach: usize, texel: usize) -> f32 {
        let place = |t: usize| ((t % size.width) as f32, (t / size.width) as f32);
        let (x, y) = place(texel);
        let others = (0..size.texels()).filter(|t| inside[*t] != inside[texel]).map(place);
        let nearest = others.map(|(a, b)| (a - x).hypot(b - y)).fold(f32::INFINITY, f32::min);
        let far = (nearest - 0.5).min(reach as f32);
        if inside[texel] { far } else { -far }
    }

    #[test]
    fn distances_are_those_to_the_nearest_texel_of_the_other_kind() {
        let mut stream = Stream::new(7, Purpose::Sample, [0]);
        for (w, h, share) in
            [(1, 1, 0.5), (9, 1, 0.3), (1, 8, 0.3), (23, 17, 0.02), (16, 31, 0.5), (20, 20, 0.97)]
        {
            let size = Size::new(w, h);
            let inside: Vec<bool> = (0..size.texels()).map(|_| stream.unit() < share).collect();
            for reach in [1, 3, 12] {
                for (texel, found) in signed_distances(size, &inside, reach).into_iter().enumerate() {
                    let truth = truth(size, &inside, reach, texel);
                    assert!((found - truth).abs() < 1e-5, "{size} {reach} {texel}: {found} and {truth}");
                }
            }
        }
    }
}
