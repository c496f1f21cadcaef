//! Masks: pictures in which texels are painted or not.

use super::meaning::Meaning;
use super::raster::decode_as;
use crate::error::Result;
use crate::job::Job;
use crate::raster::{Raster, Samples};
use crate::size::Size;

/// The texels that a mask paints.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mask {
    /// Width and height.
    pub size: Size,
    /// For each texel, whether it is painted.
    pub painted: Vec<bool>,
}

/// The mask in the bytes of a picture. A texel is painted if its brightest channel is above half. In a picture
/// with an opacity it must also be more than half opaque; and if all texels that are not fully transparent
/// have one colour, that says nothing, and the opacity alone decides.
///
/// # Errors
/// A file that is not a picture.
pub fn decode_mask(bytes: &[u8], job: &Job) -> Result<Mask> {
    let raster = decode_as(bytes, Meaning::Data, job)?;
    let size = raster.size();
    let texels = 0..size.texels();
    let painted = match raster.opacity() {
        None => texels.map(|texel| is_bright(&raster, texel)).collect(),
        Some(opacity) => {
            let by_opacity = is_of_one_color(&raster, opacity);
            let covers = |texel: usize| opacity.value(texel) > 0.5;
            texels.map(|texel| covers(texel) && (by_opacity || is_bright(&raster, texel))).collect()
        }
    };
    Ok(Mask { size, painted })
}

fn colors(raster: &Raster, texel: usize) -> impl Iterator<Item = f32> {
    let channels = raster.channels();
    (texel * channels..(texel + 1) * channels).map(|i| raster.samples().value(i))
}

fn is_bright(raster: &Raster, texel: usize) -> bool {
    colors(raster, texel).any(|value| value > 0.5)
}

/// Whether all texels that are not fully transparent have the same colour.
fn is_of_one_color(raster: &Raster, opacity: &Samples) -> bool {
    let mut visible = (0..raster.size().texels()).filter(|&texel| opacity.value(texel) > 0.0);
    let Some(first) = visible.next() else { return true };
    visible.all(|texel| colors(raster, texel).eq(colors(raster, first)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, ImageEncoder};

    fn painted(texels: &[[u8; 4]]) -> Vec<bool> {
        let mut file = Vec::new();
        let width = texels.len() as u32;
        PngEncoder::new(&mut file)
            .write_image(texels.as_flattened(), width, 1, ExtendedColorType::Rgba8)
            .unwrap();
        decode_mask(&file, &Job::default()).unwrap().painted
    }

    #[test]
    fn a_mask_may_be_painted_in_its_opacity() {
        let (white, black) = ([255, 255, 255, 255], [0, 0, 0, 255]);
        assert_eq!(painted(&[white, black, [0, 0, 255, 255]]), [true, false, true], "opaque: brightness");
        assert_eq!(painted(&[black, [0, 0, 0, 0]]), [true, false], "black strokes on nothing");
        assert_eq!(painted(&[black, [255, 255, 255, 0], [0, 0, 0, 100]]), [true, false, false]);
        assert_eq!(painted(&[white, [255, 255, 255, 0]]), [true, false], "white strokes on nothing");
        assert_eq!(painted(&[white, black, [255, 255, 255, 0]]), [true, false, false], "both count");
    }
}
