//! Which texels of developed photographs belong to the surface.

use super::Development;
use crate::error::{Error, Result};
use crate::planes::Planes;
use crate::size::Size;

impl Development {
    /// The texels of developed photographs that a mask of `size` pixels leaves: one of the size of the `whole`
    /// photographs is cropped and reduced with them, where a texel belongs to the surface if at least half of its pixels
    /// do; one of the size of developed photographs is taken as it is.
    ///
    /// # Errors
    /// A mask of another size, and one that leaves nothing.
    pub fn mask_of_texels(&self, mask: &[bool], size: Size, whole: Size) -> Result<Vec<bool>> {
        let texels = self.size_of(whole)?;
        let inside = match size {
            size if size == whole => self.over_texels(mask, whole)?,
            size if size == texels => mask.to_vec(),
            _ => {
                let cropped = if texels == whole {
                    String::new()
                } else {
                    format!(", or the {texels} that are left of them")
                };
                return Err(Error::invalid(format!(
                    "the mask has {size} pixels: expected the {whole} of the photographs{cropped}"
                )));
            }
        };
        if !inside.contains(&true) {
            return Err(Error::invalid(
                "the mask leaves no texel of the surface: what belongs to it must be bright",
            ));
        }
        Ok(inside)
    }

    fn over_texels(&self, mask: &[bool], whole: Size) -> Result<Vec<bool>> {
        let pixels = mask.iter().map(|inside| f32::from(u8::from(*inside))).collect();
        let part = self.framed(Planes::from_vec(whole, 1, pixels)?)?;
        Ok(part.plane(0).iter().map(|share| *share >= 0.5).collect())
    }
}
