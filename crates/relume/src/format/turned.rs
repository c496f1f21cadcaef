//! The orientation of pictures as cameras record it (EXIF 2.3, tag 0x0112).

use crate::error::Result;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// The picture as it is to be shown: orientations 2 to 8 mirror or turn it, others leave it.
pub(super) fn turned(raster: Raster, orientation: u16) -> Result<Raster> {
    if !(2..=8).contains(&orientation) {
        return Ok(raster);
    }
    let Size { width, height } = raster.size();
    let size = if orientation >= 5 { Size::new(height, width) } else { raster.size() };
    let (right, bottom) = (width - 1, height - 1);
    let source = |texel: usize| {
        let (x, y) = (texel % size.width, texel / size.width);
        let (x, y) = match orientation {
            2 => (right - x, y),
            3 => (right - x, bottom - y),
            4 => (x, bottom - y),
            5 => (y, x),
            6 => (y, bottom - x),
            7 => (right - y, bottom - x),
            _ => (right - y, x),
        };
        y * width + x
    };
    let sources: Vec<usize> = (0..size.texels()).map(source).collect();
    let samples = |samples: &Samples, channels: usize| match samples {
        Samples::U8(s) => Samples::U8(moved(s, &sources, channels)),
        Samples::U16(s) => Samples::U16(moved(s, &sources, channels)),
        Samples::F32(s) => Samples::F32(moved(s, &sources, channels)),
    };
    let shown = Raster::new(size, raster.channels(), samples(raster.samples(), raster.channels()))?;
    match raster.opacity() {
        Some(opacity) => shown.with_opacity(samples(opacity, 1)),
        None => Ok(shown),
    }
}

/// The picture as it is stored, from one that is turned as it is to be shown.
pub(super) fn turned_back(raster: Raster, orientation: u16) -> Result<Raster> {
    // Quarter turns undo each other; the other orientations undo themselves.
    turned(
        raster,
        match orientation {
            6 => 8,
            8 => 6,
            same => same,
        },
    )
}

fn moved<T: Copy>(samples: &[T], sources: &[usize], channels: usize) -> Vec<T> {
    sources.iter().flat_map(|texel| &samples[texel * channels..][..channels]).copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_orientation_is_undone() {
        let raster = Raster::new(Size::new(3, 2), 1, Samples::U8(vec![1, 2, 3, 4, 5, 6])).unwrap();
        for orientation in 0..=9 {
            let shown = turned(raster.clone(), orientation).unwrap();
            assert_eq!((2..=8).contains(&orientation), shown != raster);
            assert_eq!(turned_back(shown, orientation).unwrap(), raster);
        }
    }
}
