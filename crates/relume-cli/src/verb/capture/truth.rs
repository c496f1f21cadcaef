//! The ground truth of a capture.

use relume::capture::dome::Dome;
use relume::format::{Depth, ExrDepth, NormalY, PictureFormat, encode_normals, encode_picture};
use relume::{Picture, Planes, Result, Space};

use crate::output::Folder;

/// Writes the true normals, albedo and height.
pub fn write(dome: &Dome, folder: &mut Folder) -> Result<()> {
    let exr = |planes: &Planes| {
        let picture = Picture { planes: planes.clone(), space: Space::Linear };
        encode_picture(&picture, PictureFormat::Exr(ExrDepth::Float))
    };
    let normals = encode_normals(dome.normals(), NormalY::Up, PictureFormat::Exr(ExrDepth::Float))?;
    folder.add("truth/normals.exr", &normals)?;
    folder.add("truth/albedo.exr", &exr(&dome.maps().albedo)?)?;
    folder.add("truth/height.exr", &exr(&dome.maps().height)?)?;
    let packed = encode_normals(dome.normals(), NormalY::Up, PictureFormat::Png(Depth::Sixteen))?;
    folder.add("truth/normals_gl.png", &packed)
}
