//! The ground truth of a capture.

use relume::capture::dome::Dome;
use relume::format::{Depth, ExrDepth, NormalY, PictureFormat, encode_normals, encode_picture_with};
use relume::{Footprint, Job, Picture, Planes, Result, Size, Space};
use serde_json::{Value, json};

use crate::output::KeepFile;

/// Writes the true normals, albedo and height, and roughness and metal where there are maps of them.
pub fn write(dome: &Dome, keep: &mut KeepFile, job: &Job) -> Result<()> {
    let exr = |planes: &Planes| {
        let picture = Picture { planes: planes.clone(), space: Space::Linear };
        encode_picture_with(&picture, PictureFormat::Exr(ExrDepth::Float), job)
    };
    let maps = dome.maps();
    let normals = encode_normals(dome.normals(), NormalY::Up, PictureFormat::Exr(ExrDepth::Float), job)?;
    keep("truth/normals.exr", &normals)?;
    keep("truth/albedo.exr", &exr(&maps.albedo)?)?;
    keep("truth/height.exr", &exr(&maps.height)?)?;
    for (name, map) in [(ROUGHNESS, &maps.roughness), (METALLIC, &maps.metallic)] {
        if let Some(map) = map {
            keep(name, &exr(map)?)?;
        }
    }
    let packed = encode_normals(dome.normals(), NormalY::Up, PictureFormat::Png(Depth::Sixteen), job)?;
    keep("truth/normals_gl.png", &packed)
}

const ROUGHNESS: &str = "truth/roughness.exr";
const METALLIC: &str = "truth/metallic.exr";

/// What [`write`] has written, for programs.
pub fn describe(dome: &Dome) -> Value {
    let (low, high) = dome.maps().height.range(0);
    let mut truth = json!({
        "height_texels": { "file": "truth/height.exr", "lowest": low, "highest": high },
        "albedo_linear": "truth/albedo.exr",
        "normals_y_up": ["truth/normals.exr", "truth/normals_gl.png"],
    });
    let maps =
        [("roughness", ROUGHNESS, &dome.maps().roughness), ("metallic", METALLIC, &dome.maps().metallic)];
    for (field, file, _) in maps.into_iter().filter(|(_, _, map)| map.is_some()) {
        truth[field] = file.into();
    }
    truth
}

/// The memory of [`write`], beside the dome.
pub fn footprint(size: Size) -> Footprint {
    let copy = Footprint::of_texels(size, 12, 12);
    let exr = copy.then(PictureFormat::Exr(ExrDepth::Float).footprint(size, 3));
    let packed = PictureFormat::Png(Depth::Sixteen).normals_footprint(size);
    Footprint { peak: exr.peak.max(packed.peak), kept: 0 }
}
