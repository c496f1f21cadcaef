//! Joining a block to the existing texels by linear ramps across the overlaps.

use super::neighbourhood::{Margins, Neighbourhood};
use crate::size::Size;

/// The weight of the new block at each texel: (d + 1) / (margin + 1) at d texels from the edge of a filled
/// margin, the product of the ramps in corners, and 1 where nothing is filled.
pub fn ramps(shape: &Neighbourhood) -> Vec<f32> {
    let Size { width, height } = shape.extent;
    let Margins { left, top, right, bottom } = shape.margins;
    let ramp = |depth: usize, margin: usize| {
        if depth < margin { (depth + 1) as f32 / (margin + 1) as f32 } else { 1.0 }
    };
    let along_x: Vec<f32> = (0..width).map(|x| ramp(x, left) * ramp(width - 1 - x, right)).collect();
    let along_y = (0..height).map(|y| ramp(y, top) * ramp(height - 1 - y, bottom));
    along_y.flat_map(|wy| along_x.iter().map(move |wx| wx * wy)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_rise_linearly_from_each_filled_edge() {
        let margins = Margins { left: 3, top: 1, right: 0, bottom: 0 };
        let shape = Neighbourhood { extent: Size::new(5, 3), margins };
        let expected = [
            0.125, 0.25, 0.375, 0.5, 0.5, //
            0.25, 0.5, 0.75, 1.0, 1.0, //
            0.25, 0.5, 0.75, 1.0, 1.0,
        ];
        assert_eq!(ramps(&shape), expected);
        for (texel, weight) in ramps(&shape).into_iter().enumerate() {
            assert_eq!(weight < 1.0, shape.contains(texel % 5, texel / 5));
        }
    }
}
