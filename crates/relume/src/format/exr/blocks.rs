//! The blocks of an EXR file: rows or tiles that are compressed together.

use half::f16;
use half::slice::HalfFloatSliceExt;

use super::ExrDepth;
use crate::size::Size;

/// The rows that ZIP compresses together ("OpenEXR File Layout", Academy Software Foundation).
pub(in crate::format) const ROWS: usize = 16;

/// The contents of the header of a file, apart from its size.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::format) struct Head<'a> {
    /// The names of the channels, in alphabetical order.
    pub names: Vec<String>,
    pub depth: ExrDepth,
    /// Attributes of text.
    pub texts: Vec<(&'a str, String)>,
    /// The size of the tiles of the file; `None` for rows.
    pub tile: Option<Size>,
}

impl Head<'_> {
    /// The texels compressed together in a file of `size` texels.
    pub fn block(&self, size: Size) -> Size {
        self.tile.unwrap_or(Size::new(size.width, ROWS))
    }
}

/// Writes the samples of a plane, the lowest byte first; finite values stay finite.
///
/// # Panics
/// When `out` has not the bytes of all samples.
pub(in crate::format) fn write_samples(plane: &[f32], depth: ExrDepth, out: &mut [u8]) {
    assert_eq!(out.len(), plane.len() * depth.bytes(), "the bytes of all samples");
    match depth {
        ExrDepth::Half => {
            let (values, rest) = plane.as_chunks::<HALVES>();
            let (bytes, last) = out.as_chunks_mut::<{ 2 * HALVES }>();
            values.iter().zip(bytes).for_each(|(values, bytes)| write_halves(values, bytes));
            write_halves(rest, last);
        }
        ExrDepth::Float => {
            let out = out.as_chunks_mut::<4>().0;
            out.iter_mut().zip(plane).for_each(|(out, value)| *out = value.to_le_bytes());
        }
    }
}

/// Values that are rounded at once.
const HALVES: usize = 64;

/// Writes the nearest halves of at most [`HALVES`] values; finite values stay finite.
fn write_halves(values: &[f32], out: &mut [u8]) {
    let most = f16::MAX.to_f32();
    let mut within = [0.0; HALVES];
    for (within, value) in within.iter_mut().zip(values) {
        *within = if value.is_finite() { value.clamp(-most, most) } else { *value };
    }
    let mut halves = [f16::ZERO; HALVES];
    halves[..values.len()].convert_from_f32_slice(&within[..values.len()]);
    let out = out.as_chunks_mut::<2>().0;
    out.iter_mut().zip(halves).for_each(|(out, half)| *out = half.to_le_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_the_nearest_halves_and_stay_finite() {
        for length in [0, 1, 63, 64, 65, 200] {
            let plane: Vec<f32> = (0..length).map(|i| (i as f32 - 90.0).powi(3) * 0.37).collect();
            let mut bytes = vec![0; 2 * length];
            write_samples(&plane, ExrDepth::Half, &mut bytes);
            for (value, bytes) in plane.iter().zip(bytes.as_chunks::<2>().0) {
                let half = f16::from_le_bytes(*bytes);
                assert_eq!(half, f16::from_f32(value.clamp(-65504.0, 65504.0)), "{value}");
            }
        }
        let mut bytes = [0; 4];
        write_samples(&[f32::INFINITY, f32::NAN], ExrDepth::Half, &mut bytes);
        assert_eq!(f16::from_le_bytes([bytes[0], bytes[1]]), f16::INFINITY);
        assert!(f16::from_le_bytes([bytes[2], bytes[3]]).is_nan());
    }
}
