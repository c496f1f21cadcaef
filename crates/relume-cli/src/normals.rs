//! Normals as pictures.

use relume::format::{Depth, PictureFormat, encode_picture};
use relume::{Picture, Planes, Result, Space};

/// The bytes of a normal map (+Y): components from -1 to 1 in EXR and PFM, packed to 0..1 in 16-bit codes
/// otherwise.
pub fn encode(normals: &Planes, format: PictureFormat) -> Result<Vec<u8>> {
    encode_picture(&picture(normals, format), format.with_depth(Depth::Sixteen))
}

/// Normals as a picture for the given format.
pub fn picture(normals: &Planes, format: PictureFormat) -> Picture {
    let mut planes = normals.clone();
    if matches!(format, PictureFormat::Exr(_) | PictureFormat::Pfm) {
        return Picture { planes, space: Space::Linear };
    }
    planes.as_mut_slice().iter_mut().for_each(|v| *v = 0.5 * *v + 0.5);
    // Declared as encoded, so that the codes are the packed components themselves.
    Picture { planes, space: Space::Srgb }
}
