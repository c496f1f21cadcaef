//! Rectangles of texels.

use crate::size::Size;

/// A rectangle of texels, given by its top left one; coordinates are `usize` inside a picture and `i64` on
/// an endless plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Rect<C = i64> {
    /// Left column.
    pub x: C,
    /// Top row.
    pub y: C,
    /// Columns and rows.
    pub size: Size,
}

impl<C> Rect<C> {
    /// The rectangle of `size` texels whose top left one is (x, y).
    pub const fn new(x: C, y: C, size: Size) -> Self {
        Self { x, y, size }
    }
}

impl<C: Copy> Rect<C> {
    /// Column and row of the top left texel.
    pub const fn origin(self) -> [C; 2] {
        [self.x, self.y]
    }
}
