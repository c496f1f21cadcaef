//! Sums over rectangles in constant time: Crow, "Summed-area tables for texture mapping",
//! SIGGRAPH 1984. Sums are integers, so they are exact in any order.

use crate::size::Size;

/// The sums over all upper left rectangles of a table of integers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SummedArea {
    size: Size,
    /// Sums over the x first columns and y first rows, (width + 1) x (height + 1).
    sums: Vec<u64>,
}

impl SummedArea {
    /// The sums of a table given row by row.
    ///
    /// # Panics
    /// When there is not one value for each texel.
    pub fn new(size: Size, values: &[u64]) -> Self {
        assert_eq!(values.len(), size.texels(), "one value for each texel");
        let stride = size.width + 1;
        let mut sums = vec![0; stride * (size.height + 1)];
        for (y, row) in values.chunks_exact(size.width.max(1)).enumerate() {
            let (above, here) = sums[y * stride..].split_at_mut(stride);
            let mut sum = 0;
            for ((out, above), value) in here[1..].iter_mut().zip(&above[1..]).zip(row) {
                sum += value;
                *out = above + sum;
            }
        }
        Self { size, sums }
    }

    /// Width and height of the table.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The sum over the rectangle of `width` x `height` values whose top left one is (x, y); values outside
    /// the table count as zero.
    pub fn sum(&self, x: usize, y: usize, width: usize, height: usize) -> u64 {
        let Size { width: columns, height: rows } = self.size;
        let at = |x: usize, y: usize| self.sums[y.min(rows) * (columns + 1) + x.min(columns)];
        at(x + width, y + height) + at(x, y) - at(x + width, y) - at(x, y + height)
    }

    /// Adds to each of `sums` the sum over a rectangle of `width` x `height` values: the first with its top left
    /// one at (x, y), every other one column to the right of that before it.
    ///
    /// # Panics
    /// When the last of them is not inside the table.
    pub fn add_row(&self, (x, y): (usize, usize), (width, height): (usize, usize), sums: &mut [u64]) {
        let stride = self.size.width + 1;
        let corners = |x: usize, y: usize| &self.sums[y * stride..][..stride][x..][..sums.len()];
        let (first, second) = (corners(x, y), corners(x + width, y));
        let (third, fourth) = (corners(x, y + height), corners(x + width, y + height));
        let positive = fourth.iter().zip(first);
        let negative = second.iter().zip(third);
        for ((sum, (a, b)), (c, d)) in sums.iter_mut().zip(positive).zip(negative) {
            *sum += a + b - c - d;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::random::{Purpose, Stream};

    #[test]
    fn every_rectangle_has_its_sum() {
        let mut stream = Stream::new(3, Purpose::Sample, [0]);
        for size in [Size::new(1, 1), Size::new(7, 5), Size::new(1, 6), Size::new(4, 1)] {
            let values: Vec<u64> = (0..size.texels()).map(|_| stream.below(1000) as u64).collect();
            let table = SummedArea::new(size, &values);
            for (x, y) in (0..=size.width).flat_map(|x| (0..=size.height).map(move |y| (x, y))) {
                for (w, h) in (0..=size.width - x).flat_map(|w| (0..=size.height - y).map(move |h| (w, h))) {
                    let rows = (y..y + h).flat_map(|j| (x..x + w).map(move |i| (i, j)));
                    let truth: u64 = rows.map(|(i, j)| values[size.index(i, j)]).sum();
                    assert_eq!(table.sum(x, y, w, h), truth);
                    let beyond = |end: usize, length: usize| if end == length { 3 } else { 0 };
                    let (more, lower) = (beyond(x + w, size.width), beyond(y + h, size.height));
                    assert_eq!(table.sum(x, y, w + more, h + lower), truth);
                }
            }
        }
    }

    #[test]
    fn rows_of_rectangles_have_the_sums_of_each() {
        let mut stream = Stream::new(4, Purpose::Sample, [0]);
        let size = Size::new(9, 6);
        let values: Vec<u64> = (0..size.texels()).map(|_| stream.below(1000) as u64).collect();
        let table = SummedArea::new(size, &values);
        for (x, y, w, h) in [(0, 0, 1, 1), (2, 1, 3, 5), (0, 5, 9, 1), (4, 2, 0, 3)] {
            let mut sums = vec![7; size.width + 1 - w - x];
            table.add_row((x, y), (w, h), &mut sums);
            let each: Vec<u64> = (0..sums.len()).map(|i| 7 + table.sum(x + i, y, w, h)).collect();
            assert_eq!(sums, each);
        }
    }
}
