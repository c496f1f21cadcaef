//! The origin of the texels of a synthesised texture, as seen by the measures: plain numbers, so that the
//! record of any method can be measured.

use crate::error::{Error, Result};
use crate::size::Size;

/// The exemplar texel that an output texel copies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Which exemplar, from 0.
    pub exemplar: u32,
    /// Column from the left.
    pub x: u32,
    /// Row from the top.
    pub y: u32,
}

/// The sources of a texture.
#[derive(Debug, Clone, Copy)]
pub struct Sources<'a> {
    size: Size,
    texels: &'a [Source],
    exemplars: &'a [Size],
}

impl<'a> Sources<'a> {
    /// The sources of each texel, row after row, in exemplars of the given sizes.
    ///
    /// # Errors
    /// When there is not one source per texel, or one lies outside its exemplar.
    pub fn new(size: Size, texels: &'a [Source], exemplars: &'a [Size]) -> Result<Self> {
        if texels.len() != size.texels() || texels.is_empty() {
            return Err(Error::invalid(format!(
                "a texture of {size} texels has {} sources: expected one for each texel",
                texels.len()
            )));
        }
        let outside = |s: &Source| {
            let exemplar = exemplars.get(s.exemplar as usize);
            exemplar.is_none_or(|e| s.x as usize >= e.width || s.y as usize >= e.height)
        };
        if let Some(at) = texels.iter().position(outside) {
            let Source { exemplar, x, y } = texels[at];
            return Err(Error::invalid(format!(
                "texel ({}, {}) comes from ({x}, {y}) of exemplar {exemplar}, which does not exist: the map is not of \
                 this exemplar",
                at % size.width,
                at / size.width
            )));
        }
        Ok(Self { size, texels, exemplars })
    }

    /// Width and height of the texture.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The source of each texel, row after row.
    pub fn texels(&self) -> &'a [Source] {
        self.texels
    }

    /// The sizes of the exemplars.
    pub fn exemplars(&self) -> &'a [Size] {
        self.exemplars
    }

    /// Whether texel `there`, at `step` = (right, down) from `here`, continues the copy at `here`.
    pub fn continues(&self, here: usize, there: usize, step: (u32, u32)) -> bool {
        let (a, b) = (self.texels[here], self.texels[there]);
        b == Source { exemplar: a.exemplar, x: a.x + step.0, y: a.y + step.1 }
    }

    /// The pairs of neighbours inside the texture, and the step from the first to the second.
    pub fn neighbours(&self) -> impl Iterator<Item = (usize, usize, (u32, u32))> + use<> {
        let size = self.size;
        (0..size.texels()).flat_map(move |i| {
            let right = (i % size.width + 1 < size.width).then_some((i, i + 1, (1, 0)));
            let down = (i / size.width + 1 < size.height).then_some((i, i + size.width, (0, 1)));
            [right, down].into_iter().flatten()
        })
    }
}
