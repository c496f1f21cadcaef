//! Prediction of a plane of bytes from another: their difference modulo 256, around 128.

/// The plane from which another is predicted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PlaneReference {
    pub plane: usize,
    /// Whether its bytes b are taken as 255 - b.
    pub is_inverted: bool,
}

fn predicted(byte: u8, is_inverted: bool) -> u8 {
    if is_inverted { 255 - byte } else { byte }
}

/// What is left of a plane after its prediction.
pub(super) fn residual(plane: &[u8], reference: &[u8], is_inverted: bool) -> Vec<u8> {
    let left = |(&byte, &from): (&u8, &u8)| byte.wrapping_sub(predicted(from, is_inverted)).wrapping_add(128);
    plane.iter().zip(reference).map(left).collect()
}

/// The plane of which `samples` are left: the inverse of [`residual`].
pub(super) fn restore(samples: &mut [u8], reference: &[u8], is_inverted: bool) {
    for (sample, &from) in samples.iter_mut().zip(reference) {
        *sample = sample.wrapping_sub(128).wrapping_add(predicted(from, is_inverted));
    }
}

/// What a plane costs as a JPEG file, up to a factor: the sum of the differences between neighbours in a row.
pub(super) fn roughness(plane: &[u8], width: usize) -> u64 {
    let row = |row: &[u8]| row.windows(2).map(|pair| u64::from(pair[0].abs_diff(pair[1]))).sum::<u64>();
    plane.chunks(width).map(row).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_restores_the_plane() {
        let plane: Vec<u8> = (0..=255).collect();
        for shift in [0, 1, 77, 200, 255] {
            let reference: Vec<u8> = plane.iter().map(|b| b.wrapping_mul(3).wrapping_add(shift)).collect();
            for is_inverted in [false, true] {
                let mut samples = residual(&plane, &reference, is_inverted);
                restore(&mut samples, &reference, is_inverted);
                assert_eq!(samples, plane);
            }
        }
        assert_eq!(residual(&[10], &[10], false), [128]);
        assert_eq!(residual(&[10], &[245], true), [128]);
    }
}
