//! Sizes in texels.

use crate::error::{Error, Result};

/// Width and height in texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Size {
    /// Texels along x.
    pub width: usize,
    /// Texels along y.
    pub height: usize,
}

impl Size {
    /// A size of `width` x `height` texels.
    pub const fn new(width: usize, height: usize) -> Self {
        Self { width, height }
    }

    /// The number of texels.
    pub const fn texels(self) -> usize {
        self.width * self.height
    }

    /// The index of texel (x, y) in a plane.
    pub const fn index(self, x: usize, y: usize) -> usize {
        y * self.width + x
    }

    /// Refuses a rectangle of `size` texels whose top-left texel is (x, y) when it is empty or
    /// does not lie inside.
    pub fn check_crop(self, x: usize, y: usize, size: Self) -> Result<()> {
        let fits = x.checked_add(size.width).is_some_and(|end| end <= self.width)
            && y.checked_add(size.height).is_some_and(|end| end <= self.height);
        if !fits || size.texels() == 0 {
            return Err(Error::invalid(format!(
                "a crop of {size} texels at ({x}, {y}) does not lie inside {self}"
            )));
        }
        Ok(())
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} x {}", self.width, self.height)
    }
}
