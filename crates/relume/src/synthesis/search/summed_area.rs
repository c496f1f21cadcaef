//! Sums over rectangles in constant time: Crow, "Summed-area tables for texture mapping",
//! SIGGRAPH 1984.

use crate::planes::Size;

/// Sums over all upper left rectangles.
#[derive(Debug, Clone)]
pub struct SummedArea {
    stride: usize,
    sums: Vec<i64>,
}

impl SummedArea {
    /// The squares of interleaved codes, all planes of a texel together.
    pub fn of_squares(codes: &[i16], planes: usize, size: Size) -> Self {
        let stride = size.width + 1;
        let mut sums = vec![0i64; stride * (size.height + 1)];
        for y in 0..size.height {
            let mut row = 0;
            for x in 0..size.width {
                let texel = &codes[size.index(x, y) * planes..][..planes];
                row += texel.iter().map(|&code| i64::from(code).pow(2)).sum::<i64>();
                sums[(y + 1) * stride + x + 1] = sums[y * stride + x + 1] + row;
            }
        }
        Self { stride, sums }
    }

    /// The sum over a rectangle; parts outside count as nothing.
    pub fn sum(&self, x: usize, y: usize, width: usize, height: usize) -> i64 {
        let at = |x: usize, y: usize| {
            let (last_x, last_y) = (self.stride - 1, self.sums.len() / self.stride - 1);
            self.sums[y.min(last_y) * self.stride + x.min(last_x)]
        };
        at(x + width, y + height) - at(x + width, y) - at(x, y + height) + at(x, y)
    }
}
