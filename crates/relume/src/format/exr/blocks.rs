//! The blocks of an EXR file: rows or tiles that are compressed together.

use half::f16;

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

/// The samples of a plane in the form the writer expects; finite values stay finite.
pub(in crate::format) fn sample_bytes(plane: &[f32], depth: ExrDepth) -> Vec<u8> {
    match depth {
        ExrDepth::Half => plane.iter().flat_map(|&v| half_of(v).to_ne_bytes()).collect(),
        ExrDepth::Float => plane.iter().flat_map(|&v| v.to_ne_bytes()).collect(),
    }
}

/// The nearest half; finite values stay finite.
fn half_of(value: f32) -> f16 {
    let most = f16::MAX.to_f32();
    f16::from_f32(if value.is_finite() { value.clamp(-most, most) } else { value })
}
