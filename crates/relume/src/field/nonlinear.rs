//! Textures that are not linear in the numbers of their texels (docs/decisions/0013): stages take their linear form, and what
//! shows or keeps them takes them as they are.

use super::{ClusteredField, ParametricField};
use crate::size::Size;

/// A texture that is not linear in the numbers of its texels.
#[derive(Debug, Clone, PartialEq)]
pub enum NonlinearField {
    /// Reflectance models: their linear form is nearly the same texture.
    Models(ParametricField),
    /// Texels in clusters: their linear form is the same texture.
    Clusters(ClusteredField),
}

impl NonlinearField {
    /// Width and height.
    pub fn size(&self) -> Size {
        match self {
            Self::Models(models) => models.size(),
            Self::Clusters(clusters) => clusters.size(),
        }
    }
}
