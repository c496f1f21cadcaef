//! A picture: planes of colour with their space, as produced by relighting and rendering.

use crate::planes::Planes;
use crate::size::Size;
use crate::space::Space;

/// One (grey) or three (RGB) planes, and whether they are linear or encoded. 1 is white.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// The channels.
    pub planes: Planes,
    /// The encoding of the values.
    pub space: Space,
}

impl Picture {
    /// Width and height.
    pub fn size(&self) -> Size {
        self.planes.size()
    }

    /// The picture in another space; a copy when it is already in that space.
    pub fn to_space(&self, space: Space) -> Self {
        let mut planes = self.planes.clone();
        if space != self.space {
            let convert = |v: f32| space.from_linear(self.space.to_linear(v));
            planes.as_mut_slice().iter_mut().for_each(|v| *v = convert(*v));
        }
        Self { planes, space }
    }
}
