//! The ground truth of a capture.

use relume::capture::dome::Dome;
use relume::format::{Depth, ExrDepth, PictureFormat, encode_picture};
use relume::{Picture, Planes, Result, Space};

use crate::normals;
use crate::output::Folder;

/// Writes the true normals, albedo and height.
pub fn write(dome: &Dome, folder: &mut Folder) -> Result<()> {
    let exr = |planes: &Planes| {
        let picture = Picture { planes: planes.clone(), space: Space::Linear };
        encode_picture(&picture, PictureFormat::Exr(ExrDepth::Float))
    };
    folder.add("truth/normals.exr", &exr(dome.normals())?)?;
    folder.add("truth/albedo.exr", &exr(&dome.maps().albedo)?)?;
    folder.add("truth/height.exr", &exr(&dome.maps().height)?)?;
    let packed = normals::encode(dome.normals(), PictureFormat::Png(Depth::Sixteen))?;
    folder.add("truth/normals_gl.png", &packed)
}
