//! The ground truth of a capture.

use relume::capture::dome::Dome;
use relume::format::{Depth, ExrDepth, NormalY, PictureFormat, encode_normals, encode_picture_with};
use relume::{Footprint, Job, Picture, Planes, Result, Size, Space};

use crate::output::Folder;

/// Writes the true normals, albedo and height.
pub fn write(dome: &Dome, folder: &mut Folder, job: &Job) -> Result<()> {
    let exr = |planes: &Planes| {
        let picture = Picture { planes: planes.clone(), space: Space::Linear };
        encode_picture_with(&picture, PictureFormat::Exr(ExrDepth::Float), job)
    };
    let normals = encode_normals(dome.normals(), NormalY::Up, PictureFormat::Exr(ExrDepth::Float), job)?;
    folder.add("truth/normals.exr", &normals)?;
    folder.add("truth/albedo.exr", &exr(&dome.maps().albedo)?)?;
    folder.add("truth/height.exr", &exr(&dome.maps().height)?)?;
    let packed = encode_normals(dome.normals(), NormalY::Up, PictureFormat::Png(Depth::Sixteen), job)?;
    folder.add("truth/normals_gl.png", &packed)
}

/// The memory of [`write`], beside the dome.
pub fn footprint(size: Size) -> Footprint {
    let copy = Footprint::of_texels(size, 12, 12);
    let exr = copy.then(PictureFormat::Exr(ExrDepth::Float).footprint(size, 3));
    let packed = PictureFormat::Png(Depth::Sixteen).normals_footprint(size);
    Footprint { peak: exr.peak.max(packed.peak), kept: 0 }
}
